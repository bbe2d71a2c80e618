//! Resolves a scenario: builds the terrain, fills in defaults, checks that it can be flown.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use contract::limits::{DECISIONS_MAX, TREASURES_MAX};
use contract::wire::{BriefV10, GroundV2, RobotV1, brief_from_wire};
use contract::{
    Account, Body, Brief, Cell, DriveSpeed, Goal, GradientSource, Grid, Ground, Limits, MotionModel,
    MotionParameters, Name, Payoff, Priors, Profile, Range, Robots, RunId, SensorParameters, SoilMotion,
    SpeedPrior, Weights,
};
use helicopter::Sensor;
use rover::Speed;
use scout_world::Trip;
use sha2::{Digest as _, Sha256};
use terrain::{Rectangle, Relief, Sand, Terrain, TerrainError};

use crate::bounds::in_range;
use crate::error::refuse;
use crate::resolved::{ResolvedScenario, canonical, hash};
use crate::robot::check_radius_min;
use crate::robots::Design;
use crate::shape::{Shaped, grid};
use crate::truth::Mobility;
use crate::{
    MapBefore, Passages, Robot, RobotRules, Scatter, Scenario, ScenarioError, Surveyed, TerrainSource,
    Warning,
};

/// Most rectangles of sand: every cell is tested against each.
const RECTANGLES_MAX: usize = 1000;

impl Scenario {
    /// Builds the terrain and the brief of this scenario.
    ///
    /// # Errors
    /// One [`ScenarioError`] with what was needed, what was got, and what to do.
    pub fn resolve(&self) -> Result<ResolvedScenario, ScenarioError> {
        self.resolved().map_err(|error| match &self.file {
            Some(path) => ScenarioError::In { path: path.clone(), source: Box::new(error) },
            None => error,
        })
    }

    fn resolved(&self) -> Result<ResolvedScenario, ScenarioError> {
        let mut resolved = self.clone();
        resolved.resolve_paths()?;
        self.robot.check()?;
        let shaped = resolved.shape()?;
        resolved.resolve_datum(&shaped.relief)?;
        let sand = resolved.sand(&shaped)?;
        let slope_limit_rad = self.robot.slope_limit_deg.to_radians();
        let mut terrain = Terrain::new(&shaped.relief, resolved.datum_m(), slope_limit_rad, &sand);
        let trip = resolved.spread(&shaped, &mut terrain)?;
        resolved.resolve_sensor(&terrain.grid)?;
        resolved.check_hopper(&terrain.grid)?;
        resolved.check_vertical()?;

        let unused = resolved.brief.profile != Profile::Hopper && !resolved.guard.is_empty();
        let robots = resolved.robots_on(&terrain, &shaped.relief, trip)?;
        resolved.add_readings(&robots, &mut terrain);
        // Climbs are looked for along the arcs of hoppers that were checked.
        resolved.resolve_priors(&terrain);
        let mut brief = resolved.brief_on(&terrain, &robots)?;
        let table = resolved.motion_table()?;
        terrain.treasures = resolved.treasures_on(&brief, &terrain)?;
        brief.priors.treasures = terrain.treasures.len() as u32;
        resolved.truth.dynamics.check(&terrain.grid)?;
        // The wire messages check every bound that applies to scenarios too.
        if let Some(table) = &table {
            let hoppers = brief.robots.iter_mut().filter_map(|robot| match &mut robot.body {
                Body::Hopper(hopper) => Some(hopper),
                _ => None,
            });
            hoppers.for_each(|hopper| hopper.motion.table = table.fingerprint());
        }
        let robots: Vec<RobotV1> = brief.robots.iter().map(RobotV1::from).collect();
        brief = brief_from_wire(&BriefV10::from(&brief), &robots).map_err(ScenarioError::Brief)?;
        resolved.truth.dynamics.check_hops(&brief, &terrain)?;
        for ground in &terrain.cells {
            Ground::try_from(&GroundV2::from(ground)).map_err(ScenarioError::Brief)?;
        }
        brief.scenario_hash = hash(&resolved, &terrain, table.as_deref());
        Ok(ResolvedScenario {
            resolved: canonical(&resolved),
            hash: brief.scenario_hash,
            warnings: warnings(&brief, &terrain)
                .into_iter()
                .chain(unused.then_some(Warning::GuardUnused))
                .chain(shaped.warnings.take())
                .collect(),
            planners: resolved.planners()?,
            faults: resolved.faults,
            dynamics: resolved.truth.dynamics,
            table,
            terrain: Arc::new(terrain),
            brief,
        })
    }

