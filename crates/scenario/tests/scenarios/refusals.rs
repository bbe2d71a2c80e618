//! What is refused, and in which words.

use contract::Cell;
use proptest::prelude::*;
use scenario::{BUILT_IN, Scenario};

use crate::{HILLY, built_in, hilly, says};

#[test]
fn mistakes_in_the_text_are_told_with_line_and_column() {
    for (from, to, line, words) in [
        ("sigma_m = 1.0", "sigma = 1.0", "line 6, column 1", "unknown field `sigma`"),
        ("start = [0, 0]", "start = [0]", "line 10, column 9", "length"),
        (
            "start = [0, 0]",
            "start = [0, 0, 0]",
            "line 10, column 9",
            "length 3, expected an array of length 2",
        ),
        ("[brief]", "[journey]", "line 9, column 2", "unknown field `journey`"),
        ("start = [0, 0]", "profile = \"paper\"", "line 10, column 11", "unknown variant `paper`"),
        ("start = [0, 0]", "datum_m = \"lowest\"", "line 10, column 11", "need \"survey\", a number"),
        ("start = [0, 0]", "start = [0, 0", "line 1", ""),
        ("[truth.terrain.gaussians]", "[truth.terrain.sphere]", "line 2", "unknown variant `sphere`"),
    ] {
        let text = hilly(from, to).unwrap_err().to_string();
        says(&text, &["hilly: TOML parse error at", words]);
        assert!(text.contains(line) || line == "line 1", "{line} is missing in: {text}");
    }
    let two = HILLY.replace("[brief]", "[truth.terrain.elevation_file]\nfile = \"x\"\n[brief]");
    says(&Scenario::parse(&two, "two").unwrap_err().to_string(), &["TOML parse error"]);
}

#[test]
fn values_out_of_range_are_refused_with_need_and_got() {
    for (from, to, words) in [
        ("sigma_m = 1.0", "sigma_m = 0", ["sigma_m", "above 0 m"]),
        ("sigma_m = 1.0", "sigma_m = nan", ["sigma_m", "NaN"]),
        ("amplitude_m = 0.2", "amplitude_m = inf", ["amplitude_m", "inf"]),
        ("[[1, 1]]", "[[nan, 1]]", ["raised_m", "NaN"]),
        ("cell_size_m = 0.5", "cell_size_m = -0.5", ["cell_size_m", "above 0 m"]),
        ("cell_size_m = 0.5", "cell_size_m = 0.3", ["whole number of cells", "cell_size_m = 0.333"]),
        ("width_cells = 10", "width_cells = 2000", ["1 to 1024 cells", "2000"]),
        ("width_cells = 10", "width_cells = 0", ["1 to 1024 cells", "0 x 8"]),
        ("[brief]", "[brief]\nname = \"two words\"", ["brief.name", "two words"]),
        ("[brief]", "[brief]\ndatum_m = 1e9", ["brief.datum_m", "1000000000"]),
        ("[brief]", "[brief]\npayoff = { discount = 1.0 }", ["brief.payoff.discount", "got 1"]),
        ("[brief]", "[brief]\nweights = { safety = nan }", ["brief.weights.safety", "NaN"]),
        ("[brief]", "[brief]\npriors = { safety = [1, 0] }", ["brief.priors.safety", "got 0"]),
        ("[brief]", "[limits]\nsteps_max = 0\n[brief]", ["brief.steps_max", "got 0"]),
        ("[brief]", "[limits]\ndecision_budget_ms = -1\n[brief]", ["limits.decision_budget_ms", "-1"]),
        ("[brief]", "[guard]\nhazard_max = 1.5\n[brief]", ["guard.hazard_max", "1.5"]),
        ("[brief]", "[guard]\ndeadline_s = 0\n[brief]", ["guard.deadline_s", "got 0"]),
        (
            "[brief]",
            "[robot]\nslope_limit_deg = 95\n[brief]",
            ["robot.slope_limit_deg: need 0.573 to 89.954 degrees", "got 95"],
        ),
        (
            "[brief]",
            "[robot]\nlaunch_angle_deg = 0\n[brief]",
            ["robot.launch_angle_deg: need 0.573 to 89.381 degrees", "got 0"],
        ),
        ("[brief]", "[robot]\ngravity_mps2 = 0\n[brief]", ["gravity_mps2", "got 0"]),
        ("[brief]", "[robot]\nhop_distance_m = nan\n[brief]", ["robot.hop_distance_m", "NaN"]),
        ("[brief]", "[robot.sensor]\nradius_min_m = 0.2\n[brief]", ["robot.sensor.radius_min_m", "one hop"]),
        ("[brief]", "[robot.sensor]\nradius_max_m = 0.2\n[brief]", ["sensor.radius_max_m", "0.2"]),
        (
            "[brief]",
            "[robot.hard]\nintended = 0.9\nstuck = 0\nsideways = 0.2\nflights = 1\n[brief]",
            ["robot.hard: need intended + stuck + 2 x sideways = 1", "1.3"],
        ),
        (
            "[brief]",
            "[robot.sand]\nintended = 0.8\nstuck = 0\nsideways = 0.1\nflights = 3\n[brief]",
            ["motion.sand.flights", "got 3"],
        ),
        (
            "[brief]",
            "[truth.sand]\nrectangles = [{ x = [3, 1], y = [0, 1] }]\n[brief]",
            ["rectangles", "[3, 1]"],
        ),
    ] {
        let text = hilly(from, to).expect_err(to).to_string();
        says(&text, &words);
        assert_eq!(text.lines().count(), 1, "{text}");
    }
}

