//! `hop/brief`.

use bytemuck::{Pod, Zeroable};

use crate::Role;
use crate::fixed_payload;

use super::{
    Wire, cell_from_wire, cell_to_wire, float, grid_from_wire, length, name_from_wire, run_from_wire,
    run_to_wire, tag,
};
use crate::limits::{
    BUDGET_MAX_NS, DECISIONS_MAX, DESIGNS_MAX, GOALS_MAX, LENGTH_MAX_M, PAYOFF_MAX, ROBOTS_MAX, SAMPLES_MAX,
    TREASURES_MAX,
};
use crate::message::{Message, PublishSubscribe};
use crate::{
    Brief, Cell, Cover, CoverMode, Design, Designs, DistanceNorm, GradientSource, Guard, Limits, Mixed,
    MotionParameters, Name, Patrol, Payoff, Priors, Profile, Range, Reading, Refusal, RobotSet, Scout,
    SensorParameters, SoilMotion, Weights,
};

/// Scatter of hops on one soil.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct SoilMotionV1 {
    /// Probability of the intended landing on the flat.
    pub intended: f64,
    /// Probability of staying stuck.
    pub stuck: f64,
    /// Probability of a slip to either side.
    pub sideways: f64,
    /// Flights per intended hop, 1 or 2.
    pub flights: u32,
    pub reserved: u32,
}

/// How some hoppers hop and see. Slope limit, gravity and gradient source are those of the brief.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct DesignV1 {
    /// The robots that are of this design, one bit each; 0 for an unused one, whose other fields are 0 too.
    pub robots: u32,
    pub reserved: u32,
    /// Scatter on hard ground.
    pub hard: SoilMotionV1,
    /// Scatter on sand.
    pub sand: SoilMotionV1,
    /// Launch angle, radians.
    pub launch_angle_rad: f64,
    /// Sensor gain, m/m.
    pub sensor_gain: f64,
    /// Sensor offset, metres.
    pub sensor_offset_m: f64,
    /// Sensing radius, metres, smallest first.
    pub sensor_radius_m: [f64; 2],
}

#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct BriefV9 {
    pub run: [u64; 2],
    /// Name of the scenario, zero-padded ASCII.
    pub scenario: [u8; Name::BYTES],
    /// SHA-256 over the resolved scenario and its terrain.
    pub scenario_hash: [u8; 32],
    /// [`Profile::code`].
    pub profile: u32,
    /// Robots of the mission.
    pub robots: u32,
    pub width: u32,
    pub height: u32,
    /// Cells that one hop spans.
    pub hop_cells: u32,
    /// 1 measured, 2 differences over seen cells.
    pub gradient_source: u32,
    /// Edge of a cell, metres.
    pub cell_size_m: f64,
    /// Absolute elevation of height 0, metres.
    pub datum_m: f64,
    /// Start (x, y), cells.
    pub start: [i32; 2],
    /// Goal (x, y), cells.
    pub goal: [i32; 2],
    /// Weights w1, w2, w3.
    pub weights: [f64; 3],
    /// Payoff of the goal.
    pub payoff_goal: f64,
    /// Payoff of a treasure.
    pub payoff_treasure: f64,
    /// Discount γ, in (0, 1).
    pub discount: f64,
    /// Soil term T on sand.
    pub sand_term: f64,
    /// Range of S, lower end first.
    pub safety_range: [f64; 2],
    /// Range of I, metres, lower end first.
    pub height_range_m: [f64; 2],
    /// Treasures on the map; 0 for none or an unknown number.
    pub treasures: u32,
    pub reserved: u32,
    /// Scatter on hard ground.
    pub hard: SoilMotionV1,
    /// Scatter on sand.
    pub sand: SoilMotionV1,
    /// Slope limit, radians.
    pub slope_limit_rad: f64,
    /// Launch angle, radians.
    pub launch_angle_rad: f64,
    /// Gravity, m/s².
    pub gravity_mps2: f64,
    /// Sensor gain, m/m.
    pub sensor_gain: f64,
    /// Sensor offset, metres.
    pub sensor_offset_m: f64,
    /// Sensing radius, metres, smallest first.
    pub sensor_radius_m: [f64; 2],
    /// Steps after which the mission is a deadlock.
    pub steps_max: u64,
    /// Budget of a decision, nanoseconds.
    pub decision_budget_ns: u64,
    /// Largest hazard that the guard lets pass.
    pub hazard_max: f64,
    /// Time to the fallback, nanoseconds; 0 for none.
    pub deadline_ns: u64,
    /// Hops after which a patrol is flown; 0 for no patrol.
    pub hops_max: u64,
    /// What leaving the map is worth to the plan; 0 counts it as staying.
    pub leaving: f64,
    /// Distance at which D is −1, cells; 0 for that from start to goal.
    pub distance_scale_cells: f64,
    /// Steps counted for the first observation.
    pub opening_steps: u64,
    /// 0 Euclidean, 1 Manhattan.
    pub distance_norm: u32,
    /// Goals of a patrol; 0 for no patrol.
    pub goal_count: u32,
    /// The goals (x, y), cells, the rest zero.
    pub goals: [[i32; 2]; GOALS_MAX],
    /// Share of the ground that rovers shall cover, %; 0 for another task.
    pub cover_percent: u32,
    /// 0 overlap, 1 Voronoi.
    pub cover_mode: u32,
    /// Seed of planners of routes.
    pub scout_seed: u64,
    /// Samples of a rover's planner; 0 for another task.
    pub rover_samples: u32,
    /// Samples of a helicopter's planner.
    pub helicopter_samples: u32,
    /// The robots that decide a mission whose robots have tasks of their own, one bit each; 0 for another mission.
    pub required: u32,
    /// Stages after the first.
    pub further_stages: u32,
    /// Designs of hoppers that hop or see otherwise; the rest zero.
    pub designs: [DesignV1; DESIGNS_MAX],
}

