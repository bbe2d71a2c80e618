//! The paper's claims about its figures, as statements that hold or do not.
//!
//! Its words are made precise once, here, for all readings: "high" and "flat" compare means along the path;
//! "almost the same" means three quarters of the cells within one cell of the other path; "over a hill top" means
//! within one cell of its centre.

use contract::Cell;
use serde::Serialize;

use crate::{Case, Experiment, Hop, KnownMap, Model, Plan, Reading, Weights};

/// One claim of the paper.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Claim {
    /// Simulation that it is about.
    pub experiment: Experiment,
    /// The claim in words.
    pub statement: String,
    /// Whether it holds for the computed plans.
    pub holds: bool,
    /// Computed value, in words.
    pub got: String,
    /// Whether it follows from our choice of the rocks' outlines. Such claims do not count for any reading.
    pub by_construction: bool,
}

/// The cases of one map with the goal's payoff of 10.
pub(crate) fn of(cases: &[Case], experiment: Experiment) -> impl Iterator<Item = &Case> {
    cases.iter().filter(move |case| case.experiment == experiment && case.weights.goal == Weights::GOAL)
}

/// The case of fig. 10.
pub(crate) fn raised(cases: &[Case]) -> &Case {
    cases.iter().find(|case| case.weights.goal == Weights::GOAL_RAISED).expect("the case of fig. 10")
}

/// Every claim, in the paper's order.
pub(crate) fn all(cases: &[Case], reading: &Reading) -> Vec<Claim> {
    let mut claims = Vec::new();
    hard(cases, &mut claims);
    heterogeneous(cases, reading, &mut claims);
    sandy(cases, reading, &mut claims);
    rocks(cases, reading, &mut claims);
    claims
}

fn claim(experiment: Experiment, statement: String, holds: bool, got: String) -> Claim {
    Claim { experiment, statement, holds, got, by_construction: false }
}

/// Adds one claim for each weighting: that there is a path, or that there is none.
fn paths(cases: &[Case], experiment: Experiment, exists: impl Fn(f64) -> bool, claims: &mut Vec<Claim>) {
    for case in of(cases, experiment) {
        let (w1, need) = (case.weights.safety, exists(case.weights.safety));
        let what = if need { "a path" } else { "no path" };
        let statement = format!("w1 = {w1}: {what} from the start to the goal");
        claims.push(claim(experiment, statement, case.path.arrives() == need, case.path.ending.to_string()));
    }
}

/// Observation 1: hard ground.
fn hard(cases: &[Case], claims: &mut Vec<Claim>) {
    let experiment = Experiment::Hard;
    paths(cases, experiment, |_| true, claims);
    let cases: Vec<&Case> = of(cases, experiment).collect();
    let (high, flat) = (&cases[..3], &cases[4..]);
    let highest_flat_m = most(flat.iter().map(|case| case.path.mean_height_m));
    for case in high {
        let got_m = case.path.mean_height_m;
        let statement = format!(
            "w1 = {}: runs as high as possible, mean height above every path's with w1 ≥ 0.4",
            case.weights.safety
        );
        let holds = case.path.arrives() && got_m > highest_flat_m;
        claims.push(claim(
            experiment,
            statement,
            holds,
            format!("{got_m:.4} m against {highest_flat_m:.4} m"),
        ));
    }
    let halves = halves_m(cases[3]);
    claims.push(claim(
        experiment,
        "w1 = 0.3: higher places at first, lower ones near the goal".into(),
        cases[3].path.arrives() && halves[0] > halves[1],
        format!("first half {:.4} m, second {:.4} m", halves[0], halves[1]),
    ));
    let flattest_high = -most(high.iter().map(|case| -case.path.mean_slope));
    for case in flat {
        let got = case.path.mean_slope;
        let statement =
            format!("w1 = {}: flat ground, mean slope below every path's with w1 ≤ 0.2", case.weights.safety);
        let holds = case.path.arrives() && got < flattest_high;
        claims.push(claim(experiment, statement, holds, format!("{got:.4} against {flattest_high:.4}")));
    }
}

/// Observation 2: heterogeneous ground.
fn heterogeneous(cases: &[Case], reading: &Reading, claims: &mut Vec<Claim>) {
    let experiment = Experiment::Heterogeneous;
    let exists = |w1| w1 < 0.75;
    paths(cases, experiment, exists, claims);
    let tops = KnownMap::hill_tops(reading);
    let raised = raised(cases);
    let with: Vec<&Case> = of(cases, experiment).filter(|case| exists(case.weights.safety)).collect();
    for case in &with {
        let statement = format!("w1 = {}: the path avoids the sand", case.weights.safety);
        let holds = case.path.arrives() && case.path.sand_cells == 0;
        claims.push(claim(experiment, statement, holds, format!("{} cells on sand", case.path.sand_cells)));
    }
    for case in &with[..3] {
        let over = tops.iter().filter(|top| case.path.cells.iter().any(|cell| near(*cell, **top))).count();
        let statement = format!("w1 = {}: over the tops of two hills", case.weights.safety);
        claims.push(claim(experiment, statement, case.path.arrives() && over >= 2, format!("{over} tops")));
    }
    let flattest = -most(with[..6].iter().map(|case| -case.path.mean_slope));
    for case in &with[6..] {
        let got = case.path.mean_slope;
        let statement =
            format!("w1 = {}: safer, mean slope below every path's with w1 ≤ 0.5", case.weights.safety);
        let holds = case.path.arrives() && got < flattest;
        claims.push(claim(experiment, statement, holds, format!("{got:.4} against {flattest:.4}")));
    }
    claims.push(claim(
        experiment,
        "w1 = 1, goal 50: the path is back".into(),
        raised.path.arrives(),
        raised.path.ending.to_string(),
    ));
    let steepest = most(raised.path.slopes.iter().copied());
    let gentle = KnownMap::new(experiment, reading).mean_steepness();
    claims.push(claim(
        experiment,
        "w1 = 1, goal 50: it passes slopes, its steepest cell steeper than the map's mean".into(),
        raised.path.arrives() && steepest > gentle,
        format!("{steepest:.4} against {gentle:.4}"),
    ));
}

