//! What a motion model tells of an action beyond its outcome.

use std::fmt;

use serde::{Deserialize, Serialize};
use sha2::{Digest as _, Sha256};

use crate::motion_model::{FIGURES, MotionModel};
use crate::{Decision, RunId};

/// SHA-256 over the exact bits of a [`Detail`]; zero for none. Records name their detail by it.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Default, Serialize, Deserialize)]
pub struct DetailId(pub [u8; 32]);

impl DetailId {
    /// That of no detail.
    pub const NONE: Self = Self([0; 32]);

    /// Whether there is no detail.
    #[must_use]
    pub fn is_none(self) -> bool {
        self == Self::NONE
    }
}

impl fmt::Display for DetailId {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.0.iter().try_for_each(|byte| write!(f, "{byte:02x}"))
    }
}

impl fmt::Debug for DetailId {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "DetailId({self})")
    }
}

/// A place on the way of a hop: the launch, or an impact. Positions are (east, north, up), metres from the south-western corner of cell
/// (0, 0) and above the datum.
#[derive(Clone, Copy, Debug, PartialEq, Default, Serialize, Deserialize)]
pub struct PathPoint {
    /// Since the launch, seconds.
    pub seconds: f64,
    /// Where, metres.
    pub at_m: [f64; 3],
    /// Velocity with which the body leaves it, m/s.
    pub leaves_mps: [f64; 3],
}

/// Where a body has come to rest exactly, and by which way. Journalled with the decision, covered by the digest chain, and served to
/// whoever asks.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Detail {
    /// Whose figures these are.
    pub model: MotionModel,
    /// Where the body rests, (east, north, up), metres.
    pub rest_m: [f64; 3],
    /// What the model tells, in the order of [`MotionModel::figures`]; the rest zero.
    pub figures: [f64; FIGURES],
    /// The way, in order; at most [`DETAIL_POINTS_MAX`](crate::limits::DETAIL_POINTS_MAX) points.
    pub path: Vec<PathPoint>,
}

impl Detail {
    /// What is told of a body that stays where it rests.
    #[must_use]
    pub fn at_rest(&self) -> Self {
        Self { figures: [0.0; FIGURES], path: Vec::new(), ..*self }
    }

    /// What the model tells under `name`, one of [`MotionModel::figures`].
    #[must_use]
    pub fn figure(&self, name: &str) -> Option<f64> {
        let place = self.model.figures().iter().position(|figure| *figure == name)?;
        Some(self.figures[place])
    }

    /// Its name in records.
    #[must_use]
    pub fn id(&self) -> DetailId {
        let mut hasher = Sha256::new();
        hasher.update(self.model.code().to_le_bytes());
        let points = self.path.iter();
        let points = points.flat_map(|point| {
            [point.seconds].into_iter().chain(point.at_m).chain(point.leaves_mps).collect::<Vec<_>>()
        });
        for value in self.rest_m.into_iter().chain(self.figures).chain(points) {
            hasher.update(value.to_bits().to_le_bytes());
        }
        DetailId(hasher.finalize().into())
    }
}

/// Asks for the detail of a decision.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub struct DetailRequest {
    /// Run that is meant.
    pub run: RunId,
    /// The decision.
    pub decision: Decision,
}

/// The detail of a decision; there is no answer where it has none.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct DetailPage {
    /// Run it belongs to.
    pub run: RunId,
    /// The decision.
    pub decision: Decision,
    /// What is told of it.
    pub detail: Detail,
}

#[cfg(test)]
mod tests {
    use super::*;

    fn detail() -> Detail {
        let point = PathPoint { seconds: 0.5, at_m: [1.0, 2.0, 3.0], leaves_mps: [0.1, 0.2, 0.3] };
        Detail {
            model: MotionModel::Law,
            rest_m: [4.0, 5.0, 6.0],
            figures: [0.0; FIGURES],
            path: vec![point; 2],
        }
    }

    #[test]
    fn its_name_changes_with_every_bit_of_it() {
        let changes: [fn(&mut Detail); 7] = [
            |detail| detail.rest_m[0] = 4.0_f64.next_up(),
            |detail| detail.rest_m[2] = -6.0,
            |detail| detail.figures[FIGURES - 1] = -0.0,
            |detail| detail.path[1].seconds = 0.25,
            |detail| detail.path[0].at_m[1] = 2.5,
            |detail| detail.path[1].leaves_mps[2] = 0.31,
            |detail| detail.path.truncate(1),
        ];
        for change in changes {
            let mut other = detail();
            change(&mut other);
            assert_ne!(other.id(), detail().id(), "{other:?}");
        }
        assert!(!detail().id().is_none());
    }
}
