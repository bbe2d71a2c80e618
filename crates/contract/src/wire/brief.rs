//! `hop/brief`.

use bytemuck::Zeroable;

use crate::Role;
use crate::fixed_payload;

use super::codec::{
    ANY, Ascending, CELL, Codec, DISTANCE, Float, LENGTH, NAME, PAYOFF, PROBABILITY, RUN, Whole, ascending,
    at_most, by_hand, each, float, joint, narrow, or_zero, part, tag, whole,
};
use super::declaration::wire;
use super::{CELL_SIZE, GRID_SIDE, HOP_CELLS, grid_from_wire};
use crate::limits::{
    BUDGET_MAX_NS, DECISIONS_MAX, DESIGNS_MAX, GOALS_MAX, LENGTH_MAX_M, PAYOFF_MAX, ROBOTS_MAX, SAMPLES_MAX,
    TREASURES_MAX,
};
use crate::message::{Message, PublishSubscribe};
use crate::{
    Brief, Cell, Cover, CoverMode, Design, Designs, DistanceNorm, GradientSource, Grid, Guard, Limits, Mixed,
    MotionParameters, Name, Patrol, Payoff, Priors, Profile, Range, Reading, Refusal, RobotSet, Scout,
    SensorParameters, SoilMotion, Weights,
};

/// Angle of a launch above the horizontal, radians: neither flat nor straight up, where a hop gets nowhere.
const LAUNCH_ANGLE: Float = float(0.01, 1.56);

/// Gain of the sensor, metres of radius per metre of height.
const SENSOR_GAIN: Float = float(0.0, 1.0e6);

/// Samples of a planner that draws random ones.
const SAMPLES: Whole = whole(1, SAMPLES_MAX as u64);

/// Hops of a patrol.
const HOPS: Whole = whole(1, DECISIONS_MAX);

/// The ends of a range, the lower one first.
const SPAN: Ascending = ascending(LENGTH, ["", ""]);

/// The smallest and the largest sensing radius, metres.
const RADII: Ascending = ascending(DISTANCE, ["_min_m", "_max_m"]);

wire! {
    /// Scatter of hops on one soil.
    pub struct SoilMotionV1 = "hop.SoilMotion.v1", 32 bytes, refused as "motion" {
        /// Probability of the intended landing on the flat.
        intended: f64 = PROBABILITY,
        /// Probability of staying stuck.
        stuck: f64 = PROBABILITY,
        /// Probability of a slip to one side, the same to the other. All four add up to 1.
        sideways: f64 = float(0.0, 0.5),
        /// Flights per intended hop: two half hops on sand.
        flights: u32 = whole(1, 2),
        reserved: u32,
    }
    of SoilMotion { intended, stuck, sideways, flights }
    check(wire) {
        let sum = wire.intended + wire.stuck + 2.0 * wire.sideways;
        float(1.0 - 1e-9, 1.0 + 1e-9).from_wire("motion.sum", sum)?;
    }
}

wire! {
    /// How some hoppers hop and see. Slope limit, gravity and gradient source are those of the brief.
    pub struct DesignV1 = "hop.Design.v1", 112 bytes, refused as "brief" {
        /// The robots that are of this design, one bit each; 0 for an unused one, whose other fields are 0 too.
        robots: u32 = by_hand("robots of the mission, each once"),
        reserved: u32,
        /// Scatter on hard ground.
        hard: SoilMotionV1 = part::<SoilMotion>(),
        /// Scatter on sand.
        sand: SoilMotionV1 = part::<SoilMotion>(),
        /// Launch angle, radians.
        launch_angle_rad: f64 = LAUNCH_ANGLE,
        /// Sensor gain, m/m.
        sensor_gain: f64 = SENSOR_GAIN => "brief.sensor.gain",
        /// Sensor offset, metres.
        sensor_offset_m: f64 = LENGTH => "brief.sensor.offset_m",
        /// Smallest and largest sensing radius, metres.
        sensor_radius_m: [f64; 2] = RADII => "brief.sensor.radius",
    }
    of Design {
        motion: MotionParameters { hard, sand, slope_limit_rad, launch_angle_rad, gravity_mps2 },
        sensor: SensorParameters {
            gain: sensor_gain, offset_m: sensor_offset_m, radius_min_m, radius_max_m, gradient,
        },
    }
    to_wire {
        let robots = &0;
        let sensor_radius_m = &Range { min: *radius_min_m, max: *radius_max_m };
    }
    from_wire(wire) {
        let Range { min: radius_min_m, max: radius_max_m } = sensor_radius_m;
        let MotionParameters { slope_limit_rad, gravity_mps2, .. } = common.motion;
        let gradient = common.sensor.gradient;
    }
    /// The design with what it has in `common` with that of the brief.
    fn design_from_wire(common: &Design);
}

