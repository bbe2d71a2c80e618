//! What decisions depend on: the past that a command names by its digest, and nothing else.
//!
//! The same digest may come twice: a journal loses its tail, and the same actions are flown again, perhaps under other
//! planners, at other times, after other vetoes. A command that was sent before is executed then as if it were new. So
//! planners must see the same whenever the digest is the same, and decide the same.

use std::collections::BTreeMap;

use contract::{
    Action, Brief, Command, Digest, Leader, Leg, Member, MonotonicNs, Name, Origin, RobotId, Route, RunId,
    State, Team, Timing, Vetoed,
};
use planner::Situation;

use super::Checker;

/// What planners have seen on each past, and what they have decided there.
#[derive(Clone, Debug, Default)]
pub(super) struct Dependence {
    /// By run, digest and vetoes.
    views: BTreeMap<(RunId, Digest, u32), View>,
    /// Of each robot and algorithm, what may be executed.
    decisions: BTreeMap<(RunId, Digest, RobotId, Name), Action>,
}

/// What a planner sees beside the map, whose cells are compared elsewhere.
#[derive(Clone, Debug, PartialEq)]
struct View {
    brief: Brief,
    leg: Option<Leg>,
    state: State,
    team: Option<Team>,
    routes: Option<Vec<Route>>,
}

impl View {
    fn of(situation: &Situation<'_>) -> Self {
        let routes = situation.scouting.map(|scouting| scouting.routes.iter().cloned().collect());
        let Situation { brief, leg, state, team, .. } = *situation;
        Self { brief: brief.clone(), leg: leg.copied(), state: *state, team: team.cloned(), routes }
    }

    /// What of it the digest tells nothing of, if there is something.
    fn beyond_the_digest(&self) -> Option<&'static str> {
        let State { leader, last_origin, last_vetoed, landed, published, last_timing, .. } = self.state;
        let leads = |member: &Member| member.leader != Leader::default();
        if leader != Leader::default() || self.team.iter().any(|team| team.members.iter().any(leads)) {
            Some("who commands")
        } else if last_origin != Origin::Planner {
            Some("who chose the last action")
        } else if last_vetoed != Vetoed::NONE {
            Some("what was vetoed before the last action")
        } else if (landed, published, last_timing) != (MonotonicNs(0), MonotonicNs(0), Timing::default()) {
            Some("when something happened")
        } else {
            None
        }
    }
}

impl Checker {
    /// A planner is about to plan: it sees what follows from the digest, and what every other one has seen on that past.
    pub(super) fn sees(&mut self, situation: &Situation<'_>) {
        let view = View::of(situation);
        let State { run, decision, digest, vetoed, .. } = view.state;
        let beyond = view.beyond_the_digest();
        self.require(beyond.is_none(), "planners see what follows from the digest, and no more", || {
            format!("at decision {decision} a planner sees {}", beyond.unwrap_or_default())
        });
        let before = self.dependence.views.entry((run, digest, vetoed.0)).or_insert_with(|| view.clone());
        if *before != view {
            let detail = format!(
                "at decision {decision} with digest {digest} a planner sees {view:?}, saw {before:?}"
            );
            self.violate("planners see the same on every past of one digest", || detail);
        }
    }

    /// A planner commands: what may be executed of it is what the same algorithm has always commanded on that past.
    pub(super) fn decides(&mut self, command: &Command) {
        let Command { run, robot, decision, digest, action, planner, .. } = *command;
        // Of a past that is no longer, or not yet, that of the journal it is not known what the guard vetoes.
        let is_now = (run, digest) == (self.mission.brief.run, self.digest()) && robot == self.due();
        if !is_now || self.to_veto().has(action) {
            return;
        }
        let before = *self.dependence.decisions.entry((run, digest, robot, planner)).or_insert(action);
        self.require(before == action, "an algorithm decides the same on every past of one digest", || {
            format!("{planner} commands {action} at decision {decision} of robot {robot}, commanded {before}")
        });
    }
}
