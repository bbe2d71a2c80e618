//! How a hopper hops and how far it sees, and how the hoppers of one mission differ in that.

use serde::{Deserialize, Serialize};

use crate::limits::{DESIGNS_MAX, ROBOTS_MAX};
use crate::{Grid, RobotId};

/// How hops scatter on one soil, on the flat (P23 section IV).
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
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
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
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
}

/// Where the observed map takes its gradients from.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum GradientSource {
    /// The sensor measures the true slope of each seen cell.
    Measured,
    /// Differences of heights over seen cells only.
    SeenDifferences,
}

/// The elevation-dependent sensor: radius = gain · (h + offset), clamped (P23 section IV).
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct SensorParameters {
    /// Metres of radius per metre of height; 2 in P23.
    pub gain: f64,
    /// Height added before the gain, metres; 1 in P23.
    pub offset_m: f64,
    /// Smallest radius, metres; at least one hop, so that the neighbours are always seen.
    pub radius_min_m: f64,
    /// Largest radius, metres.
    pub radius_max_m: f64,
    /// Where gradients come from.
    pub gradient: GradientSource,
}

impl SensorParameters {
    /// Sensing radius in metres at `height_m` above the datum, clamped to the sensor's range.
    #[must_use]
    pub fn radius_m(&self, height_m: f64) -> f64 {
        (self.gain * (height_m + self.offset_m)).clamp(self.radius_min_m, self.radius_max_m)
    }

    /// How far it sees from `height_m` above the datum, in cells of `grid`: the sensing radius, and one hop at
    /// least, whatever the rounding. Three cells of 0.7 m divided by 0.7 m are a little less than three.
    #[must_use]
    pub fn reach_cells(&self, grid: &Grid, height_m: f64) -> f64 {
        (self.radius_m(height_m) / grid.cell_size_m).max(f64::from(grid.hop_cells))
    }
}

/// How a hopper hops and sees. The length of a hop is not part of it, since it makes the lattice of the mission; slope limit,
/// gravity and the source of gradients are those of all hoppers.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Design {
    /// How its hops slip and drift by soil, and how steeply it takes off.
    pub motion: MotionParameters,
    /// How far it sees from a height.
    pub sensor: SensorParameters,
}

/// Which hoppers of a mission are of another design than that of the brief: at most [`DESIGNS_MAX`] others.
#[derive(Clone, Copy, Debug, PartialEq, Default, Serialize, Deserialize)]
pub struct Designs {
    /// For each robot 0 for the design of the brief, or a number from 1.
    of: [u8; ROBOTS_MAX],
    designs: [Option<Design>; DESIGNS_MAX],
}

impl Designs {
    /// The designs of the robots, in their order, where they are others than the brief's. `None` if there are too many robots,
    /// or too many designs.
    #[must_use]
    pub fn new(robots: impl IntoIterator<Item = Option<Design>>) -> Option<Self> {
        let mut all = Self::default();
        for (robot, design) in robots.into_iter().enumerate() {
            let of = all.of.get_mut(robot)?;
            let Some(design) = design else { continue };
            let place = all.designs.iter().position(|known| known.is_none_or(|known| known == design))?;
            all.designs[place] = Some(design);
            *of = place as u8 + 1;
        }
        Some(all)
    }

    /// The design of `robot`, if it is another than the brief's.
    #[must_use]
    pub fn of(&self, robot: RobotId) -> Option<&Design> {
        let number = *self.of.get(usize::from(robot.0))?;
        self.designs.get(usize::from(number).checked_sub(1)?)?.as_ref()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    fn design(gain: f64) -> Design {
        let soil = SoilMotion { intended: 1.0, stuck: 0.0, sideways: 0.0, flights: 1 };
        Design {
            motion: MotionParameters {
                hard: soil,
                sand: soil,
                slope_limit_rad: 0.5,
                launch_angle_rad: 0.8,
                gravity_mps2: 3.72,
            },
            sensor: SensorParameters {
                gain,
                offset_m: 1.0,
                radius_min_m: 1.0,
                radius_max_m: 9.0,
                gradient: GradientSource::Measured,
            },
        }
    }

    #[test]
    fn equal_designs_are_kept_once_and_each_robot_has_its_own() {
        let given = [None, Some(design(1.0)), Some(design(2.0)), None, Some(design(1.0))];
        let designs = Designs::new(given).unwrap();
        for (robot, design) in (0..).zip(given) {
            assert_eq!(designs.of(RobotId(robot)).copied(), design, "robot {robot}");
        }
        assert_eq!(designs.of(RobotId(5)), None);
        assert_eq!(designs.of(RobotId(u16::MAX)), None);
        assert_eq!(Designs::new([None; ROBOTS_MAX]), Some(Designs::default()));
    }

    #[test]
    fn more_designs_or_robots_than_a_mission_may_have_are_none() {
        let different = |count: usize| (0..count).map(|number| Some(design(number as f64)));
        assert!(Designs::new(different(DESIGNS_MAX)).is_some());
        assert!(Designs::new(different(DESIGNS_MAX + 1)).is_none());
        assert!(Designs::new([Some(design(1.0)); ROBOTS_MAX + 1]).is_none());
    }
}
