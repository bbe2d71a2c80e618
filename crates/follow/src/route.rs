//! The routes that a reader needs one at a time, and keeps.

use contract::{MonotonicNs, RouteId, RoutePage, RouteRequest, Routes, RunId};

use crate::MissingRoutes;

/// The routes of one run that a reader has, and the one that it asks for.
#[derive(Clone, Debug, Default)]
pub struct RouteFollower {
    run: RunId,
    known: Routes,
    missing: MissingRoutes<()>,
}

impl RouteFollower {
    /// Begins with no route of `run`; the same run again changes nothing.
    pub fn begin(&mut self, run: RunId) {
        if self.run != run {
            *self = Self { run, ..Self::default() };
        }
    }

    /// The routes that are known.
    #[must_use]
    pub fn known(&self) -> &Routes {
        &self.known
    }

    /// Takes note that the route `id` is needed, unless it is known.
    pub fn need(&mut self, id: RouteId) {
        if self.known.get(id).is_none() {
            self.missing.need((), id);
        }
    }

    /// Takes an answer; whether it brings the route that is needed.
    pub fn page(&mut self, page: RoutePage) -> bool {
        let is_needed = page.run == self.run && !self.missing.found(page.route.id()).is_empty();
        if is_needed {
            self.known.insert(page.route);
        }
        is_needed
    }

    /// What to ask for at `now`: the route that is needed, and again if it does not come.
    pub fn ask(&mut self, now: MonotonicNs) -> Option<RouteRequest> {
        self.missing.ask(self.run, now)
    }
}

#[cfg(test)]
mod tests {
    use contract::{Route, Waypoint};

    use super::*;

    fn route(points: usize) -> Route {
        Route::new((0..points).map(|x| Waypoint { x_m: x as f64, y_m: 0.5 }).collect()).unwrap()
    }

    #[test]
    fn a_route_is_asked_for_until_it_comes_and_never_again() {
        let mut routes = RouteFollower::default();
        routes.begin(RunId(1));
        let needed = route(3);
        routes.need(needed.id());
        let request = RouteRequest { run: RunId(1), id: needed.id() };
        assert_eq!(routes.ask(MonotonicNs(5)), Some(request));
        assert_eq!(routes.ask(MonotonicNs(6)), None, "one request at a time");
        assert_eq!(routes.ask(MonotonicNs(1_000_000_000)), Some(request));
        assert!(!routes.page(RoutePage { run: RunId(2), route: needed.clone() }));
        assert!(!routes.page(RoutePage { run: RunId(1), route: route(4) }), "nobody asked for it");
        assert!(routes.page(RoutePage { run: RunId(1), route: needed.clone() }));
        routes.need(needed.id());
        assert_eq!(routes.ask(MonotonicNs(u64::MAX)), None);
        assert_eq!(routes.known().get(needed.id()), Some(&needed));
    }
}