wire! {
    /// What the mission asks for.
    pub struct BriefV9 = "hop.Brief.v9", 1032 bytes, refused as "brief" {
        /// Run that begins.
        run: [u64; 2] = RUN,
        /// Name of the scenario.
        scenario: [u8; Name::BYTES] = NAME,
        /// SHA-256 over the resolved scenario and its terrain.
        scenario_hash: [u8; 32] = ANY,
        /// Reading of the model that the mission follows.
        profile: u32 = tag(Profile::code, Profile::from_code),
        /// Robots of the mission.
        robots: u32 = narrow(1, ROBOTS_MAX as u16),
        /// Columns.
        width: u32 = GRID_SIDE => "brief.grid",
        /// Rows.
        height: u32 = GRID_SIDE => "brief.grid",
        /// Cells that one hop spans.
        hop_cells: u32 = HOP_CELLS => "brief.grid",
        /// Where gradients of the observed map come from.
        gradient_source: u32 = tag(gradient_code, gradient_from_code),
        /// Edge of a cell, metres.
        cell_size_m: f64 = CELL_SIZE => "brief.grid",
        /// Absolute elevation of height 0, metres.
        datum_m: f64 = LENGTH,
        /// Start (x, y), cells.
        start: [i32; 2] = by_hand("a cell on the grid"),
        /// Goal (x, y), cells.
        goal: [i32; 2] = by_hand("a cell on the grid; the first of `goals` on a patrol"),
        /// Weights w1, w2, w3.
        weights: [f64; 3] = each(PAYOFF, ["safety", "information", "distance"]),
        /// Payoff of the goal.
        payoff_goal: f64 = PAYOFF => "brief.payoff.goal",
        /// Payoff of a treasure.
        payoff_treasure: f64 = PAYOFF => "brief.payoff.treasure",
        /// Discount γ; so far from 0 and 1 that values stay within bounds.
        discount: f64 = float(0.01, 0.9999) => "brief.payoff.discount",
        /// Soil term T on sand.
        sand_term: f64 = PAYOFF => "brief.payoff.sand_term",
        /// Range of S.
        safety_range: [f64; 2] = SPAN => "brief.priors.safety",
        /// Range of I, metres.
        height_range_m: [f64; 2] = SPAN => "brief.priors.height_m",
        /// Treasures on the map; 0 for none or an unknown number.
        treasures: u32 = at_most(TREASURES_MAX as u64) => "brief.priors.treasures",
        reserved: u32,
        /// Scatter on hard ground.
        hard: SoilMotionV1 = part::<SoilMotion>(),
        /// Scatter on sand.
        sand: SoilMotionV1 = part::<SoilMotion>(),
        /// Slope at which a hop no longer gets anywhere, radians; below π/2.
        slope_limit_rad: f64 = float(0.01, 1.57),
        /// Launch angle, radians.
        launch_angle_rad: f64 = LAUNCH_ANGLE,
        /// Gravity, m/s²; from that of a comet to four times that of Jupiter.
        gravity_mps2: f64 = float(1.0e-4, 100.0),
        /// Sensor gain, m/m.
        sensor_gain: f64 = SENSOR_GAIN => "brief.sensor.gain",
        /// Sensor offset, metres.
        sensor_offset_m: f64 = LENGTH => "brief.sensor.offset_m",
        /// Smallest and largest sensing radius, metres.
        sensor_radius_m: [f64; 2] = RADII => "brief.sensor.radius",
        /// Steps after which the mission is a deadlock.
        steps_max: u64 = whole(1, DECISIONS_MAX),
        /// Budget of a decision, nanoseconds.
        decision_budget_ns: u64 = at_most(BUDGET_MAX_NS),
        /// Largest hazard that the guard lets pass.
        hazard_max: f64 = PROBABILITY => "brief.guard.hazard_max",
        /// Time to the fallback, nanoseconds; 0 for none.
        deadline_ns: u64 = ANY,
        /// Hops after which a patrol is flown; 0 for no patrol.
        hops_max: u64 = joint(HOPS, "read with a patrol") => "brief.patrol",
        /// What leaving the map is worth to the plan, never a gain; 0 counts it as staying.
        leaving: f64 = or_zero(float(-PAYOFF_MAX, 0.0)) => "brief.reading.leaving",
        /// Distance at which D is −1, cells: not so small that the payoff leaves its bounds; 0 for that from start
        /// to goal.
        distance_scale_cells: f64 = or_zero(float(1e-3, LENGTH_MAX_M))
            => "brief.reading.distance_scale_cells",
        /// Steps counted for the first observation.
        opening_steps: u64 = by_hand("less than `steps_max`"),
        /// How the distance D is measured.
        distance_norm: u32 = tag(norm_code, norm_from_code) => "brief.reading.distance",
        /// Goals of a patrol; 0 for no patrol.
        goal_count: u32 = joint(whole(2, GOALS_MAX as u64), "read with a patrol") => "brief.patrol",
        /// Goals (x, y) of a patrol, cells, the rest zero.
        goals: [[i32; 2]; GOALS_MAX] = by_hand("cells on the grid, each another than the one before"),
        /// Share of the ground that rovers shall cover, %; 0 for another task.
        cover_percent: u32 = at_most(100) => "brief.cover.percent",
        /// How rovers share the ground that they cover.
        cover_mode: u32 = tag(mode_code, mode_from_code) => "brief.cover.mode",
        /// Seed of planners of routes.
        scout_seed: u64 = ANY,
        /// Samples of a rover's planner; 0 for another task.
        rover_samples: u32 = joint(SAMPLES, "0 in both for another task") => "brief.scout.rover_samples",
        /// Samples of a helicopter's planner; 0 for another task.
        helicopter_samples: u32 = joint(SAMPLES, "0 in both for another task")
            => "brief.scout.helicopter_samples",
        /// The robots that decide a mission whose robots have tasks of their own, one bit each; 0 for another
        /// mission.
        required: u32 = by_hand("robots of the mission"),
        /// Stages after the first; 0 where robots have tasks of their own.
        further_stages: u32 = joint(at_most(Scout::STAGES_MAX as u64 - 1), "read with samples")
            => "brief.scout.further_stages",
        /// Designs of hoppers that hop or see otherwise; the rest zero.
        designs: [DesignV1; DESIGNS_MAX] = by_hand("as `hop.Design.v1`; zero without `required`"),
    }
    of Brief {
        run,
        scenario,
        scenario_hash,
        profile,
        robots,
        grid,
        datum_m,
        start,
        goal,
        patrol,
        weights: Weights { safety, information, distance },
        payoff: Payoff { goal: payoff_goal, treasure: payoff_treasure, discount, sand_term },
        priors: Priors { safety: safety_range, height_m: height_range_m, treasures },
        motion: MotionParameters { hard, sand, slope_limit_rad, launch_angle_rad, gravity_mps2 },
        sensor: SensorParameters {
            gain: sensor_gain, offset_m: sensor_offset_m, radius_min_m, radius_max_m, gradient: gradient_source,
        },
        limits: Limits { steps_max, decision_budget_ns },
        guard: Guard { hazard_max, deadline_ns },
        reading: Reading { leaving, distance: distance_norm, distance_scale_cells, opening_steps },
        cover,
        scout,
        mixed,
    }
    to_wire {
        let Grid { width, height, cell_size_m, hop_cells } = grid;
        let (start, goal) = (&CELL.to_wire(start), &CELL.to_wire(goal));
        let weights = &[*safety, *information, *distance];
        let sensor_radius_m = &Range { min: *radius_min_m, max: *radius_max_m };
        let (goal_count, goals, hops_max) = &patrol_to_wire(patrol.as_ref());
        let (cover_percent, cover_mode) =
            cover.as_ref().map_or((&0, &CoverMode::Overlap), |cover| (&cover.percent, &cover.mode));
        let (scout_seed, rover_samples, helicopter_samples, further_stages) = &scout_to_wire(scout.as_ref());
        let required = &mixed.map_or(0, |mixed| mixed.required.0.into());
        let designs = &designs_to_wire(*robots, mixed.as_ref());
    }
    from_wire(wire) {
        let grid = grid_from_wire("brief.grid", [width, height], cell_size_m, hop_cells)?;
        let goal = on_grid(&grid, "brief.goal", goal)?;
        let patrol = patrol_from_wire(wire, &grid)?;
        if patrol.is_some_and(|patrol| patrol.goal(0) != goal) {
            return Err(Refusal::malformed("brief.goal", "the patrol's first", goal));
        }
        let start = on_grid(&grid, "brief.start", start)?;
        let [safety, information, distance] = weights;
        let Range { min: radius_min_m, max: radius_max_m } = sensor_radius_m;
        if opening_steps >= steps_max {
            let need = format!("less than the {steps_max} steps of the mission");
            return Err(Refusal::malformed("brief.reading.opening_steps", &need, opening_steps));
        }
        let cover = (cover_percent > 0).then_some(Cover { percent: cover_percent, mode: cover_mode });
        let scout = scout_from_wire(wire)?;
        let common = Design {
            motion: MotionParameters { hard, sand, slope_limit_rad, launch_angle_rad, gravity_mps2 },
            sensor: SensorParameters {
                gain: sensor_gain, offset_m: sensor_offset_m, radius_min_m, radius_max_m, gradient: gradient_source,
            },
        };
        let mixed = mixed_from_wire(wire, robots, &common)?;
    }
}

