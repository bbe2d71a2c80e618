//! Worlds whose hops land by a table.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

use proptest::prelude::*;
use solver::landings::{
    Landing, LandingTable, Row, TableRules, TableSite, TableWorld, action_values, certify, solve,
};
use solver::{Effort, Error, GridWorld, Hop, Kind, Leaving, Rules, Site, Soil, SolveStatus, Solver};

fn landing(forward: i8, left: i8, probability: f64) -> Landing {
    Landing { forward, left, probability }
}

fn table(rows: Vec<Vec<Landing>>) -> LandingTable {
    LandingTable::new(
        rows.into_iter()
            .enumerate()
            .map(|(number, landings)| Row { landings, waits: number % 2 == 1 })
            .collect(),
    )
    .unwrap()
}

/// Of sand and hard ground: short, long, stray, and now and then lost.
fn rows() -> Vec<Vec<Landing>> {
    vec![
        vec![landing(1, 0, 0.8), landing(0, 0, 0.1), landing(2, 0, 0.05), landing(1, -1, 0.05)],
        vec![landing(1, 0, 0.3), landing(0, 0, 0.6), landing(-1, 0, 0.04), landing(1, 2, 0.03)],
        vec![landing(0, 0, 1.0)],
        vec![],
    ]
}

/// A world by `seed`, whatever its ground: a third of the hops of each of the first three classes, a few of the one that is lost.
fn world(width: usize, height: usize, seed: u64, leaving: Leaving) -> TableWorld {
    let rules = TableRules { discount: 0.95, loss: -40.0, leaving };
    let mut world = TableWorld::new(width, height, rules, table(rows())).unwrap();
    let mut state = seed | 1;
    let mut below = |most: u64| {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 33) % most
    };
    for node in 0..world.nodes() {
        let kind = match below(20) {
            0 => Kind::Lost,
            1 => Kind::Goal,
            _ => Kind::Free,
        };
        let classes = [0; 4].map(|_| [0, 0, 0, 0, 1, 1, 1, 2, 2, 3][below(10) as usize]);
        let payoff = if kind == Kind::Goal { 100.0 } else { below(3) as f64 - 1.0 };
        world.set(node, TableSite { kind, payoff, classes });
    }
    world
}

/// Value iteration from the definition, until nothing changes.
fn by_brute_force(world: &TableWorld) -> Vec<f64> {
    let mut values = vec![0.0; world.nodes()];
    for _ in 0..2_000 {
        let next = |node: usize| match world.kind(node) {
            Kind::Free => action_values(world, &values, node).into_iter().fold(f64::NEG_INFINITY, f64::max),
            Kind::Goal | Kind::Lost => 0.0,
        };
        values = (0..world.nodes()).map(next).collect();
    }
    values
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(60))]

    #[test]
    fn the_values_are_those_of_value_iteration_and_the_certificate_holds(
        seed: u64, width in 1_usize..9, height in 1_usize..9, stays: bool,
    ) {
        let leaving = if stays { Leaving::Stays } else { Leaving::Loses };
        let world = world(width, height, seed, leaving);
        let (values, solution) = solve(&world, &Effort { error_max: 1e-9, sweeps_max: u64::MAX });
        prop_assert_eq!(solution.status, SolveStatus::Solved);
        prop_assert_eq!(solution.certificate, certify(&world, &values));
        for (node, exact) in by_brute_force(&world).into_iter().enumerate() {
            let error = (values[node] - exact).abs();
            prop_assert!(error <= solution.certificate.error_bound + 1e-11, "node {}: {}", node, error);
        }
    }
}

