//! Rare events among robots of all kinds.

use contract::{Action, Body, Branch, Record, Standing, Status};

use crate::expected::goal_cell;
use crate::setup::Missions;
use crate::world::World;

impl World {
    /// Rare events that a record shows, before it is one of the checker's.
    pub(super) fn count_mixed(&mut self, record: &Record) {
        if self.setup.missions != Missions::Mixed {
            return;
        }
        let (mission, before) = (self.checker.mission(), self.checker.robots());
        let Some(robot) = mission.brief.robots.at(record.robot) else { return };
        let mut after = before.clone();
        after.committed(mission, record);
        let Record { outcome, action, status, .. } = record;
        let mut names = Vec::new();
        if let (Body::Hopper(_), Action::Hop(direction)) = (robot.body, *action)
            && outcome.branch != Branch::Stranded
        {
            let end = motion::landing(&mission.brief.grid, outcome.from, direction, outcome.branch);
            names.extend((outcome.to != end).then_some("hop_stops_before_another"));
        }
        names.extend(match (robot.body, *action) {
            (Body::Hopper(_), Action::Wait) => Some("hopper_waits"),
            (Body::Rover(_), Action::Wait) => Some("rover_waits"),
            _ => None,
        });
        let is_treasure = mission.terrain.treasures.iter().position(|cell| *cell == outcome.to);
        let is_collected = is_treasure.is_some_and(|number| record.collected.0 >> number & 1 == 1);
        names.extend(
            (after.entered(record).is_some() && is_collected).then_some("rover_enters_an_empty_find"),
        );
        let was_active = before.standing(record.robot) == Some(Standing::Active);
        let ended =
            after.standing(record.robot).filter(|standing| was_active && *standing != Standing::Active);
        let is_at_goal = goal_cell(&mission.brief.grid, robot, 0) == Some(outcome.to);
        names.extend(match (ended, robot.body) {
            (Some(Standing::Done), Body::Hopper(_)) if is_at_goal => Some("hopper_arrives"),
            (Some(Standing::Done), Body::Driver(_)) if *action == Action::Drive => Some("rover_arrives"),
            (Some(Standing::Done), _) if !robot.required && *action != Action::Done => Some("gives_up"),
            (Some(Standing::Stranded), Body::Hopper(_)) if robot.required => Some("hopper_is_lost"),
            _ => None,
        });
        let goes_on = ended == Some(Standing::Stranded) && !robot.required && *status == Status::Underway;
        names.extend(goes_on.then_some("goes_on_without_one"));
        let closes = ended.is_some() && robot.body.is_on_ground() && before.is_covering();
        names.extend((closes && *status == Status::Underway).then_some("closed_to_rovers"));
        let is_early = *status == Status::Goal && after.is_any_active();
        names.extend(is_early.then_some("ends_while_others_act"));
        names.into_iter().for_each(|name| self.coverage.count("mixed", name));
    }
}
