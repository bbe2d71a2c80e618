//! A random mission of any kind, drawn from a seed.

use std::fmt::Write as _;

use contract::{Account, Name};
use hopper_sim::Mission;
use scenario::{ResolvedScenario, Scenario};
use serde::Serialize;
use simulation::chance::Chance;
use simulation::setup::Missions;

/// Drafts that a seed may take until one can be flown: goals and starts may be cut off from each other.
const DRAFTS_MAX: u64 = 400;

/// What a mission is about.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, clap::ValueEnum)]
#[serde(rename_all = "snake_case")]
pub enum Kind {
    /// A hopper alone, to a goal.
    Hopper,
    /// A hopper alone, from goal to goal.
    Patrol,
    /// A hopper with helicopters.
    Accompanied,
    /// Rovers that cover ground.
    Rovers,
    /// A rover with a goal over ground of uncertain speed, with helicopters or without.
    Scouts,
    /// Robots of any kind, each with a task of its own.
    Mixed,
}

impl Kind {
    /// Every kind, in the order in which seeds have them.
    pub const ALL: [Kind; 6] =
        [Kind::Hopper, Kind::Patrol, Kind::Accompanied, Kind::Rovers, Kind::Scouts, Kind::Mixed];

    /// The kind of a seed.
    #[must_use]
    pub fn of(seed: u64) -> Self {
        Self::ALL[(seed % Self::ALL.len() as u64) as usize]
    }

    /// What states of such missions tell.
    fn account(self) -> Account {
        match self {
            Kind::Hopper | Kind::Patrol | Kind::Accompanied => Account::Hopper,
            Kind::Scouts => Account::Actions,
            Kind::Rovers | Kind::Mixed => Account::ActionsWithoutWaits,
        }
    }

    /// The faults that the simulation has for such missions.
    #[must_use]
    pub fn missions(self) -> Missions {
        match self {
            Kind::Hopper | Kind::Patrol => Missions::Hopper,
            Kind::Accompanied => Missions::Accompanied,
            Kind::Rovers => Missions::Rovers,
            Kind::Scouts => Missions::Scouts,
            Kind::Mixed => Missions::Mixed,
        }
    }
}

/// A mission that can be flown.
#[derive(Clone, Debug)]
pub struct Draft {
    /// What it is about.
    pub kind: Kind,
    /// Seed of the draft, and of the hops.
    pub seed: u64,
    /// Its scenario; robots name their planners.
    pub scenario: Scenario,
    /// The planner of a hopper that is alone.
    pub planner: Name,
}

impl Draft {
    /// The mission of a seed; `None` if none of 400 drafts can be flown.
    #[must_use]
    pub fn of(kind: Kind, seed: u64) -> Option<Self> {
        let mut chance = Chance::new(seed, "fuzz");
        (0..DRAFTS_MAX).find_map(|_| {
            let text = text(kind, &mut chance);
            let planner =
                chance.pick(planner::ALGORITHMS).parse().expect("the names of algorithms are names");
            let scenario =
                Scenario::parse(&text, "the draft").unwrap_or_else(|error| panic!("{error}\n{text}"));
            let draft = Self { kind, seed, scenario, planner };
            draft.world().is_some().then_some(draft)
        })
    }

    /// The mission resolved; `None` if it cannot be flown, or its robots make it one of another kind.
    #[must_use]
    pub fn world(&self) -> Option<ResolvedScenario> {
        if self.scenario.account() == self.kind.account() { self.scenario.resolve().ok() } else { None }
    }

    /// The mission, and the planner of each of its robots.
    #[must_use]
    pub fn mission(&self) -> Option<(Mission, Vec<Name>)> {
        let world = self.world()?;
        let planners = match world.brief.has_team() {
            false => vec![self.planner],
            true => world.planners.iter().map(|name| name.unwrap_or(self.planner)).collect(),
        };
        Some((Mission::of(&world, self.seed), planners))
    }
}

/// A list of things for TOML.
fn list<T: std::fmt::Debug>(things: &[T]) -> String {
    format!("{things:?}")
}

