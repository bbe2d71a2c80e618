//! Whether a goal can be reached, remembered from decision to decision.
//!
//! The answer is that of [`crate::GoalSearch`]: is there a chain of hops over free nodes, each landing with a
//! probability above 0? Each node of a chain found is remembered with its next landing and its rank, one more than that
//! of the next node. When a node loses that landing, it and all nodes of a higher rank become uncertain, whatever chain
//! they belong to, because only these can lead through it. Chains found later belong to a new generation, and the
//! limit of certain ranks is kept by generation. So a decision costs one lookup, or a search as far as the nearest
//! certain node.

use crate::{GridWorld, Hop, Kind};

/// The nodes known to lead to a goal.
#[derive(Clone, Debug, Default)]
pub(super) struct GoalReachability {
    links: Vec<Link>,
    /// Highest certain rank of each generation; no node belongs to the first.
    limits: Vec<u32>,
    /// For nodes that the search has reached, the node it came from.
    from: Vec<u32>,
    open: Vec<u32>,
    reached: Vec<u32>,
    /// The goal searched for last.
    goal: usize,
}

/// A node of a remembered chain.
#[derive(Clone, Copy, Debug, Default)]
struct Link {
    /// Hops to the goal along the chain, and in the two lowest bits the landing of the first hop.
    rank_and_landing: u32,
    generation: u32,
}

impl Link {
    fn rank(self) -> u32 {
        self.rank_and_landing / 4
    }

    fn landing(self) -> u8 {
        1 << (self.rank_and_landing % 4)
    }
}

/// Generations after which everything is forgotten.
const GENERATIONS_MAX: usize = 1 << 12;

/// Not reached by the search.
const UNREACHED: u32 = u32::MAX;

/// Which landings beside a node have a probability above 0; none unless it is free.
fn landings(world: &GridWorld, node: usize) -> u8 {
    if world.kind(node) != Kind::Free {
        return 0;
    }
    Hop::ALL.into_iter().fold(0, |landings, hop| {
        let scatter = world.scatter(node, hop);
        let bit = |hop: Hop, probability: f64| u8::from(probability > 0.0) << hop as u8;
        landings
            | bit(hop, scatter.intended)
            | bit(hop.left(), scatter.left)
            | bit(hop.right(), scatter.right)
    })
}

impl GoalReachability {
    /// Forgets all chains.
    pub fn forget(&mut self) {
        self.links.clear();
    }

    /// Takes in that a node has changed; `before` is the kind it was.
    pub fn changed(&mut self, world: &GridWorld, node: usize, before: Kind) {
        if before == Kind::Goal {
            self.forget();
        } else if world.kind(node) != Kind::Goal && self.leads(node) {
            let link = self.links[node];
            if landings(world, node) & link.landing() == 0 {
                for limit in &mut self.limits {
                    *limit = (*limit).min(link.rank() - 1);
                }
                self.limits.push(u32::MAX);
                if self.limits.len() > GENERATIONS_MAX {
                    self.forget();
                }
            }
        }
    }

    fn leads(&self, node: usize) -> bool {
        self.links
            .get(node)
            .is_some_and(|link| link.generation > 0 && link.rank() <= self.limits[link.generation as usize])
    }

    /// Whether a chain of hops leads from `node` to a goal.
    pub fn leads_to_goal(&mut self, world: &GridWorld, node: usize) -> bool {
        if self.links.len() != world.nodes() {
            self.links.clear();
            self.links.resize(world.nodes(), Link::default());
            self.from.clear();
            self.from.resize(world.nodes(), UNREACHED);
            self.limits = vec![0, u32::MAX];
        }
        if self.leads(node) {
            return true;
        }
        self.from[node] = node as u32;
        self.open.push(node as u32);
        self.reached.push(node as u32);
        let found = self.search(world);
        if let Some(end) = found {
            self.remember(world, end, node);
        }
        for node in self.reached.drain(..) {
            self.from[node as usize] = UNREACHED;
        }
        self.open.clear();
        found.is_some()
    }

