//! What holds of any hop: energy is never created, work is bounded, gravity only sets the pace.

mod hostile;

use contact::{Body, End, Noise, Soil, Surface};
use proptest::prelude::*;

use hostile::{Flown, GROWTH_MAX, Ground, SIDE};

fn soil() -> impl Strategy<Value = Soil> {
    (0.0..=1.0, 0.0..2.0, 1e-3..2.0, 0.0..2.0, 0.0..0.3).prop_map(
        |(restitution, friction, rolling, foot, roughness_rad)| Soil {
            restitution,
            restitution_speed_mps: f64::INFINITY,
            restitution_gravity_mps2: f64::INFINITY,
            friction,
            rolling,
            foot,
            roughness_rad,
        },
    )
}

/// Ground of any shape: rough, saw-toothed, walled, with pits.
fn heights() -> impl Strategy<Value = Vec<f64>> {
    let rough = proptest::collection::vec(-1.0..1.0_f64, SIDE * SIDE);
    let steps = proptest::collection::vec(prop_oneof![Just(0.0), Just(1.0), Just(-2.0)], SIDE * SIDE);
    let teeth = (0.1..2.0_f64).prop_map(|height_m| {
        (0..SIDE * SIDE).map(|index| if (index % SIDE).is_multiple_of(2) { height_m } else { 0.0 }).collect()
    });
    let flat = Just(vec![0.0; SIDE * SIDE]);
    prop_oneof![rough, steps, teeth, flat]
}

#[derive(Clone, Debug)]
struct Launch {
    cell_m: f64,
    heights_m: Vec<f64>,
    soils: [Soil; 2],
    body: Body,
    gravity_mps2: f64,
    from: [f64; 2],
    velocity: [f64; 3],
    seed: u64,
}

fn launch() -> impl Strategy<Value = Launch> {
    let place = (0.0..=1.0, 0.0..=1.0);
    let velocity = (-3.0..3.0, -3.0..3.0, -1.0..4.0);
    let body = (1e-3..0.5, 0.05..0.9);
    let all = (heights(), [soil(), soil()], body, place, velocity, 0.2..3.0, any::<u64>());
    all.prop_map(|(heights_m, soils, (radius, inertia), (x, y), (vx, vy, vz), cell_m, seed)| {
        let extent_m = SIDE as f64 * cell_m;
        Launch {
            cell_m,
            heights_m,
            soils,
            body: Body { radius_m: radius * cell_m, inertia },
            gravity_mps2: 3.72,
            from: [x * extent_m, y * extent_m],
            velocity: [vx, vy, vz],
            seed,
        }
    })
}

fn fly(launch: &Launch) -> Option<Flown> {
    let Launch { cell_m, heights_m, soils, body, gravity_mps2, from, velocity, seed } = launch.clone();
    let surface = Surface::new(Ground { cell_m, heights_m, soils });
    let mut key = [0; 32];
    key[..8].copy_from_slice(&seed.to_le_bytes());
    hostile::fly(&surface, &body, gravity_mps2, from, velocity, &mut Noise::new(key, 1))
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 2_000, ..ProptestConfig::default() })]

    /// P-CONTACT-ENERGY: Neither a flight, an impact nor a roll creates energy, and a hop ends after bounded work, on ground of any shape.
    #[test]
    fn energy_is_never_created_and_every_hop_ends(launch in launch()) {
        let Some(Flown { ending, growth }) = fly(&launch) else { return Ok(()) };
        let extent_m = SIDE as f64 * launch.cell_m;
        prop_assert!(growth <= GROWTH_MAX, "{growth}: {ending:?}");
        prop_assert!(ending.position.iter().all(|metres| metres.is_finite()) && ending.seconds.is_finite());
        let on_map = 0.0..=extent_m;
        prop_assert!(
            !matches!(ending.end, End::Rest | End::Caught)
                || (on_map.contains(&ending.position.x) && on_map.contains(&ending.position.y))
        );
        prop_assert!(ending.end != End::BouncedOn || ending.impact_count == contact::bounds::IMPACTS_MAX);
    }

    /// P-CONTACT-FROUDE: With speeds scaled by the root of gravity a body comes to rest at the same place, from Mars down to 1e-5 m/s².
    #[test]
    fn gravity_only_sets_the_pace(launch in launch(), gravity_mps2 in prop_oneof![Just(1.62), Just(5.7e-3), Just(1e-5)]) {
        let ratio = (gravity_mps2 / launch.gravity_mps2).sqrt();
        let slow = Launch { gravity_mps2, velocity: launch.velocity.map(|mps| mps * ratio), ..launch.clone() };
        let (Some(fast), Some(slow)) = (fly(&launch), fly(&slow)) else { return Ok(()) };
        let (fast, slow) = (fast.ending, slow.ending);
        // On rough ground a rounding error may choose another way at an edge: of such hops nothing is said.
        prop_assume!(fast.impact_count == slow.impact_count && fast.end == slow.end && fast.impact_count < 30);
        let apart = (fast.position - slow.position).norm();
        prop_assert!(apart <= 1e-9, "{apart}: {fast:?} {slow:?}");
    }
}
