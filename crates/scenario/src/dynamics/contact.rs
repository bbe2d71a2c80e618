//! A body that flies, hits, bounces and rolls.

use ::contact::{Aim, Body, Known, LaunchErrors, Soil};
use contract::{Body as RobotBody, Brief, Grid, Soil as SoilKind};
#[cfg(test)]
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use terrain::Terrain;

use super::{Preset, Rules};
use crate::ScenarioError;
use crate::bounds::in_range;

/// A sphere on two soils. What is left out is that of the preset, as `docs/dynamics.md` says.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(test, derive(JsonSchema))]
#[serde(deny_unknown_fields, default)]
pub struct ContactRules {
    /// Body whose soils these are: `moon`, `mars`, `phobos`, `ryugu` or `bennu`. Its gravity is that of `[robot]`.
    #[serde(skip_serializing_if = "Preset::is_mars")]
    pub preset: Preset,
    /// Radius of the body, metres; at most half a cell, since the contact point is taken to lie on the ground.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub radius_m: Option<f64>,
    /// Inertia of the body over m R²: 0.4 of a solid sphere, 2/3 of a shell.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub inertia: Option<f64>,
    /// Largest launch speed, m/s; by default 1.35 times that of the design hop on the flat.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub speed_max_mps: Option<f64>,
    /// Standard deviation of the launch speed, as a share of it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub speed_error: Option<f64>,
    /// Standard deviation of the launch's azimuth, radians.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub azimuth_error_rad: Option<f64>,
    /// Standard deviation of the launch's elevation, radians.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub elevation_error_rad: Option<f64>,
    /// Hard ground.
    #[serde(skip_serializing_if = "ContactSoilRules::is_empty")]
    pub hard: ContactSoilRules,
    /// Sand.
    #[serde(skip_serializing_if = "ContactSoilRules::is_empty")]
    pub sand: ContactSoilRules,
    /// What launch control believes of hard ground that is not so.
    #[serde(skip_serializing_if = "ContactSoilRules::is_empty")]
    pub nominal_hard: ContactSoilRules,
    /// What launch control believes of sand that is not so.
    #[serde(skip_serializing_if = "ContactSoilRules::is_empty")]
    pub nominal_sand: ContactSoilRules,
}

/// How a soil takes a body. What is left out is as it is otherwise.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(test, derive(JsonSchema))]
#[serde(deny_unknown_fields, default)]
pub struct ContactSoilRules {
    /// Normal restitution e₀, 0 to 1.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub restitution: Option<f64>,
    /// Impact speed v_e beyond which restitution falls, m/s.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub restitution_speed_mps: Option<f64>,
    /// Gravity g_e at which restitution has fallen to a half, m/s².
    #[serde(skip_serializing_if = "Option::is_none")]
    pub restitution_gravity_mps2: Option<f64>,
    /// Coulomb friction μ of an impact.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub friction: Option<f64>,
    /// Rolling resistance c: the tangent of the steepest slope on which the body rests.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub rolling: Option<f64>,
    /// Grip of the foot at a launch.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub foot: Option<f64>,
    /// Standard deviation of the normal at an impact, radians.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub roughness_rad: Option<f64>,
}

/// Largest launch speed where no other is said, in those of the design hop on the flat.
const SPEED_MAX: f64 = 1.35;

/// All parameters of the contact model.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ContactParameters {
    /// The body.
    pub body: Body,
    /// Errors of a launch.
    pub errors: LaunchErrors,
    /// Hard ground and sand, in the order of [`contract::Soil`].
    pub soils: [Soil; 2],
    /// Hard ground and sand, as launch control believes them to be.
    pub nominal: [Soil; 2],
    /// Largest launch speed, m/s, if the scenario says one.
    speed_max_mps: Option<f64>,
}

impl ContactParameters {
    /// The largest launch speed of a hopper whose hops on the flat are launched with `design_mps`, m/s.
    #[must_use]
    pub fn speed_max_mps(&self, design_mps: f64) -> f64 {
        self.speed_max_mps.unwrap_or(SPEED_MAX * design_mps)
    }
}

impl ContactRules {
    /// All parameters, with what is left out.
    #[must_use]
    pub fn parameters(&self) -> ContactParameters {
        let [hard, sand] = self.preset.soils();
        let soils = [self.hard.over(hard), self.sand.over(sand)];
        ContactParameters {
            body: Body { radius_m: self.radius_m.unwrap_or(0.1), inertia: self.inertia.unwrap_or(0.4) },
            errors: LaunchErrors {
                speed: self.speed_error.unwrap_or(0.1),
                azimuth_rad: self.azimuth_error_rad.unwrap_or(0.15),
                elevation_rad: self.elevation_error_rad.unwrap_or(0.03),
            },
            soils,
            nominal: [self.nominal_hard.over(soils[0]), self.nominal_sand.over(soils[1])],
            speed_max_mps: self.speed_max_mps,
        }
    }
}

impl ContactSoilRules {
    fn is_empty(&self) -> bool {
        *self == Self::default()
    }