/// Observation 3: sandy ground.
fn sandy(cases: &[Case], reading: &Reading, claims: &mut Vec<Claim>) {
    let experiment = Experiment::Sandy;
    let exists = |w1| w1 < 0.75;
    paths(cases, experiment, exists, claims);
    let map = KnownMap::new(experiment, reading);
    let everywhere = map.sand_share();
    let cases: Vec<&Case> = of(cases, experiment).filter(|case| exists(case.weights.safety)).collect();
    for case in &cases[1..] {
        let first = &cases[0].path;
        let close =
            case.path.cells.iter().filter(|cell| first.cells.iter().any(|other| near(**cell, *other)));
        let share = close.count() as f64 / case.path.cells.len() as f64;
        let statement = format!(
            "w1 = {}: almost the path of w1 = 0, three quarters within one cell",
            case.weights.safety
        );
        let holds = case.path.arrives() && first.arrives() && share >= 0.75;
        claims.push(claim(experiment, statement, holds, format!("{:.0} %", 100.0 * share)));
    }
    let share = |case: &&Case| case.path.sand_cells as f64 / case.path.cells.len() as f64;
    let worst = most(cases.iter().map(share));
    claims.push(claim(
        experiment,
        "w1 ≤ 0.7: less sand on every path than on the map".into(),
        cases.iter().all(|case| case.path.arrives()) && worst < everywhere,
        format!("at most {:.0} % against {:.0} %", 100.0 * worst, 100.0 * everywhere),
    ));
}

/// The claims of the paper's fourth observation, on paths among rocks.
fn rocks(cases: &[Case], reading: &Reading, claims: &mut Vec<Claim>) {
    let experiment = Experiment::Rocks;
    let Some(case) = of(cases, experiment).next() else { return };
    claims.push(claim(
        experiment,
        "w1 = 0.5: a path from the start to the goal".into(),
        case.path.arrives(),
        case.path.ending.to_string(),
    ));
    let ups: Vec<Cell> = case.path.ups().collect();
    let shown = ups.iter().map(Cell::to_string).collect::<Vec<_>>().join(", ");
    claims.push(Claim {
        by_construction: true,
        ..claim(
            experiment,
            "w1 = 0.5: the path climbs the low rock with a vertical hop at (9, 11)".into(),
            case.path.arrives() && ups.contains(&Cell::new(9, 11)),
            if ups.is_empty() { "no vertical hop".into() } else { format!("at {shown}") },
        )
    });
    let map = KnownMap::new(experiment, reading);
    let model = Model::new(&map, reading);
    let plan = Plan::new(&map, &model, reading, case.weights);
    let hops = plan.solution.policy.iter().flatten().map(|&choice| (model.choices[choice].hop, choice));
    let others = hops.clone().filter(|(hop, _)| hop.is_up()).count();
    claims.push(Claim {
        by_construction: true,
        ..claim(
            experiment,
            "w1 = 0.5: further vertical hops around the low rock".into(),
            others >= 2,
            format!("{others} in the policy"),
        )
    });
    let climbs = |&(hop, choice): &(Hop, usize)| {
        hop.is_up() && model.landings[choice][0].index < model.cells() && {
            let end = model.landings[choice][0].index;
            map.ground[end].height_m >= map.highest_m()
        }
    };
    let into = hops.filter(climbs).count();
    claims.push(claim(
        experiment,
        "w1 = 0.5: no hop runs into the tall rock".into(),
        into == 0,
        format!("{into} in the policy"),
    ));
}

fn near(one: Cell, other: Cell) -> bool {
    (one.x - other.x).abs() <= 1 && (one.y - other.y).abs() <= 1
}

fn most(values: impl Iterator<Item = f64>) -> f64 {
    values.fold(f64::NEG_INFINITY, f64::max)
}

/// Mean heights of the two halves of a path, metres.
fn halves_m(case: &Case) -> [f64; 2] {
    let heights_m = &case.path.heights_m;
    let (first, second) = heights_m.split_at(heights_m.len() / 2);
    [first, second].map(|half| half.iter().sum::<f64>() / half.len().max(1) as f64)
}