const _: () = assert!(size_of::<SoilMotionV1>() == 32);
const _: () = assert!(size_of::<DesignV1>() == 112);
const _: () = assert!(size_of::<BriefV9>() == 584 + 448);

impl Wire for BriefV9 {
    const NAME: &'static str = "hop.Brief.v9";
}

impl From<&SoilMotion> for SoilMotionV1 {
    fn from(motion: &SoilMotion) -> Self {
        Self {
            intended: motion.intended,
            stuck: motion.stuck,
            sideways: motion.sideways,
            flights: motion.flights,
            reserved: 0,
        }
    }
}

impl TryFrom<&SoilMotionV1> for SoilMotion {
    type Error = Refusal;

    fn try_from(wire: &SoilMotionV1) -> Result<Self, Refusal> {
        let sum = wire.intended + wire.stuck + 2.0 * wire.sideways;
        float("motion.sum", sum, 1.0 - 1e-9, 1.0 + 1e-9)?;
        if !(1..=2).contains(&wire.flights) {
            return Err(Refusal::malformed("motion.flights", "1 or 2", wire.flights));
        }
        Ok(Self {
            intended: float("motion.intended", wire.intended, 0.0, 1.0)?,
            stuck: float("motion.stuck", wire.stuck, 0.0, 1.0)?,
            sideways: float("motion.sideways", wire.sideways, 0.0, 0.5)?,
            flights: wire.flights,
        })
    }
}