    /// Makes paths absolute and applies `--dem` and `--nodata`.
    fn resolve_paths(&mut self) -> Result<(), ScenarioError> {
        let folder = self.folder.clone();
        if let Some(nodata) = self.nodata.take() {
            let TerrainSource::ElevationFile(source) = &mut self.truth.terrain else {
                return Err(ScenarioError::DemUnused { flag: "--nodata" });
            };
            source.nodata = Some(nodata);
        }
        match (&mut self.truth.terrain, self.dem.take()) {
            (TerrainSource::ElevationFile(source), dem) if self.elevation.is_some() => {
                source.file = dem.unwrap_or_else(|| source.file.clone());
            }
            (TerrainSource::ElevationFile(source), Some(dem)) => source.file = existing("--dem", &dem)?,
            (TerrainSource::ElevationFile(source), None) => {
                source.file = existing("truth.terrain.elevation_file.file", &folder.join(&source.file))?;
            }
            (_, Some(_)) => return Err(ScenarioError::DemUnused { flag: "--dem" }),
            (_, None) => {}
        }
        if let Some(mask) = &mut self.truth.sand.mask_file {
            *mask = existing("truth.sand.mask_file", &folder.join(&*mask))?;
        }
        if let Some(table) = &mut self.brief.motion.table {
            *table = existing("brief.motion.table", &folder.join(&*table))?;
        }
        for file in self.truth.mobility.iter_mut().flat_map(Mobility::files) {
            *file = existing("truth.mobility", &folder.join(&*file))?;
        }
        Ok(())
    }

    fn shape(&mut self) -> Result<Shaped, ScenarioError> {
        let hop_distance_m = self.robot.hop_distance_m;
        in_range("robot.hop_distance_m", hop_distance_m, 1e-3..=1e6, "0.001 to 1e6 m")?;
        // Rovers alone go from cell to cell, however long a hop would be.
        let hops_m = self.has_hoppers().then_some(hop_distance_m);
        match &mut self.truth.terrain {
            TerrainSource::Gaussians(source) => {
                let grid = grid(source.width_cells, source.height_cells, source.cell_size_m, hop_distance_m)?;
                Ok(Shaped::generated(Relief::of_gaussians(grid, &source.hills()?)))
            }
            TerrainSource::RandomHills(source) => {
                let grid = grid(source.width_cells, source.height_cells, source.cell_size_m, hop_distance_m)?;
                let extent_m = [grid.width, grid.height].map(|side| f64::from(side) * grid.cell_size_m);
                let hills = source.field()?.gaussians(extent_m);
                let reach_sigma = source.reach_sigma.unwrap_or(f64::INFINITY);
                if !(3.0..).contains(&reach_sigma) {
                    return Err(ScenarioError::Value {
                        field: "truth.terrain.random_hills.reach_sigma",
                        need: "at least 3",
                        got: reach_sigma.to_string(),
                    });
                }
                Ok(Shaped::generated(Relief::of_gaussians_within(grid, &hills, reach_sigma)))
            }
            TerrainSource::Rocks(source) => source.shape(hop_distance_m),
            TerrainSource::Obstacles(source) => source.shape(hops_m),
            TerrainSource::Passages(source) => source.shape(hops_m),
            TerrainSource::ElevationFile(source) => {
                let path = source.file.clone();
                source.read(self.elevation.as_deref(), hop_distance_m).map_err(|error| match error {
                    ScenarioError::Terrain(error @ TerrainError::File { .. }) => error.into(),
                    ScenarioError::Terrain(error) => error.of(&path).into(),
                    error => error,
                })
            }
        }
    }

    fn resolve_datum(&mut self, relief: &Relief) -> Result<(), ScenarioError> {
        if let Surveyed::Survey(_) = self.brief.datum_m {
            self.brief.datum_m = Surveyed::Given(relief.mean_height_m());
        }
        in_range("brief.datum_m", self.datum_m(), -1e6..=1e6, "-1e6 to 1e6 m")
    }