fn cell(chance: &mut Chance, width: u32, height: u32) -> [u32; 2] {
    [chance.below(width.into()) as u32, chance.below(height.into()) as u32]
}

/// The text of a scenario, which may be one that cannot be flown.
// Long: a section each.
fn text(kind: Kind, chance: &mut Chance) -> String {
    let (width, height) = match kind {
        Kind::Scouts => (chance.between(8, 24) as u32, chance.between(8, 24) as u32),
        _ => (chance.between(5, 14) as u32, chance.between(5, 14) as u32),
    };
    let drives = kind == Kind::Scouts || kind == Kind::Mixed && chance.one_in(2);
    let cell_m = if drives { 1.0 } else { chance.pick(&[0.5, 1.0, 1.0]) };
    let hop_cells = if chance.one_in(4) { 2 } else { 1 };
    let mut text = String::new();
    let mut line = |words: String| {
        let _ = writeln!(text, "{words}");
    };
    if kind != Kind::Scouts && chance.one_in(2) {
        line(format!("[truth]\ntreasures = {}", list(&places(chance, width, height, 4))));
    }
    let size = format!("width_cells = {width}\nheight_cells = {height}\ncell_size_m = {cell_m:?}");
    let seed = chance.below(1 << 20);
    if chance.one_in(3) {
        let percent = chance.pick(&[0.0, 5.0, 12.0, 25.0]);
        line(format!("[truth.terrain.obstacles]\n{size}\npercent = {percent:?}\nseed = {seed}"));
    } else {
        let (hills, least, most) = (chance.below(12), 0.8 + chance.unit(), 2.0 + 2.0 * chance.unit());
        let top = chance.pick(&[0.05, 0.3, 0.8]);
        line(format!("[truth.terrain.random_hills]\n{size}\nseed = {seed}\nhills = {hills}"));
        line(format!("sigma_m = [{least:?}, {most:?}]\namplitude_m = [0.0, {top:?}]"));
    }
    if chance.one_in(2) {
        let rectangle = |[x, y]: [u32; 2], across: u32| {
            format!(
                "{{ x = [{x}, {}], y = [{y}, {}] }}",
                (x + across).min(width - 1),
                (y + across).min(height - 1)
            )
        };
        let count = chance.between(1, 3);
        let sand: Vec<String> =
            (0..count).map(|_| rectangle(cell(chance, width, height), chance.between(1, 4) as u32)).collect();
        line(format!("[truth.sand]\nrectangles = [{}]", sand.join(", ")));
    }
    if drives {
        let classes =
            ["smooth_regolith", "rough_outcrop", "rock_field", "deep_sand", "sparse_linear_ripples"];
        let (one, other) = (chance.pick(&classes[..2]), chance.pick(&classes[2..]));
        let share = chance.pick(&[0.2, 0.5, 0.75]);
        line(format!(
            "[truth.mobility]\nseed = {}\nrock_abundance = {:?}",
            chance.below(99),
            0.2 * chance.unit()
        ));
        line(format!("classes = {{ {one} = {:?}, {other} = {share:?} }}", 1.0 - share));
    }
    let task = Task::of(kind, drives, chance, width, height);
    if let Some(sampling) = task.sampling {
        line(format!("[sampling]\n{sampling}"));
    }
    let profile = if kind == Kind::Rovers { "hopper" } else { chance.pick(&["hopper", "paper-2023"]) };
    line(format!("[brief]\nname = \"fuzz\"\nprofile = \"{profile}\""));
    if !matches!(kind, Kind::Rovers | Kind::Mixed) {
        let (start, goal) = (cell(chance, width, height), cell(chance, width, height));
        line(format!("start = {}", list(&start)));
        line(match task.patrol {
            None => format!("goal = {}", list(&goal)),
            Some((further, hops_max)) => {
                format!("goals = {}\nhops_max = {hops_max}", list(&[vec![goal], further].concat()))
            }
        });
    }
    if matches!(kind, Kind::Hopper | Kind::Patrol | Kind::Accompanied | Kind::Mixed) {
        line(hopper(chance, cell_m, hop_cells));
    }
    let steps_max = if kind == Kind::Rovers { chance.between(10, 60) } else { chance.between(10, 80) };
    line(format!("[limits]\nsteps_max = {steps_max}"));
    if profile == "hopper" && chance.one_in(2) {
        line(format!("[guard]\nhazard_max = {:?}", chance.pick(&[0.0, 0.06, 0.25, 1.0])));
    }
    let robots = robots(kind, drives, task.cover.as_deref(), chance, [width, height]);
    for (number, robot) in robots.iter().enumerate() {
        line(format!("[[robots]]\n{robot}"));
        if chance.one_in(6) {
            line(format!("[[faults]]\nrobot = {number}\naction = {}", chance.between(1, 8)));
        }
    }
    text
}