impl From<&Brief> for BriefV9 {
    fn from(brief: &Brief) -> Self {
        Self {
            run: run_to_wire(brief.run),
            scenario: brief.scenario.bytes(),
            scenario_hash: brief.scenario_hash,
            profile: brief.profile.code(),
            robots: u32::from(brief.robots),
            width: brief.grid.width,
            height: brief.grid.height,
            hop_cells: brief.grid.hop_cells,
            gradient_source: match brief.sensor.gradient {
                GradientSource::Measured => 1,
                GradientSource::SeenDifferences => 2,
            },
            cell_size_m: brief.grid.cell_size_m,
            datum_m: brief.datum_m,
            start: cell_to_wire(brief.start),
            goal: cell_to_wire(brief.goal),
            weights: [brief.weights.safety, brief.weights.information, brief.weights.distance],
            payoff_goal: brief.payoff.goal,
            payoff_treasure: brief.payoff.treasure,
            discount: brief.payoff.discount,
            sand_term: brief.payoff.sand_term,
            safety_range: [brief.priors.safety.min, brief.priors.safety.max],
            height_range_m: [brief.priors.height_m.min, brief.priors.height_m.max],
            treasures: brief.priors.treasures,
            reserved: 0,
            hard: (&brief.motion.hard).into(),
            sand: (&brief.motion.sand).into(),
            slope_limit_rad: brief.motion.slope_limit_rad,
            launch_angle_rad: brief.motion.launch_angle_rad,
            gravity_mps2: brief.motion.gravity_mps2,
            sensor_gain: brief.sensor.gain,
            sensor_offset_m: brief.sensor.offset_m,
            sensor_radius_m: [brief.sensor.radius_min_m, brief.sensor.radius_max_m],
            steps_max: brief.limits.steps_max,
            decision_budget_ns: brief.limits.decision_budget_ns,
            hazard_max: brief.guard.hazard_max,
            deadline_ns: brief.guard.deadline_ns,
            hops_max: brief.patrol.map_or(0, |patrol| patrol.hops_max),
            leaving: brief.reading.leaving.unwrap_or(0.0),
            distance_scale_cells: brief.reading.distance_scale_cells.unwrap_or(0.0),
            opening_steps: brief.reading.opening_steps,
            distance_norm: match brief.reading.distance {
                DistanceNorm::Euclidean => 0,
                DistanceNorm::Manhattan => 1,
            },
            goal_count: brief.patrol.map_or(0, |patrol| patrol.goals().len() as u32),
            goals: goals_to_wire(brief.patrol.as_ref()),
            cover_percent: brief.cover.map_or(0, |cover| cover.percent),
            cover_mode: brief.cover.map_or(0, |cover| match cover.mode {
                CoverMode::Overlap => 0,
                CoverMode::Voronoi => 1,
            }),
            scout_seed: brief.scout.map_or(0, |scout| scout.seed),
            rover_samples: brief.scout.map_or(0, |scout| scout.rover_samples),
            helicopter_samples: brief.scout.map_or(0, |scout| scout.helicopter_samples),
            required: brief.mixed.map_or(0, |mixed| mixed.required.0.into()),
            further_stages: brief.scout.map_or(0, |scout| scout.stages.saturating_sub(1)),
            designs: designs_to_wire(brief),
        }
    }
}

impl TryFrom<&BriefV9> for Brief {
    type Error = Refusal;

