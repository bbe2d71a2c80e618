//! The grid of a world whose hops land by a table.

use super::LandingTable;
use crate::{Error, GridWorld, Hop, Kind, Leaving};

/// The parameters common to all nodes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TableRules {
    /// Discount γ of one hop, in [0, 1).
    pub discount: f64,
    /// Afterstate value of being lost, in place of r + V, in units of payoff.
    pub loss: f64,
    /// What leaving the grid means.
    pub leaving: Leaving,
}

/// The properties of one node.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TableSite {
    /// Passable, a goal or impassable.
    pub kind: Kind,
    /// Payoff r of landing on it; ignored where the hopper is lost.
    pub payoff: f64,
    /// Row of the table for each hop from it, in the order of [`Hop::ALL`].
    pub classes: [u16; 4],
}

/// A grid world, its nodes row-major, southernmost row first: node = y · width + x.
#[derive(Clone, Debug, PartialEq)]
pub struct TableWorld {
    width: usize,
    height: usize,
    rules: TableRules,
    table: LandingTable,
    kinds: Vec<Kind>,
    payoffs: Vec<f64>,
    classes: Vec<[u16; 4]>,
}

impl TableWorld {
    /// A world of `width` × `height` free nodes of class 0 that pay nothing.
    ///
    /// # Errors
    /// If the size, the discount or the loss is out of its range.
    pub fn new(width: usize, height: usize, rules: TableRules, table: LandingTable) -> Result<Self, Error> {
        let nodes_max = GridWorld::NODES_MAX;
        let nodes = width.checked_mul(height).filter(|nodes| (1..=nodes_max).contains(nodes));
        let nodes = nodes.ok_or(Error::Size { width, height, nodes_max })?;
        if !(0.0..1.0).contains(&rules.discount) {
            return Err(Error::Discount { got: rules.discount });
        }
        if !rules.loss.is_finite() {
            return Err(Error::Loss { got: rules.loss });
        }
        Ok(Self {
            width,
            height,
            rules,
            table,
            kinds: vec![Kind::Free; nodes],
            payoffs: vec![0.0; nodes],
            classes: vec![[0; 4]; nodes],
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
        self.kinds.len()
    }

    /// The parameters common to all nodes.
    #[must_use]
    pub fn rules(&self) -> &TableRules {
        &self.rules
    }

    /// Where hops land.
    #[must_use]
    pub fn table(&self) -> &LandingTable {
        &self.table
    }

    /// Replaces the properties of one node.
    ///
    /// # Panics
    /// If there is no such node or class, or the payoff is not finite.
    pub fn set(&mut self, node: usize, site: TableSite) {
        let rows = self.table.rows().len();
        assert!(
            site.classes.iter().all(|class| usize::from(*class) < rows),
            "classes {:?} need to be rows of the table, which has {rows}",
            site.classes
        );
        assert!(site.payoff.is_finite(), "a node needs a finite payoff, got {}", site.payoff);
        self.kinds[node] = site.kind;
        self.payoffs[node] = site.payoff;
        self.classes[node] = site.classes;
    }

    /// Whether a node is passable, a goal or impassable.
    #[must_use]
    pub fn kind(&self, node: usize) -> Kind {
        self.kinds[node]
    }

    /// Payoff r of landing on a node.
    #[must_use]
    pub fn payoff(&self, node: usize) -> f64 {
        self.payoffs[node]
    }

    /// Row of the table for each hop from a node, in the order of [`Hop::ALL`].
    #[must_use]
    pub fn classes(&self, node: usize) -> [u16; 4] {
        self.classes[node]
    }

    /// The node `forward` hops ahead of `node` and `left` hops to the left of `hop`; `None` outside the grid.
    #[must_use]
    pub fn landing(&self, node: usize, hop: Hop, forward: i8, left: i8) -> Option<usize> {
        self.landing_from([node % self.width, node / self.width], hop, forward, left)
    }

    /// [`Self::landing`] from the node in that column and row.
    #[inline]
    pub(super) fn landing_from(&self, [x, y]: [usize; 2], hop: Hop, forward: i8, left: i8) -> Option<usize> {
        let [east, north] = offset(hop, forward, left);
        let (x, y) = (x.checked_add_signed(east)?, y.checked_add_signed(north)?);
        if x < self.width && y < self.height { Some(y * self.width + x) } else { None }
    }

    /// The afterstate value of landing on a node under `values`: r + V, r at a goal, the loss where lost.
    #[must_use]
    pub fn afterstate_value(&self, values: &[f64], node: usize) -> f64 {
        match self.kinds[node] {
            Kind::Free => self.payoffs[node] + values[node],
            Kind::Goal => self.payoffs[node],
            Kind::Lost => self.rules.loss,
        }
    }
}

/// A landing in the frame of the grid: nodes to the east and to the north.
pub(super) fn offset(hop: Hop, forward: i8, left: i8) -> [isize; 2] {
    let (forward, left) = (isize::from(forward), isize::from(left));
    match hop {
        Hop::North => [-left, forward],
        Hop::East => [forward, left],
        Hop::South => [left, -forward],
        Hop::West => [-forward, -left],
    }
}
