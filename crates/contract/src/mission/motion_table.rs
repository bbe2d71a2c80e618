//! Where hops end by soil and slope, as planners believe it in place of the four branches, and how that travels.
//!
//! A row is a class: soil of departure, slope along the hop and slope across it, in bins of 2.5° up to ±30°. Hopper-sim serves the rows
//! in pages, and the brief has the fingerprint of them all ([`crate::MotionParameters::table`]), so a planner knows whether it holds the
//! table that it is to believe.

use serde::{Deserialize, Serialize};
use sha2::{Digest as _, Sha256};

use crate::{Refusal, RunId, Soil};

/// A landing in the frame of the hop.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct TableLanding {
    /// Hops forward, −[`MotionRow::REACH`] to [`MotionRow::REACH`].
    pub forward: i8,
    /// Hops to the left, −[`MotionRow::REACH`] to [`MotionRow::REACH`].
    pub left: i8,
    /// Probability of it, 0 to 1.
    pub probability: f64,
}

/// The landings of one class. What they leave of 1 is the probability of being lost, as of a body that rolls away.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
#[serde(into = "Vec<TableLanding>")]
pub struct MotionRow {
    pub(crate) count: usize,
    pub(crate) landings: [TableLanding; MotionRow::LANDINGS_MAX],
}

impl MotionRow {
    /// Most landings of a class.
    pub const LANDINGS_MAX: usize = 13;

    /// Farthest landing along an axis, hops.
    pub const REACH: i8 = 8;

    /// How far probabilities may add up to more than 1.
    pub const SUM_TOLERANCE: f64 = 1e-9;

    /// The row of these landings.
    ///
    /// # Errors
    /// If there are too many, one is out of reach or has a probability that is none, or they add up to more than 1.
    pub fn new(landings: &[TableLanding]) -> Result<Self, Refusal> {
        if landings.len() > Self::LANDINGS_MAX {
            let need = format!("at most {}", Self::LANDINGS_MAX);
            return Err(Refusal::malformed("table.landings", &need, landings.len()));
        }
        let mut row = Self { count: landings.len(), ..Self::default() };
        row.landings[..landings.len()].copy_from_slice(landings);
        for TableLanding { forward, left, probability } in landings {
            let reach = Self::REACH;
            if [forward, left].iter().any(|hops| !(-reach..=reach).contains(*hops)) {
                let need = format!("−{reach} to {reach} hops");
                return Err(Refusal::malformed("table.offset", &need, format!("({forward}, {left})")));
            }
            if !(0.0..=1.0).contains(probability) {
                return Err(Refusal::malformed("table.probability", "0 to 1", probability));
            }
        }
        let sum: f64 = landings.iter().map(|landing| landing.probability).sum();
        if sum > 1.0 + Self::SUM_TOLERANCE {
            return Err(Refusal::malformed("table.sum", "at most 1 over the landings of a class", sum));
        }
        Ok(row)
    }

    /// Its landings, at most [`Self::LANDINGS_MAX`].
    #[must_use]
    pub fn landings(&self) -> &[TableLanding] {
        &self.landings[..self.count]
    }

    /// Its landings and the unused places behind them, which are 0: as many for each row.
    #[must_use]
    pub fn all(&self) -> &[TableLanding] {
        &self.landings
    }
}

impl From<MotionRow> for Vec<TableLanding> {
    fn from(row: MotionRow) -> Self {
        row.landings().to_vec()
    }
}

/// The rows of all classes.
#[derive(Clone, Debug, PartialEq)]
pub struct MotionTable {
    rows: Vec<MotionRow>,
    fingerprint: u64,
}

impl MotionTable {
    /// Distance between the slopes of two classes, degrees.
    pub const BIN_DEG: f64 = 2.5;

    /// Classes to each side of level ground: up to 30°.
    pub const BINS: i32 = 12;

    /// Slopes along one axis.
    const SIDE: usize = 2 * Self::BINS as usize + 1;

    /// Classes: two soils, slopes along, and slopes across.
    pub const ROWS: usize = Soil::ALL.len() * Self::SIDE * Self::SIDE;

    /// Largest fingerprint: a double holds it exactly.
    pub const FINGERPRINT_MAX: u64 = (1 << 53) - 1;

