//! Planners for rovers that cover ground: those of the crate `coverage`, on the observed map.
//!
//! Home of the decision rule of Laîné & Yoshida 2019 and of `cover_frontier`, as planners of a process. All rovers share
//! one map, so a process that commands several of them keeps one [`Cover`].

use contract::{Action, Body, Brief, Goal, Name, ObservedMap, Placement, Robot, RunId, Standing, Team};
use coverage::{Algorithm, Knowledge, Rover, TeamMap};

use crate::names;
use crate::others::{goal_of_hops, wait_or_hold};
use crate::plan::{Budget, Plan, PlanStatus, Planner, Situation};

/// A planner for coverage, with the observed map in the form that it searches.
#[derive(Debug)]
pub struct Cover {
    algorithm: Algorithm,
    planner: coverage::Planner,
    /// The map as of a fingerprint of the observed one.
    map: Option<(RunId, u64, TeamMap)>,
    rovers: Vec<Rover>,
}

impl Cover {
    /// A planner that has seen nothing.
    #[must_use]
    pub fn new(algorithm: Algorithm) -> Self {
        Self { algorithm, planner: coverage::Planner::new(algorithm), map: None, rovers: Vec::new() }
    }

    /// Brings the map up to date with what changed in the observed one.
    fn refresh(&mut self, observed: &ObservedMap) -> &TeamMap {
        let known =
            self.map.take().filter(|(run, _, map)| *run == observed.run && *map.grid() == observed.grid);
        let changes =
            known.and_then(|(_, observation, map)| Some((map, observed.changed_since(observation)?)));
        let map = match changes {
            Some((mut map, changed)) => {
                changed.iter().for_each(|&index| learn(&mut map, observed, index as usize));
                map
            }
            None => {
                let mut map = TeamMap::new(observed.grid);
                (0..observed.cells().len()).for_each(|index| learn(&mut map, observed, index));
                map
            }
        };
        let (_, _, map) = self.map.insert((observed.run, observed.observation(), map));
        map
    }
}

impl Planner for Cover {
    fn name(&self) -> Name {
        names::name(self.algorithm.name())
    }

    fn suits(&self, robot: &Robot) -> bool {
        covers(robot)
    }

    fn plan(&mut self, situation: &Situation<'_>, _: &Budget) -> Plan {
        let brief = situation.brief;
        let (Some(team), Some(cover)) = (situation.team, brief.cover()) else {
            return Plan::at_once(Action::Hold, PlanStatus::Infeasible);
        };
        if !brief.robots.at(team.due).is_some_and(covers) {
            return Plan::at_once(Action::Hold, PlanStatus::Infeasible);
        }
        let before = brief.robots.iter().take(team.due.0.into());
        let robot = before.filter(|robot| covers(robot)).count();
        self.rovers.clear();
        self.rovers.extend(rovers(brief, team));
        self.refresh(situation.map);
        let Self { planner, map: Some((_, _, map)), rovers, .. } = self else {
            return Plan::at_once(Action::Hold, PlanStatus::Infeasible);
        };
        // Rovers alone make way for each other; robots of other kinds may have to act first.
        let waits = if brief.robots.iter().all(covers) { Action::Hold } else { wait_or_hold(team) };
        let situated = coverage::Situation { map, rovers, mode: cover.mode, robot };
        match planner.decide(&situated).map(Action::Step) {
            // The guard knows better: another robot may have come there since the map was sensed.
            Some(step) if situation.state.vetoed.has(step) => Plan::at_once(waits, PlanStatus::Infeasible),
            Some(step) => Plan::at_once(step, PlanStatus::Solved),
            None => Plan::at_once(waits, PlanStatus::Infeasible),
        }
    }
}

/// Whether a robot is a rover that covers ground.
fn covers(robot: &Robot) -> bool {
    matches!((robot.body, robot.goal), (Body::Rover(_), Goal::Cover(_)))
}

/// The rovers that cover ground, in the order of their numbers, and behind them what stands in the way as a stranded rover does:
/// all other robots on the map's ground, and the goals of hoppers. Those have no region: ties go to the first rover, whose start they share.
fn rovers<'a>(brief: &'a Brief, team: &'a Team) -> impl Iterator<Item = Rover> + 'a {
    let first = brief.robots.iter().find(|robot| covers(robot)).map(|robot| robot.start);
    let robots = || brief.robots.iter().zip(team.members.iter());
    let on_map = robots().filter(move |(_, member)| brief.grid.contains(member.at.cell));
    let rovers = on_map.clone().filter(|(robot, _)| covers(robot)).map(|(robot, member)| Rover {
        start: robot.start,
        pose: member.at,
        stranded: member.standing == Standing::Stranded,
    });
    let others = on_map.filter(|(robot, _)| !covers(robot) && robot.body.is_on_ground());
    let goals = robots().filter_map(move |(robot, member)| {
        let cell = goal_of_hops(brief, robot).filter(|goal| brief.grid.contains(*goal))?;
        Some(Placement { cell, ..member.at })
    });
    let in_the_way = others.map(|(_, member)| member.at).chain(goals);
    rovers.chain(in_the_way.filter_map(move |pose| Some(Rover { start: first?, pose, stranded: true })))
}

/// Writes one cell of the observed map into `map`.
fn learn(map: &mut TeamMap, observed: &ObservedMap, index: usize) {
    let knowledge = match observed.cells()[index] {
        None => Knowledge::Unknown,
        Some(ground) if ground.is_drivable() => Knowledge::Free,
        Some(_) => Knowledge::Obstacle,
    };
    map.set(observed.grid.cell(index), knowledge, observed.visits(index).into());
}
