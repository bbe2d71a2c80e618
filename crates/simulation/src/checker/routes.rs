//! What planners of routes announce, are served, and plan with.

use std::sync::Arc;

use contract::{
    Action, Announcement, Command, Leader, PriorCell, PriorPage, Record, Route, RoutePage, RouteRequest,
    TablePage, Team,
};
use planner::Situation;

use super::Checker;
use crate::routes::fingerprint;

impl Checker {
    /// A planner publishes the points of a route.
    pub(crate) fn announced(&mut self, announcement: &Announcement) {
        self.model.routes_mut().publish(announcement);
    }

    /// A planner sends a command, which may name a route.
    pub(super) fn announced_before(&mut self, command: &Command) {
        let Action::Announce(id) = command.action else { return };
        let is_announced = self.model.routes().is_published(command.run, id);
        self.require(is_announced, "the points of a route are sent before the command that names it", || {
            format!("{} names route {id} at decision {}", command.incarnation, command.decision)
        });
    }

    /// `frame` was written, which holds `record`: behind one that announces a route lie its points.
    pub(crate) fn journalled(&mut self, record: &Record, frame: &[u8]) {
        let Action::Announce(id) = record.action else { return };
        let Some(points) = self.model.routes().route(id) else { return };
        let mut need = (points.len() as u64).to_le_bytes().to_vec();
        for point in points {
            need.extend(point.x_m.to_le_bytes());
            need.extend(point.y_m.to_le_bytes());
        }
        let is_whole = frame.ends_with(&need);
        self.require(is_whole, "the journal holds the points of every announced route", || {
            format!("those of {id} are not behind decision {}", record.decision)
        });
    }

    /// The journal was read, and holds these routes.
    pub(crate) fn routes_read(&mut self, routes: &[Route]) {
        let need: Vec<_> =
            self.model.routes().announced().iter().map(|(_, points)| points.as_slice()).collect();
        let got: Vec<_> = routes.iter().map(Route::waypoints).collect();
        let (held, right) = (need.len(), need == got);
        self.require(right, "the journal holds the points of every announced route", || {
            format!("{} routes are in the journal, {held} were announced", routes.len())
        });
    }

    /// Somebody asks for a route.
    pub(crate) fn route_asked(&mut self, request: &RouteRequest) {
        let RouteRequest { run, id } = *request;
        let is_announced = self.model.routes().is_published(run, id);
        self.require(is_announced, "only routes that were announced are asked for", || {
            format!("route {id} of run {run}")
        });
    }

    /// hopper-sim answers a request for a route.
    pub(crate) fn route_served(&mut self, request: &RouteRequest, page: &RoutePage) {
        let points = page.route.waypoints();
        let (asked, got) = (request.id, fingerprint(points));
        self.require(asked == got, "who asks for a route is answered with that one", || {
            format!("asked for {asked}, answered with {got}")
        });
        let need = self.model.routes().route(fingerprint(points));
        let right = page.run == self.mission.brief.run && need == Some(points);
        self.require(right, "nothing is published that the journal does not hold", || {
            format!("a route of {} points that no decision has announced", points.len())
        });
    }

    /// hopper-sim answers for the prior.
    pub(crate) fn prior_served(&mut self, page: &PriorPage) {
        let from = page.from as usize;
        let right = page.run == self.mission.brief.run
            && page.grid == self.mission.brief.grid
            && page.cells.iter().enumerate().all(|(index, cell)| self.is_prior(from + index, cell));
        self.require(right, "the prior is that of the scenario", || {
            format!("the page from cell {from} is not")
        });
    }

    /// hopper-sim answers for the motion table.
    pub(crate) fn table_served(&mut self, page: &TablePage) {
        let rows = self.mission.table.as_ref().and_then(|table| table.rows().get(page.from as usize..));
        let right =
            page.run == self.mission.brief.run && rows.is_some_and(|rows| rows.starts_with(&page.rows));
        self.require(right, "the motion table is that of the scenario", || {
            format!("the page from class {} is not", page.from)
        });
    }

    /// Whether that is known of a cell before the mission.
    fn is_prior(&self, index: usize, got: &PriorCell) -> bool {
        let terrain = &self.mission.terrain;
        terrain.prior.get(index) == Some(&got.speeds)
            && terrain.cells.get(index).is_some_and(|ground| ground.height_m == got.height_m)
    }

    /// A planner is about to plan with these robots, this prior and these routes.
    pub(super) fn plans_with_robots(&mut self, situation: &Situation<'_>) {
        let state = situation.state;
        if state.run != self.mission.brief.run {
            return;
        }
        let is_table = situation.leg.is_none() || situation.table == self.mission.table.as_deref();
        self.require(
            is_table,
            "every plan of a hop is made with the motion table of the scenario, if it has one",
            || format!("at decision {} it is another", state.decision),
        );
        // While an action is in the air the robots before it are planned with, in vain.
        let is_now = state.decision.0 == self.records.len() as u64 && state.digest == self.digest();
        if is_now && self.mission.brief.has_team() {
            // Who commands them is not for planners to see.
            let mut need = self.model.team(state.run, state.decision, state.digest);
            Arc::make_mut(&mut need.members).iter_mut().for_each(|member| member.leader = Leader::default());
            let right = situation.team == Some(&need);
            self.require(right, "every plan is made with the robots as they are", || {
                format!("at decision {} they are {:?}, need {need:?}", state.decision, situation.team)
            });
        }
        if is_now {
            self.plans_own_way(situation);
        }
        if self.mission.brief.sampling.is_none() {
            return;
        }
        let prior = situation.scouting.map(|scouting| scouting.prior);
        // Who plans only for robots that go from cell to cell does not know it.
        let due = situation.team.and_then(|team| team.member(team.due));
        let needs_none = due.is_some_and(|due| due.travel.is_none());
        let right = prior.map_or(needs_none, |prior| {
            prior.run == state.run
                && prior.cells.len() == self.mission.terrain.prior.len()
                && prior.cells.iter().enumerate().all(|(index, cell)| self.is_prior(index, cell))
        });
        self.require(right, "every plan is made with the prior of its own run", || {
            format!("at decision {} it is another", state.decision)
        });
        let wrong = situation.team.and_then(|team| self.wrong_route(team, situation));
        self.require(wrong.is_none(), "every plan is made with the routes that were announced", || {
            format!("at decision {} route {wrong:?} has other points", state.decision)
        });
    }

    /// A route that a robot follows and whose points are not known, or not those that have its fingerprint.
    fn wrong_route(&self, team: &Team, situation: &Situation<'_>) -> Option<contract::RouteId> {
        let routes = situation.scouting?.routes;
        let followed = team.members.iter().filter_map(|member| member.travel?.route);
        let is_right = |id: &contract::RouteId| {
            routes.get(*id).is_some_and(|route| fingerprint(route.waypoints()) == *id)
        };
        followed.into_iter().find(|id| !is_right(id))
    }
}
