//! What planners are given of state and robots.

use std::collections::BTreeSet;

use contract::{RouteId, Routes, State, Team};

/// What planners are given of state and robots: what follows from the past that the digest names.
#[derive(Clone, Debug, Default)]
pub(super) struct Given {
    pub state: Option<State>,
    pub team: Option<Team>,
    /// The routes that robots of that team follow, as far as they are known. Which others are known depends on the life of this
    /// process.
    pub routes: Routes,
    /// Which these are.
    followed: BTreeSet<RouteId>,
}

impl Given {
    /// Gives the routes that robots follow, as far as they are `known`.
    pub fn give_routes(&mut self, known: &Routes) {
        let members = self.team.iter().flat_map(|team| team.members.iter());
        let followed = members.filter_map(|member| member.travel?.route);
        let followed: BTreeSet<RouteId> = followed.filter(|id| known.get(*id).is_some()).collect();
        if followed == self.followed {
            return;
        }
        let mut routes = Routes::default();
        followed.iter().filter_map(|id| known.get(*id)).for_each(|route| routes.insert(route.clone()));
        (self.routes, self.followed) = (routes, followed);
    }
}