    fn datum_m(&self) -> f64 {
        match self.brief.datum_m {
            Surveyed::Given(datum_m) => datum_m,
            Surveyed::Survey(_) => 0.0,
        }
    }

    fn sand(&self, shaped: &Shaped) -> Result<Sand, ScenarioError> {
        let rules = &self.truth.sand;
        if rules.rectangles.len() > RECTANGLES_MAX {
            return Err(ScenarioError::Value {
                field: "truth.sand.rectangles",
                need: "at most 1000",
                got: rules.rectangles.len().to_string(),
            });
        }
        for rectangle in &rules.rectangles {
            if rectangle.x[0] > rectangle.x[1] || rectangle.y[0] > rectangle.y[1] {
                return Err(ScenarioError::Value {
                    field: "truth.sand.rectangles",
                    need: "[first, last] with first at most last",
                    got: format!("x = {:?}, y = {:?}", rectangle.x, rectangle.y),
                });
            }
        }
        let mask = match &rules.mask_file {
            Some(path) => {
                let (mask, notes) = Sand::read_mask(path, &shaped.source)?;
                shaped.warn_of(path, &notes);
                mask
            }
            None => Vec::new(),
        };
        Ok(Sand {
            rectangles: rules.rectangles.iter().map(|&one| Rectangle { x: one.x, y: one.y }).collect(),
            below_height_m: rules.below_height_m,
            mask,
        })
    }

    /// The treasures in index order, checked: each cell once, on passable ground of the lattice of a hopper, neither start nor goal of
    /// any.
    fn treasures_on(&mut self, brief: &Brief, terrain: &Terrain) -> Result<Vec<Cell>, ScenarioError> {
        let refuse = |need, got: String| Err(ScenarioError::Value { field: "truth.treasures", need, got });
        let grid = &brief.grid;
        let way = |robot: &contract::Robot| {
            [robot.start.cell, robot.goal.cell(grid, 0).unwrap_or(robot.start.cell)]
        };
        let hoppers = brief.robots.iter().filter(|robot| robot.body.hops());
        let mut ways: Vec<[Cell; 2]> = hoppers.map(way).collect();
        if ways.is_empty() {
            ways.extend(brief.robots.iter().find(|robot| robot.required).map(way));
        }
        let given = &mut self.truth.treasures;
        if given.len() > TREASURES_MAX {
            return refuse("at most 16 cells", given.len().to_string());
        }
        given.sort_by_key(|&[x, y]| (y, x));
        let cells: Vec<Cell> = given.iter().map(|&[x, y]| Cell::new(x, y)).collect();
        if let Some(twice) = cells.windows(2).find(|pair| pair[0] == pair[1]) {
            return refuse("each cell once", format!("{} twice", twice[0]));
        }
        for &cell in &cells {
            let Some(ground) = terrain.ground(cell) else {
                return refuse("cells on the map", cell.to_string());
            };
            let is_end = ways.iter().any(|way| way.contains(&cell));
            if is_end || brief.visits().is_some_and(|visits| visits.goals().contains(&cell)) {
                return refuse("cells other than start and goal", cell.to_string());
            }
            if !ground.passable {
                return refuse("passable ground", cell.to_string());
            }
            if !ways.iter().any(|way| grid.on_same_lattice(cell, way[1])) {
                return refuse("cells whole hops away from the goal of a hopper", cell.to_string());
            }
        }
        Ok(cells)
    }

