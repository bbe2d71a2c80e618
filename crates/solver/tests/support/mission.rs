//! A mission over a world that the hopper discovers one disc at a time.

use solver::fixtures::SplitMix64;
use solver::{GridWorld, Hop, Kind, Site};

/// The world of a mission, and what is known of it beforehand.
#[derive(Clone, Debug)]
pub struct Mission {
    pub truth: GridWorld,
    pub unseen: GridWorld,
    pub start: usize,
    /// Radius of the disc that the hopper sees, in nodes.
    pub radius: f64,
}

/// One run of a mission; outcomes are drawn from a seed.
#[derive(Clone, Debug)]
pub struct Rollout<'a> {
    mission: &'a Mission,
    draw: SplitMix64,
    pub here: usize,
}

impl Mission {
    /// A run from the start, its outcomes drawn from `seed`.
    pub fn fly(&self, seed: u64) -> Rollout<'_> {
        Rollout { mission: self, draw: SplitMix64(seed ^ 0x5eed), here: self.start }
    }
}

impl Rollout<'_> {
    /// The nodes seen from here, and their properties.
    pub fn seen(&self) -> Vec<(usize, Site)> {
        let truth = &self.mission.truth;
        let (width, height) = (truth.width() as i64, truth.height() as i64);
        let (x0, y0) = (self.here as i64 % width, self.here as i64 / width);
        let radius = self.mission.radius;
        let reach = radius.floor() as i64;
        let mut seen = Vec::new();
        for y in (y0 - reach).max(0)..=(y0 + reach).min(height - 1) {
            for x in (x0 - reach).max(0)..=(x0 + reach).min(width - 1) {
                if (((x - x0).pow(2) + (y - y0).pow(2)) as f64).sqrt() <= radius {
                    let node = (y * width + x) as usize;
                    seen.push((node, truth.site(node)));
                }
            }
        }
        seen
    }

    /// Draws the outcome of `hop`; whether the mission goes on.
    pub fn hop(&mut self, hop: Hop) -> bool {
        let truth = &self.mission.truth;
        let scatter = truth.scatter(self.here, hop);
        let uniform = self.draw.uniform();
        let towards = if uniform < scatter.intended {
            Some(hop)
        } else if uniform < scatter.intended + scatter.stayed {
            None
        } else if uniform < scatter.intended + scatter.stayed + scatter.left {
            Some(hop.left())
        } else {
            Some(hop.right())
        };
        // Leaving the grid means staying, whatever the plan's rules say.
        self.here = towards.map_or(Some(self.here), |to| truth.neighbour(self.here, to)).unwrap_or(self.here);
        truth.kind(self.here) == Kind::Free
    }
}