fn gradient_code(source: GradientSource) -> u32 {
    match source {
        GradientSource::Measured => 1,
        GradientSource::SeenDifferences => 2,
    }
}

fn gradient_from_code(code: u32) -> Option<GradientSource> {
    match code {
        1 => Some(GradientSource::Measured),
        2 => Some(GradientSource::SeenDifferences),
        _ => None,
    }
}

fn norm_code(norm: DistanceNorm) -> u32 {
    match norm {
        DistanceNorm::Euclidean => 0,
        DistanceNorm::Manhattan => 1,
    }
}

fn norm_from_code(code: u32) -> Option<DistanceNorm> {
    match code {
        0 => Some(DistanceNorm::Euclidean),
        1 => Some(DistanceNorm::Manhattan),
        _ => None,
    }
}

fn mode_code(mode: CoverMode) -> u32 {
    match mode {
        CoverMode::Overlap => 0,
        CoverMode::Voronoi => 1,
    }
}

fn mode_from_code(code: u32) -> Option<CoverMode> {
    match code {
        0 => Some(CoverMode::Overlap),
        1 => Some(CoverMode::Voronoi),
        _ => None,
    }
}

fn on_grid(grid: &Grid, field: &str, cell: [i32; 2]) -> Result<Cell, Refusal> {
    let cell = CELL.from_wire(field, cell)?;
    if grid.contains(cell) { Ok(cell) } else { Err(Refusal::malformed(field, "a cell on the grid", cell)) }
}