    // Long: every field is validated once, in the order of the struct.
    fn try_from(wire: &BriefV9) -> Result<Self, Refusal> {
        let grid = grid_from_wire("brief.grid", [wire.width, wire.height], wire.cell_size_m, wire.hop_cells)?;
        let on_grid = |field: &str, cell: [i32; 2]| -> Result<Cell, Refusal> {
            let cell = cell_from_wire(field, cell)?;
            if grid.contains(cell) {
                Ok(cell)
            } else {
                Err(Refusal::malformed(field, "a cell on the grid", cell))
            }
        };
        let payoff = |field: &str, value| float(field, value, -PAYOFF_MAX, PAYOFF_MAX);
        let range = |field: &str, [min, max]: [f64; 2]| -> Result<Range, Refusal> {
            Ok(Range { min: length(field, min)?, max: float(field, max, min, LENGTH_MAX_M)? })
        };
        let goal = on_grid("brief.goal", wire.goal)?;
        let patrol = patrol_from_wire(wire, on_grid)?;
        if patrol.is_some_and(|patrol| patrol.goal(0) != goal) {
            return Err(Refusal::malformed("brief.goal", "the patrol's first", goal));
        }
        let Design { motion, sensor } = design_from_wire(wire, &own_design(wire))?;
        let robots =
            u16::try_from(wire.robots).ok().filter(|robots| (1..=ROBOTS_MAX).contains(&usize::from(*robots)));
        Ok(Self {
            run: run_from_wire(wire.run),
            scenario: name_from_wire("brief.scenario", wire.scenario)?,
            scenario_hash: wire.scenario_hash,
            profile: tag("brief.profile", wire.profile, Profile::from_code)?,
            robots: robots.ok_or_else(|| {
                Refusal::malformed("brief.robots", &format!("1 to {ROBOTS_MAX}"), wire.robots)
            })?,
            grid,
            datum_m: length("brief.datum_m", wire.datum_m)?,
            start: on_grid("brief.start", wire.start)?,
            goal,
            patrol,
            weights: Weights {
                safety: payoff("brief.weights.safety", wire.weights[0])?,
                information: payoff("brief.weights.information", wire.weights[1])?,
                distance: payoff("brief.weights.distance", wire.weights[2])?,
            },
            payoff: Payoff {
                goal: payoff("brief.payoff.goal", wire.payoff_goal)?,
                treasure: payoff("brief.payoff.treasure", wire.payoff_treasure)?,
                discount: float("brief.payoff.discount", wire.discount, 0.01, 0.9999)?,
                sand_term: payoff("brief.payoff.sand_term", wire.sand_term)?,
            },
            priors: Priors {
                safety: range("brief.priors.safety", wire.safety_range)?,
                height_m: range("brief.priors.height_m", wire.height_range_m)?,
                treasures: treasures_from_wire(wire.treasures)?,
            },
            motion,
            sensor,
            limits: Limits {
                steps_max: if (1..=DECISIONS_MAX).contains(&wire.steps_max) {
                    wire.steps_max
                } else {
                    return Err(Refusal::malformed(
                        "brief.steps_max",
                        &format!("1 to {DECISIONS_MAX}"),
                        wire.steps_max,
                    ));
                },
                decision_budget_ns: if wire.decision_budget_ns <= BUDGET_MAX_NS {
                    wire.decision_budget_ns
                } else {
                    return Err(Refusal::malformed(
                        "brief.decision_budget_ns",
                        &format!("at most {BUDGET_MAX_NS}"),
                        wire.decision_budget_ns,
                    ));
                },
            },
            guard: Guard {
                hazard_max: float("brief.guard.hazard_max", wire.hazard_max, 0.0, 1.0)?,
                deadline_ns: wire.deadline_ns,
            },
            reading: reading_from_wire(wire)?,
            cover: cover_from_wire(wire)?,
            scout: scout_from_wire(wire)?,
            mixed: mixed_from_wire(wire)?,
        })
    }
}

/// Smallest distance at which D may be −1, cells: the payoff stays within bounds.
const SCALE_MIN_CELLS: f64 = 1e-3;

fn treasures_from_wire(treasures: u32) -> Result<u32, Refusal> {
    if treasures as usize <= TREASURES_MAX {
        Ok(treasures)
    } else {
        Err(Refusal::malformed("brief.priors.treasures", &format!("at most {TREASURES_MAX}"), treasures))
    }
}

fn reading_from_wire(wire: &BriefV9) -> Result<Reading, Refusal> {
    let given = |value: f64| (value != 0.0).then_some(value);
    let leaving = float("brief.reading.leaving", wire.leaving, -PAYOFF_MAX, 0.0)?;
    let scale = match given(wire.distance_scale_cells) {
        Some(scale) => {
            Some(float("brief.reading.distance_scale_cells", scale, SCALE_MIN_CELLS, LENGTH_MAX_M)?)
        }
        None => None,
    };
    if wire.opening_steps >= wire.steps_max {
        let need = format!("less than the {} steps of the mission", wire.steps_max);
        return Err(Refusal::malformed("brief.reading.opening_steps", &need, wire.opening_steps));
    }
    Ok(Reading {
        leaving: given(leaving),
        distance: tag("brief.reading.distance", wire.distance_norm, |code| match code {
            0 => Some(DistanceNorm::Euclidean),
            1 => Some(DistanceNorm::Manhattan),
            _ => None,
        })?,
        distance_scale_cells: scale,
        opening_steps: wire.opening_steps,
    })
}

fn cover_from_wire(wire: &BriefV9) -> Result<Option<Cover>, Refusal> {
    if wire.cover_percent > 100 {
        return Err(Refusal::malformed("brief.cover.percent", "at most 100", wire.cover_percent));
    }
    let mode = tag("brief.cover.mode", wire.cover_mode, |code| match code {
        0 => Some(CoverMode::Overlap),
        1 => Some(CoverMode::Voronoi),
        _ => None,
    })?;
    Ok((wire.cover_percent > 0).then_some(Cover { percent: wire.cover_percent, mode }))
}