    /// The soil, with what is left out of `base`.
    fn over(&self, base: Soil) -> Soil {
        Soil {
            restitution: self.restitution.unwrap_or(base.restitution),
            restitution_speed_mps: self.restitution_speed_mps.unwrap_or(base.restitution_speed_mps),
            restitution_gravity_mps2: self.restitution_gravity_mps2.unwrap_or(base.restitution_gravity_mps2),
            friction: self.friction.unwrap_or(base.friction),
            rolling: self.rolling.unwrap_or(base.rolling),
            foot: self.foot.unwrap_or(base.foot),
            roughness_rad: self.roughness_rad.unwrap_or(base.roughness_rad),
        }
    }
}

/// Names of the fields of a soil, in the order of [`values`].
macro_rules! soil_fields {
    ($soil:literal) => {
        [
            concat!("truth.dynamics.", $soil, ".restitution"),
            concat!("truth.dynamics.", $soil, ".restitution_speed_mps"),
            concat!("truth.dynamics.", $soil, ".restitution_gravity_mps2"),
            concat!("truth.dynamics.", $soil, ".friction"),
            concat!("truth.dynamics.", $soil, ".rolling"),
            concat!("truth.dynamics.", $soil, ".foot"),
            concat!("truth.dynamics.", $soil, ".roughness_rad"),
        ]
    };
}

/// What the fields of a soil need to be.
const SOIL_RANGES: [(f64, f64, &str); 7] = [
    (0.0, 1.0, "0 to 1"),
    (1e-9, f64::INFINITY, "a speed of at least 1e-9 m/s"),
    (1e-9, f64::INFINITY, "a gravity of at least 1e-9 m/s²"),
    (0.0, 100.0, "0 to 100"),
    (1e-6, 100.0, "0.000001 to 100"),
    (0.0, 100.0, "0 to 100"),
    (0.0, 0.5, "0 to 0.5 rad"),
];

fn values(soil: &Soil) -> [f64; 7] {
    let Soil { restitution, restitution_speed_mps, restitution_gravity_mps2, .. } = *soil;
    let Soil { friction, rolling, foot, roughness_rad, .. } = *soil;
    [restitution, restitution_speed_mps, restitution_gravity_mps2, friction, rolling, foot, roughness_rad]
}

impl Rules for ContactRules {
    fn check(&self, grid: &Grid) -> Result<(), ScenarioError> {
        let all = self.parameters();
        let radius = "above 0 and at most half the edge of a cell, since the contact point is taken to lie on the ground";
        in_range("truth.dynamics.radius_m", all.body.radius_m, 1e-6..=grid.cell_size_m / 2.0, radius)?;
        in_range("truth.dynamics.inertia", all.body.inertia, 1e-3..=1.0, "0.001 to 1")?;
        let speed_mps = all.speed_max_mps.unwrap_or(1.0);
        in_range("truth.dynamics.speed_max_mps", speed_mps, 1e-9..=1e3, "a speed above 0, at most 1000 m/s")?;
        let LaunchErrors { speed, azimuth_rad, elevation_rad } = all.errors;
        in_range("truth.dynamics.speed_error", speed, 0.0..=1.0, "0 to 1")?;
        in_range("truth.dynamics.azimuth_error_rad", azimuth_rad, 0.0..=1.0, "0 to 1 rad")?;
        in_range("truth.dynamics.elevation_error_rad", elevation_rad, 0.0..=1.0, "0 to 1 rad")?;
        let [hard, sand] = &all.soils;
        let [nominal_hard, nominal_sand] = &all.nominal;
        for (fields, soil) in [
            (soil_fields!("hard"), hard),
            (soil_fields!("sand"), sand),
            (soil_fields!("nominal_hard"), nominal_hard),
            (soil_fields!("nominal_sand"), nominal_sand),
        ] {
            for ((field, value), (min, max, need)) in fields.into_iter().zip(values(soil)).zip(SOIL_RANGES) {
                in_range(field, value, min..=max, need)?;
            }
        }
        Ok(())
    }

    fn check_hops(&self, brief: &Brief, terrain: &Terrain) -> Result<(), ScenarioError> {
        let parameters = self.parameters();
        let ContactParameters { body: sphere, nominal, .. } = &parameters;
        let hop_m = brief.grid.hop_distance_m();
        let hoppers = brief.robots.iter().filter_map(|robot| match &robot.body {
            RobotBody::Hopper(hopper) => Some(hopper.motion),
            _ => None,
        });
        for motion in hoppers {
            let design = motion::launch_over(&motion, hop_m);
            let aim = Aim {
                target_m: [hop_m, 0.0],
                elevation_rad: motion.launch_angle_rad,
                speed_max_mps: parameters.speed_max_mps(design.speed_mps),
            };
            for kind in SoilKind::ALL {
                let known = Known { gradient: [0.0; 2], soil: nominal[kind as usize] };
                let is_there = terrain.cells.iter().any(|ground| ground.soil == kind);
                if is_there && !aim.is_reached(sphere, motion.gravity_mps2, &known) {
                    return Err(ScenarioError::ShortHop {
                        soil: kind.name(),
                        hop_m,
                        speed_mps: aim.speed_max_mps,
                        foot: known.soil.foot,
                    });
                }
            }
        }
        Ok(())
    }
}
