//! `cover_frontier`: each rover drives the shortest way to the uncovered ground that is nearest to it and to no other rover.
//!
//! Ways lead over sensed free ground. The cell beside visited ground is always sensed, so the nearest uncovered cell is
//! known to be free before a rover drives there. Three rules decide:
//!
//! 1. A rover goes to uncovered cells that it is nearer to than any other rover, by length of way; the lowest number
//!    wins a tie. If there is none, it goes to the nearest of all, which moves it to where ground is left.
//! 2. Of equally near cells it takes the one with the fewest uncovered neighbours, as Warnsdorff's rule for knight's tours
//!    does: a cell that is left behind alone costs a way back.
//! 3. Of those, the one that a turn to the right leads to, then straight on, then left, as in the spiral.

use contract::Direction;

use crate::team_map::Place;
use crate::{CoverMode, Situation};

/// Memory of the search, reused between decisions.
#[derive(Clone, Debug, Default)]
pub struct Frontier {
    /// By place; empty again after each search.
    reached: Vec<Option<Reached>>,
    /// Places in the order in which they were reached.
    queue: Vec<Place>,
}

/// Whose ways a search follows.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Search {
    /// The ways of the rover that decides.
    Alone,
    /// The ways of all rovers, each to the cells that no other rover is nearer to.
    Shared,
}

/// How a place was reached first.
#[derive(Clone, Copy, Debug)]
struct Reached {
    /// Number of the nearest rover.
    robot: usize,
    /// First step of `robot` on the way; `None` where it stands.
    first: Option<Direction>,
    /// Length of the way in steps.
    steps: u32,
}

/// An uncovered cell to go to.
#[derive(Clone, Copy, Debug)]
struct Target {
    /// Length of the way in steps.
    steps: u32,
    uncovered_neighbours: u32,
    /// First step on the way.
    first: Direction,
}

impl Frontier {
    /// The next step; `None` if no way to uncovered ground is known, or another rover blocks it.
    #[must_use]
    pub fn decide(&mut self, situation: &Situation<'_>) -> Option<Direction> {
        let own = self.nearest(situation, Search::Alone)?;
        // Who is more than twice as far away is not nearer to anything that this rover reaches in so many steps.
        let rivals = situation.mode == CoverMode::Overlap && situation.others_within(2 * own.steps);
        let shared = if rivals { self.nearest(situation, Search::Shared) } else { None };
        Some(shared.unwrap_or(own).first)
    }

    fn nearest(&mut self, situation: &Situation<'_>, search: Search) -> Option<Target> {
        let map = situation.map;
        self.reached.resize(map.places(), None);
        for (robot, rover) in situation.rovers.iter().enumerate().filter(|(_, rover)| rover.stranded) {
            self.reach(map.place(rover.pose.cell), Reached { robot, first: None, steps: 0 });
        }
        // What is stranded blocks the way and leads nowhere.
        let mut next = self.queue.len();
        for (robot, rover) in situation.rovers.iter().enumerate().filter(|(_, rover)| !rover.stranded) {
            if search == Search::Shared || robot == situation.robot {
                self.reach(map.place(rover.pose.cell), Reached { robot, first: None, steps: 0 });
            }
        }
        let mut best: Option<Target> = None;
        let mut unreached = map.frontier();
        while let Some(&place) = self.queue.get(next)
            && unreached > 0
        {
            next += 1;
            let Some(reached) = self.reached[place] else { continue };
            if best.is_some_and(|best| reached.steps > best.steps) {
                break;
            }
            let uncovered = map.visits_at(place) == 0;
            unreached -= usize::from(uncovered);
            if let Some(first) = reached.first
                && uncovered
                && reached.robot == situation.robot
            {
                let uncovered_neighbours = situation.uncovered_neighbours(place);
                if best.is_none_or(|best| uncovered_neighbours < best.uncovered_neighbours) {
                    best = Some(Target { steps: reached.steps, uncovered_neighbours, first });
                }
            } else {
                self.expand(situation, place, reached);
            }
        }
        for place in self.queue.drain(..) {
            self.reached[place] = None;
        }
        best
    }

    fn reach(&mut self, place: Place, reached: Reached) {
        self.reached[place] = Some(reached);
        self.queue.push(place);
    }

    fn expand(&mut self, situation: &Situation<'_>, place: Place, reached: Reached) {
        let front = situation.rovers[reached.robot].pose.heading;
        for direction in [front.right(), front, front.left(), front.left().left()] {
            let next = situation.map.neighbour(place, direction);
            let blocked = reached.first.is_none() && situation.is_occupied(next);
            if self.reached[next].is_none() && situation.is_open(next) && !blocked {
                let first = reached.first.or(Some(direction));
                self.reach(next, Reached { first, steps: reached.steps + 1, ..reached });
            }
        }
    }
}
