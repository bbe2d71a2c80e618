//! Planners for rovers that cover ground: those of the crate `coverage`, on the observed map.
//!
//! Home of the decision rule of Laîné & Yoshida 2019 and of `cover_frontier`, as planners of a process. All rovers share
//! one map, so a process that commands several of them keeps one [`Cover`].

use contract::{
    Action, Cover as Share, Grid, Member, Name, ObservedMap, Placement, RunId, Standing, Task, Team, Vehicle,
};
use coverage::{Algorithm, Knowledge, Rover, TeamMap};

use crate::names;
use crate::others::wait_or_hold;
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

    fn suits(&self, task: Task) -> bool {
        matches!(task, Task::Cover(_))
    }

    fn plan(&mut self, situation: &Situation<'_>, _: &Budget) -> Plan {
        let (Some(team), Some(Share { mode, .. })) = (situation.team, situation.brief.cover) else {
            return Plan::at_once(Action::Hold, PlanStatus::Infeasible);
        };
        let is_rover = |member: &&Member| matches!(member.robot.vehicle, Vehicle::Rover { .. });
        let due = usize::from(team.due.0);
        let robot = team.members.iter().take(due).filter(is_rover).count();
        if !team.members.get(due).is_some_and(|member| is_rover(&member)) {
            return Plan::at_once(Action::Hold, PlanStatus::Infeasible);
        }
        self.rovers.clear();
        self.rovers.extend(rovers(team, &situation.map.grid));
        self.refresh(situation.map);
        let Self { planner, map: Some((_, _, map)), rovers, .. } = self else {
            return Plan::at_once(Action::Hold, PlanStatus::Infeasible);
        };
        let waits = if situation.brief.mixed.is_some() { wait_or_hold(team) } else { Action::Hold };
        let situated = coverage::Situation { map, rovers, mode, robot };
        match planner.decide(&situated).map(Action::Step) {
            // The guard knows better: another robot may have come there since the map was sensed.
            Some(step) if situation.state.vetoed.has(step) => Plan::at_once(waits, PlanStatus::Infeasible),
            Some(step) => Plan::at_once(step, PlanStatus::Solved),
            None => Plan::at_once(waits, PlanStatus::Infeasible),
        }
    }
}

/// The rovers that cover ground, in the order of their numbers, and behind them what stands in the way as a stranded rover does:
/// all other robots on the map's ground, and the goals of hoppers. Those have no region: ties go to the first rover, whose start they share.
fn rovers<'a>(team: &'a Team, grid: &'a Grid) -> impl Iterator<Item = Rover> + 'a {
    let is_rover = |member: &&Member| matches!(member.robot.vehicle, Vehicle::Rover { .. });
    let first = team.members.iter().find(is_rover).map(|member| member.robot.start);
    let on_map = |member: &&Member| grid.contains(member.at.cell);
    let rovers = team.members.iter().filter(is_rover).filter(on_map).map(|member| Rover {
        start: member.robot.start,
        pose: member.at,
        stranded: member.standing == Standing::Stranded,
    });
    let is_other = move |member: &&Member| {
        !is_rover(member) && member.robot.vehicle.is_on_ground() && grid.contains(member.at.cell)
    };
    let others = team.members.iter().filter(is_other).map(|member| member.at);
    let goals = team.members.iter().filter_map(|member| {
        let cell = member.robot.vehicle.hop_goal().filter(|goal| grid.contains(*goal))?;
        Some(Placement { cell, ..member.at })
    });
    let in_the_way = others.chain(goals);
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
