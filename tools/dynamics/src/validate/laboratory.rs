//! Impacts in the laboratory and in microgravity.

use contact::{Body, Impact, Noise, Place, Plane, Soil, Surface};
use nalgebra::Vector3;
use scenario::Preset;

use super::Row;
use crate::hopper_on::soil_of;

const EARTH_MPS2: f64 = 9.81;

/// Drops of a sphere on level ground: the first impact of each, at speeds between two, m/s, that many degrees above the ground.
fn impacts(
    radius_m: f64,
    soil: Soil,
    gravity_mps2: f64,
    speeds_mps: [f64; 2],
    above_deg: f64,
) -> Vec<Impact> {
    const DROPS: u32 = 200;
    let plane = Plane::new(1.0, [0.0; 2], soil);
    let middle_m = plane.middle_m();
    let surface = Surface::new(plane);
    let body = Body { radius_m, inertia: 0.4 };
    let place = Place { surface: &surface, body: &body, gravity_mps2, hop_m: 1.0 };
    let from = Vector3::new(middle_m, middle_m, 0.0);
    let drop = |number: u32| {
        let speed_mps =
            speeds_mps[0] + (speeds_mps[1] - speeds_mps[0]) * f64::from(number) / f64::from(DROPS - 1);
        let above = above_deg.to_radians();
        let velocity = Vector3::new(libm::cos(above), 0.0, -libm::sin(above)) * speed_mps;
        let noise = &mut Noise::new([1; 32], u64::from(number));
        place.hop(from, velocity, noise).impacts.into_iter().next()
    };
    (0..DROPS).filter_map(drop).collect()
}

/// The share of impacts after which a sphere leaves the ground, faster than counts as rest.
fn rebounds(impacts: &[Impact], radius_m: f64, gravity_mps2: f64) -> f64 {
    let stop_mps = Body { radius_m, inertia: 0.4 }.stop_mps(gravity_mps2);
    let leaving = impacts.iter().filter(|impact| impact.after.z >= stop_mps).count();
    leaving as f64 / impacts.len() as f64
}

fn share(of: f64) -> String {
    format!("{:.0} %", 100.0 * of)
}

/// The rows.
pub fn rows() -> Vec<Row> {
    let (sand, regolith) =
        (soil_of(Preset::Mars, contract::Soil::Sand), soil_of(Preset::Ryugu, contract::Soil::Sand));
    let in_sand = [0.2, 1.0].map(|gravity_mps2| {
        rebounds(&impacts(0.05, sand, gravity_mps2, [0.02, 0.4], 90.0), 0.05, gravity_mps2)
    });
    let at = |gravities: f64, speeds_mps| {
        let gravity_mps2 = gravities * EARTH_MPS2;
        rebounds(&impacts(0.01, regolith, gravity_mps2, speeds_mps, 90.0), 0.01, gravity_mps2)
    };
    let (embedded, slow) = (at(1e-2, [0.04, 2.3]), at(5e-5, [0.01, 0.3]));
    let coarse = soil_of(Preset::Ryugu, contract::Soil::Hard);
    let on_grains =
        rebounds(&impacts(0.01, coarse, 1e-5 * EARTH_MPS2, [0.05, 2.0], 60.0), 0.01, 1e-5 * EARTH_MPS2);
    let grazing = rebounds(&impacts(0.008, sand, EARTH_MPS2, [2.0, 5.0], 20.0), 0.008, EARTH_MPS2);
    vec![
        Row::new(
            "Murdoch et al. 2017, arXiv 1702.05980",
            "rebounds of a 10 cm sphere from sand, 2 to 40 cm/s, 0.2 m/s²",
            "none",
        )
        .is(share(in_sand[0]), in_sand[0] == 0.0),
        Row::new("Murdoch et al. 2017, arXiv 1702.05980", "the same at 1 m/s²", "none")
            .is(share(in_sand[1]), in_sand[1] == 0.0),
        Row::new(
            "Brisset et al. 2018, arXiv 1810.01459",
            "rebounds from regolith at 1e-2 g, 4 to 230 cm/s",
            "none: all embed",
        )
        .is(share(embedded), embedded == 0.0),
        Row::new("Brisset et al. 2018, arXiv 1810.01459", "rebounds of slow impacts below 1e-4 g", "some")
            .is(share(slow), slow > 0.0),
        Row::new(
            "Brisset et al. 2020, arXiv 2008.08720",
            "bouncing on coarse grains in microgravity below 2 m/s",
            "frequent",
        )
        .is(share(on_grains), on_grains >= 0.5),
        Row::new(
            "Wright et al. 2020, arXiv 2002.01468",
            "ricochets of a sphere that grazes sand at 20°, 2 to 5 m/s",
            "some: faster and flatter ones",
        )
        .is(share(grazing), grazing > 0.0),
    ]
}
