//! Whether a goal can be reached, remembered from decision to decision.
//!
//! The answer is that of [`crate::Reach`]: some chain of hops over free nodes, each landing of it with a
//! probability above 0. Nodes of a chain found once are remembered; the memory is dropped when one of them
//! loses a landing. Until then a decision costs one look.

use crate::{Hop, Kind, World};

/// Nodes known to lead to a goal.
#[derive(Clone, Debug, Default)]
pub(super) struct Witness {
    /// Nodes whose stamp is the present one lead to a goal.
    leads: Vec<u32>,
    stamp: u32,
    /// Where the search came from, for nodes it has reached.
    from: Vec<u32>,
    open: Vec<u32>,
    reached: Vec<u32>,
    /// The goal searched for last.
    goal: usize,
}

/// Not reached by the search.
const UNREACHED: u32 = u32::MAX;

/// Which landings beside a node have a probability above 0; none unless it is free.
pub(super) fn landings(world: &World, node: usize) -> u8 {
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

impl Witness {
    /// Forgets everything.
    pub fn forget(&mut self) {
        self.leads.clear();
    }

    /// A node's landings and kind were others.
    pub fn changed(&mut self, node: usize, before: (Kind, u8), after: (Kind, u8)) {
        let lost = before.0 == Kind::Goal || before.1 & !after.1 != 0;
        if lost && after.0 != Kind::Goal && self.leads.get(node) == Some(&self.stamp) {
            self.forget();
        }
    }

    /// Whether `node` leads to a goal.
    pub fn leads_to_goal(&mut self, world: &World, node: usize) -> bool {
        if self.leads.len() != world.nodes() {
            self.leads.clear();
            self.leads.resize(world.nodes(), 0);
            self.stamp = 1;
        }
        if self.leads[node] == self.stamp {
            return true;
        }
        self.from.resize(world.nodes(), UNREACHED);
        self.from[node] = node as u32;
        self.open.push(node as u32);
        self.reached.push(node as u32);
        let found = self.search(world);
        if let Some(mut end) = found {
            while self.leads[end] != self.stamp {
                self.leads[end] = self.stamp;
                end = self.from[end] as usize;
            }
        }
        for node in self.reached.drain(..) {
            self.from[node as usize] = UNREACHED;
        }
        self.open.clear();
        found.is_some()
    }

    /// Depth first, towards the goal first of all: over open ground hardly more than the way itself.
    fn search(&mut self, world: &World) -> Option<usize> {
        let width = world.width();
        let goal = self.goal(world)?;
        let distance =
            |node: usize| (node % width).abs_diff(goal % width) + (node / width).abs_diff(goal / width);
        while let Some(node) = self.open.pop() {
            let node = node as usize;
            if world.kind(node) == Kind::Goal || self.leads[node] == self.stamp {
                return Some(node);
            }
            let landings = landings(world, node);
            let mut beside =
                Hop::ALL.map(|hop| world.neighbour(node, hop).filter(|_| landings & (1 << hop as u8) != 0));
            beside.sort_by_key(|to| std::cmp::Reverse(to.map_or(0, distance)));
            for to in beside.into_iter().flatten() {
                if self.from[to] == UNREACHED {
                    self.from[to] = node as u32;
                    self.open.push(to as u32);
                    self.reached.push(to as u32);
                }
            }
        }
        None
    }

    fn goal(&mut self, world: &World) -> Option<usize> {
        if self.goal >= world.nodes() || world.kind(self.goal) != Kind::Goal {
            self.goal = (0..world.nodes()).find(|&node| world.kind(node) == Kind::Goal)?;
        }
        Some(self.goal)
    }
}
