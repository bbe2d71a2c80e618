//! What a robot that goes from point to point may do.

use std::ops::ControlFlow;

use contract::{Action, Body, Helicopter, RobotId, RouteId, Vetoed, Waypoint};
use rover::{Segment, Speed, traverse};

use super::{Scouts, TOLERANCE_M, point};
use crate::expected::Shown;

impl Scouts {
    /// The drive of the rover that is due, if it is too dangerous by what anybody can know.
    pub fn blocked(&self) -> Vetoed {
        let drive = self.next().map(|due| &self.scouts[due]).and_then(|scout| {
            let drives = scout.robot.body.drives();
            scout.next().filter(|to| drives && self.hazard(scout.at, *to) > self.hazard_max)
        });
        drive.map_or(Vetoed::NONE, |_| Vetoed::NONE.with(Action::Drive))
    }

    /// The largest probability of a cell between two points that it is a trap: what has been seen is certain,
    /// and what was read by a camera that errs weighs the prior by how likely it is.
    fn hazard(&self, from: Waypoint, to: Waypoint) -> f64 {
        let mut hazard = 0.0;
        let leg = Segment { from: point(from), to: point(to) };
        let _ = traverse(self.surface.lattice(), leg, |cell, _| {
            let is_trap = self.truth.speeds[cell] == Speed::Zero;
            let prior = self.prior[cell].probabilities();
            let stuck = match (self.shown[cell], self.readings[cell]) {
                (Shown::Truth, _) => f64::from(u8::from(is_trap)),
                (Shown::Reading, Some(reading)) => {
                    let misread = (1.0 - self.accuracy) / 3.0;
                    let weight = |speed: usize| {
                        prior[speed] * if speed == reading as usize { self.accuracy } else { misread }
                    };
                    let sum = weight(0) + weight(1) + weight(2) + weight(3);
                    if sum > 0.0 { weight(0) / sum } else { prior[0] }
                }
                _ => prior[0],
            };
            hazard = f64::max(hazard, stuck);
            ControlFlow::<()>::Continue(())
        });
        hazard
    }

    /// Whether the robot that is due may do that.
    pub fn may(&self, due: usize, action: Action) -> bool {
        let scout = &self.scouts[due];
        let is_within_budget = |length_m: f64| match scout.robot.body {
            Body::Helicopter(Helicopter { budget_m, .. }) => {
                length_m <= budget_m - scout.flown_m + TOLERANCE_M
            }
            Body::Hopper(_) | Body::Rover(_) | Body::Driver(_) => true,
        };
        match (action, scout.robot.body) {
            (Action::Hold | Action::Wait | Action::Done, _) => true,
            (Action::Announce(id), _) => self.points(due, id).is_some_and(|points| {
                let begins_m = point(points[0]).distance_m(point(scout.at));
                let length_m = points.windows(2).map(|leg| point(leg[0]).distance_m(point(leg[1]))).sum();
                let on_map = points.iter().all(|at| self.surface.lattice().contains(point(*at)));
                on_map && begins_m <= TOLERANCE_M && is_within_budget(length_m)
            }),
            (Action::Drive, Body::Driver(_)) => scout.next().is_some() && self.blocked() == Vetoed::NONE,
            (Action::Fly, Body::Helicopter(_)) => {
                scout.next().is_some_and(|to| is_within_budget(point(scout.at).distance_m(point(to))))
            }
            _ => false,
        }
    }

    /// The points of a route that the robot may announce: published for it, or announced before.
    pub(super) fn points(&self, due: usize, id: RouteId) -> Option<&[Waypoint]> {
        let published = self.announced.get(&(self.run, RobotId(due as u16), id)).map(Vec::as_slice);
        published.or_else(|| self.route(id))
    }
}
