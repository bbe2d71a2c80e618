//! The paper's observations under the reading in use.

use std::f64::consts::FRAC_1_PI;

use contract::Soil;
use p22::{
    Experiment, Findings, HillHeight, KnownError, KnownMap, P22, Plan, Reading, Weights, figure, figures,
};

/// P-KNOWN: On known ground 67 of 69 claims of Sakamoto & Kubota 2022 hold; the two that do not are
/// named.
#[test]
fn all_but_two_of_the_papers_claims_come_out() {
    let findings = Findings::new(&P22);
    let failing: Vec<&str> =
        findings.claims.iter().filter(|claim| !claim.holds).map(|claim| claim.statement.as_str()).collect();
    let known = [
        "w1 = 0.8: no path from the start to the goal",
        "w1 = 0.6: safer, mean slope below every path's with w1 ≤ 0.5",
    ];
    assert_eq!(failing, known);
    assert_eq!(findings.score(), (67, 69));
    assert!(findings.cases.iter().all(|case| case.settled));
}

#[test]
fn paths_are_lower_and_flatter_where_safety_weighs_most_than_where_information_does() {
    let findings = Findings::new(&P22);
    let cases: Vec<_> = findings.of(Experiment::Hard).collect();
    assert!(cases.iter().all(|case| case.path.arrives()));
    assert!(cases[0].path.mean_height_m > cases[10].path.mean_height_m);
    assert!(cases[0].path.mean_slope > cases[10].path.mean_slope);
    // In mean slope it never goes back.
    assert!(cases.windows(2).all(|pair| pair[1].path.mean_slope <= pair[0].path.mean_slope));
}

#[test]
fn every_answer_in_use_is_one_that_was_searched() {
    let questions = P22.questions();
    for question in &questions {
        assert!(question.answers.contains(&P22), "{}", question.field);
        assert!(question.answers.len() >= 2, "{}", question.field);
    }
    let fields = serde_json::to_value(P22).unwrap().as_object().unwrap().len();
    assert_eq!(questions.len(), fields, "every field of a reading is a question");
}

#[test]
fn hills_are_those_of_the_papers_table() {
    let printed = KnownMap::new(Experiment::Hard, &Reading { hill_height: HillHeight::Printed, ..P22 });
    let without =
        KnownMap::new(Experiment::Hard, &Reading { hill_height: HillHeight::WithoutDeterminant, ..P22 });
    for (low, high) in printed.ground.iter().zip(&without.ground) {
        assert!((4.0 * low.height_m - high.height_m).abs() < 1e-12, "the root of |Σ| = 16 is 4");
    }
    // P23 on the same hills: heights of −0.159 to 0.161 m, slopes up to 0.087.
    let most =
        |value: fn(&contract::Ground) -> f64| without.ground.iter().map(value).fold(f64::MIN, f64::max);
    assert!((most(|ground| ground.height_m) - 0.161).abs() < 1e-3);
    assert!((most(|ground| -ground.height_m) - 0.159).abs() < 1e-3);
    assert!((most(|ground| ground.steepness()) - 0.087).abs() < 1e-3);
    assert!((HillHeight::WithoutDeterminant.amplitude_m() - FRAC_1_PI / 2.0).abs() < 1e-15);
}

#[test]
fn sand_lies_where_the_paper_has_it() {
    let sand = |experiment| {
        let world = KnownMap::new(experiment, &P22);
        world.ground.iter().filter(|ground| ground.soil == Soil::Sand).count()
    };
    assert_eq!(sand(Experiment::Hard), 0);
    assert_eq!(sand(Experiment::Heterogeneous), 7 * 9);
    assert!(sand(Experiment::Sandy) > 200, "most of it: {}", sand(Experiment::Sandy));
    assert_eq!(sand(Experiment::Rocks), 0);
}

#[test]
fn weights_that_are_none_are_refused() {
    for w1 in [-0.1, 1.1, f64::NAN] {
        assert!(matches!(Weights::new(w1, 10.0), Err(KnownError::Weight { .. })), "{w1}");
    }
    for goal in [0.0, -1.0, f64::INFINITY, f64::NAN] {
        assert!(matches!(Weights::new(0.5, goal), Err(KnownError::GoalPayoff { .. })), "{goal}");
    }
    assert!("moon".parse::<Experiment>().is_err());
}

#[test]
fn every_figure_is_a_document_with_a_panel_a_plan() {
    let findings = Findings::new(&P22);
    let drawn = figures(&findings).unwrap();
    assert_eq!(drawn, figures(&findings).unwrap(), "the same to the byte");
    for (figure, panels) in drawn.iter().zip([11, 12, 11, 1, 0]) {
        let document = roxmltree::Document::parse(&figure.svg).unwrap();
        let uses = document.descendants().filter(|node| node.has_tag_name("use")).count();
        assert_eq!(uses, panels, "{}", figure.name);
        let text: String = document.descendants().filter_map(|node| node.text()).collect();
        assert_eq!(
            text.contains("): no path"),
            ["heterogeneous", "sandy"].contains(&figure.name),
            "{}",
            figure.name
        );
    }
    let world = KnownMap::new(Experiment::Rocks, &P22);
    let model = p22::Model::new(&world, &P22);
    let plan = Plan::new(&world, &model, &P22, Weights::new(0.5, 10.0).unwrap());
    let svg = figure(&world, &model, &plan).unwrap();
    assert!(
        roxmltree::Document::parse(&svg)
            .unwrap()
            .descendants()
            .any(|node| node.text() == Some("vertical hop"))
    );
}
