//! The report of `hopper scenario check` about a scenario that resolves.

use std::fmt;

use contract::{Brief, Cover, CoverMode, Robot, Scout, Sensor, Soil, Vehicle};
use serde::Serialize;

use crate::{Fleet, ResolvedScenario, Warning};

/// Summary of a resolved scenario. Displayed, it is text for a terminal.
#[derive(Clone, Debug, Serialize)]
pub struct ScenarioCheck {
    /// [`ResolvedScenario::hash`], hexadecimal.
    pub hash: String,
    /// The brief that hopper-sim will publish.
    pub brief: Brief,
    /// The robots, with the faults to come; absent for a single hopper.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub fleet: Option<Fleet>,
    /// Share of cells that are sand, 0 to 1.
    pub sand_share: f64,
    /// Share of cells that are impassable, 0 to 1.
    pub impassable_share: f64,
    /// Fewest hops over passable ground to the goal; `None` if no chain of hops leads there.
    pub hops_min: Option<u32>,
    /// Warnings; empty for a sound scenario.
    #[serde(rename = "findings")]
    pub warnings: Vec<Warning>,
}

impl ScenarioCheck {
    /// What `hopper scenario check` prints of `world`.
    #[must_use]
    pub fn of(world: &ResolvedScenario) -> Self {
        let cells = &world.terrain.cells;
        let share = |count: usize| count as f64 / cells.len() as f64;
        Self {
            hash: world.hash.iter().map(|byte| format!("{byte:02x}")).collect(),
            brief: world.brief,
            fleet: world.fleet.clone(),
            sand_share: share(cells.iter().filter(|ground| ground.soil == Soil::Sand).count()),
            impassable_share: share(cells.iter().filter(|ground| !ground.passable).count()),
            hops_min: world.terrain.hops_between(world.brief.start, world.brief.goal),
            warnings: world.warnings.clone(),
        }
    }

    /// Writes how the robot moves and senses, what the payoff weighs, and which limits apply.
    fn write_rules(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Brief { grid, weights, payoff, priors, motion, sensor, guard, .. } = &self.brief;
        let mut line = |name: &str, value: String| write_line(f, name, &value);
        line(
            "robot",
            format!(
                "hops of {} m at {:.1} degrees under {} m/s2, slopes up to {:.1} degrees",
                grid.hop_distance_m(),
                motion.launch_angle_rad.to_degrees(),
                motion.gravity_mps2,
                motion.slope_limit_rad.to_degrees()
            ),
        )?;
        line(
            "sensor",
            format!(
                "radius {} x (h + {} m), {} to {:.2} m, gradients {}",
                sensor.gain,
                sensor.offset_m,
                sensor.radius_min_m,
                sensor.radius_max_m,
                match sensor.gradient {
                    contract::GradientSource::Measured => "measured",
                    contract::GradientSource::SeenDifferences => "from seen heights",
                }
            ),
        )?;
        line(
            "payoff",
            format!(
                "safety {}, information {}, distance {}, goal {}, discount {}, sand term {}",
                weights.safety,
                weights.information,
                weights.distance,
                payoff.goal,
                payoff.discount,
                payoff.sand_term
            ),
        )?;
        line(
            "priors",
            format!(
                "safety {:.4} to {:.4}, heights {:.3} to {:.3} m",
                priors.safety.min, priors.safety.max, priors.height_m.min, priors.height_m.max
            ),
        )?;
        self.write_limits(f)?;
        let mut line = |name: &str, value: String| write_line(f, name, &value);
        if *guard != contract::Guard::OFF {
            let deadline = match guard.deadline_ns {
                0 => "no fallback".into(),
                ns => format!("fallback after {} s", ns as f64 / 1e9),
            };
            line("guard", format!("vetoes hazards above {}, {deadline}", guard.hazard_max))?;
        }
        Ok(())
    }
}

impl ScenarioCheck {
    fn write_limits(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let limits = &self.brief.limits;
        let budget_ms = limits.decision_budget_ns as f64 / 1e6;
        write_line(f, "limits", &format!("{} steps, {budget_ms} ms a decision", limits.steps_max))
    }

    /// Writes what the robots of `fleet` shall do, how they move and sense, and when they fail.
    fn write_fleet(&self, task: &str, fleet: &Fleet, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write_line(f, "mission", task)?;
        for (number, robot) in fleet.robots.iter().enumerate() {
            write_line(f, &format!("robot {number}"), &in_words(robot))?;
        }
        for fault in &fleet.faults {
            let fails = format!("robot {} is stranded at its action {}", fault.robot, fault.action);
            write_line(f, "fault", &fails)?;
        }
        self.write_limits(f)
    }
}

