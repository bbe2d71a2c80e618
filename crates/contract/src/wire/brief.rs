//! `hop/brief`.

use super::declaration::wire;
use super::{CELL_SIZE, GRID_SIDE, HOP_CELLS, RobotV1, grid_from_wire};
use crate::codec::{
    ANY, Ascending, Codec, LENGTH, NAME, PAYOFF, PROBABILITY, RUN, Whole, ascending, at_most, by_hand, each,
    float, joint, or_zero, tag, whole,
};
use crate::limits::{
    BUDGET_MAX_NS, DECISIONS_MAX, LENGTH_MAX_M, PAYOFF_MAX, ROBOTS_MAX, SAMPLES_MAX, TREASURES_MAX,
};
use crate::message::{Capacity, Message, Payload, PublishSubscribe};
use crate::{
    Account, Brief, Cell, DistanceNorm, Goal, Grid, Guard, Limits, Name, Payoff, Priors, Profile, Reading,
    Refusal, Robot, Robots, Role, Sampling, UnseenGround, Weights,
};

/// Samples of a planner that draws random ones.
const SAMPLES: Whole = whole(1, SAMPLES_MAX as u64);

/// The ends of a range, the lower one first.
const SPAN: Ascending = ascending(LENGTH, ["", ""]);

wire! {
    /// What the mission asks for; the payload is the robots.
    pub struct BriefV10 = "hop.Brief.v10", 288 bytes, refused as "brief" {
        /// Run that begins.
        run: [u64; 2] = RUN,
        /// Name of the scenario.
        scenario: [u8; Name::BYTES] = NAME,
        /// SHA-256 over the resolved scenario and its terrain.
        scenario_hash: [u8; 32] = ANY,
        /// Reading of the model that the mission follows.
        profile: u32 = tag(Profile::code, Profile::from_code),
        /// What states tell, and what the limit counts.
        account: u32 = tag(Account::code, Account::from_code),
        /// Columns.
        width: u32 = GRID_SIDE => "brief.grid",
        /// Rows.
        height: u32 = GRID_SIDE => "brief.grid",
        /// Cells that one hop spans.
        hop_cells: u32 = HOP_CELLS => "brief.grid",
        /// Treasures on the map; 0 for none or an unknown number.
        treasures: u32 = at_most(TREASURES_MAX as u64) => "brief.priors.treasures",
        /// Edge of a cell, metres.
        cell_size_m: f64 = CELL_SIZE => "brief.grid",
        /// Absolute elevation of height 0, metres.
        datum_m: f64 = LENGTH,
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
        /// Steps after which the mission is a deadlock.
        steps_max: u64 = whole(1, DECISIONS_MAX),
        /// Budget of a decision, nanoseconds.
        decision_budget_ns: u64 = at_most(BUDGET_MAX_NS),
        /// Largest hazard that the guard lets pass.
        hazard_max: f64 = PROBABILITY => "brief.guard.hazard_max",
        /// Time to the fallback, nanoseconds; 0 for none.
        deadline_ns: u64 = ANY,
        /// What leaving the map is worth to the plan, never a gain; 0 counts it as staying.
        leaving: f64 = or_zero(float(-PAYOFF_MAX, 0.0)) => "brief.reading.leaving",
        /// Distance at which D is −1, cells: not so small that the payoff leaves its bounds; 0 for that from start
        /// to goal.
        distance_scale_cells: f64 = or_zero(float(1e-3, LENGTH_MAX_M))
            => "brief.reading.distance_scale_cells",
        /// Steps counted for the first observation.
        opening_steps: u64 = by_hand("less than `steps_max`"),
        /// How the distance D is measured, and what the plan takes unseen ground for.
        distance_norm: u32 = tag(norm_code, norm_from_code) => "brief.reading.distance",
        /// Stages after the first of a mission over uncertain ground.
        further_stages: u32 = joint(at_most(Sampling::STAGES_MAX as u64 - 1), "read with samples")
            => "brief.sampling.further_stages",
        /// Seed of planners of routes.
        sampling_seed: u64 = ANY,
        /// Samples of a rover's planner; 0 where nobody drives over uncertain ground.
        rover_samples: u32 = joint(SAMPLES, "0 in both for none") => "brief.sampling.rover_samples",
        /// Samples of a helicopter's planner; 0 where nobody drives over uncertain ground.
        helicopter_samples: u32 = joint(SAMPLES, "0 in both for none")
            => "brief.sampling.helicopter_samples",
    }
    of Brief {
        run,
        scenario,
        scenario_hash,
        profile,
        grid,
        datum_m,
        weights: Weights { safety, information, distance },
        payoff: Payoff { goal: payoff_goal, treasure: payoff_treasure, discount, sand_term },
        priors: Priors { safety: safety_range, height_m: height_range_m, treasures },
        limits: Limits { steps_max, decision_budget_ns },
        guard: Guard { hazard_max, deadline_ns },
        reading: Reading { leaving, distance: norm, distance_scale_cells, opening_steps, unseen },
        account,
        sampling,
        robots,
    }
    to_wire {
        let Grid { width, height, cell_size_m, hop_cells } = grid;
        let (distance_norm, weights) = (&(*norm, *unseen), &[*safety, *information, *distance]);
        let (sampling_seed, rover_samples, helicopter_samples, further_stages) =
            &sampling_to_wire(sampling.as_ref());
    }
    from_wire(wire) {
        let grid = grid_from_wire("brief.grid", [width, height], cell_size_m, hop_cells)?;
        let ([safety, information, distance], (norm, unseen)) = (weights, distance_norm);
        if opening_steps >= steps_max {
            let need = format!("less than the {steps_max} steps of the mission");
            return Err(Refusal::malformed("brief.reading.opening_steps", &need, opening_steps));
        }
        let sampling = sampling_from_wire(wire, account)?;
        let robots = robots_from_wire(cells, &grid, account)?;
        let drives = robots.iter().any(|robot| robot.body.drives());
        if drives && sampling.is_none() {
            let need = "some, where a robot drives over uncertain ground";
            return Err(Refusal::malformed("brief.sampling.rover_samples", need, rover_samples));
        }
    }
    /// The brief of a copied message.
    ///
    /// # Errors
    /// If there is no robot or there are too many, one is malformed or does not go with the others, or the header is malformed.
    pub fn brief_from_wire(cells: &[RobotV1]);
}

