//! Whether the rise of a flight meets the ground (P22 section "Payoff function").
//!
//! A hopper that touches the ground before its apex bounces off; one that touches it on the way down has landed. The
//! ground under a flight is a polyline, which may have vertical steps. The arc is concave and each segment is straight,
//! so their distance is least at an end of the segment: checking the corners up to the apex, and the apex, is exact.

use crate::Launch;

/// Clearance that counts as a touch: far above rounding, and far below the resolution of any terrain model.
const TOUCH_M: f64 = 1e-9;

/// The ground along the path of a flight.
#[derive(Clone, Debug, PartialEq)]
pub struct GroundProfile {
    /// Corners (distance, height above the launch), metres, distances ascending; two at one distance are a
    /// vertical step. The first is the launch; behind the last the ground is level.
    corners: Vec<[f64; 2]>,
}

impl GroundProfile {
    /// Ground that is straight from the middle of each cell to the next. `heights_m` are those of the
    /// cells in the direction of the flight, the cell of departure first.
    ///
    /// # Panics
    /// If there is no cell, or a height is not finite.
    #[must_use]
    pub fn sloping(heights_m: &[f64], cell_size_m: f64) -> Self {
        let launch_m = launch_height_m(heights_m);
        let corner = |(n, height_m): (usize, &f64)| [n as f64 * cell_size_m, height_m - launch_m];
        Self { corners: heights_m.iter().enumerate().map(corner).collect() }
    }

    /// Ground that is level within each cell, with vertical steps half way between the middles, for rocks on a
    /// plain.
    ///
    /// # Panics
    /// If there is no cell, or a height is not finite.
    #[must_use]
    pub fn stepped(heights_m: &[f64], cell_size_m: f64) -> Self {
        let launch_m = launch_height_m(heights_m);
        let mut corners = vec![[0.0, 0.0]];
        for (n, pair) in heights_m.windows(2).enumerate() {
            let border_m = (n as f64 + 0.5) * cell_size_m;
            corners.extend([[border_m, pair[0] - launch_m], [border_m, pair[1] - launch_m]]);
        }
        Self { corners }
    }

    /// Height of the ground at `distance_m`, the higher one at a step, metres above the launch.
    #[must_use]
    pub fn height_m(&self, distance_m: f64) -> f64 {
        let mut height_m = None;
        for pair in self.corners.windows(2) {
            let ([from_m, low_m], [to_m, high_m]) = (pair[0], pair[1]);
            if !(from_m..=to_m).contains(&distance_m) {
                continue;
            }
            let here_m = match to_m > from_m {
                true => low_m + (high_m - low_m) * (distance_m - from_m) / (to_m - from_m),
                false => low_m.max(high_m),
            };
            height_m = Some(height_m.map_or(here_m, |before_m: f64| before_m.max(here_m)));
        }
        height_m.unwrap_or_else(|| self.corners.last().map_or(0.0, |corner| corner[1]))
    }
}

/// Distance along the ground, metres, of the first corner or apex at which the rising flight is on or under
/// the ground; `None` if it reaches its apex without a touch. The hopper is a point, as in the paper.
#[must_use]
pub fn collision_m(launch: &Launch, ground: &GroundProfile) -> Option<f64> {
    let apex_m = launch.apex_distance_m();
    let apex = [apex_m, ground.height_m(apex_m)];
    let rising = ground.corners.iter().skip(1).copied().filter(|corner| corner[0] <= apex_m).chain([apex]);
    rising
        .filter(|&[distance_m, _]| distance_m > 0.0)
        .find(|&[distance_m, height_m]| launch.height_m(distance_m) - height_m <= TOUCH_M)
        .map(|[distance_m, _]| distance_m)
}

fn launch_height_m(heights_m: &[f64]) -> f64 {
    assert!(
        heights_m.iter().all(|height_m| height_m.is_finite()),
        "heights need to be finite, got {heights_m:?}"
    );
    *heights_m.first().expect("a flight departs from a cell")
}
