//! Uncertain ground as planners of routes know it: the prior, the true speeds of the cells that have been seen, and what a
//! camera that errs has read, by Bayes' rule.

use std::sync::Arc;

use contract::{
    Action, Body, Brief, Cell, DriveSpeed, Goal, Member, ObservedMap, Reach, Robot, Route, Sampling,
    Standing, Team, Travel, Waypoint,
};
use helicopter::{Sensor, Sighting};
use routing::{Trip, stage_seed};
use rover::{Belief, Lattice, Point, Speed, SpeedDistribution, Surface};

use crate::others::{self, goals, stopped, taken};
use crate::plan::{Scouting, Situation};

/// How far a helicopter may have flown beyond the legs of its route, metres: their lengths are rounded, and a route may begin
/// next to where it is.
const FLOWN_TOLERANCE_M: f64 = 1e-3;

/// A situation of a robot that goes from point to point, taken apart.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Turn<'a> {
    pub brief: &'a Brief,
    pub sampling: Sampling,
    pub team: &'a Team,
    /// The robot that decides.
    pub me: &'a Member,
    /// What it is.
    pub robot: &'a Robot,
    pub travel: Travel,
    pub scouting: Scouting<'a>,
    pub map: &'a ObservedMap,
}

/// Cells that a rover drives around.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Around {
    /// Cells where robots stand for good, and the goals of hoppers: a drive may lead over them, but
    /// must not end there for good.
    Stopped,
    /// Cells where robots stand, for good or just now, and the goals of hoppers.
    All,
    /// The goals of hoppers within reach of the rover's own, where it would be in their way for good.
    Goals,
}

impl<'a> Turn<'a> {
    /// `None` in another mission.
    pub fn of(situation: &Situation<'a>) -> Option<Self> {
        let (team, scouting) = (situation.team?, situation.scouting?);
        let brief = situation.brief;
        let (me, robot) = (team.member(team.due)?, brief.robots.at(team.due)?);
        let (sampling, travel) = (brief.sampling?, me.travel?);
        Some(Self { brief, sampling, team, me, robot, travel, scouting, map: situation.map })
    }

    /// What is known of the speeds; `None` if prior and map are of different ground.
    pub fn belief(&self) -> Option<Belief> {
        self.belief_with(&[])
    }

    /// What is known of the speeds, with no way through cells where the rover should not stop.
    pub fn belief_around(&self, cells: Around) -> Option<Belief> {
        let grid = &self.map.grid;
        let closed: Vec<Cell> = match cells {
            Around::Stopped => stopped(self.brief, self.team).chain(self.goals()).collect(),
            Around::All => taken(self.brief, self.team).chain(self.goals()).collect(),
            Around::Goals => {
                let Goal::Reach(goal) = self.robot.goal else { return None };
                let reach_m = goal.radius_m + grid.cell_size_m;
                let is_near = |cell: &Cell| {
                    point(Waypoint::middle_of(grid, *cell)).distance_m(point(goal.at)) <= reach_m
                };
                self.goals().filter(is_near).collect()
            }
        };
        let mut closed: Vec<usize> = closed
            .iter()
            .filter(|cell| **cell != self.me.at.cell)
            .filter_map(|cell| grid.index(*cell))
            .collect();
        closed.sort_unstable();
        self.belief_with(&closed)
    }

    /// Where hoppers go that still act.
    fn goals(&self) -> impl Iterator<Item = Cell> {
        goals(self.brief, self.team)
    }

