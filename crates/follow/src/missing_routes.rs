//! Routes that were announced, and whose points are asked for until they come.

use std::collections::BTreeMap;

use contract::{MonotonicNs, RouteId, RouteRequest, RunId};

use crate::page_cursor::OneByOne;

/// Routes whose points are missing, by what needs them: a decision, a robot. The first one is asked for first.
#[derive(Clone, Debug)]
pub struct MissingRoutes<K> {
    needed: BTreeMap<K, RouteId>,
    asked: OneByOne<RouteId>,
}

impl<K> Default for MissingRoutes<K> {
    fn default() -> Self {
        Self { needed: BTreeMap::new(), asked: OneByOne::default() }
    }
}

impl<K: Copy + Ord> MissingRoutes<K> {
    /// Notes that `by` needs the points of `route`, instead of any that it has needed.
    pub fn need(&mut self, by: K, route: RouteId) {
        self.needed.insert(by, route);
    }

    /// Takes note that the points of `route` are there; who has needed them.
    pub fn found(&mut self, route: RouteId) -> Vec<K> {
        self.found_by(route, |_| true)
    }

    /// As [`MissingRoutes::found`], where only those whom `has` names have the points.
    pub fn found_by(&mut self, route: RouteId, has: impl Fn(&K) -> bool) -> Vec<K> {
        let found = self.needed.extract_if(.., |by, missing| *missing == route && has(by));
        found.map(|(by, _)| by).collect()
    }

    /// Whether no route is missing.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.needed.is_empty()
    }

    /// Needs no route any more.
    pub fn clear(&mut self) {
        self.needed.clear();
    }

    /// What to ask for at `now`: the first route that is missing, and again if it does not come.
    pub fn ask(&mut self, run: RunId, now: MonotonicNs) -> Option<RouteRequest> {
        let first = *self.needed.first_key_value()?.1;
        let id = self.asked.ask(first, now)?;
        Some(RouteRequest { run, id })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_first_route_that_is_missing_is_asked_for_until_it_comes_and_then_the_next() {
        let (run, one, two) = (RunId(1), RouteId(11), RouteId(22));
        let asks = |id| Some(RouteRequest { run, id });
        let mut missing = MissingRoutes::default();
        assert_eq!(missing.ask(run, MonotonicNs(1)), None);
        missing.need(5, one);
        missing.need(7, two);
        missing.need(9, one);
        assert_eq!(missing.ask(run, MonotonicNs(2)), asks(one));
        assert_eq!(missing.ask(run, MonotonicNs(3)), None, "one request at a time");
        assert_eq!(missing.ask(run, MonotonicNs(1_000_000_000)), asks(one));
        assert_eq!(missing.found(one), [5, 9]);
        assert_eq!(missing.found(one), []);
        assert_eq!(missing.ask(run, MonotonicNs(1_000_000_001)), asks(two), "another need not wait");
        assert!(!missing.is_empty());
        missing.clear();
        assert!(missing.is_empty() && missing.ask(run, MonotonicNs(u64::MAX)).is_none());
    }
}
