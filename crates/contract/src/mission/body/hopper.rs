//! The body of a hopper, with how its hops scatter.

use serde::{Deserialize, Serialize};

use super::BodyKind;
use crate::MotionTable;
use crate::block::Block;
use crate::codec::{PROBABILITY, at_most, float, whole};
use crate::mission::kind::Kind;

/// How hops scatter on one soil, on the flat (P23 section IV).
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct SoilMotion {
    /// Probability of the intended landing.
    pub intended: f64,
    /// Probability of staying stuck whatever the slope.
    pub stuck: f64,
    /// Probability of slipping one hop to the left; the same to the right.
    pub sideways: f64,
    /// Flights per intended hop: 1, or 2 half hops on sand.
    pub flights: u32,
}

/// Parameters of the motion-uncertainty form and of the flight.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct MotionParameters {
    /// Scatter on hard ground.
    pub hard: SoilMotion,
    /// How hops from sand slip and drift.
    pub sand: SoilMotion,
    /// Slope at which a hop no longer gets anywhere, radians; π/6 in the papers.
    pub slope_limit_rad: f64,
    /// Launch angle above the horizontal, radians; π/4 in P23.
    pub launch_angle_rad: f64,
    /// Surface gravity, m/s².
    pub gravity_mps2: f64,
    /// Whether it has the vertical hop at 80° (P22), and so checks each arc against the ground: where a hop at its own angle would
    /// collide, it hops up instead, or not at all.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub vertical: bool,
    /// Fingerprint of the motion table that planners believe in place of the four branches
    /// ([`crate::MotionTable::fingerprint`]); 0 for none.
    #[serde(default, skip_serializing_if = "is_zero")]
    pub table: u64,
}

fn is_zero(number: &u64) -> bool {
    *number == 0
}

/// Hops to one of four cells at a time. The length of a hop makes the lattice of the mission, and is the same for all.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Hopper {
    /// How its hops slip and drift by soil, and how steeply it takes off, as planners believe it.
    pub motion: MotionParameters,
}

impl Kind for Hopper {
    const NAME: &'static str = "hopper";

    fn parameters(&mut self, block: &mut Block<'_>) {
        let MotionParameters { hard, sand, slope_limit_rad, launch_angle_rad, gravity_mps2, vertical, table } =
            &mut self.motion;
        for (soil, motion) in [("hard", hard), ("sand", sand)] {
            let name = |what: &str| format!("motion.{soil}.{what}");
            block.float(
                &name("intended"),
                "Probability of the intended landing on the flat.",
                PROBABILITY,
                &mut motion.intended,
            );
            block.float(&name("stuck"), "Probability of staying stuck.", PROBABILITY, &mut motion.stuck);
            block.float(
                &name("sideways"),
                "Probability of a slip to one side, the same to the other.",
                float(0.0, 0.5),
                &mut motion.sideways,
            );
            block.whole(
                &name("flights"),
                "Flights per intended hop: two half hops on sand.",
                whole(1, 2),
                &mut motion.flights,
            );
            let sum = motion.intended + motion.stuck + 2.0 * motion.sideways;
            block.holds(&name("sum"), float(1.0 - 1e-9, 1.0 + 1e-9), sum);
        }
        block.float(
            "motion.slope_limit_rad",
            "Slope at which a hop no longer gets anywhere, radians; below π/2.",
            float(0.01, 1.57),
            slope_limit_rad,
        );
        block.float(
            "motion.launch_angle_rad",
            "Launch angle above the horizontal, radians: neither flat nor straight up, where a hop gets \
             nowhere.",
            float(0.01, 1.56),
            launch_angle_rad,
        );
        block.float(
            "motion.gravity_mps2",
            "Gravity, m/s²; from that of a small asteroid to four times that of Jupiter.",
            float(1.0e-5, 100.0),
            gravity_mps2,
        );
        block.choice("motion.vertical", "Vertical hops at 80°: 0 without, 1 with.", &[false, true], vertical);
        block.whole(
            "motion.table",
            "Fingerprint of the motion table that planners believe, on `hop/table`; 0 for none.",
            at_most(MotionTable::FINGERPRINT_MAX),
            table,
        );
    }
}

impl BodyKind for Hopper {
    fn word(&self) -> &'static str {
        "hopper"
    }

    fn hops(&self) -> bool {
        true
    }
}
