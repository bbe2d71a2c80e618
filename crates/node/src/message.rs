//! Which wire types carry which message.

use contract::wire::{
    BriefV2, CommandV1, GroundV1, HeartbeatV1, MapHeaderV2, PolicyCellV1, PolicyHeaderV1, StateV2,
    TerrainHeaderV2, Wire, map_from_wire, policy_from_wire,
};
use contract::{Brief, Cell, Command, Grid, Ground, Heartbeat, ObservedMap, Policy, Refusal, RunId, State};

/// A message of one fixed size.
pub trait Plain: Sized {
    /// What crosses shared memory.
    type Wire: Wire;

    /// The message as it crosses.
    fn to_wire(&self) -> Self::Wire;

    /// The message of a copied sample.
    ///
    /// # Errors
    /// A refusal naming the field.
    fn from_wire(wire: &Self::Wire) -> Result<Self, Refusal>;
}

macro_rules! plain {
    ($($message:ty => $wire:ty),*) => {$(
        impl Plain for $message {
            type Wire = $wire;

            fn to_wire(&self) -> $wire {
                self.into()
            }

            fn from_wire(wire: &$wire) -> Result<Self, Refusal> {
                wire.try_into()
            }
        }
    )*};
}

plain!(Brief => BriefV2, State => StateV2, Command => CommandV1, Heartbeat => HeartbeatV1);

/// A message of a header and as many cells as the grid has.
pub trait Sheet: Sized {
    /// The header that crosses shared memory.
    type Header: Wire;
    /// One cell that crosses shared memory.
    type Cell: Wire;

    /// The header as it crosses.
    fn header(&self) -> Self::Header;

    /// Number of cells.
    fn cells(&self) -> usize;

    /// The cell at `index` as it crosses.
    fn cell(&self, index: usize) -> Self::Cell;

    /// The message of a copied sample.
    ///
    /// # Errors
    /// A refusal naming the field.
    fn from_wire(header: &Self::Header, cells: &[Self::Cell]) -> Result<Self, Refusal>;
}

impl Sheet for ObservedMap {
    type Header = MapHeaderV2;
    type Cell = GroundV1;

    fn header(&self) -> MapHeaderV2 {
        self.into()
    }

    fn cells(&self) -> usize {
        self.cells.len()
    }

    fn cell(&self, index: usize) -> GroundV1 {
        self.cells[index].as_ref().into()
    }

    fn from_wire(header: &MapHeaderV2, cells: &[GroundV1]) -> Result<Self, Refusal> {
        map_from_wire(header, cells)
    }
}

impl Sheet for Policy {
    type Header = PolicyHeaderV1;
    type Cell = PolicyCellV1;

    fn header(&self) -> PolicyHeaderV1 {
        self.into()
    }

    fn cells(&self) -> usize {
        self.cells.len()
    }

    fn cell(&self, index: usize) -> PolicyCellV1 {
        (&self.cells[index]).into()
    }

    fn from_wire(header: &PolicyHeaderV1, cells: &[PolicyCellV1]) -> Result<Self, Refusal> {
        policy_from_wire(header, cells)
    }
}

/// The true ground of a run, as `truth/terrain` carries it.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
pub struct Truth {
    /// The run.
    pub run: RunId,
    /// The lattice.
    pub grid: Grid,
    /// Cells in index order.
    pub cells: Vec<Ground>,
    /// Cells with treasures, in index order.
    pub treasures: Vec<Cell>,
}

impl Sheet for Truth {
    type Header = TerrainHeaderV2;
    type Cell = GroundV1;

    fn header(&self) -> TerrainHeaderV2 {
        TerrainHeaderV2::new(self.run, &self.grid, &self.treasures)
    }

    fn cells(&self) -> usize {
        self.cells.len()
    }

    fn cell(&self, index: usize) -> GroundV1 {
        Some(&self.cells[index]).into()
    }

    fn from_wire(header: &TerrainHeaderV2, cells: &[GroundV1]) -> Result<Self, Refusal> {
        let (run, grid, treasures) = header.decode()?;
        if cells.len() != grid.cells() {
            return Err(Refusal::malformed("terrain.cells", &format!("{} cells", grid.cells()), cells.len()));
        }
        let known = |cell: &GroundV1| {
            Option::<Ground>::try_from(cell)?
                .ok_or_else(|| Refusal::malformed("terrain.soil", "hard or sand", "unseen"))
        };
        Ok(Self { run, grid, cells: cells.iter().map(known).collect::<Result<_, _>>()?, treasures })
    }
}