fn places(chance: &mut Chance, width: u32, height: u32, most: u64) -> Vec<[u32; 2]> {
    let mut places: Vec<[u32; 2]> =
        (0..chance.between(1, most)).map(|_| cell(chance, width, height)).collect();
    places.sort_unstable();
    places.dedup();
    places
}

/// What is to be done, as far as the kind of mission says.
#[derive(Default)]
struct Task {
    /// Goals of a patrol after the first, and its hops.
    patrol: Option<(Vec<[u32; 2]>, u64)>,
    /// Goal of all rovers.
    cover: Option<String>,
    /// Section `[sampling]`.
    sampling: Option<String>,
}

impl Task {
    fn of(kind: Kind, drives: bool, chance: &mut Chance, width: u32, height: u32) -> Self {
        let samples = |chance: &mut Chance| {
            format!(
                "rover_samples = {}\nhelicopter_samples = {}",
                chance.between(10, 60),
                chance.between(10, 60)
            )
        };
        let nothing = Self::default();
        match kind {
            Kind::Hopper | Kind::Accompanied => nothing,
            Kind::Patrol => {
                let goals = places(chance, width, height, 3);
                Self { patrol: Some((goals, chance.between(5, 50))), ..nothing }
            }
            Kind::Rovers => {
                let (percent, mode) = (chance.between(20, 100), chance.pick(&["overlap", "voronoi"]));
                Self { cover: Some(format!("{{ cover = {percent}, mode = \"{mode}\" }}")), ..nothing }
            }
            Kind::Scouts => Self { sampling: Some(samples(chance)), ..nothing },
            Kind::Mixed => {
                let sampling = if drives { Some(samples(chance)) } else { None };
                let cover = format!("{{ cover = {} }}", chance.pick(&[2, 10, 40, 100]));
                Self { cover: Some(cover), sampling, ..nothing }
            }
        }
    }
}

/// Section `[robot]`: how a hopper hops and sees.
fn hopper(chance: &mut Chance, cell_m: f64, hop_cells: u32) -> String {
    let hop_m = cell_m * f64::from(hop_cells);
    let stuck = chance.pick(&[0.0, 0.1, 0.3]);
    let sideways = chance.pick(&[0.0, 0.05, 0.15]);
    let intended = 1.0 - stuck - 2.0 * sideways;
    let scatter = format!(
        "{{ intended = {intended:?}, stuck = {stuck:?}, sideways = {sideways:?}, flights = {} }}",
        chance.between(1, 2)
    );
    let which = chance.pick(&["hard", "sand"]);
    format!(
        "[robot]\nhop_distance_m = {hop_m:?}\nlaunch_angle_deg = {:?}\ngravity_mps2 = {:?}\nslope_limit_deg = {:?}\n\
         {which} = {scatter}\nsensor = {{ gain = {:?}, offset_m = {:?} }}",
        chance.pick(&[30.0, 45.0, 60.0]),
        chance.pick(&[1.62, 3.72]),
        chance.pick(&[15.0, 30.0]),
        chance.pick(&[0.0, 1.0, 2.0, 5.0]),
        chance.pick(&[0.5, 1.0, 2.0])
    )
}