#[test]
fn a_value_too_many_is_refused_wherever_their_number_is_fixed() {
    let ends = "[brief]\nstart = [0, 0]\ngoal = [8, 6]\n";
    let hills = "[truth.terrain.random_hills]\nwidth_cells = 9\nheight_cells = 9\ncell_size_m = 1\nseed = 1\nhills = 1\n";
    for (old, new) in [
        ("start = [0, 0]", "start = [0, 0, 0]"),
        ("goal = [8, 6]", "goal = [8, 6, 6]"),
        ("[brief]", "[brief]\npriors = { safety = [-1, 0, 0] }"),
        ("[brief]", "[mission]\ngoals = [[1, 1], [2, 2, 2]]\n[brief]"),
        ("[brief]", "[[robots]]\nstart = [1, 1, 1]\n[brief]"),
        ("[brief]", "[[robots]]\ngoal = [1, 1, 1]\n[brief]"),
        ("[brief]", "[truth]\ntreasures = [[1, 1], [2, 2, 2]]\n[brief]"),
        ("[brief]", "[truth.sand]\nrectangles = [{ x = [0, 1, 2], y = [0, 1] }]\n[brief]"),
        ("[brief]", "[truth.sand]\nrectangles = [{ x = [0, 1], y = [0, 1, 2] }]\n[brief]"),
        ("[brief]", "[truth.mobility]\nspeeds = [0, 0, 0, 1, 0]\n[brief]"),
        ("[[1, 1]]", "[[1, 1], [2, 2, 2]]"),
        ("[[1, 1]]", "[[1, 1]]\nlowered_m = [[2, 2, 2]]"),
    ] {
        let text = hilly(old, new).expect_err(new).to_string();
        says(&text, &["TOML parse error at line"]);
        assert!(text.contains("expected") || text.contains("need"), "{text}");
    }
    for ranges in ["sigma_m = [1, 2, 3]\namplitude_m = [0, 1]", "sigma_m = [1, 2]\namplitude_m = [0, 1, 2]"] {
        let error = Scenario::parse(&format!("{hills}{ranges}\n{ends}"), "hills").unwrap_err().to_string();
        says(&error, &["invalid length 3, expected an array of length 2"]);
    }
}

/// P-TREASURE-CELLS: Treasures lie where they can be collected, or the scenario is refused.
#[test]
fn treasures_lie_where_they_can_be_collected() {
    let treasures = built_in("treasures").terrain.treasures.clone();
    assert_eq!(
        treasures,
        [(12, 4), (4, 10), (10, 10), (15, 15)].map(|(x, y)| Cell::new(x, y)),
        "in index order"
    );
    let at = |cells: &str| {
        let text = BUILT_IN.iter().find(|(name, _)| *name == "treasures").unwrap().1;
        let all = "[[12, 4], [10, 10], [4, 10], [15, 15]]";
        assert!(text.contains(all));
        Scenario::parse(&text.replace(all, cells), "test").unwrap().resolve()
    };
    assert_ne!(at("[[12, 4]]").unwrap().hash, at("[[12, 5]]").unwrap().hash);
    assert_eq!(at("[[5, 4], [3, 4]]").unwrap().hash, at("[[3, 4], [5, 4]]").unwrap().hash);
    let many = format!("{:?}", [[3, 3]; 17]);
    for (cells, got) in [
        ("[[20, 4]]", "(20, 4)"),
        ("[[-1, 4]]", "(-1, 4)"),
        ("[[1, 2]]", "other than start and goal"),
        ("[[18, 18]]", "other than start and goal"),
        ("[[3, 3], [4, 4], [3, 3]]", "(3, 3) twice"),
        (&many, "got 17"),
    ] {
        says(&at(cells).unwrap_err().to_string(), &["truth.treasures", got]);
    }
}

#[test]
fn random_hills_out_of_bounds_are_refused() {
    let text = |fields: &str| {
        let terrain = format!(
            "[truth.terrain.random_hills]\nwidth_cells = 9\nheight_cells = 9\ncell_size_m = 1\nseed = 1\n{fields}\n"
        );
        let scenario = format!("{terrain}[brief]\nstart = [0, 0]\ngoal = [8, 8]\n");
        Scenario::parse(&scenario, "hills").unwrap().resolve().unwrap_err().to_string()
    };
    says(&text("hills = 1001\nsigma_m = [1, 2]\namplitude_m = [0, 1]"), &["at most 1000 hills", "1001"]);
    says(&text("hills = 5\nsigma_m = [0, 2]\namplitude_m = [0, 1]"), &["sigma_m", "[0, 2]"]);
    says(&text("hills = 5\nsigma_m = [1, 2]\namplitude_m = [2, 1]"), &["amplitude_m", "[2, 1]"]);
    let near = "hills = 5\nsigma_m = [1, 2]\namplitude_m = [0, 1]\nreach_sigma = 2";
    says(&text(near), &["reach_sigma", "at least 3", "got 2"]);
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 400, ..ProptestConfig::default() })]

    #[test]
    fn a_scenario_with_foreign_bytes_resolves_or_is_refused(
        changes in prop::collection::vec((any::<prop::sample::Index>(), any::<char>()), 1..4),
    ) {
        let mut text: Vec<char> = HILLY.chars().collect();
        for (at, character) in changes {
            let at = at.index(text.len());
            text[at] = character;
        }
        let text: String = text.into_iter().collect();
        let _ = Scenario::parse(&text, "damaged").and_then(|scenario| scenario.resolve());
    }
}
