//! The grid world: what each node pays, how it slopes, and how hops from it scatter.
//!
//! The slope law is [`scatter`]'s. The slope forwards is clamped to [0, 1], the one sideways to [−1, 1], so two
//! numbers per node suffice: the slope towards the east and towards the north, clamped to [−1, 1].

use scatter::{FlatScatter, Scatter};

use crate::{Error, Hop, Soil, pages};

/// What a node is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// Passable ground, from which the hopper hops on.
    Free,
    /// A goal, where the process ends; its afterstate value is its payoff.
    Goal,
    /// Impassable ground, where the hopper is lost; its afterstate value is the loss.
    Lost,
}

/// What leaving the grid means.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Leaving {
    /// The hopper stays where it was.
    Stays,
    /// The hopper is lost.
    Loses,
}

/// The properties of one node.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Site {
    /// Passable, a goal or impassable.
    pub kind: Kind,
    /// Payoff r of landing on it; ignored where the hopper is lost.
    pub payoff: f64,
    /// Slope towards the east, in slope limits; beyond ±1 as ±1.
    pub slope_east: f64,
    /// Slope towards the north, in slope limits; beyond ±1 as ±1.
    pub slope_north: f64,
    /// Index of its soil in [`Rules::soils`].
    pub soil: u8,
}

/// The parameters common to all nodes.
#[derive(Clone, Debug, PartialEq)]
pub struct Rules {
    /// Discount γ of one period, in [0, 1).
    pub discount: f64,
    /// Afterstate value of being lost, in place of r + V, in units of payoff.
    pub loss: f64,
    /// What leaving the grid means.
    pub leaving: Leaving,
    /// The soils that nodes may have, 1 to [`GridWorld::SOILS_MAX`].
    pub soils: Vec<Soil>,
}

/// A grid world, its nodes row-major, southernmost row first: node = y · width + x.
#[derive(Clone, Debug, PartialEq)]
pub struct GridWorld {
    width: usize,
    height: usize,
    rules: Rules,
    payoffs: Vec<f64>,
    slopes_east: Vec<f64>,
    slopes_north: Vec<f64>,
    /// Soil index and kind of each node.
    classes: Vec<Class>,
}

/// Soil and kind in a byte.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Class(u8);

impl Default for Class {
    fn default() -> Self {
        Self::LOST
    }
}

impl Class {
    const GOAL_BIT: u8 = 0x40;
    const LOST_BIT: u8 = 0x80;
    /// A node where the hopper is lost.
    pub(crate) const LOST: Self = Self(Self::LOST_BIT);

    /// Free ground of soil 0, or of nothing yet.
    pub(crate) const NONE: Self = Self(0);

    /// The union of kinds and soils, as bits.
    #[inline(always)]
    pub(crate) fn or(self, other: Self) -> Self {
        Self(self.0 | other.0)
    }

    fn new(kind: Kind, soil: u8) -> Self {
        match kind {
            Kind::Free => Self(soil),
            Kind::Goal => Self(soil | Self::GOAL_BIT),
            Kind::Lost => Self(soil | Self::LOST_BIT),
        }
    }

    pub(crate) fn kind(self) -> Kind {
        match self.0 & (Self::GOAL_BIT | Self::LOST_BIT) {
            0 => Kind::Free,
            Self::GOAL_BIT => Kind::Goal,
            _ => Kind::Lost,
        }
    }

    /// Whether it is a goal, or a union of classes with a goal's among them.
    pub(crate) fn is_goal(self) -> bool {
        self.0 & Self::GOAL_BIT != 0
    }

    #[inline(always)]
    pub(crate) fn is_free(self) -> bool {
        self.0 < Self::GOAL_BIT
    }

    #[inline(always)]
    pub(crate) fn is_lost(self) -> bool {
        self.0 >= Self::LOST_BIT
    }

    /// Rows of a table over classes: one for free ground of each soil, and the last for all else.
    pub(crate) const ROWS: usize = GridWorld::SOILS_MAX + 1;

    /// Its row of a table over classes.
    #[inline(always)]
    pub(crate) fn row(self) -> usize {
        usize::from(self.0).min(Self::ROWS - 1)
    }

    pub(crate) fn soil(self) -> usize {
        usize::from(self.0 & !(Self::GOAL_BIT | Self::LOST_BIT))
    }
}

impl GridWorld {
    /// Most soils of a world.
    pub const SOILS_MAX: usize = 6;

    /// Most nodes of a world.
    pub const NODES_MAX: usize = 1 << 26;

    /// A world of `width` × `height` free, flat nodes of soil 0 that pay nothing.
    ///
    /// # Errors
    /// If the size, the discount, the loss or a soil is out of its range.
    pub fn new(width: usize, height: usize, rules: Rules) -> Result<Self, Error> {
        let nodes = width.checked_mul(height).filter(|nodes| (1..=Self::NODES_MAX).contains(nodes));
        let nodes = nodes.ok_or(Error::Size { width, height, nodes_max: Self::NODES_MAX })?;
        check(&rules)?;
        Ok(Self {
            width,
            height,
            rules: normalised(rules),
            payoffs: pages::filled(0.0, nodes),
            slopes_east: pages::filled(0.0, nodes),
            slopes_north: pages::filled(0.0, nodes),
            classes: vec![Class::new(Kind::Free, 0); nodes],
        })
    }

    /// Nodes per row.
    #[must_use]
    pub fn width(&self) -> usize {
        self.width
    }

