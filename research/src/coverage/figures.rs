//! Figs 6 to 8 as curves.

use ::coverage::Algorithm;
use report::picture::{Chart, Curves, Line};

use super::case::Row;
use super::study::{PERCENTS, PLANNERS, SIDES, Sharing, Study, TEAMS, row};

/// Points of a distribution in Fig. 7.
const POINTS: usize = 60;

/// File names and SVG documents.
pub fn all(study: &Study) -> [(String, String); 3] {
    [("fig-6.svg", six(study)), ("fig-7.svg", seven(study)), ("fig-8.svg", eight(study))]
        .map(|(name, curves)| (name.to_owned(), curves.svg()))
}

fn worlds(study: &Study) -> String {
    format!("{} random worlds with 10 % obstacles", study.sampling.runs)
}

fn six(study: &Study) -> Curves {
    let chart = |quantity: &str, of: fn(&Row) -> f64| Chart {
        quantity: quantity.into(),
        lines: PLANNERS
            .map(|algorithm| Line {
                name: short(algorithm).into(),
                values: PERCENTS.map(|percent| Some(of(row(&study.single, algorithm, percent)))).into(),
            })
            .into(),
    };
    Curves {
        title: "Path ratio of one rover".into(),
        caption: format!("{}, 20 × 20 cells", worlds(study)),
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
fn seven(study: &Study) -> Curves {
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
        caption: format!("{}; the paper shows one mission in each mode, of 444 and 449 steps", worlds(study)),
        axis: "path ratio".into(),
        at: points().collect(),
        charts: study.pairs.iter().map(chart).collect(),
    }
}

/// Path ratios at which the distributions of Fig. 7 are drawn, up to 1.2.
fn points() -> impl Iterator<Item = f64> {
    (0..=POINTS).map(|n| 1.2 * n as f64 / POINTS as f64)
}

fn eight(study: &Study) -> Curves {
    let chart = |side: u32| {
        let of = |row: fn(&Sharing) -> &Row| {
            let cells = study.sharing.iter().map(row).filter(|row| row.case.ground.side == side);
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
        caption: worlds(study),
        axis: "rovers".into(),
        at: TEAMS.map(|rovers| rovers as f64).into(),
        charts: SIDES.map(chart).into(),
    }
}
