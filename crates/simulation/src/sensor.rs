//! What sensors should show, by code that shares nothing with the product's. What is seen along a way is with the bodies, in the
//! folder of the oracle.
//!
//! Each sensor is a file of this folder, and a line in the list below.

use std::num::NonZeroU8;

use contract::{Brief, Cell, GradientSource, Pose};

contract::rules! {
    /// The rules of a sensor.
    pub(crate) fn of(Sensor) -> Sensor;
    disc => Disc,
    square => Square,
    on_way => Track | Camera | ErringCamera,
}

/// What is asked of a sensor.
pub(crate) trait Sensor {
    /// Indices of the cells that it shows from `pose`, whatever is seen on the way there.
    fn around(&self, _brief: &Brief, _pose: Pose) -> Vec<usize> {
        Vec::new()
    }

    /// What it reports of a cell that it shows, so far away.
    fn reports(&self, _distance_m: f64) -> Option<NonZeroU8> {
        None
    }

    /// Where gradients come from, if it decides that.
    fn gradient(&self) -> Option<GradientSource> {
        None
    }
}

/// All cells, in index order.
pub(crate) fn cells_of(brief: &Brief) -> impl Iterator<Item = Cell> + use<> {
    let (width, height) = (brief.grid.width as i32, brief.grid.height as i32);
    (0..height).flat_map(move |y| (0..width).map(move |x| Cell::new(x, y)))
}

/// Whether a cell is on the map.
pub(crate) fn is_inside(brief: &Brief, cell: Cell) -> bool {
    (0..brief.grid.width as i32).contains(&cell.x) && (0..brief.grid.height as i32).contains(&cell.y)
}

/// Indices of the cells for which that holds.
fn indices(brief: &Brief, is_in_view: impl Fn(Cell) -> bool) -> Vec<usize> {
    let cells = cells_of(brief).enumerate();
    cells.filter(|(_, cell)| is_in_view(*cell)).map(|(index, _)| index).collect()
}

/// How far a cell is from another, metres.
pub(crate) fn distance_m(brief: &Brief, from: Cell, to: Cell) -> f64 {
    let (x, y) = (to.x - from.x, to.y - from.y);
    f64::from(x * x + y * y).sqrt() * brief.grid.cell_size_m
}
