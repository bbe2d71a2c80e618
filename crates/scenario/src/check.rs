//! The report of `hopper scenario check` about a scenario that resolves.

use std::fmt;

use contract::{Account, Brief, Cover, CoverMode, Goal, Leg, Limits, Robot, Sampling, Soil};
use serde::Serialize;

use crate::{Fault, ResolvedScenario, Warning};

/// Summary of a resolved scenario. Displayed, it is text for a terminal.
#[derive(Clone, Debug, Serialize)]
pub struct ScenarioCheck {
    /// [`ResolvedScenario::hash`], hexadecimal.
    pub hash: String,
    /// The brief that hopper-sim will publish.
    pub brief: Brief,
    /// The robots that will fail; absent if none will.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub faults: Vec<Fault>,
    /// Share of cells that are sand, 0 to 1.
    pub sand_share: f64,
    /// Share of cells that are impassable, 0 to 1.
    pub impassable_share: f64,
    /// Fewest hops over passable ground to the goal, in a hopper's mission; `None` if no chain of hops leads there, and in other
    /// missions.
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
        let hopper = (world.brief.account == Account::Hopper).then(|| world.brief.leg(0));
        Self {
            hash: world.hash.iter().map(|byte| format!("{byte:02x}")).collect(),
            brief: world.brief.clone(),
            faults: world.faults.clone(),
            sand_share: share(cells.iter().filter(|ground| ground.soil == Soil::Sand).count()),
            impassable_share: share(cells.iter().filter(|ground| !ground.passable).count()),
            hops_min: hopper.and_then(|leg| world.terrain.hops_between(leg.start, leg.goal)),
            warnings: world.warnings.clone(),
        }
    }

    /// Writes how the robot moves and senses, what the payoff weighs, and which limits apply.
    fn write_rules(&self, leg: &Leg, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Leg { grid, weights, payoff, priors, motion, sensor, guard, .. } = leg;
        let mut line = |name: &str, value: String| write_line(f, name, &value);
        line(
            "robot",
            format!(
                "hops of {} m at {:.1} degrees{} under {} m/s2, slopes up to {:.1} degrees",
                grid.hop_distance_m(),
                motion.launch_angle_rad.to_degrees(),
                if motion.vertical { ", vertical hops at 80 degrees" } else { "" },
                motion.gravity_mps2,
                motion.slope_limit_rad.to_degrees()
            ),
        )?;
        if motion.table != 0 {
            let words = "planners believe a table of landings, fingerprint";
            line("motion", format!("{words} {:014x}", motion.table))?;
        }
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

    fn write_limits(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Limits { steps_max, decision_budget_ns } = self.brief.limits;
        let steps = match self.brief.account {
            Account::Hopper if self.brief.visits().is_some() => "no limit of steps".to_owned(),
            Account::Hopper => format!("{steps_max} steps"),
            Account::Actions => format!("{steps_max} actions of each robot"),
            Account::ActionsWithoutWaits => format!("{steps_max} actions of each robot, without waits"),
        };
        let budget_ms = decision_budget_ns as f64 / 1e6;
        write_line(f, "limits", &format!("{steps}, {budget_ms} ms a decision"))
    }

    /// Writes what the robots shall do, how they move and sense, and when they fail.
    fn write_robots(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write_line(f, "mission", &tasks_in_words(&self.brief))?;
        for (number, robot) in self.brief.robots.numbered() {
            write_line(f, &format!("robot {number}"), &in_words(robot, &self.brief))?;
        }
        for fault in &self.faults {
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
        if brief.account != Account::Hopper {
            self.write_robots(f)?;
            return self.warnings.iter().try_for_each(|warning| writeln!(f, "warning: {warning}"));
        }
        let leg = brief.leg(0);
        let way = self.hops_min.map_or("no way".into(), |hops| format!("{hops} hops at least"));
        line("mission", format!("from {} to {}, {way}", leg.start, leg.goal))?;
        if let Some(visits) = brief.visits() {
            let goals: Vec<String> = visits.goals().iter().map(ToString::to_string).collect();
            line("patrol", format!("{} in turn, {} hops", goals.join(", "), visits.hops_max))?;
        }
        if brief.has_team() {
            for (number, robot) in brief.robots.numbered() {
                line(&format!("robot {number}"), in_words(robot, brief))?;
            }
        }
        self.write_rules(&leg, f)?;
        self.warnings.iter().try_for_each(|warning| writeln!(f, "warning: {warning}"))
    }
}

/// What the robots of a mission that is not one hopper's shall do.
fn tasks_in_words(brief: &Brief) -> String {
    let covers = |robot: &Robot| robot.required && matches!(robot.goal, Goal::Cover(_));
    let is_one_task = brief.account == Account::Actions || brief.robots.iter().all(covers);
    let needed = (!is_one_task).then(|| {
        let required = brief.robots.those(|robot| robot.required);
        format!("required to reach their goals: robots {required}")
    });
    let cover = brief.cover().map(cover_in_words);
    let sampling = brief.sampling.as_ref().map(sampling_in_words);
    let parts: Vec<String> = [needed, cover, sampling].into_iter().flatten().collect();
    parts.join("; ")
}

fn cover_in_words(cover: Cover) -> String {
    let mode = match cover.mode {
        CoverMode::Overlap => "together",
        CoverMode::Voronoi => "each the cells nearest to its start",
    };
    format!("cover {} % of the cells that can be reached, {mode}", cover.percent)
}

fn sampling_in_words(sampling: &Sampling) -> String {
    let Sampling { rover_samples, helicopter_samples, stages, .. } = sampling;
    let stages = match stages {
        1 => String::new(),
        stages => format!(", in {stages} stages, each but the last of a Sol of driving"),
    };
    format!(
        "the rover drives to its goal over ground of uncertain speed{stages}; RRT* planners draw {rover_samples} samples for it, \
         {helicopter_samples} for a helicopter"
    )
}

fn in_words(robot: &Robot, brief: &Brief) -> String {
    let Robot { body, sensor, start, start_at, goal, .. } = robot;
    let start = if body.along_route().is_some() { start_at.to_string() } else { start.cell.to_string() };
    let way = match goal.in_words(&brief.grid) {
        // The goal of a hopper's mission has a line of its own.
        Some(goal) if brief.account != Account::Hopper => format!("from {start} {goal}"),
        _ => format!("at {start}"),
    };
    let view = match sensor.in_words() {
        Some(view) => format!("sees {view}"),
        None => format!("sensor {}", sensor.name()),
    };
    format!("{} {way}{}, {view}", body.word(), body.in_words(robot.start.heading))
}

fn write_line(f: &mut fmt::Formatter<'_>, name: &str, value: &str) -> fmt::Result {
    writeln!(f, "{name:<10} {value}")
}
