//! `cover_frontier`: the shortest way to the nearest uncovered ground.

use std::collections::VecDeque;

use contract::Direction;

use crate::Situation;
use crate::team_map::Place;

/// Memory of the search, reused between decisions.
#[derive(Clone, Debug, Default)]
pub struct Frontier {
    first: Vec<Option<Direction>>,
    queue: VecDeque<Place>,
}

impl Frontier {
    /// The next step; `None` if no uncovered ground is known to be reachable.
    #[must_use]
    pub fn decide(&mut self, situation: &Situation<'_>) -> Option<Direction> {
        let map = situation.map;
        self.first.clear();
        self.first.resize(map.places(), None);
        self.queue.clear();
        let here = map.place(situation.own().pose.cell);
        for direction in Direction::ALL {
            let place = map.neighbour(here, direction);
            if situation.is_open(place) && !situation.is_occupied(place) {
                self.first[place] = Some(direction);
                self.queue.push_back(place);
            }
        }
        while let Some(place) = self.queue.pop_front() {
            if map.visits_at(place) == 0 {
                return self.first[place];
            }
            for direction in Direction::ALL {
                let next = map.neighbour(place, direction);
                if self.first[next].is_none() && next != here && situation.is_open(next) {
                    self.first[next] = self.first[place];
                    self.queue.push_back(next);
                }
            }
        }
        None
    }
}