fn scout_from_wire(wire: &BriefV9) -> Result<Option<Scout>, Refusal> {
    let BriefV9 { scout_seed: seed, rover_samples, helicopter_samples, further_stages, .. } = *wire;
    if rover_samples == 0 && helicopter_samples == 0 {
        return Ok(None);
    }
    for (field, samples) in
        [("brief.scout.rover_samples", rover_samples), ("brief.scout.helicopter_samples", helicopter_samples)]
    {
        if !(1..=SAMPLES_MAX).contains(&samples) {
            return Err(Refusal::malformed(field, &format!("1 to {SAMPLES_MAX}"), samples));
        }
    }
    if wire.cover_percent > 0 && wire.required == 0 {
        return Err(Refusal::malformed(
            "brief.scout",
            "no ground to cover, unless robots have tasks of their own",
            format!("{} %", wire.cover_percent),
        ));
    }
    if further_stages >= Scout::STAGES_MAX {
        let need = format!("below {}", Scout::STAGES_MAX);
        return Err(Refusal::malformed("brief.scout.further_stages", &need, further_stages));
    }
    if further_stages > 0 && wire.required != 0 {
        let need = "0 where robots have tasks of their own";
        return Err(Refusal::malformed("brief.scout.further_stages", need, further_stages));
    }
    Ok(Some(Scout { seed, rover_samples, helicopter_samples, stages: further_stages + 1 }))
}

fn mixed_from_wire(wire: &BriefV9) -> Result<Option<Mixed>, Refusal> {
    if wire.required == 0 {
        let need = "none but where robots have tasks of their own";
        return match wire.designs.iter().find(|design| **design != DesignV1::zeroed()) {
            None => Ok(None),
            Some(design) => Err(Refusal::malformed("brief.designs", need, design.robots)),
        };
    }
    if wire.goal_count > 0 {
        return Err(Refusal::malformed(
            "brief.patrol",
            "none where robots have tasks of their own",
            wire.goal_count,
        ));
    }
    let all = RobotSet::ALL.of(u16::try_from(wire.robots).unwrap_or(u16::MAX));
    let required = u16::try_from(wire.required).ok().map(RobotSet).filter(|set| set.0 & !all.0 == 0);
    let refuse =
        || Refusal::malformed("brief.required", &format!("robots of the mission, {all}"), wire.required);
    Ok(Some(Mixed { required: required.ok_or_else(refuse)?, designs: designs_from_wire(wire)? }))
}

/// The design that most hoppers have, as one of many.
fn own_design(wire: &BriefV9) -> DesignV1 {
    DesignV1 {
        robots: 0,
        reserved: 0,
        hard: wire.hard,
        sand: wire.sand,
        launch_angle_rad: wire.launch_angle_rad,
        sensor_gain: wire.sensor_gain,
        sensor_offset_m: wire.sensor_offset_m,
        sensor_radius_m: wire.sensor_radius_m,
    }
}

fn design_from_wire(brief: &BriefV9, wire: &DesignV1) -> Result<Design, Refusal> {
    let [min_m, max_m] = wire.sensor_radius_m;
    Ok(Design {
        motion: MotionParameters {
            hard: (&wire.hard).try_into()?,
            sand: (&wire.sand).try_into()?,
            slope_limit_rad: float("brief.slope_limit_rad", brief.slope_limit_rad, 0.01, 1.57)?,
            launch_angle_rad: float("brief.launch_angle_rad", wire.launch_angle_rad, 0.01, 1.56)?,
            gravity_mps2: float("brief.gravity_mps2", brief.gravity_mps2, 1.0e-4, 100.0)?,
        },
        sensor: SensorParameters {
            gain: float("brief.sensor.gain", wire.sensor_gain, 0.0, 1.0e6)?,
            offset_m: length("brief.sensor.offset_m", wire.sensor_offset_m)?,
            radius_min_m: float("brief.sensor.radius_min_m", min_m, 0.0, LENGTH_MAX_M)?,
            radius_max_m: float("brief.sensor.radius_max_m", max_m, min_m, LENGTH_MAX_M)?,
            gradient: tag("brief.gradient_source", brief.gradient_source, |code| match code {
                1 => Some(GradientSource::Measured),
                2 => Some(GradientSource::SeenDifferences),
                _ => None,
            })?,
        },
    })
}

