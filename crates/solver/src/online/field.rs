//! A world laid out on rings for the kernel.

use std::ops::Range;

use super::kernel::{Ground, Scattered};
use super::patterns::{CLASSES, Patterns};
use super::rings::{LANES, Rings, Seat};
use crate::{Hop, Kind, Site, World, pages};

/// Class of a place that no backup may change.
const FIXED: u8 = 7;

/// The world as streams, a number a place.
#[derive(Clone, Debug)]
pub(super) struct Field {
    pub rings: Rings,
    /// Whether the rings lie around a goal.
    pub centred: bool,
    pub grounds: Vec<Ground>,
    /// Soil of each place, or fixed.
    classes: Vec<u8>,
    /// Which of `patterns` each block has.
    pub patterns_of: Vec<u32>,
    /// The soils of blocks.
    pub patterns: Patterns,
    pub discount: f64,
    waits: [f64; 8],
    /// No worth nor base exceeds this, nor ever needs to.
    pub magnitude: f64,
}

impl Field {
    /// Lays out `world`, around its first goal.
    pub fn new(world: &World) -> Self {
        let rules = world.rules();
        let centre = (0..world.nodes()).find(|&node| world.kind(node) == Kind::Goal);
        let rings = Rings::new(world.width(), world.height(), centre.unwrap_or(0), rules.leaving);
        let places = rings.places;
        let mut scatters = [Scattered::STILL; CLASSES];
        let mut waits = [0.0; 8];
        for (index, soil) in rules.soils.iter().enumerate() {
            let d = soil.discount(rules.discount);
            scatters[index] = Scattered {
                ahead: d * soil.intended,
                sideways: d * (0.5 * (1.0 - soil.intended - soil.stuck)),
                stuck: d * soil.stuck,
                gain: 1.0 / (1.0 - d * soil.stuck),
            };
            waits[index] = soil.wait;
        }
        let mut field = Self {
            rings,
            centred: centre.is_some(),
            grounds: pages::filled(Ground::default(), places / LANES),
            classes: vec![FIXED; places],
            patterns_of: vec![0; places / LANES],
            patterns: Patterns::new(scatters, [FIXED; LANES], places / LANES),
            discount: rules.discount,
            waits,
            magnitude: 4.0 * world.worth_max(),
        };
        for sector in field.rings.sectors() {
            for level in 0..field.rings.levels {
                let Some(ring) = field.rings.ring(sector, level) else { continue };
                let nodes: Vec<_> = field.rings.nodes(sector, level).collect();
                for (node, place) in nodes {
                    field.put(sector, place, &world.site(node));
                }
                for block in field.rings.at(ring).blocks() {
                    field.sort(field.rings.at(ring).place(block));
                }
            }
        }
        field
    }

    /// Takes over one node of the world; `None` where it has no seat.
    pub fn set(&mut self, node: usize, site: &Site) -> Option<Seat> {
        let seat = self.rings.seat(node)?;
        let sector = self.rings.sector(node)?;
        self.put(sector, seat.place, site);
        self.sort(seat.place / LANES * LANES);
        if site.kind == Kind::Free {
            self.magnitude = self.magnitude.max(4.0 * site.payoff.abs() / (1.0 - self.discount));
        }
        Some(seat)
    }

    fn put(&mut self, sector: usize, place: usize, site: &Site) {
        let towards = |hop: Hop| match hop {
            Hop::East => site.slope_east,
            Hop::North => site.slope_north,
            Hop::West => -site.slope_east,
            Hop::South => -site.slope_north,
        };
        let (u, v) = Rings::axes(sector);
        let is_free = site.kind == Kind::Free;
        let wait = self.waits[usize::from(site.soil)];
        let (ground, lane) = (&mut self.grounds[place / LANES], place % LANES);
        self.classes[place] = if is_free { site.soil } else { FIXED };
        ground.base[lane] = if is_free { site.payoff * (1.0 + self.discount * wait) } else { 0.0 };
        ground.slope_u[lane] = towards(u).clamp(-1.0, 1.0);
        ground.slope_v[lane] = towards(v).clamp(-1.0, 1.0);
    }

    /// Finds the soils of the block that begins at `place`.
    fn sort(&mut self, place: usize) {
        let mut pattern = [FIXED; LANES];
        pattern.copy_from_slice(&self.classes[place..place + LANES]);
        let of = &mut self.patterns_of[place / LANES];
        *of = self.patterns.change(*of, pattern);
    }

    /// Which of the places hold a free node.
    pub fn free(&self, places: Range<usize>) -> impl Iterator<Item = bool> + '_ {
        self.classes[places].iter().map(|class| *class < FIXED)
    }

    /// Worths from values of the row-major `world`, mirrors included.
    pub fn worths(&self, world: &World, values: &[f64], worths: &mut Vec<f64>) {
        worths.clear();
        worths.resize(self.rings.places, 0.0);
        let mut centre = None;
        for node in 0..world.nodes() {
            match self.rings.seat(node) {
                Some(seat) => worths[seat.place] = world.worth(values, node),
                None => centre = Some(world.worth(values, node)),
            }
        }
        for place in self.rings.centres() {
            worths[place] = centre.unwrap_or(0.0);
        }
        for mirror in self.rings.all_mirrors() {
            worths[mirror.to] = worths[mirror.from];
        }
        for &place in &self.rings.beyond {
            worths[place] = world.rules().loss;
        }
    }
}
