//! Rare events that a record of several robots shows.

use contract::{Account, Action, Branch, Record, RobotId, Standing, Status};

use super::actor::Actor;
use super::{Oracle, goal};
use crate::model::{Counter, Model};
use crate::setup::Missions;

impl Oracle {
    /// Those of `record`, which is about to be committed after the records `before`.
    pub(super) fn events_of(&self, missions: Missions, record: &Record, before: &[Record]) -> Vec<Counter> {
        let Some(actor) = self.turns.actors.get(usize::from(record.robot.0)) else { return Vec::new() };
        let mut events = Vec::new();
        if matches!(record.action, Action::Up(_)) {
            let is_aimed = record.outcome.branch == Branch::Intended;
            events.push(("vertical", if is_aimed { "climbed" } else { "missed" }));
        }
        if missions == Missions::Rovers {
            events.extend(self.command_events(record));
        }
        if actor.body().along_route().is_some() {
            events.extend(self.route_events(actor, record, before));
        }
        let is_accompanied = self.mission.brief.account == Account::Hopper && self.mission.brief.has_team();
        if is_accompanied && actor.body().hops() && record.outcome.branch == Branch::Stranded {
            events.push(("scouts", "hopper_out"));
        }
        if missions == Missions::Mixed {
            events.extend(self.mixed_events(actor, record).into_iter().map(|name| ("mixed", name)));
        }
        events
    }

    /// Who commands the robots beside the one that acts.
    fn command_events(&self, record: &Record) -> Vec<Counter> {
        let mut events = Vec::new();
        if record.outcome.branch == Branch::Stranded {
            events.push(("rovers", "stranded"));
        }
        let numbers = (0..self.turns.actors.len()).map(|number| RobotId(number as u16));
        let others = numbers.filter(|robot| *robot != record.robot).map(|robot| self.leader(robot));
        let mut leaders = others.filter(|leader| leader.term.0 > 0);
        if leaders.any(|leader| leader.incarnation == record.leader.incarnation) {
            events.push(("rovers", "two_led_by_one"));
        } else if self.leader(record.robot).incarnation != record.leader.incarnation {
            events.push(("rovers", "another_leads"));
        }
        events
    }

    /// Who announces, who sets off, who goes on along the route of another life.
    fn route_events(&self, actor: &Actor, record: &Record, before: &[Record]) -> Vec<Counter> {
        let flies = !actor.body().is_on_ground();
        // Its last announcement, drive or flight.
        let moves =
            |before: &&Record| matches!(before.action, Action::Announce(_) | Action::Drive | Action::Fly);
        let last = before.iter().filter(|before| before.robot == record.robot).rev().find(moves);
        let is_another = last.is_some_and(|last| last.leader.incarnation != record.leader.incarnation);
        let has_announced = last.is_some_and(|last| matches!(last.action, Action::Announce(_)));
        let is_stranded = record.outcome.branch == Branch::Stranded;
        let goes_on = record.origin.is_fallback();
        let is_misled = record.action == Action::Drive && self.uncertain.has_misreadings(&self.shown);
        let name = match (record.action, flies) {
            (_, true) if is_stranded => Some("helicopter_out"),
            (Action::Drive, false) if is_stranded && record.outcome.flight.range_m > 0.0 => {
                Some("rover_trapped")
            }
            (_, false) if is_stranded => Some("rover_out"),
            (Action::Fly, _) if goes_on => Some("fallback_flies"),
            (Action::Drive, _) if goes_on => Some("fallback_drives"),
            (Action::Fly, _) if is_another && has_announced => Some("another_life_takes_off"),
            (Action::Drive, _) if is_another && has_announced => Some("another_life_drives_off"),
            (Action::Fly, _) if is_another => Some("flight_taken_over"),
            (Action::Drive, _) if is_another => Some("drive_taken_over"),
            (Action::Announce(_), false) if last.is_some() => Some("announced_anew"),
            (Action::Wait, _) => Some("waits"),
            (Action::Done, true) => Some("flown"),
            _ => None,
        };
        let names = [is_misled.then_some("drives_misled"), name].into_iter().flatten();
        let mut events: Vec<Counter> = names.map(|name| ("scouts", name)).collect();
        let stage = self.stage_event(actor, record, is_another);
        events.extend(stage.map(|name| ("stages", name)));
        events
    }

    /// The end of a stage, or the beginning of one that is not the first.
    fn stage_event(&self, actor: &Actor, record: &Record, is_another: bool) -> Option<&'static str> {
        let actors = &self.turns.actors;
        let ended = actors.iter().filter_map(|actor| actor.halted).max();
        let begins = actors.iter().any(|actor| actor.halts > 0) && actor.moved <= ended;
        let is_halted = record.outcome.branch == Branch::Halted;
        match record.action {
            Action::Drive if is_halted && record.origin.is_fallback() => Some("fallback_halted"),
            Action::Drive if is_halted => Some("halted"),
            Action::Announce(_) if begins && !actor.body().is_on_ground() => Some("flies_again"),
            Action::Announce(_) if begins => Some("replanned_after_halt"),
            Action::Drive if begins && is_another => Some("another_life_after_halt"),
            _ => None,
        }
    }

    /// Robots of several kinds that are in each other's way, or done before each other.
    fn mixed_events(&self, actor: &Actor, record: &Record) -> Vec<&'static str> {
        let (mission, robot) = (&self.mission, &actor.robot);
        let mut after = self.clone();
        after.committed(record);
        let standing = after.turns.actors[usize::from(record.robot.0)].standing;
        let (body, required) = (actor.body(), robot.required);
        let Record { outcome, action, status, .. } = record;
        let mut names = Vec::new();
        if let (true, Action::Hop(direction)) = (body.hops(), *action)
            && outcome.branch != Branch::Stranded
        {
            let end = motion::landing(&mission.brief.grid, outcome.from, direction, outcome.branch);
            names.extend((outcome.to != end).then_some("hop_stops_before_another"));
        }
        if *action == Action::Wait && body.along_route().is_none() {
            names.push(if body.hops() { "hopper_waits" } else { "rover_waits" });
        }
        let is_treasure = mission.terrain.treasures.iter().position(|cell| *cell == outcome.to);
        let is_collected = is_treasure.is_some_and(|number| record.collected.0 >> number & 1 == 1);
        if after.entered(record).is_some() && is_collected {
            names.push("rover_enters_an_empty_find");
        }
        let ended = (actor.is_active() && standing != Standing::Active).then_some(standing);
        let is_at_goal = goal::of(&robot.goal).cell(&mission.brief.grid, 0) == Some(outcome.to);
        names.extend(match ended {
            Some(Standing::Done) if body.hops() && is_at_goal => Some("hopper_arrives"),
            Some(Standing::Done) if body.is_on_ground() && *action == Action::Drive => Some("rover_arrives"),
            Some(Standing::Done) if !required && *action != Action::Done => Some("gives_up"),
            Some(Standing::Stranded) if body.hops() && required => Some("hopper_is_lost"),
            _ => None,
        });
        let is_underway = *status == Status::Underway;
        if ended == Some(Standing::Stranded) && !required && is_underway {
            names.push("goes_on_without_one");
        }
        if ended.is_some() && body.is_on_ground() && self.is_covering() && is_underway {
            names.push("closed_to_rovers");
        }
        if *status == Status::Goal && after.turns.actors.iter().any(Actor::is_active) {
            names.push("ends_while_others_act");
        }
        names
    }
}
