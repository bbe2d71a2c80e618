//! The bounds against MODEL's figures, against enumeration, and against what the planner reaches.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

use clairvoyant::{Bounds, Clairvoyant, ClairvoyantError, bounds};
use contract::{Action, Branch, Cell, Direction, Grid, Leg, Soil};
use motion::{landing, steps, transition};
use scenario::ResolvedScenario;
use terrain::Terrain;

fn world(name: &str) -> ResolvedScenario {
    scenario::load(name).unwrap().resolve().unwrap()
}

#[track_caller]
fn rounds_to(got: f64, need: &str) {
    assert_eq!(format!("{got:.2}"), need);
}

/// P-BOUNDS.
#[test]
fn success_on_the_papers_grounds_is_bounded_as_the_model_says() {
    for (name, success) in [("hard", "100.00"), ("heterogeneous", "100.00"), ("sandy", "99.12")] {
        let ResolvedScenario { brief, terrain, .. } = world(name);
        rounds_to(100.0 * bounds(&brief.leg(0), &terrain).success, success);
    }
}

#[test]
fn restricted_means_on_the_papers_grounds_are_bounded_by_the_least_expected_steps_of_the_model() {
    // The model's figures know no clock and price leaving the map otherwise: 74.11, 74.89, 111.98.
    for (name, least, model) in
        [("hard", "74.12", 74.11), ("heterogeneous", "74.89", 74.89), ("sandy", "111.94", 111.98)]
    {
        let ResolvedScenario { brief, terrain, .. } = world(name);
        let restricted = bounds(&brief.leg(0), &terrain).restricted_mean_steps;
        rounds_to(restricted, least);
        assert!((restricted - model).abs() <= 0.05, "{name}: {restricted}");
    }
}

/// A world of 3 × 3 cells cut from sandy ground, with slopes, sand and a rock.
fn nine_cells(steps_max: u64) -> (Leg, Terrain) {
    let ResolvedScenario { brief, terrain, .. } = world("sandy");
    let mut terrain = Terrain::clone(&terrain);
    let full = terrain.grid;
    let grid = Grid::new(3, 3, 1.0, 1).unwrap();
    let cell = |c: Cell| terrain.cells[full.index(Cell::new(c.x + 6, c.y + 8)).unwrap()];
    terrain.cells = grid.iter().map(cell).collect();
    terrain.cells[4].soil = Soil::Sand;
    terrain.cells[1].gradient = [0.2, -0.1];
    terrain.cells[5].passable = false;
    terrain.grid = grid;
    let mut leg = Leg { grid, start: Cell::new(0, 0), goal: Cell::new(2, 2), ..brief.leg(0) };
    leg.limits.steps_max = steps_max;
    (leg, terrain)
}

/// Both bounds by walking the whole tree of what may happen, standing still included.
fn enumerated(leg: &Leg, terrain: &Terrain, cell: Cell, spent: u64) -> Bounds {
    let limit = leg.limits.steps_max;
    let failed = Bounds { success: 0.0, restricted_mean_steps: limit as f64 };
    if cell == leg.goal && spent <= limit {
        return Bounds { success: 1.0, restricted_mean_steps: spent as f64 };
    }
    let Some(ground) = terrain.ground(cell).filter(|ground| ground.passable && spent < limit) else {
        return failed;
    };
    let mut best = enumerated(leg, terrain, cell, spent + steps(ground.soil, Action::Hold, Branch::Held));
    for direction in Direction::ALL {
        let mut sum = Bounds { success: 0.0, restricted_mean_steps: 0.0 };
        for branch in [Branch::Intended, Branch::Stayed, Branch::Left, Branch::Right] {
            let p = transition(&leg.motion, ground, direction).probability(branch);
            let to = landing(&leg.grid, cell, direction, branch);
            let then =
                enumerated(leg, terrain, to, spent + steps(ground.soil, Action::Hop(direction), branch));
            sum.success += p * then.success;
            sum.restricted_mean_steps += p * then.restricted_mean_steps;
        }
        best.success = best.success.max(sum.success);
        best.restricted_mean_steps = best.restricted_mean_steps.min(sum.restricted_mean_steps);
    }
    best
}

/// P-BOUNDS: The clairvoyant bounds equal those of enumeration and of the published reading, and
/// are reached.
#[test]
fn the_bounds_are_those_of_enumeration_on_nine_cells() {
    for steps_max in 0..=10 {
        let (leg, terrain) = nine_cells(steps_max);
        let (got, need) = (bounds(&leg, &terrain), enumerated(&leg, &terrain, leg.start, 0));
        assert!((got.success - need.success).abs() <= 1e-12, "{steps_max}: {got:?}, {need:?}");
        assert!((got.restricted_mean_steps - need.restricted_mean_steps).abs() <= 1e-12, "{got:?}, {need:?}");
    }
}

#[test]
fn a_table_that_would_not_fit_is_refused() {
    let ResolvedScenario { mut brief, terrain, .. } = world("hard");
    brief.limits.steps_max = u64::MAX;
    let need = ClairvoyantError::TooLarge { cells: 400, steps: u64::MAX };
    assert_eq!(Clairvoyant::new(&brief.leg(0), &terrain, None).err(), Some(need));
}
