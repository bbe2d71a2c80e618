//! Which wire types carry which message.

use contract::wire::{
    BriefV3, CommandV1, ControlV1, GroundV1, HeartbeatV1, MapPageV1, MapPatchV1, MapRequestV1, PastHeaderV1,
    PastRequestV1, PolicyCellV1, PolicyHeaderV1, RecordV3, SeenCellV1, StateV3, TempoV1, TruthPageV1,
    TruthRequestV1, Wire, map_page_from_wire, page_from_wire, patch_from_wire, policy_from_wire,
    truth_page_from_wire,
};
use contract::{
    Brief, Command, Control, Heartbeat, MapPage, MapPatch, MapRequest, PastPage, PastRequest, Policy,
    Refusal, State, Tempo, TruthPage, TruthRequest,
};

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

plain!(Brief => BriefV3, State => StateV3, Command => CommandV1, Heartbeat => HeartbeatV1, Control => ControlV1, Tempo => TempoV1);

/// A message of a header and cells.
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

macro_rules! sheet {
    ($($message:ty: $header:ty, $cell:ty, $field:ident, $convert:expr, $from_wire:expr);*) => {$(
        impl Sheet for $message {
            type Header = $header;
            type Cell = $cell;

            fn header(&self) -> $header {
                self.into()
            }

            fn cells(&self) -> usize {
                self.$field.len()
            }

            #[inline]
            fn cell(&self, index: usize) -> $cell {
                $convert(&self.$field[index])
            }

            fn from_wire(header: &$header, cells: &[$cell]) -> Result<Self, Refusal> {
                $from_wire(header, cells)
            }
        }
    )*};
}

sheet!(
    MapPatch: MapPatchV1, SeenCellV1, cells, SeenCellV1::from, patch_from_wire;
    MapPage: MapPageV1, SeenCellV1, cells, SeenCellV1::from, map_page_from_wire;
    TruthPage: TruthPageV1, GroundV1, cells, GroundV1::from, truth_page_from_wire;
    PastPage: PastHeaderV1, RecordV3, records, RecordV3::from, page_from_wire;
    Policy: PolicyHeaderV1, PolicyCellV1, cells, PolicyCellV1::from, policy_from_wire
);

/// A message that is answered by another.
pub trait Question: Plain {
    /// The answer: a page.
    type Answer: Sheet;
}

plain!(PastRequest => PastRequestV1, MapRequest => MapRequestV1, TruthRequest => TruthRequestV1);

impl Question for PastRequest {
    type Answer = PastPage;
}

impl Question for MapRequest {
    type Answer = MapPage;
}

impl Question for TruthRequest {
    type Answer = TruthPage;
}