    /// What is known of the speeds, with no way through the `closed` cells, whose indices are in order.
    fn belief_with(&self, closed: &[usize]) -> Option<Belief> {
        let grid = self.map.grid;
        let lattice = Lattice::new(grid.width as usize, grid.height as usize).ok()?;
        let mut accuracies = self.brief.robots.iter().filter_map(|robot| robot.sensor.accuracy());
        let camera = accuracies.next().and_then(|accuracy| Sensor::with_accuracy(accuracy).ok());
        let cells = self.scouting.prior.cells.iter().zip(self.map.cells()).enumerate();
        let speed = |speed: DriveSpeed| Speed::ALL[speed as usize];
        let speeds = cells.map(|(index, (prior, seen))| {
            if closed.binary_search(&index).is_ok() {
                return Some(SpeedDistribution::certain(Speed::Zero));
            }
            let sighting = Sighting {
                speed: seen.and_then(|ground| ground.speed).map(speed),
                reading: seen.and_then(|ground| ground.reading).map(speed),
            };
            let prior = SpeedDistribution::as_given(prior.speeds.probabilities()).ok()?;
            Some(sighting.belief(prior, camera.as_ref()))
        });
        let heights_m: Vec<f64> = self.scouting.prior.cells.iter().map(|prior| prior.height_m).collect();
        let surface = Surface::from_heights(lattice, &heights_m).ok()?;
        Belief::new(Arc::new(surface), speeds.collect::<Option<_>>()?).ok()
    }

    /// Whether no other robot is on the ground.
    pub fn is_alone(&self) -> bool {
        !self.others().any(|(robot, _)| robot.body.is_on_ground())
    }

    /// The stage that the rover is in, from 1; the first if there is none.
    pub fn stage(&self) -> u32 {
        let travels = self.team.members.iter().filter_map(|member| member.travel);
        1 + travels.map(|travel| travel.halts).max().unwrap_or_default()
    }

    /// The seed of this stage's planners.
    pub fn seed(&self) -> u64 {
        stage_seed(self.sampling.seed, self.stage())
    }

    /// Where a member is and what is left of its route.
    pub fn rest_of(&self, member: &Member) -> Option<Vec<Point>> {
        let (travel, route) = (member.travel?, self.route_of(member)?);
        Some(travel.rest(route).map(point).collect())
    }

    /// What the robot does if it can go on only once others have acted.
    pub fn wait_or_hold(&self) -> Action {
        others::wait_or_hold(self.team)
    }

    /// The points of a member's route.
    pub fn route_of(&self, member: &Member) -> Option<&'a Route> {
        self.scouting.routes.get(member.travel?.route?)
    }

    /// All robots but the one that decides.
    pub fn others(&self) -> impl Iterator<Item = (&'a Robot, &'a Member)> {
        others::others(self.brief, self.team)
    }

    /// Whether a helicopter flies for the first time in this stage, or is about to. One that flies again looks ahead for hoppers,
    /// and so may one that waits. Who plans for it does not count: the digest tells nothing of that.
    pub fn is_scouted(&self) -> bool {
        self.others().any(|(robot, member)| {
            let Some(travel) = member.travel else { return false };
            let flies = matches!(robot.body, Body::Helicopter(_));
            let is_at_work = member.standing == Standing::Active && !member.waits;
            let is_to_fly = travel.route.is_none() || travel.is_under_way() && self.is_first_flight(member);
            flies && is_at_work && is_to_fly
        })
    }

    /// Whether a helicopter has flown no further in this stage than along its present route.
    fn is_first_flight(&self, member: &Member) -> bool {
        let (Some(travel), Some(route)) = (member.travel, self.route_of(member)) else { return false };
        let along = route.waypoints().windows(2).take(travel.reached as usize);
        let along_m: f64 = along.map(|leg| leg[0].distance_m(leg[1])).sum();
        travel.flown_m <= along_m + FLOWN_TOLERANCE_M
    }
}

/// The points of a planner's route as an announcement has them, bit for bit; `None` if they are too many or too far apart.
pub(crate) fn announcement(points: &[Point]) -> Option<Route> {
    Route::new(points.iter().map(|point| Waypoint { x_m: point.x_m, y_m: point.y_m }).collect()).ok()
}

/// The trip to `goal` of a rover from where it is.
pub(crate) fn trip(travel: &Travel, goal: &Reach) -> Trip {
    Trip { start: point(travel.at), goal: routing::Goal { at: point(goal.at), radius_m: goal.radius_m } }
}

pub(crate) fn point(at: Waypoint) -> Point {
    Point::new(at.x_m, at.y_m)
}

// The names of the speeds in messages and in the model are in the same order.
const _: () = assert!(DriveSpeed::ALL.len() == Speed::ALL.len());
