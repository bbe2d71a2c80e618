//! Arrows of a policy, packed into short SVG paths.

use std::fmt::Write as _;

use contract::Direction;

use super::svg_writer::{Number, SvgWriter};

/// Arrows of one length, drawn in units of a fiftieth of it so that coordinates are short integers.
#[derive(Clone, Copy, Debug)]
pub struct Quiver {
    /// A fiftieth of an arrow, in the picture's units.
    unit: f64,
}

impl Quiver {
    pub fn new(length: f64) -> Self {
        // Rounded to the digits that are written, so that positions agree with the written scale.
        Self { unit: ((length * 200.0).round() / 10_000.0).max(0.0001) }
    }

    /// Opens the group that the paths of the arrows belong to.
    pub fn open(self, svg: &mut SvgWriter) {
        svg.open("g", &format!("transform=\"scale({})\"", Number(self.unit)));
    }

    /// The path of arrows towards `direction`, centred on the points (x, y).
    pub fn path(self, direction: Direction, at: impl IntoIterator<Item = (f64, f64)>) -> String {
        let mut path = String::new();
        let mut pen = (0, 0);
        for (x, y) in at {
            let (x, y) = ((x / self.unit).round() as i64, (y / self.unit).round() as i64);
            // Each arrow ends where it began.
            let _ = write!(path, "m{}{}{}", x - pen.0, Next(y - pen.1), arrow(direction));
            pen = (x, y);
        }
        path
    }
}

/// A number that follows another: with a space unless it starts with a minus sign.
struct Next(i64);

impl std::fmt::Display for Next {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        if self.0 < 0 { write!(f, "{}", self.0) } else { write!(f, " {}", self.0) }
    }
}

/// Outline of an arrow 50 units long towards `direction`, from its middle and back; north is up.
pub fn arrow(direction: Direction) -> String {
    let (dx, dy) = direction.step();
    let (ahead, aside) = ((i64::from(dx), i64::from(-dy)), (i64::from(dy), i64::from(dx)));
    let corners = [(-25, 4), (4, 4), (4, 13), (25, 0), (4, -13), (4, -4), (-25, -4), (-25, 0)];
    let mut path = String::new();
    let mut pen = (0, 0);
    // The first stroke runs inside the outline to the tail: once filled, it is invisible.
    for (along, across) in std::iter::once((-25, 0)).chain(corners) {
        let at = (along * ahead.0 + across * aside.0, along * ahead.1 + across * aside.1);
        let _ = match (at.0 - pen.0, at.1 - pen.1) {
            (along_x, 0) => write!(path, "h{along_x}"),
            (0, along_y) => write!(path, "v{along_y}"),
            (along_x, along_y) => write!(path, "l{along_x}{}", Next(along_y)),
        };
        pen = at;
    }
    path.push('z');
    path
}
