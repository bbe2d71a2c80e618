//! The predecessor paper's figures: plans on ground known from edge to edge.

use node::Failure;
use p22::{Findings, P22};

use super::Figure;

/// All figures of the findings on known ground.
///
/// # Errors
/// If they cannot be drawn.
pub fn figures() -> Result<Vec<Figure>, Failure> {
    let drawn = p22::figures(&Findings::new(&P22)).map_err(Failure::run)?;
    Ok(drawn.into_iter().map(figure).collect())
}

fn figure(p22::Figure { name, svg }: p22::Figure) -> Figure {
    let (title, what) = match name {
        "hard" => ("Known ground, hard", "The eleven weightings on hard ground"),
        "heterogeneous" => (
            "Known ground, heterogeneous",
            "The eleven weightings on heterogeneous ground, and (1, 0) again with a goal of 50",
        ),
        "sandy" => ("Known ground, sandy", "The eleven weightings on sandy ground"),
        "rocks" => ("Known ground, two rocks", "The way over the rocks, with its vertical hop"),
        _ => ("Known ground, means along the path", "What the paths run over, against w1"),
    };
    let text = format!(
        "{what}, after Sakamoto & Kubota 2022. `hopper known findings` tells which of the paper's claims they \
         bear out; [known-terrain.md](known-terrain.md) what was read into it."
    );
    Figure { name: format!("known-{name}"), title: title.into(), text, svg }
}
