//! Plots the time of each decision, with the budget, on a logarithmic scale.

use std::fmt::Write as _;

use super::DecisionTimings;
use crate::picture::escaped;

const WIDTH: f64 = 960.0;
const HEIGHT: f64 = 360.0;
const LEFT: f64 = 70.0;
const RIGHT: f64 = 20.0;
const TOP: f64 = 40.0;
const BOTTOM: f64 = 45.0;

/// Most points that are drawn; with more decisions, the longest of each stretch.
const POINTS_MAX: usize = 4_000;

/// An SVG document with one point for each decision, coloured by term, and the budget as a line.
#[must_use]
pub fn plot(timings: &DecisionTimings, budget_ns: u64, title: &str) -> String {
    const COLOURS: [&str; 6] = ["#1f5fa8", "#c2571a", "#2c7a3f", "#7d3c98", "#8a6d00", "#555555"];
    let decisions = timings.decisions();
    let totals = || decisions.iter().map(|timed| timed.timing.total_ns().max(1)).chain([budget_ns.max(1)]);
    let decade = |ns: u64| libm::log10(ns as f64);
    let low = decade(totals().min().unwrap_or(1)).floor();
    let high = decade(totals().max().unwrap_or(1)).ceil().max(low + 1.0);
    let last = decisions.last().map_or(1, |timed| timed.decision.0.max(1)) as f64;
    let x = |decision: u64| LEFT + (WIDTH - LEFT - RIGHT) * decision as f64 / last;
    let y = |ns: u64| TOP + (HEIGHT - TOP - BOTTOM) * (high - decade(ns.max(1))) / (high - low);
    let mut svg = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{WIDTH}\" height=\"{HEIGHT}\" \
         viewBox=\"0 0 {WIDTH} {HEIGHT}\" role=\"img\" font-family=\"DejaVu Sans, Verdana, sans-serif\" \
         font-size=\"12\" fill=\"#222\">\n<title>{title}</title>\n\
         <rect width=\"{WIDTH}\" height=\"{HEIGHT}\" fill=\"#fff\"/>\n<text x=\"{LEFT}\" y=\"22\" \
         font-size=\"14\">{title}</text>\n",
        title = escaped(title)
    );
    for power in low as i32..=high as i32 {
        let at = y(10_u64.saturating_pow(power.max(0) as u32));
        let _ = writeln!(
            svg,
            "<path d=\"M{LEFT} {at:.1}H{:.1}\" stroke=\"#ddd\"/><text x=\"{:.1}\" y=\"{:.1}\" \
             text-anchor=\"end\">{}</text>",
            WIDTH - RIGHT,
            LEFT - 6.0,
            at + 4.0,
            duration(power)
        );
    }
    let terms: Vec<u64> = {
        let mut terms: Vec<u64> = decisions.iter().map(|timed| timed.leader.term.0).collect();
        terms.dedup();
        terms
    };
    let stretch = decisions.len().div_ceil(POINTS_MAX).max(1);
    for chunk in decisions.chunks(stretch) {
        let Some(timed) = chunk.iter().max_by_key(|timed| timed.timing.total_ns()) else { continue };
        let term = terms.iter().position(|term| *term == timed.leader.term.0).unwrap_or(0);
        let _ = writeln!(
            svg,
            "<circle cx=\"{:.1}\" cy=\"{:.1}\" r=\"1.8\" fill=\"{}\" fill-opacity=\"0.7\"/>",
            x(timed.decision.0),
            y(timed.timing.total_ns()),
            COLOURS[term % COLOURS.len()]
        );
    }
    let at = y(budget_ns);
    let _ = writeln!(
        svg,
        "<path d=\"M{LEFT} {at:.1}H{:.1}\" stroke=\"#b00020\" stroke-dasharray=\"6 4\"/>\
         <text x=\"{:.1}\" y=\"{:.1}\" text-anchor=\"end\" fill=\"#b00020\">budget</text>",
        WIDTH - RIGHT,
        WIDTH - RIGHT,
        at - 5.0
    );
    let _ = writeln!(
        svg,
        "<text x=\"{:.1}\" y=\"{:.1}\" text-anchor=\"middle\">decision, 0 to {last}; landed to committed; a colour \
         a term</text>\n</svg>",
        (LEFT + WIDTH - RIGHT) / 2.0,
        HEIGHT - 12.0
    );
    svg
}

fn duration(power_ns: i32) -> String {
    const NAMES: [&str; 15] = [
        "1 ns", "10 ns", "100 ns", "1 µs", "10 µs", "100 µs", "1 ms", "10 ms", "100 ms", "1 s", "10 s",
        "100 s", "1000 s", "10⁴ s", "10⁵ s",
    ];
    NAMES[(power_ns.max(0) as usize).min(NAMES.len() - 1)].into()
}