    /// Writes speeds and prior of uncertain ground into `terrain`. Returns the trip of passages, which are the world of the Monte Carlo
    /// study, bit for bit.
    fn spread(&self, shaped: &Shaped, terrain: &mut Terrain) -> Result<Option<Trip>, ScenarioError> {
        let mobility = self.truth.mobility.as_ref();
        let passages = match &self.truth.terrain {
            TerrainSource::Passages(Passages { seed }) => Some(*seed),
            _ => None,
        };
        let field = match (passages, mobility) {
            (None, None) => return Ok(None),
            (Some(_), Some(_)) => {
                let need = "terrain other than passages, whose speeds are drawn";
                return refuse("truth.mobility", need, "both".into());
            }
            (Some(_), None) => "truth.terrain.passages",
            (None, Some(_)) => "truth.mobility",
        };
        if self.account() == Account::Hopper {
            let need = "a robot that drives, body = \"driver\" or body = \"rover\": a hopper has no use for speeds of ground";
            return refuse(field, need, "a hopper without any".into());
        }
        if let Some(mobility) = mobility {
            mobility.spread(shaped, terrain)?;
        }
        let world = passages.map(scout_world::monte_carlo);
        if let Some(world) = &world {
            for (ground, speed) in terrain.cells.iter_mut().zip(&world.truth.speeds) {
                ground.speed = Some(scout_world::drive_speed(*speed));
            }
            let priors = world.prior.cells().iter().map(|speeds| SpeedPrior::new(speeds.probabilities()));
            terrain.prior = priors.collect::<Result<_, _>>().map_err(ScenarioError::Brief)?;
        }
        if self.account() == Account::Actions {
            close_where_none_drives(terrain);
        }
        Ok(world.map(|world| world.trip))
    }

    /// Writes into `terrain` what the helicopters that err read of each cell, if there are any.
    fn add_readings(&self, robots: &[contract::Robot], terrain: &mut Terrain) {
        let mut accuracies = robots.iter().filter_map(|robot| robot.sensor.accuracy());
        let camera = accuracies.next().and_then(|accuracy| Sensor::with_accuracy(accuracy).ok());
        let Some((camera, seed)) = camera.zip(self.ground_seed()) else { return };
        let speed = |ground: &Ground| ground.speed.map_or(Speed::Zero, scout_world::speed);
        let speeds: Vec<Speed> = terrain.cells.iter().map(speed).collect();
        for (ground, reading) in terrain.cells.iter_mut().zip(scout_world::readings(&speeds, &camera, seed)) {
            ground.reading = Some(scout_world::drive_speed(reading));
        }
    }

    /// Seed of uncertain ground; `None` on other ground.
    fn ground_seed(&self) -> Option<u64> {
        match (&self.truth.terrain, &self.truth.mobility) {
            (TerrainSource::Passages(passages), _) => Some(passages.seed),
            (_, mobility) => mobility.as_ref().map(|mobility| mobility.seed),
        }
    }

    /// Seed of the random numbers of planners of routes. It is public, so it is derived one-way from that of the world,
    /// from which the truth follows.
    fn planner_seed(&self) -> u64 {
        let Some(seed) = self.ground_seed() else { return 0 };
        let mut hasher = Sha256::new();
        hasher.update(b"hopper planner seed v1");
        hasher.update(seed.to_le_bytes());
        let bytes: [u8; 32] = hasher.finalize().into();
        u64::from_le_bytes(std::array::from_fn(|index| bytes[index]))
    }

    fn resolve_priors(&mut self, terrain: &Terrain) {
        // In the paper of 2022 sand has a term of its own beside S.
        let sand_term = match self.brief.profile {
            Profile::Paper2022 => 0.0,
            Profile::Paper2023 | Profile::Hopper => self.brief.payoff.sand_term,
        };
        let Design { motion, .. } = self.design();
        let own = self.robots.iter().filter_map(RobotRules::own_launch_angle_deg);
        let own = own.map(|deg| MotionParameters { launch_angle_rad: deg.to_radians(), ..motion });
        let slopes = terrain.safety_range(sand_term);
        let safety = [motion]
            .into_iter()
            .chain(own)
            .fold(slopes, |range, motion| with_climbs(range, &motion, terrain));
        let priors = &mut self.brief.priors;
        for (prior, surveyed) in
            [(&mut priors.safety, safety), (&mut priors.height_m, terrain.height_range())]
        {
            if let Surveyed::Survey(_) = prior {
                *prior = Surveyed::Given([surveyed.min, surveyed.max]);
            }
        }
    }