/// The law of the papers is a table of four landings: on level ground both solvers find the same values.
#[test]
fn a_table_of_four_landings_is_the_law() {
    let row = vec![landing(1, 0, 0.8), landing(0, 0, 0.1), landing(0, 1, 0.05), landing(0, -1, 0.05)];
    let cases = [Leaving::Stays, Leaving::Loses].map(|leaving| [(leaving, false), (leaving, true)]);
    for (leaving, waits) in cases.into_iter().flatten() {
        let soil = Soil { intended: 0.8, stuck: 0.1, sideways: 0.05, wait: f64::from(u8::from(waits)) };
        let rules = TableRules { discount: 0.99, loss: -30.0, leaving };
        let by_row = LandingTable::new(vec![Row { landings: row.clone(), waits }]).unwrap();
        let mut by_table = TableWorld::new(23, 17, rules, by_row).unwrap();
        let rules = Rules { discount: 0.99, loss: -30.0, leaving, soils: vec![soil] };
        let mut by_law = GridWorld::new(23, 17, rules).unwrap();
        for node in 0..by_law.nodes() {
            let kind = match node {
                200 => Kind::Goal,
                node if node % 11 == 3 => Kind::Lost,
                _ => Kind::Free,
            };
            let payoff = if kind == Kind::Goal { 100.0 } else { -1.0 };
            by_table.set(node, TableSite { kind, payoff, classes: [0; 4] });
            by_law.set(node, Site { kind, payoff, ..by_law.site(node) });
        }
        let effort = Effort { error_max: 1e-9, sweeps_max: u64::MAX };
        let (values, solution) = solve(&by_table, &effort);
        let mut solver = Solver::new();
        let other = solver.solve(&by_law, &effort);
        assert_eq!((solution.status, other.status), (SolveStatus::Solved, SolveStatus::Solved));
        for (node, value) in values.iter().enumerate() {
            if by_law.kind(node) == Kind::Free {
                assert!((value - solver.values()[node]).abs() <= 2e-9, "{leaving:?}, node {node}");
            }
        }
    }
}

/// Landings turn with the hop.
#[test]
fn a_landing_is_in_the_frame_of_its_hop() {
    let world = world(9, 9, 1, Leaving::Loses);
    let from = 4 * 9 + 4;
    let to = |hop| world.landing(from, hop, 2, 1).map(|node| (node % 9, node / 9));
    assert_eq!(Hop::ALL.map(to), [Some((3, 6)), Some((6, 5)), Some((5, 2)), Some((2, 3))]);
    assert_eq!(world.landing(0, Hop::South, 1, 0), None);
}

#[test]
fn a_budget_cuts_and_the_certificate_says_how_far_it_is() {
    let world = world(40, 40, 3, Leaving::Stays);
    let (values, solution) = solve(&world, &Effort { error_max: 1e-9, sweeps_max: 2 });
    assert_eq!((solution.status, solution.sweeps), (SolveStatus::Cut, 2));
    let (exact, _) = solve(&world, &Effort { error_max: 1e-9, sweeps_max: u64::MAX });
    let far = values.iter().zip(&exact).map(|(value, exact)| (value - exact).abs()).fold(0.0, f64::max);
    assert!(far > 1e-6 && far <= solution.certificate.error_bound, "{far} {solution:?}");
}

#[test]
fn what_no_double_can_certify_ends_at_the_limit() {
    let world = world(12, 12, 5, Leaving::Stays);
    let (_, solution) = solve(&world, &Effort { error_max: 0.0, sweeps_max: u64::MAX });
    assert_eq!(solution.status, SolveStatus::AtLimit);
    assert!(solution.certificate.error_bound < 1e-9, "{solution:?}");
}

#[test]
fn tables_that_are_none_are_refused_by_row() {
    let refused =
        |landings: Vec<Landing>| LandingTable::new(vec![Row::default(), Row { landings, waits: false }]);
    assert_eq!(LandingTable::new(Vec::new()), Err(Error::Rows { got: 0, rows_max: 16_384 }));
    assert!(matches!(refused(vec![landing(0, 0, 0.0); 14]), Err(Error::Landings { row: 1, got: 14, .. })));
    for wrong in [landing(9, 0, 0.1), landing(0, -9, 0.1), landing(1, 0, -0.1), landing(1, 0, f64::NAN)] {
        assert!(matches!(refused(vec![wrong]), Err(Error::Landing { row: 1, .. })), "{wrong:?}");
    }
    let sum = refused(vec![landing(1, 0, 0.7), landing(0, 0, 0.4)]).unwrap_err();
    assert!(sum.to_string().contains("row 1 of a table need to add up to at most 1, got 1.1"), "{sum}");
}
