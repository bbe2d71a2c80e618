//! Figs 5 to 8: missions as maps of visits, and path ratios as curves.

use ::coverage::{Algorithm, CoverMode};
use contract::Cell;
use coverage_world::{Mission, World};
use node::Failure;
use p19::{Account, Case, PERCENTS, PLANNERS, Row, SIDES, Sharing, TEAMS, mission, row};
use report::picture::{Chart, Curves, Field, FieldGrid, Line};

use crate::studies::coverage::failure;

/// Points of a distribution in Fig. 7.
const POINTS: usize = 60;

/// Shares of coverage at which Fig. 5 shows its mission, besides the start.
const FIG_5_PERCENTS: [u32; 3] = [50, 95, 100];

/// Path ratio at which the mission of Fig. 5 ends.
const FIG_5_RATIO: f64 = 1.75;

/// Steps of the missions of Fig. 7, in overlap and in Voronoi.
const FIG_7_STEPS: [f64; 2] = [444.0, 449.0];

/// Side of the worlds on which missions of that length are likeliest.
const FIG_7_SIDE: u32 = 30;

/// File names and SVG documents.
///
/// # Errors
/// If a mission that is drawn does not end.
pub fn all(account: &Account) -> Result<Vec<(String, String)>, Failure> {
    Ok(vec![
        ("fig-6.svg".into(), six(account).svg()),
        ("fig-7.svg".into(), seven(account).svg()),
        ("fig-8.svg".into(), eight(account).svg()),
        ("fig-5.svg".into(), five(account)?),
        ("fig-7-missions.svg".into(), seven_missions(account)?),
    ])
}

/// How often each cell was visited; no number on an obstacle.
fn visited(world: &World, mission: &Mission<'_>) -> Vec<f64> {
    let grid = *world.grid();
    let cells = (0..grid.height as i32).flat_map(|y| (0..grid.width as i32).map(move |x| Cell { x, y }));
    let visits = |cell| if world.is_free(cell) { f64::from(mission.map().visits(cell)) } else { f64::NAN };
    cells.map(visits).collect()
}

/// The mission of `case` to the last of `percents`, with its visits at the start and when each was covered.
fn stages(case: Case, percents: &[u32], seed: u64) -> Result<Vec<Field>, Failure> {
    let to = percents.iter().copied().max().unwrap_or(100);
    let whole = mission(case, to, seed, |_, _| {}).map_err(failure)?;
    let steps_to = |percent: u32| match case.mode {
        CoverMode::Overlap => whole.steps_to(percent),
        CoverMode::Voronoi => (percent == to).then_some(whole.steps),
    };
    let cells = f64::from(case.ground.side.pow(2));
    let mut due: Vec<(u64, String)> = vec![(0, "start".into())];
    due.extend(percents.iter().filter_map(|percent| {
        let steps = steps_to(*percent)?;
        Some((steps, format!("{percent} %: {steps} steps, ratio {:.2}", steps as f64 / cells)))
    }));
    let mut fields = Vec::new();
    mission(case, to, seed, |world, mission| {
        let steps = mission.outcome().steps;
        let reached = due.iter().filter(|(at, _)| *at == steps);
        let field = |heading: &String| Field { heading: heading.clone(), values: visited(world, mission) };
        fields.extend(reached.map(|(_, heading)| field(heading)));
    })
    .map_err(failure)?;
    Ok(fields)
}

fn of_visits(title: String, caption: String, side: u32, fields: Vec<Field>) -> String {
    let quantity = "visits".into();
    FieldGrid { title, caption, quantity, columns: side as usize, fields }.svg()
}

/// A mission of `case`: how often each cell was visited.
///
/// # Errors
/// If it does not end.
pub fn visits(case: Case, percents: &[u32], seed: u64) -> Result<String, Failure> {
    let fields = stages(case, percents, seed)?;
    Ok(of_visits(format!("Visits: {case}"), format!("World of seed {seed}"), case.ground.side, fields))
}

/// The world of the run for which `distance` is least.
fn nearest(account: &Account, distance: impl Fn(usize) -> f64) -> u64 {
    let runs = 0..account.seeds.len();
    let run = runs.min_by(|a, b| distance(*a).total_cmp(&distance(*b)));
    account.seeds[run.expect("a study has worlds")]
}