    /// Remembers the chain just found, from `start` to `end`.
    fn remember(&mut self, world: &GridWorld, end: usize, start: usize) {
        let mut rank = if world.kind(end) == Kind::Goal { 0 } else { self.links[end].rank() };
        let mut next = end;
        while next != start {
            let node = self.from[next] as usize;
            let towards = |hop: &Hop| world.neighbour(node, *hop) == Some(next);
            let landing =
                Hop::ALL.into_iter().find(towards).expect("a chain goes from neighbour to neighbour");
            rank += 1;
            let generation = self.limits.len() as u32 - 1;
            self.links[node] = Link { rank_and_landing: 4 * rank + landing as u32, generation };
            next = node;
        }
    }

    /// Searches depth first, hops towards the goal first: over open ground it reaches little more than the way itself.
    fn search(&mut self, world: &GridWorld) -> Option<usize> {
        let width = world.width();
        let goal = self.goal(world)?;
        let distance =
            |node: usize| (node % width).abs_diff(goal % width) + (node / width).abs_diff(goal / width);
        while let Some(node) = self.open.pop() {
            let node = node as usize;
            if world.kind(node) == Kind::Goal || self.leads(node) {
                return Some(node);
            }
            let landings = landings(world, node);
            let mut beside = Hop::ALL.map(|hop| {
                let lands = landings & (1 << hop as u8) != 0;
                if lands { world.neighbour(node, hop) } else { None }
            });
            beside.sort_by_key(|to| std::cmp::Reverse(to.map_or(0, distance)));
            for to in beside.into_iter().flatten() {
                if self.from[to] == UNREACHED {
                    self.from[to] = node as u32;
                    // Otherwise a way found from one row further would run alongside the one before.
                    if self.leads(to) {
                        self.reached.push(to as u32);
                        return Some(to);
                    }
                    self.open.push(to as u32);
                    self.reached.push(to as u32);
                }
            }
        }
        None
    }

    fn goal(&mut self, world: &GridWorld) -> Option<usize> {
        if self.goal >= world.nodes() || world.kind(self.goal) != Kind::Goal {
            self.goal = (0..world.nodes()).find(|&node| world.kind(node) == Kind::Goal)?;
        }
        Some(self.goal)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::GoalSearch;
    use crate::fixtures::{DISCOUNT, HARD, SplitMix64};
    use crate::{Leaving, Rules, Site};

    #[test]
    fn what_is_remembered_never_differs_from_a_search_from_nothing() {
        for seed in 0..30 {
            let mut draw = SplitMix64(seed);
            let (width, height) = (4 + seed as usize % 7, 9);
            let rules =
                Rules { discount: DISCOUNT, loss: -500.0, leaving: Leaving::Stays, soils: vec![HARD] };
            let mut world = GridWorld::new(width, height, rules).expect("a world in range");
            let mut reachability = GoalReachability::default();
            let mut lost = 0;
            for _ in 0..400 {
                let mut pick = |below: usize| (draw.uniform() * below as f64) as usize;
                let node = pick(world.nodes());
                let kind = match pick(60) {
                    0 => Kind::Goal,
                    1..=20 => Kind::Lost,
                    _ => Kind::Free,
                };
                let slope = [0.0, 1.0, -1.0, 0.3][pick(4)];
                let before = world.kind(node);
                let flat = Site { kind, payoff: 0.0, slope_east: slope, slope_north: 0.0, soil: 0 };
                world.set(node, flat);
                reachability.changed(&world, node, before);
                for _ in 0..3 {
                    let here = pick(world.nodes());
                    let leads = GoalSearch::default().leads_to_goal(&world, here);
                    if world.kind(here) == Kind::Free {
                        assert_eq!(reachability.leads_to_goal(&world, here), leads, "seed {seed}");
                        lost += u32::from(!leads);
                    }
                }
            }
            assert!(lost > 0);
        }
    }
}
