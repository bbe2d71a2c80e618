//! Where hops of a class land, in the frame of the hop.

use crate::Error;

/// A landing: whole hops forward and to the left of the node of departure.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Landing {
    /// Hops forward, −[`LandingTable::REACH`] to [`LandingTable::REACH`].
    pub forward: i8,
    /// Hops to the left, −[`LandingTable::REACH`] to [`LandingTable::REACH`].
    pub left: i8,
    /// Probability of it, in [0, 1].
    pub probability: f64,
}

/// The landings of one class; what is left to 1 is lost, as of a body that rolls away.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Row {
    /// At most [`LandingTable::LANDINGS_MAX`].
    pub landings: Vec<Landing>,
    /// Whether a hop takes two periods, the first of which is spent at the departure and pays for it.
    pub waits: bool,
}

/// The rows of all classes.
#[derive(Clone, Debug, PartialEq)]
pub struct LandingTable {
    rows: Vec<Row>,
}

impl LandingTable {
    /// Most landings of a row.
    pub const LANDINGS_MAX: usize = 13;

    /// Farthest landing along an axis, hops.
    pub const REACH: i8 = 8;

    /// Most classes.
    pub const ROWS_MAX: usize = 1 << 14;

    /// How far the probabilities of a row may add up to more than 1.
    const SUM_TOLERANCE: f64 = 1e-9;

    /// A table of these rows.
    ///
    /// # Errors
    /// If there is no row or there are too many, or a row has too many landings, one out of reach, or probabilities that are none or
    /// add up to more than 1.
    pub fn new(rows: Vec<Row>) -> Result<Self, Error> {
        if !(1..=Self::ROWS_MAX).contains(&rows.len()) {
            return Err(Error::Rows { got: rows.len(), rows_max: Self::ROWS_MAX });
        }
        for (row, Row { landings, .. }) in rows.iter().enumerate() {
            if landings.len() > Self::LANDINGS_MAX {
                return Err(Error::Landings { row, got: landings.len(), landings_max: Self::LANDINGS_MAX });
            }
            for landing in landings {
                let within = |hops: i8| hops.unsigned_abs() <= Self::REACH.unsigned_abs();
                let is_sound = within(landing.forward)
                    && within(landing.left)
                    && (0.0..=1.0).contains(&landing.probability);
                if !is_sound {
                    let Landing { forward, left, probability } = *landing;
                    return Err(Error::Landing { row, forward, left, probability, reach: Self::REACH });
                }
            }
            let sum: f64 = landings.iter().map(|landing| landing.probability).sum();
            if sum > 1.0 + Self::SUM_TOLERANCE {
                return Err(Error::Sum { row, got: sum });
            }
        }
        Ok(Self { rows })
    }

    /// The rows, by class.
    #[must_use]
    pub fn rows(&self) -> &[Row] {
        &self.rows
    }
}

impl Row {
    /// Probability of being lost, whatever the ground.
    #[must_use]
    pub fn lost(&self) -> f64 {
        let sum: f64 = self.landings.iter().map(|landing| landing.probability).sum();
        (1.0 - sum).max(0.0)
    }
}