/// The sections `[[robots]]`.
fn robots(
    kind: Kind,
    drives: bool,
    cover: Option<&str>,
    chance: &mut Chance,
    [width, height]: [u32; 2],
) -> Vec<String> {
    let text = |body, has_place, chance: &mut Chance| {
        let flies_for = (kind, drives);
        robot(body, if has_place { Some([width, height]) } else { None }, flies_for, cover, chance)
    };
    let count = chance.between(1, 4);
    match kind {
        Kind::Hopper | Kind::Patrol => Vec::new(),
        Kind::Accompanied => {
            let mut robots = vec![text(Body::Hopper, false, chance)];
            robots.extend((0..count.min(3)).map(|_| text(Body::Helicopter, false, chance)));
            robots
        }
        Kind::Rovers => (0..count).map(|_| text(Body::Rover, true, chance)).collect(),
        Kind::Scouts => {
            let mut robots = vec![text(Body::Driver, false, chance)];
            robots.extend((1..count).map(|_| text(Body::Helicopter, false, chance)));
            robots
        }
        Kind::Mixed => (0..count + 1)
            .map(|_| match chance.below(if drives { 5 } else { 4 }) {
                0 | 1 => text(Body::Hopper, true, chance),
                2 => text(Body::Rover, true, chance),
                3 => text(Body::Helicopter, true, chance),
                _ => text(Body::Driver, true, chance),
            })
            .collect(),
    }
}

/// One section of `[[robots]]`; with start, and with the goal of one that has a cell to go to, somewhere on a map of that size.
fn robot(
    body: Body,
    place: Option<[u32; 2]>,
    (kind, drives): (Kind, bool),
    cover: Option<&str>,
    chance: &mut Chance,
) -> String {
    let mut robot = format!("body = \"{}\"\n", body.name());
    if let Some([width, height]) = place {
        robot += &format!("start = {}\n", list(&cell(chance, width, height)));
        if matches!(body, Body::Hopper | Body::Driver) {
            robot += &format!("goal = {}\n", list(&cell(chance, width, height)));
        }
    }
    let heading = chance.pick(&["north", "east", "south", "west"]);
    if matches!(body, Body::Hopper | Body::Rover) {
        robot += &format!("heading = \"{heading}\"\n");
    }
    let flies_for_rover = drives && !chance.one_in(4);
    let planner = match body {
        Body::Hopper => chance.pick(planner::ALGORITHMS),
        Body::Driver => chance.pick(planner::DRIVE_ALGORITHMS),
        Body::Rover => chance.pick(planner::COVER_ALGORITHMS),
        Body::Helicopter if kind == Kind::Scouts || kind == Kind::Mixed && flies_for_rover => {
            chance.pick(planner::FLY_ALGORITHMS)
        }
        Body::Helicopter => planner::AHEAD_ALGORITHMS[0],
    };
    robot += &format!("planner = \"{planner}\"\n");
    match body {
        Body::Helicopter => {
            robot += &format!(
                "speed_mps = {:?}\nbudget_m = {:?}\nview_radius_m = {:?}",
                chance.pick(&[0.2, 1.0, 5.0]),
                chance.pick(&[0.0, 5.0, 20.0, 100.0]),
                chance.pick(&[0.8, 2.0, 5.0])
            );
        }
        Body::Rover => {
            robot += &format!(
                "speed_mps = {:?}\nsensor_range_cells = {}\ngoal = {}",
                chance.pick(&[0.1, 0.3, 0.5]),
                chance.between(1, 3),
                cover.unwrap_or("{ cover = 100 }")
            );
        }
        Body::Hopper | Body::Driver => {}
    }
    robot
}

/// What a robot of a draft is.
#[derive(Clone, Copy)]
enum Body {
    Hopper,
    Rover,
    Driver,
    Helicopter,
}

impl Body {
    /// As written in a scenario.
    fn name(self) -> &'static str {
        match self {
            Body::Hopper => "hopper",
            Body::Rover => "rover",
            Body::Driver => "driver",
            Body::Helicopter => "helicopter",
        }
    }
}
