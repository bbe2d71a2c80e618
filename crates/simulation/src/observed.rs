//! A planner that is watched: the checker sees every situation it is given.

use std::sync::{Arc, Mutex};

use contract::{
    Brief, Leg, MotionTable, Name, ObservedMap, PolicyCell, Prior, Robot, Route, Routes, State, Team,
};
use planner::{Budget, Plan, Planner, Scouting, Situation};

/// What the planner was last given, until the checker has looked at it.
pub(crate) type Seen = Arc<Mutex<Option<Given>>>;

/// A situation that was given to a planner.
#[derive(Debug)]
pub(crate) struct Given {
    brief: Brief,
    leg: Option<Leg>,
    map: ObservedMap,
    state: State,
    team: Option<Team>,
    scouting: Option<(Prior, Routes)>,
    table: Option<MotionTable>,
}

impl Given {
    fn of(situation: &Situation<'_>) -> Self {
        let scouting = situation.scouting.map(|scouting| (scouting.prior.clone(), scouting.routes.clone()));
        let Situation { brief, leg, map, state, team, table, .. } = *situation;
        let (leg, team) = (leg.copied(), team.cloned());
        Self {
            brief: brief.clone(),
            leg,
            map: map.clone(),
            state: *state,
            team,
            scouting,
            table: table.cloned(),
        }
    }

    pub fn situation(&self) -> Situation<'_> {
        let Self { brief, leg, map, state, team, scouting, table } = self;
        let scouting = scouting.as_ref().map(|(prior, routes)| Scouting { prior, routes });
        Situation {
            brief,
            leg: leg.as_ref(),
            map,
            state,
            team: team.as_ref(),
            scouting,
            table: table.as_ref(),
        }
    }
}

/// Passes everything on to the real planner.
pub(crate) struct Observed {
    pub planner: Box<dyn Planner>,
    pub seen: Seen,
}

impl Planner for Observed {
    fn name(&self) -> Name {
        self.planner.name()
    }

    fn suits(&self, robot: &Robot) -> bool {
        self.planner.suits(robot)
    }

    fn announces(&self) -> bool {
        self.planner.announces()
    }

    fn plan(&mut self, situation: &Situation<'_>, budget: &Budget) -> Plan {
        let seen = Given::of(situation);
        *self.seen.lock().unwrap_or_else(std::sync::PoisonError::into_inner) = Some(seen);
        // What takes long calls the pulse; the quick planners of small worlds do so here.
        budget.pulse.beat();
        self.planner.plan(situation, budget)
    }

    fn announced(&self) -> Option<&Route> {
        self.planner.announced()
    }

    fn policy(&mut self) -> Option<Vec<PolicyCell>> {
        self.planner.policy()
    }
}
