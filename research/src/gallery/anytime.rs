//! What planners of routes have found after a time: measured beside OMPL, drawn from the measurements.

use node::Failure;
use report::picture::{LogChart, LogCurves, PointLine};

use super::Figure;

/// The measurements, which `research/p21/benches/ompl.sh` writes.
pub const MEASURED: &str = include_str!("../../p21/benches/anytime.csv");

/// Planners that are drawn as lines.
const LINES: [&str; 3] = ["rrt_star_ett", "RRTstar", "BITstar"];

/// One measurement.
#[derive(Clone, Debug, PartialEq)]
pub struct Measured {
    /// Cells to a side of the map.
    pub side: u32,
    /// Ours, or one of OMPL's.
    pub planner: String,
    /// Processor time, milliseconds.
    pub time_ms: f64,
    /// Expected cost of the route above that of `ett_exact`, percent.
    pub above_percent: f64,
}

/// The measurements in the order of their file.
///
/// # Errors
/// If a line is none.
pub fn measured(text: &str) -> Result<Vec<Measured>, Failure> {
    let line = |line: &str| {
        let [side, planner, time_ms, above] = line.split(',').collect::<Vec<_>>().try_into().ok()?;
        Some(Measured {
            side: side.parse().ok()?,
            planner: planner.into(),
            time_ms: time_ms.parse().ok().filter(|ms| *ms > 0.0)?,
            above_percent: above.parse().ok()?,
        })
    };
    let read = |text: &str| {
        let need = "side, planner, milliseconds above 0, percent";
        line(text).ok_or_else(|| Failure::usage(format!("anytime.csv: need {need}, got {text:?}")))
    };
    text.lines().skip(1).map(read).collect()
}

/// The curves on both maps.
///
/// # Errors
/// If the measurements cannot be read.
pub fn figure() -> Result<Figure, Failure> {
    let all = measured(MEASURED)?;
    let chart = |side: u32| {
        let of = |planner: &'static str| {
            let own = all.iter().filter(move |one| one.side == side && one.planner == planner);
            // A logarithmic axis has no place for a cost that rounds to that of `ett_exact`.
            own.filter(|one| one.planner == "ett_exact" || one.above_percent > 0.0)
        };
        let line = |planner: &'static str| PointLine {
            name: planner.into(),
            points: of(planner).map(|one| [one.time_ms, one.above_percent]).collect(),
        };
        LogChart {
            quantity: format!("above ett_exact [%], {side} × {side}"),
            lines: LINES.map(line).into(),
            mark: of("ett_exact").next().map(|one| ("ett_exact ends".into(), one.time_ms)),
        }
    };
    let title = "Cost over time, beside OMPL";
    Ok(Figure {
        name: "anytime".into(),
        title: title.into(),
        text: "What a planner has found after a time, in per cent above the cost of `ett_exact`, which ends at the green line; \
               both axes are logarithmic. Drawn from the measurements in `research/p21/benches/anytime.csv`, which \
               `research/p21/benches/ompl.sh` writes anew; [scouting.md](scouting.md#beside-ompl) says on which \
               machine. `rrt_star_ett` is not asymptotically optimal; each of its points is a run with more samples. \
               RRTstar and BITstar are OMPL's."
            .into(),
        svg: LogCurves {
            title: title.into(),
            caption: "Medians of three seeds, processor time of one thread".into(),
            axis: "time [ms]".into(),
            charts: vec![chart(200), chart(821)],
        }
        .svg(),
    })
}
