//! The search for a goal over all possible landings.

use crate::{GridWorld, Hop, Kind};

/// A search that reuses its buffers.
#[derive(Clone, Debug, Default)]
pub struct GoalSearch {
    reached: Vec<bool>,
    open: Vec<usize>,
}

impl GoalSearch {
    /// Whether some chain of hops over free nodes leads from `node` to a goal, each landing of it with a
    /// probability above 0. Where none does, no plan can succeed, however long it is computed.
    pub fn leads_to_goal(&mut self, world: &GridWorld, node: usize) -> bool {
        self.reached.clear();
        self.reached.resize(world.nodes(), false);
        self.open.clear();
        self.open.push(node);
        self.reached[node] = true;
        while let Some(from) = self.open.pop() {
            match world.kind(from) {
                Kind::Goal => return true,
                Kind::Free => {}
                Kind::Lost => continue,
            }
            for hop in Hop::ALL {
                let scatter = world.scatter(from, hop);
                let landings =
                    [(hop, scatter.intended), (hop.left(), scatter.left), (hop.right(), scatter.right)];
                for (towards, probability) in landings {
                    if probability <= 0.0 {
                        continue;
                    }
                    let Some(to) = world.neighbour(from, towards) else { continue };
                    if !self.reached[to] {
                        self.reached[to] = true;
                        self.open.push(to);
                    }
                }
            }
        }
        false
    }
}