    /// Rows of nodes.
    #[must_use]
    pub fn height(&self) -> usize {
        self.height
    }

    /// Number of nodes, width times height.
    #[must_use]
    pub fn nodes(&self) -> usize {
        self.payoffs.len()
    }

    /// The parameters common to all nodes, soils normalised.
    #[must_use]
    pub fn rules(&self) -> &Rules {
        &self.rules
    }

    /// Replaces [`Rules::loss`].
    ///
    /// # Errors
    /// If it is not finite.
    pub fn set_loss(&mut self, loss: f64) -> Result<(), Error> {
        if !loss.is_finite() {
            return Err(Error::Loss { got: loss });
        }
        self.rules.loss = loss;
        Ok(())
    }

    /// Replaces the properties of one node.
    ///
    /// # Panics
    /// If there is no such node or soil, or a number is not finite.
    pub fn set(&mut self, node: usize, site: Site) {
        assert!(
            usize::from(site.soil) < self.rules.soils.len(),
            "soil {} needs to be one of the rules'",
            site.soil
        );
        assert!(
            site.payoff.is_finite() && site.slope_east.is_finite() && site.slope_north.is_finite(),
            "a node needs finite numbers, got {site:?}"
        );
        self.payoffs[node] = site.payoff;
        self.slopes_east[node] = site.slope_east.clamp(-1.0, 1.0);
        self.slopes_north[node] = site.slope_north.clamp(-1.0, 1.0);
        self.classes[node] = Class::new(site.kind, site.soil);
    }

    /// The properties of one node.
    #[must_use]
    pub fn site(&self, node: usize) -> Site {
        let class = self.classes[node];
        Site {
            kind: class.kind(),
            payoff: self.payoffs[node],
            slope_east: self.slopes_east[node],
            slope_north: self.slopes_north[node],
            soil: class.soil() as u8,
        }
    }

    /// Whether a node is passable, a goal or impassable.
    #[must_use]
    pub fn kind(&self, node: usize) -> Kind {
        self.classes[node].kind()
    }

    /// Payoff r of landing on a node.
    #[must_use]
    pub fn payoff(&self, node: usize) -> f64 {
        self.payoffs[node]
    }

    /// The soil of a node, normalised.
    #[must_use]
    pub fn soil(&self, node: usize) -> &Soil {
        &self.rules.soils[self.classes[node].soil()]
    }

    /// Payoffs, slopes towards the east and the north, and classes of a row.
    pub(crate) fn row(&self, y: usize) -> (&[f64], &[f64], &[f64], &[Class]) {
        let row = y * self.width..(y + 1) * self.width;
        let Self { payoffs, slopes_east, slopes_north, classes, .. } = self;
        (&payoffs[row.clone()], &slopes_east[row.clone()], &slopes_north[row.clone()], &classes[row])
    }

    /// Payoffs and classes of all nodes.
    pub(crate) fn payoffs(&self) -> (&[f64], &[Class]) {
        (&self.payoffs, &self.classes)
    }

    /// Slopes towards the east and the north of all nodes.
    pub(crate) fn slopes(&self) -> [&[f64]; 2] {
        [&self.slopes_east, &self.slopes_north]
    }

    /// The node that `hop` from `node` aims at; `None` outside the grid.
    #[must_use]
    pub fn neighbour(&self, node: usize, hop: Hop) -> Option<usize> {
        let (x, y) = (node % self.width, node / self.width);
        match hop {
            Hop::North => (y + 1 < self.height).then(|| node + self.width),
            Hop::East => (x + 1 < self.width).then(|| node + 1),
            Hop::South => (y > 0).then(|| node - self.width),
            Hop::West => (x > 0).then(|| node - 1),
        }
    }

    /// The landings of `hop` from `node`, by the slope law.
    #[must_use]
    pub fn scatter(&self, node: usize, hop: Hop) -> Scatter {
        let Soil { intended, stuck, sideways, .. } = *self.soil(node);
        let (east, north) = (self.slopes_east[node], self.slopes_north[node]);
        let towards = |hop| match hop {
            Hop::North => north,
            Hop::East => east,
            Hop::South => -north,
            Hop::West => -east,
        };
        FlatScatter { intended, stuck, sideways }.on_slope(towards(hop), towards(hop.right()))
    }

    /// The afterstate value of landing on a node under `values`: r + V, r at a goal, the loss where lost.
    #[must_use]
    pub fn afterstate_value(&self, values: &[f64], node: usize) -> f64 {
        match self.kind(node) {
            Kind::Free => self.payoffs[node] + values[node],
            Kind::Goal => self.payoffs[node],
            Kind::Lost => self.rules.loss,
        }
    }
}

fn normalised(mut rules: Rules) -> Rules {
    for soil in &mut rules.soils {
        *soil = soil.normalised();
    }
    rules
}

fn check(rules: &Rules) -> Result<(), Error> {
    if !(0.0..1.0).contains(&rules.discount) {
        return Err(Error::Discount { got: rules.discount });
    }
    if !rules.loss.is_finite() {
        return Err(Error::Loss { got: rules.loss });
    }
    if !(1..=GridWorld::SOILS_MAX).contains(&rules.soils.len()) {
        return Err(Error::Soils { got: rules.soils.len(), soils_max: GridWorld::SOILS_MAX });
    }
    rules.soils.iter().enumerate().try_for_each(|(index, soil)| soil.check(index))
}
