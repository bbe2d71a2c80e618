//! Cells where other robots stand, as ground that nobody can enter.

use contract::{Ground, ObservedMap};

/// The observed map with some of its seen cells made impassable: what a hopper's planner is given, which knows of no other
/// robots. It follows the observed map by its changes, and is the same however it came about.
#[derive(Clone, Debug)]
pub(crate) struct ClosedMap {
    map: ObservedMap,
    /// Fingerprint of the observed map that it follows.
    observation: u64,
    /// Indices of the cells that are made impassable, in order.
    closed: Vec<usize>,
}

impl ClosedMap {
    /// The map that follows from `observed` with `closed` cells, made from `known` if that is quicker.
    pub fn of(known: Option<Self>, observed: &ObservedMap, closed: Vec<usize>) -> Self {
        let known = known.filter(|known| known.map.run == observed.run && known.map.grid == observed.grid);
        let changes = known.and_then(|known| {
            let changed = observed.changed_since(known.observation)?;
            Some((known, changed))
        });
        let (mut map, changed, before) = match changes {
            Some((known, changed)) => (known.map, changed, known.closed),
            None => (observed.clone(), &[][..], Vec::new()),
        };
        let changed = changed.iter().map(|index| *index as usize);
        for index in changed.chain(before).chain(closed.iter().copied()) {
            let Some(ground) = observed.cells()[index] else { continue };
            let passable = ground.passable && closed.binary_search(&index).is_err();
            map.learn_visited(index, Ground { passable, ..ground }, observed.visits(index));
        }
        map.set_treasures(observed.treasures());
        let ObservedMap { robot, through, digest, sequence, sensed, published, .. } = *observed;
        (map.robot, map.through, map.digest) = (robot, through, digest);
        (map.sequence, map.sensed, map.published) = (sequence, sensed, published);
        map.mark();
        Self { map, observation: observed.observation(), closed }
    }

    /// Whether it is that of these.
    pub fn is_of(&self, observed: &ObservedMap, closed: &[usize]) -> bool {
        let has_same_past = (self.map.run, self.map.through, self.map.digest)
            == (observed.run, observed.through, observed.digest);
        has_same_past && self.observation == observed.observation() && self.closed == closed
    }

    pub fn map(&self) -> &ObservedMap {
        &self.map
    }
}

#[cfg(test)]
mod tests {
    use contract::{Grid, RobotId, RunId};

    use super::*;

    #[test]
    fn a_closed_map_is_the_same_followed_and_made_anew() {
        let grid = Grid::new(4, 3, 1.0, 1).unwrap();
        let mut observed = ObservedMap::unseen(RunId(1), RobotId(0), grid);
        let mut followed: Option<ClosedMap> = None;
        for (round, closed) in [vec![], vec![1], vec![1, 5], vec![5], vec![5, 11]].into_iter().enumerate() {
            for index in 0..=2 * round + 2 {
                observed.learn(index, Ground { height_m: round as f64, ..Ground::FLAT });
            }
            observed.mark();
            let anew = ClosedMap::of(None, &observed, closed.clone());
            let then = ClosedMap::of(followed, &observed, closed.clone());
            assert_eq!(then.map, anew.map, "round {round}");
            assert_eq!(then.map.observation(), anew.map.observation(), "round {round}");
            for (index, ground) in then.map.cells().iter().enumerate() {
                let seen = observed.cells()[index];
                let expected = seen.map(|seen| Ground { passable: !closed.contains(&index), ..seen });
                assert_eq!(*ground, expected, "round {round}, cell {index}");
            }
            assert!(then.is_of(&observed, &closed) && !then.is_of(&observed, &[0]));
            followed = Some(then);
        }
    }
}