/// The norm in the lowest bit, unseen ground above it, so briefs from before that choice keep their meaning.
fn norm_code((norm, unseen): (DistanceNorm, UnseenGround)) -> u32 {
    let norm = match norm {
        DistanceNorm::Euclidean => 0,
        DistanceNorm::Manhattan => 1,
    };
    2 * unseen as u32 + norm
}

fn norm_from_code(code: u32) -> Option<(DistanceNorm, UnseenGround)> {
    let norm = if code.is_multiple_of(2) { DistanceNorm::Euclidean } else { DistanceNorm::Manhattan };
    Some((norm, *UnseenGround::ALL.get(code as usize / 2)?))
}

/// Seed, samples of a rover's and of a helicopter's planner, and stages after the first.
fn sampling_to_wire(sampling: Option<&Sampling>) -> (u64, u32, u32, u32) {
    let Some(sampling) = sampling else { return (0, 0, 0, 0) };
    let Sampling { seed, rover_samples, helicopter_samples, stages } = *sampling;
    (seed, rover_samples, helicopter_samples, stages.saturating_sub(1))
}

fn sampling_from_wire(wire: &BriefV10, account: Account) -> Result<Option<Sampling>, Refusal> {
    let BriefV10 { sampling_seed: seed, rover_samples, helicopter_samples, further_stages, .. } = *wire;
    if rover_samples == 0 && helicopter_samples == 0 {
        return Ok(None);
    }
    let rover_samples = SAMPLES.from_wire("brief.sampling.rover_samples", rover_samples)?;
    let helicopter_samples = SAMPLES.from_wire("brief.sampling.helicopter_samples", helicopter_samples)?;
    let refuse = |need: &str| Refusal::malformed("brief.sampling.further_stages", need, further_stages);
    if further_stages >= Sampling::STAGES_MAX {
        return Err(refuse(&format!("below {}", Sampling::STAGES_MAX)));
    }
    if further_stages > 0 && account == Account::ActionsWithoutWaits {
        return Err(refuse("0 where robots have goals of different kinds"));
    }
    Ok(Some(Sampling { seed, rover_samples, helicopter_samples, stages: further_stages + 1 }))
}

fn robots_from_wire(cells: &[RobotV1], grid: &Grid, account: Account) -> Result<Robots, Refusal> {
    let robots: Vec<Robot> = cells.iter().map(Robot::try_from).collect::<Result<_, _>>()?;
    let Some(robots) = Robots::new(&robots) else {
        return Err(Refusal::malformed("brief.robots", &format!("1 to {ROBOTS_MAX}"), cells.len()));
    };
    for robot in robots.iter() {
        on_grid(grid, "robot.start", robot.start.cell)?;
        if robot.as_hopper().is_some() {
            on_grid(grid, "robot.goal", robot.goal.cell(grid, 0).unwrap_or_default())?;
        }
        if let Goal::Visit(visit) = &robot.goal {
            visit.goals().iter().try_for_each(|goal| on_grid(grid, "robot.goal.goals", *goal))?;
        }
    }
    if !robots.iter().any(|robot| robot.required) {
        return Err(Refusal::malformed("robot.required", "1 of at least one robot", 0));
    }
    let is_of_hopper = || {
        let looks_ahead = |robot: &Robot| robot.goal.looks_ahead();
        robots[0].as_hopper().is_some()
            && robots[0].goal.cell(grid, 0).is_some()
            && robots[1..].iter().all(looks_ahead)
    };
    if account == Account::Hopper && !is_of_hopper() {
        let need = "that of actions, unless robot 0 is a hopper with a goal and all others look ahead";
        return Err(Refusal::malformed("brief.account", need, account.code()));
    }
    Ok(robots)
}

fn on_grid(grid: &Grid, field: &str, cell: Cell) -> Result<(), Refusal> {
    if grid.contains(cell) { Ok(()) } else { Err(Refusal::malformed(field, "a cell on the grid", cell)) }
}

impl Payload for Brief {
    type Header = BriefV10;
    type Cell = RobotV1;

    fn header(&self) -> BriefV10 {
        self.into()
    }

    fn cells(&self) -> usize {
        self.robots.len()
    }

    fn cell(&self, index: usize) -> RobotV1 {
        (&self.robots[index]).into()
    }

    fn from_wire(header: &BriefV10, cells: &[RobotV1]) -> Result<Self, Refusal> {
        brief_from_wire(header, cells)
    }
}

/// Tells every process of the run; a late reader gets the last one.
impl Message for Brief {
    const SERVICE: PublishSubscribe = PublishSubscribe {
        max_subscribers: 24,
        capacity: Capacity::Cells(ROBOTS_MAX),
        ..PublishSubscribe::new("hop/brief", &[Role::HopperSim])
    };
}