    /// The table of these rows, in the order of [`Self::index`]; `None` unless there are [`Self::ROWS`].
    #[must_use]
    pub fn new(rows: Vec<MotionRow>) -> Option<Self> {
        if rows.len() != Self::ROWS {
            return None;
        }
        let fingerprint = fingerprint(&rows);
        Some(Self { rows, fingerprint })
    }

    /// The rows, by class.
    #[must_use]
    pub fn rows(&self) -> &[MotionRow] {
        &self.rows
    }

    /// What the brief says of it: 1 to [`Self::FINGERPRINT_MAX`], from SHA-256 over the landings.
    #[must_use]
    pub fn fingerprint(&self) -> u64 {
        self.fingerprint
    }

    /// The class of hops from `soil`, by its slopes in bins, −[`Self::BINS`] to [`Self::BINS`], rising ahead and to the left; steeper
    /// ones are of the steepest class.
    #[must_use]
    pub fn index(soil: Soil, along: i32, across: i32) -> usize {
        let place = |bin: i32| (bin.clamp(-Self::BINS, Self::BINS) + Self::BINS) as usize;
        (soil as usize * Self::SIDE + place(along)) * Self::SIDE + place(across)
    }

    /// The soil of a class, an index below [`Self::ROWS`].
    #[must_use]
    pub fn soil_of(class: usize) -> Soil {
        Soil::ALL[class / (Self::SIDE * Self::SIDE)]
    }
}

fn fingerprint(rows: &[MotionRow]) -> u64 {
    let mut hasher = Sha256::new();
    hasher.update(b"hopper motion table v1");
    for row in rows {
        hasher.update([row.count as u8]);
        for TableLanding { forward, left, probability } in row.landings() {
            hasher.update([forward.cast_unsigned(), left.cast_unsigned()]);
            hasher.update(probability.to_bits().to_le_bytes());
        }
    }
    let hash: [u8; 32] = hasher.finalize().into();
    let bits = u64::from_le_bytes(std::array::from_fn(|index| hash[index]));
    (bits & MotionTable::FINGERPRINT_MAX).max(1)
}

/// Asks hopper-sim for the motion table from a class on.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct TableRequest {
    /// Run it belongs to; whoever follows another run refuses it.
    pub run: RunId,
    /// First class wanted.
    pub from: u32,
}

/// Consecutive rows of the motion table, at most [`crate::limits::TABLE_PAGE_ROWS`].
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct TablePage {
    /// Run it belongs to; whoever follows another run refuses it.
    pub run: RunId,
    /// Class of the first row.
    pub from: u32,
    /// In the order of classes.
    pub rows: Vec<MotionRow>,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_class_has_a_row_of_its_own_and_steeper_slopes_the_last() {
        let mut indices: Vec<usize> = Vec::new();
        for soil in Soil::ALL {
            for along in -MotionTable::BINS..=MotionTable::BINS {
                for across in -MotionTable::BINS..=MotionTable::BINS {
                    indices.push(MotionTable::index(soil, along, across));
                }
            }
        }
        assert_eq!(indices, (0..MotionTable::ROWS).collect::<Vec<_>>());
        for soil in Soil::ALL {
            for bin in [-MotionTable::BINS, MotionTable::BINS] {
                assert_eq!(MotionTable::soil_of(MotionTable::index(soil, bin, bin)), soil);
            }
        }
        assert_eq!(MotionTable::index(Soil::Sand, 40, -40), MotionTable::index(Soil::Sand, 12, -12));
    }

    #[test]
    fn a_table_is_known_by_what_its_rows_say() {
        let sure = MotionRow::new(&[TableLanding { forward: 1, left: 0, probability: 1.0 }]).unwrap();
        let table = |rows| MotionTable::new(rows).unwrap();
        let rows = vec![sure; MotionTable::ROWS];
        let same = table(rows.clone());
        assert_eq!(table(rows.clone()).fingerprint(), same.fingerprint());
        let mut others = rows.clone();
        others[7] = MotionRow::default();
        assert_ne!(table(others).fingerprint(), same.fingerprint());
        assert!((1..=MotionTable::FINGERPRINT_MAX).contains(&same.fingerprint()));
        assert_eq!(MotionTable::new(rows[1..].to_vec()), None);
    }
}
