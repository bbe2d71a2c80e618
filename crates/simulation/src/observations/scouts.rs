//! Rare events around routes: who announces, who sets off, what is asked for again.

use contract::{Account, Action, Body, Branch, Command, Incarnation, PriorPage, Record, RouteRequest};

use crate::life::Life;
use crate::world::World;

impl World {
    /// Rare events among a rover and helicopters that a record shows, before it is one of the checker's.
    pub(super) fn count_scouts(&mut self, record: &Record) {
        let brief = &self.checker.mission().brief;
        let Some(robot) = brief.robots.at(record.robot) else { return };
        let flies = match robot.body {
            Body::Hopper(_) => {
                let has_helicopters = brief.account == Account::Hopper && brief.has_team();
                if has_helicopters && record.outcome.branch == Branch::Stranded {
                    self.coverage.count("scouts", "hopper_out");
                }
                return;
            }
            Body::Rover(_) => return,
            Body::Driver(_) => false,
            Body::Helicopter(_) => true,
        };
        let before = self.checker.records().iter().filter(|before| before.robot == record.robot);
        // Its last announcement, drive or flight.
        let moves =
            |before: &&Record| matches!(before.action, Action::Announce(_) | Action::Drive | Action::Fly);
        let last = before.rev().find(moves);
        let is_another = last.is_some_and(|last| last.leader.incarnation != record.leader.incarnation);
        let has_announced = last.is_some_and(|last| matches!(last.action, Action::Announce(_)));
        let is_stranded = record.outcome.branch == Branch::Stranded;
        let goes_on = record.origin.is_fallback();
        if record.action == Action::Drive && self.checker.scouts().has_misreadings() {
            self.coverage.count("scouts", "drives_misled");
        }
        let scouts = self.checker.scouts();
        let begins = scouts.halts() > 0 && !scouts.has_moved_in_stage(record.robot);
        let event = match record.action {
            Action::Drive if record.outcome.branch == Branch::Halted && goes_on => Some("fallback_halted"),
            Action::Drive if record.outcome.branch == Branch::Halted => Some("halted"),
            Action::Announce(_) if begins && flies => Some("flies_again"),
            Action::Announce(_) if begins => Some("replanned_after_halt"),
            Action::Drive if begins && is_another => Some("another_life_after_halt"),
            _ => None,
        };
        if let Some(event) = event {
            self.coverage.count("stages", event);
        }
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
        if let Some(name) = name {
            self.coverage.count("scouts", name);
        }
    }

    /// hopper-sim receives a command whose route it has not received, though its planner has sent it.
    pub(super) fn count_lost_announcement(&mut self, life: &Life, command: &Command) {
        let Action::Announce(id) = command.action else { return };
        let is_sent = self.checker.scouts().is_announced(command.run, id);
        if is_sent && !self.scouting.received.contains(&(life.incarnation, command.run, id)) {
            self.coverage.count("scouts", "announcement_lost");
        }
    }

    /// A process asks for a route, perhaps as an earlier life of it has done.
    pub(super) fn count_route_request(&mut self, life: &Life, request: &RouteRequest) {
        let RouteRequest { run, id } = *request;
        let first = *self.scouting.askers.entry((life.slot, run, id)).or_insert(life.incarnation);
        if first != life.incarnation {
            self.coverage.count("scouts", "route_asked_again");
        }
    }

    /// A planner takes a page of the prior.
    pub(super) fn count_prior_page(&mut self, life: &Life, page: &PriorPage, server: Incarnation) {
        let first = self.scouting.priors.entry(life.incarnation).or_insert((page.run, server));
        if first.0 != page.run || page.from == 0 {
            *first = (page.run, server);
        } else if first.1 != server {
            self.coverage.count("scouts", "prior_of_two_lives");
        }
    }
}