impl fmt::Display for ScenarioCheck {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let brief = &self.brief;
        let grid = &brief.grid;
        let mut line = |name: &str, value: String| write_line(f, name, &value);
        line("scenario", format!("{}, profile {}", brief.scenario, brief.profile))?;
        line("hash", self.hash.clone())?;
        line(
            "map",
            format!(
                "{} x {} cells of {} m, datum {} m, {:.1} % sand, {:.1} % impassable",
                grid.width,
                grid.height,
                grid.cell_size_m,
                brief.datum_m,
                100.0 * self.sand_share,
                100.0 * self.impassable_share
            ),
        )?;
        if !brief.is_of_hopper()
            && let Some(fleet) = &self.fleet
        {
            let cover = self.brief.cover.map(cover_in_words);
            let scout = self.brief.scout.as_ref().map(scout_in_words);
            let mixed = self.brief.mixed.map(|mixed| {
                let needed = mixed.required.of(brief.robots);
                format!("tasks of their own, of which those of the robots {needed} are needed")
            });
            let parts: Vec<String> = [mixed, cover, scout].into_iter().flatten().collect();
            let task = parts.join("; ");
            self.write_fleet(&task, fleet, f)?;
            return self.warnings.iter().try_for_each(|warning| writeln!(f, "warning: {warning}"));
        }
        let way = self.hops_min.map_or("no way".into(), |hops| format!("{hops} hops at least"));
        line("mission", format!("from {} to {}, {way}", brief.start, brief.goal))?;
        if let Some(patrol) = &brief.patrol {
            let goals: Vec<String> = patrol.goals().iter().map(ToString::to_string).collect();
            line("patrol", format!("{} in turn, {} hops", goals.join(", "), patrol.hops_max))?;
        }
        for (number, robot) in self.fleet.iter().flat_map(|fleet| fleet.robots.iter().enumerate()) {
            line(&format!("robot {number}"), in_words(robot))?;
        }
        self.write_rules(f)?;
        self.warnings.iter().try_for_each(|warning| writeln!(f, "warning: {warning}"))
    }
}

fn cover_in_words(cover: Cover) -> String {
    let mode = match cover.mode {
        CoverMode::Overlap => "together",
        CoverMode::Voronoi => "each the cells nearest to its start",
    };
    format!("cover {} % of the cells that can be reached, {mode}", cover.percent)
}

fn scout_in_words(scout: &Scout) -> String {
    let Scout { rover_samples, helicopter_samples, stages, .. } = scout;
    let stages = match stages {
        1 => String::new(),
        stages => format!(", in {stages} stages, each but the last of a Sol of driving"),
    };
    format!(
        "the rover drives to its goal over ground of uncertain speed{stages}; RRT* planners draw {rover_samples} samples for it, \
         {helicopter_samples} for a helicopter"
    )
}

fn in_words(robot: &Robot) -> String {
    let (cell, heading) = (robot.start.cell, robot.start.heading);
    let body = match robot.vehicle {
        Vehicle::Rover { speed_mps } => format!("rover at {cell} facing {heading}, {speed_mps} m/s"),
        Vehicle::Driver { start, goal, goal_radius_m } => {
            format!("rover from {start} to within {goal_radius_m} m of {goal}")
        }
        Vehicle::Helicopter { start, speed_mps, budget_m } => {
            format!("helicopter at {start}, {speed_mps} m/s, {budget_m} m of flight")
        }
        Vehicle::Hopper => format!("hopper at {cell}"),
        Vehicle::HopperTo { goal } => format!("hopper from {cell} to {goal}"),
    };
    let view = match robot.sensor {
        Sensor::Square { range_cells } => format!("{0} x {0} cells", 2 * range_cells + 1),
        Sensor::Track => "the cells that it drives over".into(),
        Sensor::Camera { radius_m } => format!("{radius_m:.1} m to each side"),
        Sensor::Disc => "a disc that grows with its height".into(),
        Sensor::ErringCamera { radius_m, accuracy } => {
            format!("{radius_m:.1} m to each side, {:.1} % of the speeds right", 100.0 * accuracy)
        }
    };
    format!("{body}, sees {view}")
}

fn write_line(f: &mut fmt::Formatter<'_>, name: &str, value: &str) -> fmt::Result {
    writeln!(f, "{name:<10} {value}")
}
