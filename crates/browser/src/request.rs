//! What mission is asked for: the parts of a page's link.

use std::sync::Arc;

use contract::{Brief, Decision, MotionModel, Name, Pace, Profile, RunId};
use hopper_sim::Mission;
use lockstep::PlannerSchedule;
use scenario::{Overrides, ResolvedScenario, Scenario};
use serde::Deserialize;

/// A mission that is asked for. Everything but the scenario has a default.
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Request {
    /// Name of a built-in scenario; of no account where there is an elevation model without one.
    pub scenario: Option<String>,
    /// Seed of the hops.
    pub seed: u64,
    /// Replaces the profile of the scenario.
    pub profile: Option<String>,
    /// Replaces what decides where hops end: `law`, `collision` or `contact`.
    pub dynamics: Option<String>,
    /// Who commands from which decision on; by default what the scenario says.
    pub planners: Vec<Turnover>,
    /// How fast landings follow each other at first, as `hopper run --pace` takes it.
    pub pace: Option<String>,
    /// Number of the run, 32 hexadecimal digits; a page takes another number for another mission.
    pub run: Option<String>,
    /// Name of the file of the elevation model that was handed over beside this.
    pub dem: Option<String>,
}

/// A planner takes command.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Turnover {
    /// Its first decision.
    pub from: u64,
    /// Name of its algorithm.
    pub planner: String,
}

/// A mission with who commands in it.
#[derive(Debug)]
pub(crate) struct Wanted {
    pub mission: Mission,
    pub schedule: PlannerSchedule,
    pub pace: Pace,
    /// Algorithms that may take command, each once; none where every robot keeps its planner.
    pub suited: Vec<&'static str>,
    /// What the scenario's author should know.
    pub warnings: Vec<String>,
}

impl Request {
    /// The mission, over the ground of `dem` if it names a file of it.
    ///
    /// # Errors
    /// What was needed and what was got, in a sentence.
    pub(crate) fn mission(&self, dem: &Arc<[u8]>) -> Result<Wanted, String> {
        let profile = self.profile.as_deref().map(str::parse::<Profile>).transpose()?;
        let dynamics = self.dynamics.as_deref().map(str::parse::<MotionModel>).transpose()?;
        let pace = self.pace.as_deref().map_or(Ok(Pace::Max), str::parse)?;
        let overrides = Overrides { profile, dynamics, ..Overrides::default() };
        let world = self.scenario(dem)?.with(&overrides).resolve().map_err(|error| error.to_string())?;
        let run = self.run.as_deref().map_or(Ok(1), |run| u128::from_str_radix(run, 16));
        let run = RunId(run.map_err(|_| "a run needs to be 32 hexadecimal digits".to_owned())?);
        let schedule = self.schedule(&world)?;
        let mut suited = Vec::new();
        if !world.brief.has_routes() {
            for name in world.brief.robots.iter().flat_map(|robot| planner::suited(&world.brief, robot)) {
                if !suited.contains(&name) {
                    suited.push(name);
                }
            }
        }
        let warnings = world.warnings.iter().map(ToString::to_string).collect();
        let brief = Brief { run, ..world.brief.clone() };
        let mission = Mission { brief, ..Mission::of(&world, self.seed) };
        Ok(Wanted { mission, schedule, pace, suited, warnings })
    }

    fn scenario(&self, dem: &Arc<[u8]>) -> Result<Scenario, String> {
        let scenario = match (&self.scenario, &self.dem) {
            (Some(name), _) => {
                let known = scenario::BUILT_IN.iter().any(|(known, _)| known == name);
                let names = || scenario::BUILT_IN.map(|(name, _)| name).join(", ");
                if !known {
                    return Err(format!("a scenario needs to be one of {}, got {name:?}", names()));
                }
                scenario::load(name).map_err(|error| error.to_string())?
            }
            (None, Some(file)) => {
                return scenario::fitted_to(file, dem)
                    .map(|fitted| fitted.scenario)
                    .map_err(|error| error.to_string());
            }
            (None, None) => return Err("a mission needs a scenario or an elevation model".into()),
        };
        Ok(match &self.dem {
            Some(file) => scenario.on_elevation(file, Arc::clone(dem)),
            None => scenario,
        })
    }

    /// Who commands: as asked, otherwise what the scenario names for each robot, otherwise the usual planner.
    fn schedule(&self, world: &ResolvedScenario) -> Result<PlannerSchedule, String> {
        let named = |name: &str| -> Result<Name, String> {
            let name: Name = name.parse().map_err(|error| format!("{error}"))?;
            let planner = planner::algorithm(name.as_str()).map_err(|error| error.to_string())?;
            let scenario = world.brief.scenario;
            match world.brief.robots.iter().any(|robot| planner.suits(robot)) {
                true => Ok(name),
                false => Err(format!("scenario {scenario} needs another planner than {name}")),
            }
        };
        if self.planners.is_empty() {
            let names = planner::assigned(&world.brief, None, &world.planners);
            let names = names.map_err(|error| error.in_scenario(world.brief.scenario))?;
            return Ok(PlannerSchedule::of_robots(&names));
        }
        if world.brief.has_routes() {
            return Err("robots of different kinds keep the planners that their scenario names".into());
        }
        let mut turnovers = Vec::new();
        for Turnover { from, planner } in &self.planners {
            turnovers.push((Decision(*from), named(planner)?));
        }
        if turnovers.first().is_some_and(|(from, _)| from.0 > 0)
            || !turnovers.is_sorted_by_key(|(from, _)| *from)
        {
            return Err(
                "planners need to be in the order of their first decisions, the first from 0 on".into()
            );
        }
        Ok(PlannerSchedule::in_turn(&turnovers))
    }
}