/// How many goals, which, and after how many hops they are visited.
fn patrol_to_wire(patrol: Option<&Patrol>) -> (u32, [[i32; 2]; GOALS_MAX], u64) {
    let mut cells = [[0; 2]; GOALS_MAX];
    let Some(patrol) = patrol else { return (0, cells, 0) };
    for (wire, goal) in cells.iter_mut().zip(patrol.goals()) {
        *wire = CELL.to_wire(goal);
    }
    (patrol.goals().len() as u32, cells, patrol.hops_max)
}

fn patrol_from_wire(wire: &BriefV9, grid: &Grid) -> Result<Option<Patrol>, Refusal> {
    if wire.goal_count == 0 && wire.hops_max == 0 {
        return Ok(None);
    }
    let need = format!("2 to {GOALS_MAX}, each another than the one before, and 1 to {DECISIONS_MAX} hops");
    let refuse = || Refusal::malformed("brief.patrol", &need, wire.goal_count);
    let cells = wire.goals.get(..wire.goal_count as usize).ok_or_else(refuse)?;
    let goals = cells.iter().map(|cell| on_grid(grid, "brief.patrol", *cell));
    let goals = goals.collect::<Result<Vec<Cell>, _>>()?;
    if wire.hops_max > DECISIONS_MAX {
        return Err(refuse());
    }
    Patrol::new(&goals, wire.hops_max).map(Some).ok_or_else(refuse)
}

/// Seed, samples of a rover's and of a helicopter's planner, and stages after the first.
fn scout_to_wire(scout: Option<&Scout>) -> (u64, u32, u32, u32) {
    let Some(scout) = scout else { return (0, 0, 0, 0) };
    (scout.seed, scout.rover_samples, scout.helicopter_samples, scout.stages.saturating_sub(1))
}

