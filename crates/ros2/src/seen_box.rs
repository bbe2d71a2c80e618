//! The smallest rectangle of cells that holds all seen ones.

use contract::{Cell, ObservedMap};

/// A rectangle of cells; empty by default.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct SeenBox(Option<[Cell; 2]>);

impl SeenBox {
    /// Takes in what the map has seen since it had the fingerprint `before`.
    pub fn grow(&mut self, map: &ObservedMap, before: Option<u64>) {
        match before.and_then(|before| map.changed_since(before)) {
            Some(changed) => changed.iter().for_each(|index| self.add(map.grid.cell(*index as usize))),
            None => {
                let seen = map.cells().iter().enumerate().filter(|(_, cell)| cell.is_some());
                *self = Self::default();
                seen.for_each(|(index, _)| self.add(map.grid.cell(index)));
            }
        }
    }

    fn add(&mut self, cell: Cell) {
        let [least, most] = self.0.unwrap_or([cell; 2]);
        let least = Cell::new(least.x.min(cell.x), least.y.min(cell.y));
        self.0 = Some([least, Cell::new(most.x.max(cell.x), most.y.max(cell.y))]);
    }

    /// The south-western and the north-eastern cell; `None` if nothing is seen.
    pub fn corners(&self) -> Option<[Cell; 2]> {
        self.0
    }

    /// Cells in x and in y.
    pub fn sides(&self) -> [u32; 2] {
        self.0.map_or([0, 0], |[least, most]| [most.x.abs_diff(least.x) + 1, most.y.abs_diff(least.y) + 1])
    }

    /// Number of its cells.
    pub fn cells(&self) -> u64 {
        let [x, y] = self.sides();
        u64::from(x) * u64::from(y)
    }
}

#[cfg(test)]
mod tests {
    use contract::{Grid, Ground, RobotId, RunId};

    use super::*;

    #[test]
    fn it_grows_with_what_changed_and_is_found_again_where_that_is_not_known() {
        let grid = Grid::new(9, 7, 1.0, 1).unwrap();
        let mut map = ObservedMap::unseen(RunId(1), RobotId(0), grid);
        let mut seen = SeenBox::default();
        assert_eq!((seen.corners(), seen.cells()), (None, 0));
        let index = |x, y| grid.index(Cell::new(x, y)).unwrap();
        map.learn(index(3, 2), Ground::FLAT);
        map.mark();
        seen.grow(&map, None);
        assert_eq!((seen.corners(), seen.sides()), (Some([Cell::new(3, 2); 2]), [1, 1]));
        let before = map.observation();
        map.learn(index(8, 1), Ground::FLAT);
        map.learn(index(4, 6), Ground::FLAT);
        map.mark();
        let mut again = seen;
        seen.grow(&map, Some(before));
        again.grow(&map, Some(before ^ 1));
        assert_eq!(seen.corners(), Some([Cell::new(3, 1), Cell::new(8, 6)]));
        assert_eq!((again, seen.cells()), (seen, 36));
    }
}