    fn resolve_sensor(&mut self, grid: &Grid) -> Result<(), ScenarioError> {
        let (profile, has_hoppers) = (self.brief.profile, self.has_hoppers());
        let sensor = &mut self.robot.sensor;
        sensor.gradient.get_or_insert(match profile {
            Profile::Paper2023 | Profile::Paper2022 => GradientSource::Measured,
            Profile::Hopper => GradientSource::SeenDifferences,
        });
        let hop_m = grid.hop_distance_m();
        let min_m = *sensor.radius_min_m.get_or_insert(hop_m);
        check_radius_min("robot.sensor.radius_min_m", min_m, hop_m)?;
        let diagonal_m = libm::hypot(f64::from(grid.width), f64::from(grid.height)) * grid.cell_size_m;
        sensor.radius_max_m.get_or_insert(diagonal_m.max(min_m));
        if self.brief.map == MapBefore::Known {
            if !has_hoppers {
                return refuse("brief.map", "a hopper, whose map it is, or \"unknown\"", "\"known\"".into());
            }
            sensor.radius_min_m = Some(diagonal_m.max(hop_m));
            sensor.radius_max_m = sensor.radius_min_m;
            if self.robots.iter().any(RobotRules::has_own_radius) {
                let need = "no radius where brief.map is \"known\": the whole map is seen";
                return refuse("robots.sensor", need, "one".into());
            }
        }
        Ok(())
    }

    /// The brief; its scenario hash is filled in by the caller.
    // Long: every field of the brief.
    fn brief_on(&mut self, terrain: &Terrain, robots: &[contract::Robot]) -> Result<Brief, ScenarioError> {
        let datum_m = self.datum_m();
        let planner_seed = self.planner_seed();
        let account = self.account();
        let Self { brief: mission, limits, guard, sampling, .. } = self;
        let name: Name = mission.name.get_or_insert_with(|| "scenario".into()).parse()?;
        let budget_ms = limits.decision_budget_ms;
        in_range("limits.decision_budget_ms", budget_ms, 1e-6..=1e12, "1e-6 to 1e12 ms")?;
        let range = |prior: Surveyed<[f64; 2]>| match prior {
            Surveyed::Given([min, max]) => Range { min, max },
            Surveyed::Survey(_) => Range { min: 0.0, max: 0.0 },
        };
        let drives = robots.iter().any(|robot| robot.body.drives());
        let flies = robots.iter().any(|robot| matches!(robot.body, Body::Helicopter(_)));
        let visits_goals = matches!(robots[0].goal, Goal::Visit(_));
        Ok(Brief {
            run: RunId(0),
            scenario: name,
            scenario_hash: [0; 32],
            profile: mission.profile,
            grid: terrain.grid,
            datum_m,
            weights: Weights {
                safety: mission.weights.safety,
                information: mission.weights.information,
                distance: mission.weights.distance,
            },
            payoff: Payoff {
                goal: mission.payoff.goal,
                treasure: mission.payoff.treasure,
                discount: mission.payoff.discount,
                sand_term: mission.payoff.sand_term,
            },
            priors: Priors {
                safety: range(mission.priors.safety),
                height_m: range(mission.priors.height_m),
                // Counted once they are checked.
                treasures: 0,
            },
            limits: Limits {
                steps_max: if visits_goals { DECISIONS_MAX } else { limits.steps_max },
                decision_budget_ns: limits.decision_budget_ns(),
            },
            guard: guard.resolve(mission.profile)?,
            reading: mission.reading.resolve(mission.profile)?,
            account,
            sampling: sampling.resolve(account, drives, flies, planner_seed)?,
            robots: Robots::new(robots).expect("1 to 16 robots, as was checked"),
        })
    }

    /// How hoppers hop and see by `[robot]`.
    pub(crate) fn design(&self) -> Design {
        let Robot { hard, sand, slope_limit_deg, launch_angle_deg, gravity_mps2, vertical, sensor, .. } =
            self.robot;
        Design {
            motion: MotionParameters {
                hard: hard.into(),
                sand: sand.into(),
                slope_limit_rad: slope_limit_deg.to_radians(),
                launch_angle_rad: launch_angle_deg.to_radians(),
                gravity_mps2,
                vertical,
                table: 0,
            },
            sensor: SensorParameters {
                gain: sensor.gain,
                offset_m: sensor.offset_m,
                radius_min_m: sensor.radius_min_m.unwrap_or_default(),
                radius_max_m: sensor.radius_max_m.unwrap_or_default(),
                gradient: sensor.gradient.unwrap_or_default(),
            },
        }
    }

