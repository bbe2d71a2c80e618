//! How the observed map travels: patches as it grows, pages for whoever missed one.

use serde::{Deserialize, Serialize};

use crate::{Cell, Decision, Digest, Grid, Ground, MonotonicNs, RobotId, RunId};

/// A seen cell and its index.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct SeenCell {
    /// Row-major index.
    pub index: u32,
    /// How often rovers have entered it, starts included, as far as it is counted: up to [`u16::MAX`]. 0 in the mission
    /// of a hopper.
    #[serde(default, skip_serializing_if = "is_never")]
    pub visits: u16,
    /// What is known of it.
    pub ground: Ground,
}

fn is_never(visits: &u16) -> bool {
    *visits == 0
}

/// What one landing changed in the map, or a part of that: at most [`crate::limits::MAP_PATCH_CELLS`] cells.
///
/// Patches form a chain: each names the fingerprint of the map it goes on
/// ([`crate::ObservedMap::observation`]) and that of the map it makes, so a reader that has missed one knows. A patch without cells whose two
/// fingerprints are one is a reminder, for whoever missed the last.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct MapPatch {
    /// Run it belongs to; whoever follows another run refuses it.
    pub run: RunId,
    /// The robot whose sensor it is.
    pub robot: RobotId,
    /// The decision whose pose is folded in by the last part.
    pub through: Decision,
    /// [`crate::State::digest`] of the state with that pose.
    pub digest: Digest,
    /// Parts of the same landing that follow.
    pub more: u32,
    /// Its place in the run's stream of patches, from 1; a reminder has that of the last patch.
    pub sequence: u64,
    /// Fingerprint of the map that it goes on.
    pub before: u64,
    /// Fingerprint of the map with its cells.
    pub after: u64,
    /// When the pose was folded in.
    pub sensed: MonotonicNs,
    /// When it was published; of a reminder, when the last patch was.
    pub published: MonotonicNs,
    /// Lattice of the mission; every cell of the message lies on it.
    pub grid: Grid,
    /// Seen cells of the map with its cells.
    pub seen_cells: u32,
    /// Treasures of the map with its cells that are not yet collected, in index order.
    pub treasures: Vec<Cell>,
    /// Cells seen for the first time, or better, in index order.
    pub cells: Vec<SeenCell>,
}

/// Asks perception for the map from an index on.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct MapRequest {
    /// Run it belongs to; whoever follows another run refuses it.
    pub run: RunId,
    /// Robot 0, the only one of a mission.
    pub robot: RobotId,
    /// First index wanted.
    pub from: u32,
    /// Fingerprint of what the asker has; if it is the map's, no cells are sent.
    pub observation: u64,
}

/// The seen cells of a stretch of the map, at most [`crate::limits::MAP_PAGE_CELLS`], at one moment.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct MapPage {
    /// Run it belongs to; whoever follows another run refuses it.
    pub run: RunId,
    /// Robot 0, the only one of a mission.
    pub robot: RobotId,
    /// The last decision whose pose was folded in at that moment.
    pub through: Decision,
    /// [`crate::State::digest`] of the state with that pose.
    pub digest: Digest,
    /// The last patch published before that moment.
    pub sequence: u64,
    /// Fingerprint of the whole map at that moment.
    pub observation: u64,
    /// When the pose of `through` was folded in.
    pub sensed: MonotonicNs,
    /// When the last patch was published.
    pub published: MonotonicNs,
    /// Lattice of the mission; every cell of the message lies on it.
    pub grid: Grid,
    /// First index of the stretch.
    pub from: u32,
    /// First index after the stretch; the number of cells at the end.
    pub next: u32,
    /// Treasures seen and not yet collected, in index order.
    pub treasures: Vec<Cell>,
    /// The seen cells of the stretch, in index order.
    pub cells: Vec<SeenCell>,
}