/// The mission whose path ratio comes nearest to the paper's.
fn five(account: &Account) -> Result<String, Failure> {
    let all = row(&account.single, Algorithm::Spiral, 100);
    let seed = nearest(account, |run| (all.ratios[run] - FIG_5_RATIO).abs());
    let side = all.case.ground.side;
    let caption = format!(
        "{side} × {side} cells, seed {seed}: of {} missions the nearest to {FIG_5_RATIO}",
        account.seeds.len()
    );
    let fields = stages(all.case, &FIG_5_PERCENTS, seed)?;
    Ok(of_visits("A typical mission with spiral".into(), caption, side, fields))
}

/// The pair of missions whose steps come nearest to the paper's.
fn seven_missions(account: &Account) -> Result<String, Failure> {
    let of_side = |pair: &&[Row; 2]| pair[0].case.ground.side == FIG_7_SIDE;
    let pair = account.pairs.iter().find(of_side).expect("one of the sides");
    let cells = f64::from(FIG_7_SIDE.pow(2));
    let seed = nearest(account, |run| {
        [0, 1].map(|mode| (pair[mode].ratios[run] * cells - FIG_7_STEPS[mode]).abs()).iter().sum()
    });
    let mut fields = Vec::new();
    for (row, name) in pair.iter().zip(["overlap", "Voronoi"]) {
        let Some(end) = stages(row.case, &[row.percent], seed)?.pop() else { continue };
        fields.push(Field { heading: format!("{name}, {}", end.heading), ..end });
    }
    let caption = format!(
        "{FIG_7_SIDE} × {FIG_7_SIDE} cells, seed {seed}: of {} pairs the nearest to 444 and 449 steps",
        account.seeds.len()
    );
    Ok(of_visits("Four rovers to 99 %".into(), caption, FIG_7_SIDE, fields))
}

fn worlds(account: &Account) -> String {
    format!("{} random worlds with 10 % obstacles", account.sampling.runs)
}

fn six(account: &Account) -> Curves {
    let chart = |quantity: &str, of: fn(&Row) -> f64| Chart {
        quantity: quantity.into(),
        lines: PLANNERS
            .map(|algorithm| Line {
                name: short(algorithm).into(),
                values: PERCENTS.map(|percent| Some(of(row(&account.single, algorithm, percent)))).into(),
            })
            .into(),
    };
    Curves {
        title: "Path ratio of one rover".into(),
        caption: format!("{}, 20 × 20 cells", worlds(account)),
        axis: "covered [%]".into(),
        at: PERCENTS.map(f64::from).into(),
        charts: vec![
            chart("mean path ratio", |row| row.mean.value),
            chart("standard deviation", |row| row.sd),
        ],
    }
}

/// The names at the foot of a figure have little room.
fn short(algorithm: Algorithm) -> &'static str {
    match algorithm {
        Algorithm::SpiralCircumnavigation => "spiral, circumn.",
        Algorithm::BoustrophedonCircumnavigation => "boustroph., circumn.",
        other => other.name(),
    }
}

/// One chart for each size.
fn seven(account: &Account) -> Curves {
    let chart = |pair: &[Row; 2]| {
        let side = pair[0].case.ground.side;
        let line = |name: &str, row: &Row| Line {
            name: name.into(),
            values: points().map(|ratio| Some(row.share_up_to(ratio))).collect(),
        };
        Chart {
            quantity: format!("share of missions, {side} × {side}"),
            lines: vec![line("overlap", &pair[0]), line("Voronoi", &pair[1])],
        }
    };
    Curves {
        title: "Path ratio of four rovers to 99 %".into(),
        caption: format!(
            "{}; the paper shows one mission in each mode, of 444 and 449 steps",
            worlds(account)
        ),
        axis: "path ratio".into(),
        at: points().collect(),
        charts: account.pairs.iter().map(chart).collect(),
    }
}

/// Path ratios at which the distributions of Fig. 7 are drawn, up to 1.2.
fn points() -> impl Iterator<Item = f64> {
    (0..=POINTS).map(|n| 1.2 * n as f64 / POINTS as f64)
}

fn eight(account: &Account) -> Curves {
    let chart = |side: u32| {
        let of = |row: fn(&Sharing) -> &Row| {
            let cells = account.sharing.iter().map(row).filter(|row| row.case.ground.side == side);
            cells.map(|row| Some(row.mean.value)).collect()
        };
        Chart {
            quantity: format!("path ratio, {side} × {side}"),
            lines: vec![
                Line { name: "overlap".into(), values: of(|both| &both.overlap) },
                Line { name: "Voronoi".into(), values: of(|both| &both.voronoi) },
            ],
        }
    };
    Curves {
        title: "Path ratio of teams at 95 %".into(),
        caption: worlds(account),
        axis: "rovers".into(),
        at: TEAMS.map(|rovers| rovers as f64).into(),
        charts: SIDES.map(chart).into(),
    }
}
