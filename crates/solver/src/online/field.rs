//! A world laid out on rings for the kernel.

use std::ops::Range;

use super::kernel::{Ground, Scattered};
use super::rings::{LANES, Rings, Seat};
use crate::{Hop, Kind, Leaving, Site, World, pages};

/// Class of a place that no backup may change.
const FIXED: u8 = 7;
/// Class of a block whose lanes differ.
const MIXED: u8 = 8;

/// The world as streams, a number a place.
#[derive(Clone, Debug)]
pub(super) struct Field {
    pub rings: Rings,
    /// Whether the rings lie around a goal.
    pub centred: bool,
    base: Vec<f64>,
    slope_u: Vec<f64>,
    slope_v: Vec<f64>,
    /// Soil of each place, or fixed.
    classes: Vec<u8>,
    /// Soil of each block, or mixed.
    blocks: Vec<u8>,
    soils: [Scattered; 8],
    soils_len: usize,
    pub discount: f64,
    waits: [f64; 8],
    /// Whether leaving the grid loses the hopper.
    pub loses: bool,
    /// No worth nor base exceeds this, nor ever needs to.
    pub magnitude: f64,
}

impl Field {
    /// Lays out `world`, around its first goal.
    pub fn new(world: &World) -> Self {
        let centre = (0..world.nodes()).find(|&node| world.kind(node) == Kind::Goal);
        let rings = Rings::new(world.width(), world.height(), centre.unwrap_or(0));
        let places = rings.places;
        let rules = world.rules();
        let mut soils = [Scattered::default(); 8];
        let mut waits = [0.0; 8];
        for (index, soil) in rules.soils.iter().enumerate() {
            let d = soil.discount(rules.discount);
            soils[index] = Scattered {
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
            base: pages::filled(0.0, places),
            slope_u: pages::filled(0.0, places),
            slope_v: pages::filled(0.0, places),
            classes: vec![FIXED; places],
            blocks: vec![FIXED; places / LANES],
            soils,
            soils_len: rules.soils.len(),
            discount: rules.discount,
            waits,
            loses: rules.leaving == Leaving::Loses,
            magnitude: 4.0 * world.worth_max(),
        };
        for quadrant in 0..4 {
            for level in 0..field.rings.levels {
                let Some(ring) = field.rings.ring(quadrant, level) else { continue };
                let nodes: Vec<_> = field.rings.nodes(quadrant, level).collect();
                for (node, place) in nodes {
                    field.put(quadrant, place, &world.site(node));
                }
                for block in field.rings.at(ring).blocks() {
                    field.sort(field.rings.at(ring).place(block));
                }
            }
        }
        field
    }

    /// Takes over one node of the world; `None` for the centre.
    pub fn set(&mut self, node: usize, site: &Site) -> Option<Seat> {
        let seat = self.rings.seat(node)?;
        let quadrant = self.rings.quadrant(node)?;
        self.put(quadrant, seat.place, site);
        self.sort(seat.place / LANES * LANES);
        if site.kind == Kind::Free {
            self.magnitude = self.magnitude.max(4.0 * site.payoff.abs() / (1.0 - self.discount));
        }
        Some(seat)
    }

    fn put(&mut self, quadrant: usize, place: usize, site: &Site) {
        let towards = |hop: Hop| match hop {
            Hop::East => site.slope_east,
            Hop::North => site.slope_north,
            Hop::West => -site.slope_east,
            Hop::South => -site.slope_north,
        };
        let (u, v) = Rings::axes(quadrant);
        let soil = usize::from(site.soil);
        self.classes[place] = if site.kind == Kind::Free { site.soil } else { FIXED };
        self.base[place] = site.payoff * (1.0 + self.discount * self.waits[soil]);
        self.slope_u[place] = towards(u).clamp(-1.0, 1.0);
        self.slope_v[place] = towards(v).clamp(-1.0, 1.0);
    }

    /// Finds out whether a block is of one soil.
    fn sort(&mut self, place: usize) {
        let lanes = &self.classes[place..place + LANES];
        let same = lanes.iter().all(|class| *class == lanes[0]);
        self.blocks[place / LANES] = if same { lanes[0] } else { MIXED };
    }

    /// The soils of a block's lanes.
    #[inline(always)]
    pub fn soil(&self, place: usize) -> Result<&Scattered, &[u8; LANES]> {
        let class = self.blocks[place / LANES];
        if class == MIXED {
            Err(lanes(&self.classes, place))
        } else {
            Ok(&self.soils[usize::from(class & 7)])
        }
    }

    /// The soils there are.
    #[inline(always)]
    pub fn soils(&self) -> &[Scattered] {
        &self.soils[..self.soils_len]
    }

    /// The ground of a block.
    #[inline(always)]
    pub fn ground(&self, place: usize) -> Ground<'_> {
        Ground {
            base: lanes(&self.base, place),
            slope_u: lanes(&self.slope_u, place),
            slope_v: lanes(&self.slope_v, place),
        }
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
        self.mirror_all(world, worths);
    }

    fn mirror_all(&self, world: &World, worths: &mut [f64]) {
        let loss = world.rules().loss;
        for quadrant in self.rings.quadrants() {
            for level in 0..self.rings.levels {
                let Some(ring) = self.rings.ring(quadrant, level) else { continue };
                for mirror in self.rings.mirrors(ring) {
                    worths[mirror.to] = if mirror.rim && self.loses { loss } else { worths[mirror.from] };
                }
            }
        }
    }
}

/// The lanes of a stream that begin at `place`.
#[inline(always)]
pub(super) fn lanes<T>(stream: &[T], place: usize) -> &[T; LANES] {
    stream[place..place + LANES].try_into().expect("as many lanes as there are")
}
