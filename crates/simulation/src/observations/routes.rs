//! Rare events around routes: which announcement is lost, what is asked for again.

use contract::{Action, Command, Incarnation, PriorPage, RouteRequest};

use crate::life::Life;
use crate::world::World;

impl World {
    /// hopper-sim receives a command whose route it has not received, though its planner has sent it.
    pub(super) fn count_lost_announcement(&mut self, life: &Life, command: &Command) {
        let Action::Announce(id) = command.action else { return };
        let is_sent = self.checker.model().routes().is_published(command.run, id);
        if is_sent && !self.route_memory.received.contains(&(life.incarnation, command.run, id)) {
            self.coverage.count("scouts", "announcement_lost");
        }
    }

    /// A process asks for a route, perhaps as an earlier life of it has done.
    pub(super) fn count_route_request(&mut self, life: &Life, request: &RouteRequest) {
        let RouteRequest { run, id } = *request;
        let first = *self.route_memory.askers.entry((life.slot, run, id)).or_insert(life.incarnation);
        if first != life.incarnation {
            self.coverage.count("scouts", "route_asked_again");
        }
    }

    /// A planner takes a page of the prior.
    pub(super) fn count_prior_page(&mut self, life: &Life, page: &PriorPage, server: Incarnation) {
        let first = self.route_memory.priors.entry(life.incarnation).or_insert((page.run, server));
        if first.0 != page.run || page.from == 0 {
            *first = (page.run, server);
        } else if first.1 != server {
            self.coverage.count("scouts", "prior_of_two_lives");
        }
    }
}