fn designs_from_wire(wire: &BriefV9) -> Result<Designs, Refusal> {
    let mut of = [None; ROBOTS_MAX];
    let all = RobotSet::ALL.of(u16::try_from(wire.robots).unwrap_or(u16::MAX));
    for design in wire.designs.iter().filter(|design| **design != DesignV1::zeroed()) {
        let parsed = design_from_wire(wire, design)?;
        let robots =
            u16::try_from(design.robots).ok().map(RobotSet).filter(|set| set.0 != 0 && set.0 & !all.0 == 0);
        let refuse = || {
            let need = format!("robots of the mission, {all}, each once");
            Refusal::malformed("brief.designs", &need, design.robots)
        };
        for robot in robots.ok_or_else(refuse)?.iter() {
            if of[usize::from(robot.0)].replace(parsed).is_some() {
                return Err(refuse());
            }
        }
    }
    Designs::new(of).ok_or_else(|| {
        let need = format!("at most {DESIGNS_MAX} different ones");
        Refusal::malformed("brief.designs", &need, "more")
    })
}

fn designs_to_wire(brief: &Brief) -> [DesignV1; DESIGNS_MAX] {
    let mut designs = [DesignV1::zeroed(); DESIGNS_MAX];
    let Some(mixed) = &brief.mixed else { return designs };
    for robot in RobotSet::first(brief.robots).iter() {
        let Some(Design { motion, sensor }) = mixed.designs.of(robot) else { continue };
        let wire = DesignV1 {
            robots: 0,
            reserved: 0,
            hard: (&motion.hard).into(),
            sand: (&motion.sand).into(),
            launch_angle_rad: motion.launch_angle_rad,
            sensor_gain: sensor.gain,
            sensor_offset_m: sensor.offset_m,
            sensor_radius_m: [sensor.radius_min_m, sensor.radius_max_m],
        };
        let same = |known: &&mut DesignV1| known.robots == 0 || DesignV1 { robots: 0, ..**known } == wire;
        if let Some(place) = designs.iter_mut().find(same) {
            *place = DesignV1 { robots: place.robots | 1 << robot.0, ..wire };
        }
    }
    designs
}

fn goals_to_wire(patrol: Option<&Patrol>) -> [[i32; 2]; GOALS_MAX] {
    let mut cells = [[0; 2]; GOALS_MAX];
    for (wire, goal) in cells.iter_mut().zip(patrol.map_or(&[][..], Patrol::goals)) {
        *wire = cell_to_wire(*goal);
    }
    cells
}

fn patrol_from_wire(
    wire: &BriefV9,
    on_grid: impl Fn(&str, [i32; 2]) -> Result<Cell, Refusal>,
) -> Result<Option<Patrol>, Refusal> {
    if wire.goal_count == 0 && wire.hops_max == 0 {
        return Ok(None);
    }
    let need = format!("2 to {GOALS_MAX}, each another than the one before, and 1 to {DECISIONS_MAX} hops");
    let refuse = || Refusal::malformed("brief.patrol", &need, wire.goal_count);
    let cells = wire.goals.get(..wire.goal_count as usize).ok_or_else(refuse)?;
    let goals: Vec<Cell> =
        cells.iter().map(|cell| on_grid("brief.patrol", *cell)).collect::<Result<_, _>>()?;
    let hops_max = Some(wire.hops_max).filter(|hops| *hops <= DECISIONS_MAX).ok_or_else(refuse)?;
    Patrol::new(&goals, hops_max).map(Some).ok_or_else(refuse)
}

fixed_payload!(Brief => BriefV9);

/// Tells every process of the run; a late reader gets the last one.
impl Message for Brief {
    const SERVICE: PublishSubscribe =
        PublishSubscribe { max_subscribers: 24, ..PublishSubscribe::new("hop/brief", &[Role::HopperSim]) };
}
