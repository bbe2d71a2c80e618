//! A world laid out on [`super::rings`] for the kernel.

use std::ops::Range;

use super::kernel::{NodeLanes, SoilCoefficients};
use super::patterns::{CLASSES, Patterns};
use super::rings::{Rings, Slot};
use crate::simd::DOUBLE_LANES as LANES;
use crate::{GridWorld, Hop, Kind, Site, pages};

/// Class of an entry that no backup may change.
const FIXED: u8 = CLASSES as u8 - 1;

/// Each soil has a class, and there is one more.
const _: () = assert!(GridWorld::SOILS_MAX < CLASSES);

/// The world's numbers, block by block.
#[derive(Clone, Debug)]
pub(super) struct Layout {
    pub rings: Rings,
    /// Whether a goal is at the centre.
    pub centred: bool,
    pub node_lanes: Vec<NodeLanes>,
    /// Soil of each entry, or [`FIXED`].
    classes: Vec<u8>,
    /// The number of each block's pattern in `patterns`.
    pub patterns_of: Vec<u32>,
    /// The patterns of soils that blocks have.
    pub patterns: Patterns,
    pub discount: f64,
    waits: [f64; CLASSES],
    /// Bound on the magnitude of every afterstate value and base. The true ones lie within it.
    pub magnitude: f64,
}

impl Layout {
    /// Lays out `world`, around its first goal.
    pub fn new(world: &GridWorld) -> Self {
        let rules = world.rules();
        let centre = (0..world.nodes()).find(|&node| world.kind(node) == Kind::Goal);
        let rings = Rings::new(world.width(), world.height(), centre.unwrap_or(0), rules.leaving);
        let entries = rings.entries;
        let mut scatters = [SoilCoefficients::STILL; CLASSES];
        let mut waits = [0.0; CLASSES];
        for (index, soil) in rules.soils.iter().enumerate() {
            let d = soil.discount(rules.discount);
            scatters[index] = SoilCoefficients {
                ahead: d * soil.intended,
                sideways: d * (0.5 * (1.0 - soil.intended - soil.stuck)),
                stuck: d * soil.stuck,
                gain: 1.0 / (1.0 - d * soil.stuck),
            };
            waits[index] = soil.wait;
        }
        let mut layout = Self {
            rings,
            centred: centre.is_some(),
            node_lanes: pages::filled(NodeLanes::default(), entries / LANES),
            classes: vec![FIXED; entries],
            patterns_of: vec![0; entries / LANES],
            patterns: Patterns::new(scatters, [FIXED; LANES], entries / LANES),
            discount: rules.discount,
            waits,
            magnitude: 4.0 * world.afterstate_max(),
        };
        for sector in layout.rings.sectors() {
            for level in 0..layout.rings.levels {
                let Some(ring) = layout.rings.ring(sector, level) else { continue };
                let nodes: Vec<_> = layout.rings.nodes(sector, level).collect();
                for (node, entry) in nodes {
                    layout.put(sector, entry, &world.site(node));
                }
                for block in layout.rings.at(ring).blocks() {
                    layout.find_pattern(layout.rings.at(ring).entry(block));
                }
            }
        }
        layout
    }

    /// Updates one node; `None` where it has no slot.
    pub fn set(&mut self, node: usize, site: &Site) -> Option<Slot> {
        let slot = self.rings.slot(node)?;
        let sector = self.rings.sector(node)?;
        self.put(sector, slot.entry, site);
        self.find_pattern(slot.entry / LANES * LANES);
        if site.kind == Kind::Free {
            self.magnitude = self.magnitude.max(4.0 * site.payoff.abs() / (1.0 - self.discount));
        }
        Some(slot)
    }

    fn put(&mut self, sector: usize, entry: usize, site: &Site) {
        let towards = |hop: Hop| match hop {
            Hop::East => site.slope_east,
            Hop::North => site.slope_north,
            Hop::West => -site.slope_east,
            Hop::South => -site.slope_north,
        };
        let (u, v) = Rings::axes(sector);
        let is_free = site.kind == Kind::Free;
        let wait = self.waits[usize::from(site.soil)];
        let (ground, lane) = (&mut self.node_lanes[entry / LANES], entry % LANES);
        self.classes[entry] = if is_free { site.soil } else { FIXED };
        ground.base[lane] = if is_free { site.payoff * (1.0 + self.discount * wait) } else { 0.0 };
        ground.slope_u[lane] = towards(u).clamp(-1.0, 1.0);
        ground.slope_v[lane] = towards(v).clamp(-1.0, 1.0);
    }

    /// Finds the pattern of the block that begins at `entry`.
    fn find_pattern(&mut self, entry: usize) {
        let mut pattern = [FIXED; LANES];
        pattern.copy_from_slice(&self.classes[entry..entry + LANES]);
        let of = &mut self.patterns_of[entry / LANES];
        *of = self.patterns.change(*of, pattern);
    }

    /// Which of the entries hold a free node.
    pub fn free(&self, entries: Range<usize>) -> impl Iterator<Item = bool> + '_ {
        self.classes[entries].iter().map(|class| *class < FIXED)
    }

    /// Fills a field, ghosts included, with the row-major `values` of `world`.
    pub fn fill(&self, world: &GridWorld, values: &[f64], afterstates: &mut Vec<f64>) {
        afterstates.clear();
        afterstates.resize(self.rings.entries, 0.0);
        let mut centre = None;
        for node in 0..world.nodes() {
            match self.rings.slot(node) {
                Some(slot) => afterstates[slot.entry] = world.afterstate_value(values, node),
                None => centre = Some(world.afterstate_value(values, node)),
            }
        }
        for entry in self.rings.centres() {
            afterstates[entry] = centre.unwrap_or(0.0);
        }
        for ghost in self.rings.all_ghosts() {
            afterstates[ghost.to] = afterstates[ghost.from];
        }
        for &entry in &self.rings.outside {
            afterstates[entry] = world.rules().loss;
        }
    }
}
