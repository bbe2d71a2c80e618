//! Histograms of the steps of successful trials, cell by cell, as SVG.

use std::fmt::Write as _;

use contract::Status;

use crate::{Cell, Report, Tally};

const WIDTH: f64 = 920.0;
const LEFT: f64 = 310.0;
const RIGHT: f64 = 190.0;
const TOP: f64 = 64.0;
const ROW: f64 = 46.0;
const BOTTOM: f64 = 52.0;

impl Report {
    /// One histogram of steps over successful trials for each cell, with its mean and the number of successes,
    /// all on one axis from 0 to the largest step limit; `axis` is what the axis says.
    #[must_use]
    pub fn distribution_svg(&self, axis: &str) -> String {
        let cells: Vec<_> = self.cells().filter(|(_, tally)| tally.trials() > 0).collect();
        let steps_max = cells.iter().map(|(cell, _)| cell.steps_max).max().unwrap_or(150);
        // At the usual limit of 150 steps a bin is one hop (2 steps); larger limits keep the number of bins.
        let bin = 2 * (steps_max / 150).max(1);
        let bottom = TOP + ROW * cells.len() as f64;
        let mut svg = format!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {WIDTH} {height}\" font-family=\"DejaVu Sans, Verdana, Helvetica, sans-serif\" \
             font-size=\"12\" fill=\"#222\">\n<rect width=\"{WIDTH}\" height=\"{height}\" fill=\"#fff\"/>\n\
             <text x=\"16\" y=\"26\" font-size=\"17\">Steps of successful missions</text>\n\
             <text x=\"16\" y=\"46\" fill=\"#666\">bars: share of the cell's successes in bins of {bin} steps, \
             each row to its own height; line: mean; right: trials that reached the goal</text>\n",
            height = bottom + BOTTOM
        );
        let x = |steps: f64| LEFT + (WIDTH - LEFT - RIGHT) * steps / (steps_max + bin) as f64;
        let pitch = round(steps_max / 6);
        for tick in (0..=steps_max / pitch).map(|n| n * pitch) {
            let at = x(tick as f64);
            let _ = writeln!(
                svg,
                "<line x1=\"{at:.1}\" x2=\"{at:.1}\" y1=\"{TOP}\" y2=\"{bottom}\" stroke=\"#ddd\"/>\
                 <text x=\"{at:.1}\" y=\"{:.1}\" text-anchor=\"middle\">{tick}</text>",
                bottom + 18.0
            );
        }
        let _ = writeln!(
            svg,
            "<text x=\"{:.1}\" y=\"{:.1}\" text-anchor=\"middle\">{axis}</text>",
            x(steps_max as f64 / 2.0),
            bottom + 38.0
        );
        for (place, (cell, tally)) in cells.iter().enumerate() {
            svg += &row(cell, tally, TOP + ROW * place as f64, bin, &x);
        }
        svg + "</svg>\n"
    }
}

/// A round number of steps that is at least `steps`.
fn round(steps: u64) -> u64 {
    let rounds = [5, 10, 25, 50, 100, 250, 500];
    rounds.into_iter().find(|&round| round >= steps).unwrap_or_else(|| steps.next_multiple_of(1000))
}

fn row(cell: &Cell, tally: &Tally, top: f64, bin: u64, x: &impl Fn(f64) -> f64) -> String {
    let base = top + ROW - 4.0;
    let mut bins = std::collections::BTreeMap::<u64, u64>::new();
    for (steps, count) in tally.steps() {
        *bins.entry(steps / bin).or_default() += count;
    }
    let most = bins.values().copied().max().unwrap_or(1) as f64;
    let colour = if cell.planner == "greedy" { "#c77c2a" } else { "#2a6fb0" };
    let mut svg = format!(
        "<text x=\"16\" y=\"{:.1}\">{}</text>\n<line x1=\"{:.1}\" x2=\"{:.1}\" y1=\"{base:.1}\" y2=\"{base:.1}\" \
         stroke=\"#999\"/>\n",
        base - 8.0,
        escaped(&cell.to_string()),
        x(0.0),
        WIDTH - RIGHT
    );
    for (number, count) in bins {
        let (from, to) = (x((number * bin) as f64), x(((number + 1) * bin) as f64));
        let height = (ROW - 12.0) * count as f64 / most;
        let _ = writeln!(
            svg,
            "<rect x=\"{from:.1}\" y=\"{:.1}\" width=\"{:.1}\" height=\"{height:.1}\" fill=\"{colour}\"/>",
            base - height,
            to - from - 0.5
        );
    }
    let statistics = tally.statistics(cell.steps_max);
    if let Some(mean) = statistics.steps.mean {
        let at = x(mean);
        let _ = writeln!(
            svg,
            "<line x1=\"{at:.1}\" x2=\"{at:.1}\" y1=\"{:.1}\" y2=\"{base:.1}\" stroke=\"#000\" stroke-width=\"1.5\"/>",
            top + 4.0
        );
    }
    let mean = statistics.steps.mean.map_or(String::new(), |mean| format!(", mean {mean:.1}"));
    let _ = writeln!(
        svg,
        "<text x=\"{:.1}\" y=\"{:.1}\">{} of {}{mean}</text>",
        WIDTH - RIGHT + 10.0,
        base - 8.0,
        tally.count(Status::Goal),
        tally.trials()
    );
    svg
}

fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;")
}