fn scout_from_wire(wire: &BriefV9) -> Result<Option<Scout>, Refusal> {
    let BriefV9 { scout_seed: seed, rover_samples, helicopter_samples, further_stages, .. } = *wire;
    if rover_samples == 0 && helicopter_samples == 0 {
        return Ok(None);
    }
    let rover_samples = SAMPLES.from_wire("brief.scout.rover_samples", rover_samples)?;
    let helicopter_samples = SAMPLES.from_wire("brief.scout.helicopter_samples", helicopter_samples)?;
    if wire.cover_percent > 0 && wire.required == 0 {
        let need = "no ground to cover, unless robots have tasks of their own";
        return Err(Refusal::malformed("brief.scout", need, format!("{} %", wire.cover_percent)));
    }
    let refuse = |need: &str| Refusal::malformed("brief.scout.further_stages", need, further_stages);
    if further_stages >= Scout::STAGES_MAX {
        return Err(refuse(&format!("below {}", Scout::STAGES_MAX)));
    }
    if further_stages > 0 && wire.required != 0 {
        return Err(refuse("0 where robots have tasks of their own"));
    }
    Ok(Some(Scout { seed, rover_samples, helicopter_samples, stages: further_stages + 1 }))
}

fn mixed_from_wire(wire: &BriefV9, robots: u16, common: &Design) -> Result<Option<Mixed>, Refusal> {
    if wire.required == 0 {
        let need = "none but where robots have tasks of their own";
        return match wire.designs.iter().find(|design| **design != DesignV1::zeroed()) {
            None => Ok(None),
            Some(design) => Err(Refusal::malformed("brief.designs", need, design.robots)),
        };
    }
    if wire.goal_count > 0 {
        let need = "none where robots have tasks of their own";
        return Err(Refusal::malformed("brief.patrol", need, wire.goal_count));
    }
    let all = RobotSet::first(robots);
    let Some(required) = robots_of(all, wire.required) else {
        let need = format!("robots of the mission, {all}");
        return Err(Refusal::malformed("brief.required", &need, wire.required));
    };
    Ok(Some(Mixed { required, designs: designs_from_wire(&wire.designs, all, common)? }))
}

/// The robots of these marks, if all of them are in the mission.
fn robots_of(all: RobotSet, marks: u32) -> Option<RobotSet> {
    let set = u16::try_from(marks).ok().map(RobotSet)?;
    if set.0 & !all.0 == 0 { Some(set) } else { None }
}

fn designs_from_wire(
    wire: &[DesignV1; DESIGNS_MAX],
    all: RobotSet,
    common: &Design,
) -> Result<Designs, Refusal> {
    let mut of = [None; ROBOTS_MAX];
    for design in wire.iter().filter(|design| **design != DesignV1::zeroed()) {
        let parsed = design_from_wire(design, common)?;
        let refuse = || {
            let need = format!("robots of the mission, {all}, each once");
            Refusal::malformed("brief.designs", &need, design.robots)
        };
        let robots = robots_of(all, design.robots).ok_or_else(refuse)?;
        if robots == RobotSet::NONE {
            return Err(refuse());
        }
        for robot in robots.iter() {
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

/// Each design once, with the robots that have it.
fn designs_to_wire(robots: u16, mixed: Option<&Mixed>) -> [DesignV1; DESIGNS_MAX] {
    let mut designs = [DesignV1::zeroed(); DESIGNS_MAX];
    let Some(mixed) = mixed else { return designs };
    for robot in RobotSet::first(robots).iter() {
        let Some(design) = mixed.designs.of(robot) else { continue };
        let wire = DesignV1::from(design);
        let same = |known: &&mut DesignV1| known.robots == 0 || DesignV1 { robots: 0, ..**known } == wire;
        if let Some(place) = designs.iter_mut().find(same) {
            *place = DesignV1 { robots: place.robots | 1 << robot.0, ..wire };
        }
    }
    designs
}

fixed_payload!(Brief => BriefV9);

/// Tells every process of the run; a late reader gets the last one.
impl Message for Brief {
    const SERVICE: PublishSubscribe =
        PublishSubscribe { max_subscribers: 24, ..PublishSubscribe::new("hop/brief", &[Role::HopperSim]) };
}
