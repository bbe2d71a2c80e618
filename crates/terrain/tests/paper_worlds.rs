//! The worlds of Sakamoto & Kunii 2023, against the numbers that are known of them.

#![allow(clippy::unwrap_used)]

use std::f64::consts::{FRAC_PI_6, PI};

use contract::{Grid, Soil};
use terrain::{Gaussian, Relief, Sand, Terrain};

const RAISED: [[f64; 2]; 5] = [[1.0, 6.0], [5.0, 0.0], [5.0, 20.0], [7.0, 14.0], [8.0, 8.0]];
const LOWERED: [[f64; 2]; 3] = [[10.0, 18.0], [12.0, 1.0], [15.0, 10.0]];

fn relief() -> Relief {
    let amplitude_m = 1.0 / (2.0 * PI);
    let hill = |centre_m, amplitude_m| Gaussian { centre_m, sigma_m: 2.0, amplitude_m };
    let hills: Vec<Gaussian> = RAISED
        .into_iter()
        .map(|centre| hill(centre, amplitude_m))
        .chain(LOWERED.into_iter().map(|centre| hill(centre, -amplitude_m)))
        .collect();
    Relief::of_gaussians(Grid::new(20, 20, 1.0, 1).unwrap(), &hills)
}

#[test]
fn heights_span_the_published_range_and_the_steepest_slope_is_the_published_one() {
    let terrain = Terrain::new(&relief(), 0.0, FRAC_PI_6, &Sand::default());
    let range = terrain.height_range();
    assert!((range.min - -0.159).abs() < 5e-4 && (range.max - 0.161).abs() < 5e-4, "{range:?}");
    let safety = terrain.safety_range(-5.0);
    assert!((safety.min - -0.087).abs() < 5e-4, "{safety:?}");
    assert!(terrain.cells.iter().all(|ground| ground.passable));
}

#[test]
fn heights_and_gradients_are_the_sums_of_the_closed_form() {
    let relief = relief();
    for cell in relief.grid.iter() {
        let mut height = 0.0;
        let mut gradient = [0.0, 0.0];
        for (centres, sign) in [(&RAISED[..], 1.0), (&LOWERED[..], -1.0)] {
            for [cx, cy] in centres {
                let (dx, dy) = (f64::from(cell.x) - cx, f64::from(cell.y) - cy);
                let one = sign / (2.0 * PI) * (-(dx * dx + dy * dy) / 8.0).exp();
                height += one;
                gradient[0] -= dx / 4.0 * one;
                gradient[1] -= dy / 4.0 * one;
            }
        }
        let (got, [gx, gy]) = relief.cells[relief.grid.index(cell).unwrap()].unwrap();
        assert!((got - height).abs() < 1e-15, "{cell}");
        assert!((gx - gradient[0]).abs() < 1e-15 && (gy - gradient[1]).abs() < 1e-15, "{cell}");
    }
}

#[test]
fn forty_two_cells_of_the_sandy_world_stay_hard() {
    let sand = Sand { below_height_m: Some(0.1), ..Sand::default() };
    let terrain = Terrain::new(&relief(), 0.0, FRAC_PI_6, &sand);
    assert_eq!(terrain.cells.iter().filter(|ground| ground.soil == Soil::Hard).count(), 42);
}
