//! Rare events among robots of all kinds.

use contract::{Action, Branch, Record, Standing, Status, Vehicle};

use crate::world::World;

impl World {
    /// Rare events that a record shows, before it is one of the checker's.
    pub(super) fn count_mixed(&mut self, record: &Record) {
        let mission = self.checker.mission();
        let Some(before) = self.checker.mixed() else { return };
        let Some(robot) =
            mission.fleet.as_ref().and_then(|fleet| fleet.robots.get(usize::from(record.robot.0)))
        else {
            return;
        };
        let mut after = before.clone();
        after.committed(mission, record);
        let Record { outcome, action, status, .. } = record;
        let mut names = Vec::new();
        if let (Vehicle::HopperTo { .. }, Action::Hop(direction)) = (robot.vehicle, *action)
            && outcome.branch != Branch::Stranded
        {
            let end = motion::landing(&mission.brief.grid, outcome.from, direction, outcome.branch);
            names.extend((outcome.to != end).then_some("hop_stops_before_another"));
        }
        names.extend(match (robot.vehicle, *action) {
            (Vehicle::HopperTo { .. }, Action::Wait) => Some("hopper_waits"),
            (Vehicle::Rover { .. }, Action::Wait) => Some("rover_waits"),
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
        let needed = after.needs(record.robot);
        names.extend(match (ended, robot.vehicle) {
            (Some(Standing::Done), Vehicle::HopperTo { goal }) if outcome.to == goal => {
                Some("hopper_arrives")
            }
            (Some(Standing::Done), Vehicle::Driver { .. }) if *action == Action::Drive => {
                Some("rover_arrives")
            }
            (Some(Standing::Done), _) if !needed && *action != Action::Done => Some("gives_up"),
            (Some(Standing::Stranded), Vehicle::HopperTo { .. }) if needed => Some("hopper_is_lost"),
            _ => None,
        });
        let goes_on = ended == Some(Standing::Stranded) && !needed && *status == Status::Underway;
        names.extend(goes_on.then_some("goes_on_without_one"));
        let closes = ended.is_some() && robot.vehicle.is_on_ground() && before.is_covering();
        names.extend((closes && *status == Status::Underway).then_some("closed_to_rovers"));
        let is_early = *status == Status::Goal && after.is_any_active();
        names.extend(is_early.then_some("ends_while_others_act"));
        names.into_iter().for_each(|name| self.coverage.count("mixed", name));
    }
}