    /// Refuses the vertical hop where no arc is checked, or where it is no steeper than any other hop.
    fn check_vertical(&self) -> Result<(), ScenarioError> {
        if !self.robot.vertical {
            return Ok(());
        }
        let model = self.truth.dynamics.model();
        if model != MotionModel::Collision {
            let need = "truth.dynamics.model = \"collision\": the other models check no arc";
            return refuse("robot.vertical", need, format!("\"{model}\""));
        }
        let own_deg = self.robots.iter().filter_map(RobotRules::own_launch_angle_deg);
        match own_deg
            .chain([self.robot.launch_angle_deg])
            .find(|angle_deg| *angle_deg >= motion::VERTICAL_DEG)
        {
            Some(angle_deg) => {
                let need = "launch angles below the 80 degrees of the vertical hop";
                refuse("robot.vertical", need, format!("{angle_deg} degrees"))
            }
            None => Ok(()),
        }
    }

    /// Checks the hopper of `[robot]`, whether the mission has one or not.
    fn check_hopper(&self, grid: &Grid) -> Result<(), ScenarioError> {
        let Design { motion, sensor } = self.design();
        let hopper = contract::Robot::hopper(grid, motion, sensor, [Cell::default(); 2]);
        contract::Robot::try_from(&RobotV1::from(&hopper)).map_err(ScenarioError::Brief)?;
        Ok(())
    }
}

impl From<Scatter> for SoilMotion {
    fn from(scatter: Scatter) -> Self {
        let Scatter { intended, stuck, sideways, flights } = scatter;
        Self { intended, stuck, sideways, flights }
    }
}

/// The range of S, widened by the climbs of all vertical hops that the ground offers: there S is −|Δh| (P22 eq. 10).
fn with_climbs(slopes: Range, motion: &MotionParameters, terrain: &Terrain) -> Range {
    if !motion.vertical {
        return slopes;
    }
    let grid = &terrain.grid;
    let height_m = |cell| terrain.ground(cell).map(|ground| ground.height_m);
    let standing = grid.iter().zip(&terrain.cells).filter(|(_, ground)| ground.passable);
    let climbs = standing.flat_map(|from| motion::offers(motion, grid, from, height_m)).flatten();
    let climbs = climbs.filter_map(|offer| offer.climb_m).map(|climb_m| -climb_m.abs());
    climbs.fold(slopes, |range, climb| Range { min: range.min.min(climb), max: range.max.max(climb) })
}

/// On ground that only a driver and helicopters are on, what a driver cannot drive over is impassable.
fn close_where_none_drives(terrain: &mut Terrain) {
    for ground in &mut terrain.cells {
        ground.passable = ground.speed != Some(DriveSpeed::Zero);
    }
}

fn warnings(brief: &Brief, terrain: &Terrain) -> Vec<Warning> {
    if brief.account != Account::Hopper {
        return Vec::new();
    }
    let leg = brief.leg(0);
    let (start, goal, steps_max) = (leg.start, leg.goal, brief.limits.steps_max);
    match terrain.hops_between(start, goal) {
        None => vec![Warning::Unreachable { start, goal }],
        Some(0) => vec![Warning::StartIsGoal { start }],
        Some(hops) if 2 * u64::from(hops) > steps_max => {
            vec![Warning::TooFewSteps { hops, steps: 2 * u64::from(hops), steps_max }]
        }
        Some(_) => Vec::new(),
    }
}

fn existing(field: &'static str, path: &Path) -> Result<PathBuf, ScenarioError> {
    let path = path.canonicalize().map_err(|_| ScenarioError::FileMissing {
        field,
        path: std::path::absolute(path).unwrap_or_else(|_| path.into()),
    })?;
    if path.to_str().is_none() { Err(not_utf_8(field, &path)) } else { Ok(path) }
}

/// A scenario is text, and the journal holds it with all its paths.
pub(crate) fn not_utf_8(field: &'static str, path: &Path) -> ScenarioError {
    let got = format!("{}: rename it, or put it into another folder", path.display());
    ScenarioError::Value { field, need: "a path that is UTF-8", got }
}
