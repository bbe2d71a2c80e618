//! Cells.

use super::{Codec, Ends};
use crate::{Cell, Refusal};

/// A cell as (x, y).
pub(crate) struct CellAt;

/// A cell of the grid or next to it; which, its reader decides.
pub(crate) const CELL: CellAt = CellAt;

impl CellAt {
    /// Farther than any grid reaches, with room to count on.
    const FAR: i32 = 1 << 20;
}

impl Codec<[i32; 2]> for CellAt {
    type Value = Cell;

    #[inline]
    fn to_wire(&self, cell: &Cell) -> [i32; 2] {
        [cell.x, cell.y]
    }

    #[inline]
    fn from_wire(&self, field: &str, [x, y]: [i32; 2]) -> Result<Cell, Refusal> {
        let near = -Self::FAR..=Self::FAR;
        if near.contains(&x) && near.contains(&y) {
            Ok(Cell::new(x, y))
        } else {
            Err(Refusal::malformed(field, &self.range(), Cell::new(x, y)))
        }
    }

    fn range(&self) -> String {
        format!("x and y from {} to {}", -Self::FAR, Self::FAR)
    }

    fn ends(&self) -> Ends<[i32; 2]> {
        let far = Self::FAR;
        Ends {
            inside: vec![[far, -far], [-far, far]],
            outside: vec![[far + 1, 0], [0, far + 1], [-far - 1, 0], [0, -far - 1]],
        }
    }
}
