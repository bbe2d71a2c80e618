//! Symbols of start, goal, hopper and treasures.

use super::svg_writer::Number;
use crate::colour;

/// Whether a treasure was collected, seen or neither.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TreasureState {
    Collected,
    Seen,
    Unseen,
}

/// Symbol of the start: a blue dot, as in P23.
pub fn start(x: f64, y: f64, size: f64) -> String {
    dot(x, y, size, colour::START, "#fff")
}

/// Symbol of the hopper: a yellow dot, as in P23.
pub fn hopper(x: f64, y: f64, size: f64) -> String {
    dot(x, y, size, colour::HOPPER, "#111")
}

pub fn dot(x: f64, y: f64, size: f64, fill: &str, stroke: &str) -> String {
    format!(
        "<circle cx=\"{}\" cy=\"{}\" r=\"{}\" fill=\"{fill}\" stroke=\"{stroke}\" stroke-width=\"1.8\"/>",
        Number(x),
        Number(y),
        Number(size)
    )
}

/// Path of the symbol of an impact: a diamond.
pub fn impact(x: f64, y: f64, size: f64) -> String {
    let (across, back) = (Number(size), Number(-size));
    format!("M{} {}l{across} {across}l{back} {across}l{back} {back}z", Number(x), Number(y - size))
}

/// Symbol of a goal: a red star instead of P23's red dot, so that the shape differs too; with a dark rim around the white one,
/// since neither red nor white stands out on ground of middling height.
pub fn goal(x: f64, y: f64, size: f64) -> String {
    let path = outline(x, y, size);
    let rim = format!(
        "<polygon points=\"{path}\" fill=\"none\" stroke=\"{}\" stroke-width=\"3.8\" stroke-linejoin=\"round\"/>",
        colour::DARK
    );
    rim + &star(x, y, size, &format!("fill=\"{}\" stroke=\"#fff\"", colour::GOAL))
}

/// Symbol of a treasure: a black star, as in P23; golden once collected, faint while unseen.
pub fn treasure(x: f64, y: f64, size: f64, treasure_state: TreasureState) -> String {
    let ink = match treasure_state {
        TreasureState::Collected => "fill=\"#ffc400\" stroke=\"#111\"",
        TreasureState::Seen => "fill=\"#111\" stroke=\"#fff\"",
        TreasureState::Unseen => "fill=\"#111\" stroke=\"#fff\" opacity=\".45\"",
    };
    star(x, y, size, ink)
}

fn star(x: f64, y: f64, size: f64, ink: &str) -> String {
    format!(
        "<polygon points=\"{}\" {ink} stroke-width=\"1.8\" stroke-linejoin=\"round\" paint-order=\"stroke\"/>",
        outline(x, y, size)
    )
}

/// The corners of a star.
fn outline(x: f64, y: f64, size: f64) -> String {
    let points: Vec<String> = (0..10)
        .map(|n| {
            let radius = size * if n % 2 == 0 { 1.45 } else { 0.62 };
            let angle = std::f64::consts::PI * f64::from(n) / 5.0;
            format!("{} {}", Number(x + radius * libm::sin(angle)), Number(y - radius * libm::cos(angle)))
        })
        .collect();
    points.join(" ")
}
