//! Histograms of the steps of successful trials, cell by cell, as SVG.

use std::collections::BTreeMap;
use std::fmt::Write as _;

use contract::Status;

use crate::{Cell, Report, Tally};

const WIDTH: f64 = 960.0;
const LEFT: f64 = 310.0;
const RIGHT: f64 = 230.0;
const TOP: f64 = 64.0;
const ROW: f64 = 46.0;
const BOTTOM: f64 = 52.0;

/// How missions fail, with the word and the colour of each.
const FAILURES: [(Status, &str, &str); 4] = [
    (Status::Deadlock, "out of steps", "#d9a441"),
    (Status::LeftMap, "left the map", "#7a5195"),
    (Status::Lost, "lost", "#c0392b"),
    (Status::Underway, "stopped", "#888"),
];

/// Rows of one step limit, which share an axis.
struct Block<'a> {
    steps_max: u64,
    rows: Vec<(&'a Cell, &'a Tally)>,
}

impl Block<'_> {
    /// Steps in a bin: at the usual limit of 150 steps it is one hop (2 steps); larger limits keep the number of bins.
    fn bin(&self) -> u64 {
        2 * (self.steps_max / 150).max(1)
    }

    /// Place of a number of steps on the axis.
    fn x(&self, steps: f64) -> f64 {
        LEFT + (WIDTH - LEFT - RIGHT) * steps / (self.steps_max + self.bin()) as f64
    }

    /// Its rows and the axis below them, from `top` on.
    fn drawn(&self, top: f64, axis: &str) -> String {
        let (mut svg, bottom) = (String::new(), top + ROW * self.rows.len() as f64);
        let pitch = round(self.steps_max / 6);
        for tick in (0..=self.steps_max / pitch).map(|n| n * pitch) {
            let (at, below) = (self.x(tick as f64), bottom + 18.0);
            let _ = writeln!(
                svg,
                "<line x1=\"{at:.1}\" x2=\"{at:.1}\" y1=\"{top}\" y2=\"{bottom}\" stroke=\"#ddd\"/>\
                 <text x=\"{at:.1}\" y=\"{below:.1}\" text-anchor=\"middle\">{tick}</text>"
            );
        }
        let (middle, below) = (self.x(self.steps_max as f64 / 2.0), bottom + 36.0);
        let _ = writeln!(
            svg,
            "<text x=\"{middle:.1}\" y=\"{below:.1}\" text-anchor=\"middle\">{axis} (bins of {})</text>",
            self.bin()
        );
        for (place, (cell, tally)) in self.rows.iter().enumerate() {
            svg += &self.row(cell, tally, top + ROW * place as f64);
        }
        svg
    }

    /// The histogram of one cell.
    fn row(&self, cell: &Cell, tally: &Tally, top: f64) -> String {
        let (base, bin) = (top + ROW - 4.0, self.bin());
        let mut bins = BTreeMap::<u64, u64>::new();
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
            self.x(0.0),
            WIDTH - RIGHT
        );
        for (number, count) in bins {
            let (from, to) = (self.x((number * bin) as f64), self.x(((number + 1) * bin) as f64));
            let height = (ROW - 12.0) * count as f64 / most;
            let _ = writeln!(
                svg,
                "<rect x=\"{from:.1}\" y=\"{:.1}\" width=\"{:.1}\" height=\"{height:.1}\" fill=\"{colour}\"/>",
                base - height,
                to - from - 0.5
            );
        }
        let mean = tally.statistics(cell.steps_max).steps.mean;
        if let Some(mean) = mean {
            let (at, top) = (self.x(mean), top + 4.0);
            let _ = writeln!(
                svg,
                "<line x1=\"{at:.1}\" x2=\"{at:.1}\" y1=\"{top:.1}\" y2=\"{base:.1}\" stroke=\"#000\" stroke-width=\"1.5\"/>"
            );
        }
        svg + &beside(tally, mean, base)
    }
}

/// What stands to the right of a row: how many reached the goal, and as a bar and in words how the others ended.
fn beside(tally: &Tally, mean: Option<f64>, base: f64) -> String {
    let (left, width, trials) = (WIDTH - RIGHT + 10.0, RIGHT - 26.0, tally.trials());
    let mean = mean.map_or(String::new(), |mean| format!(", mean {mean:.1}"));
    let goals = tally.count(Status::Goal);
    let mut svg =
        format!("<text x=\"{left:.1}\" y=\"{:.1}\">{goals} of {trials}{mean}</text>\n", base - 20.0);
    let (mut from, mut words) = (left, Vec::new());
    for (status, word, colour) in FAILURES {
        let count = tally.count(status);
        if count == 0 {
            continue;
        }
        let share = width * count as f64 / trials as f64;
        let _ = writeln!(
            svg,
            "<rect x=\"{from:.1}\" y=\"{:.1}\" width=\"{share:.1}\" height=\"4\" fill=\"{colour}\"/>",
            base - 4.0
        );
        from += share;
        words.push(format!("{count} {word}"));
    }
    if !words.is_empty() {
        let words = words.join(", ");
        let _ =
            writeln!(svg, "<text x=\"{left:.1}\" y=\"{:.1}\" fill=\"#8a1c1c\">{words}</text>", base - 7.0);
    }
    svg
}

impl Report {
    /// One histogram of steps over successful trials for each cell, with its mean, the number of successes, and how the
    /// others ended. Cells of one step limit share an axis; `axis` is what it says.
    #[must_use]
    pub fn distribution_svg(&self, axis: &str) -> String {
        let mut blocks: Vec<Block<'_>> = Vec::new();
        for (cell, tally) in self.cells().filter(|(_, tally)| tally.trials() > 0) {
            match blocks.iter_mut().find(|block| block.steps_max == cell.steps_max) {
                Some(block) => block.rows.push((cell, tally)),
                None => blocks.push(Block { steps_max: cell.steps_max, rows: vec![(cell, tally)] }),
            }
        }
        let (mut drawn, mut bottom) = (String::new(), TOP);
        for block in &blocks {
            drawn += &block.drawn(bottom, axis);
            bottom += ROW * block.rows.len() as f64 + BOTTOM;
        }
        format!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {WIDTH} {bottom}\" font-family=\"DejaVu Sans, Verdana, Helvetica, sans-serif\" \
             font-size=\"12\" fill=\"#222\">\n<rect width=\"{WIDTH}\" height=\"{bottom}\" fill=\"#fff\"/>\n\
             <text x=\"16\" y=\"26\" font-size=\"17\">Steps of successful missions</text>\n\
             <text x=\"16\" y=\"46\" fill=\"#666\">bars: share of the cell's successes, each row to its own height; \
             line: mean; right: trials that reached the goal, and how the others ended</text>\n{drawn}</svg>\n"
        )
    }
}

/// A round number of steps that is at least `steps`.
fn round(steps: u64) -> u64 {
    let rounds = [5, 10, 25, 50, 100, 250, 500];
    rounds.into_iter().find(|&round| round >= steps).unwrap_or_else(|| steps.next_multiple_of(1000))
}

fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;")
}
