//! What of a scenario stands in the brief and in the hash.

use contract::{Cell, DistanceNorm, GradientSource, Profile, Range, Reading, UnseenGround};
use scenario::{Overrides, Scenario, load};

use crate::{Folder, HILLY, REAL, built_in, grid, hilly, says};

#[test]
fn a_resolved_scenario_resolves_to_the_very_same_world() {
    let folder = Folder::new();
    let real = folder.world(&REAL.replace("datum_m = -4000", "datum_m = \"survey\"")).unwrap();
    let hopper = Overrides { profile: Some(Profile::Hopper), ..Overrides::default() };
    let worlds = [
        "hard",
        "heterogeneous",
        "sandy",
        "hills",
        "patrol",
        "coverage",
        "hopper-scout",
        "rover-helicopter",
        "expedition",
    ]
    .into_iter()
    .flat_map(|name| [built_in(name), load(name).unwrap().with(&hopper).resolve().unwrap()])
    .chain([real]);
    for world in worlds {
        let again = Scenario::parse(&world.resolved, "resolved").unwrap().resolve().unwrap();
        assert_eq!(again, world, "{}", world.resolved);
    }
}

#[test]
fn the_gradient_source_follows_the_profile_unless_stated() {
    let source = |text: &str, profile: Option<Profile>| {
        let overrides = Overrides { profile, ..Overrides::default() };
        let world = Scenario::parse(text, "hilly").unwrap().with(&overrides).resolve().unwrap();
        world.brief.leg(0).sensor.gradient
    };
    assert_eq!(source(HILLY, None), GradientSource::Measured);
    assert_eq!(source(HILLY, Some(Profile::Hopper)), GradientSource::SeenDifferences);
    let stated = format!("{HILLY}[robot.sensor]\ngradient = \"measured\"\n");
    assert_eq!(source(&stated, Some(Profile::Hopper)), GradientSource::Measured);
}

/// P-GUARD-SCENARIO: `[guard]` is validated; it is on by default in profile hopper and off in
/// profile paper-2023.
#[test]
fn the_guard_is_on_in_profile_hopper_and_off_in_the_papers() {
    let world = |text: &str, profile: Profile| {
        let overrides = Overrides { profile: Some(profile), ..Overrides::default() };
        Scenario::parse(text, "hilly").unwrap().with(&overrides).resolve().unwrap()
    };
    let guard = |text: &str, profile| {
        let guard = world(text, profile).brief.guard;
        (guard.hazard_max, guard.deadline_ns)
    };
    assert_eq!(guard(HILLY, Profile::Hopper), (0.25, 0));
    assert_eq!(guard(HILLY, Profile::Paper2023), (1.0, 0));
    let stated = format!("{HILLY}[guard]\nhazard_max = 0.0\ndeadline_s = 1.5\n");
    assert_eq!(guard(&stated, Profile::Hopper), (0.0, 1_500_000_000));
    assert_eq!(guard(&stated, Profile::Paper2023), (1.0, 0), "the paper flies without a guard");
    let unused = world(&stated, Profile::Paper2023);
    assert!(unused.warnings.iter().any(|warning| warning.to_string().contains("[guard] is not used")));
    assert!(world(HILLY, Profile::Paper2023).warnings.is_empty());
    // The guard is a part of the mission, and of its hash; without one, everything is as it was.
    assert_ne!(world(HILLY, Profile::Hopper).hash, world(&stated, Profile::Hopper).hash);
    assert_eq!(world(HILLY, Profile::Paper2023).hash, unused.hash);
    assert!(!unused.resolved.contains("[guard]"));
}

/// P-READINGS.
#[test]
fn a_reading_is_in_the_brief_and_in_the_hash_only_where_it_differs() {
    let text = include_str!("../../../../scenarios/hard.toml");
    let plain = Scenario::parse(text, "hard").unwrap().resolve().unwrap();
    assert!(plain.brief.reading.is_default() && !plain.resolved.contains("reading"));
    assert!(!plain.resolved.contains("ground_at"));
    let read = |section: &str| {
        Scenario::parse(&format!("{text}\n[brief.reading]\n{section}\n"), "hard").unwrap().resolve()
    };
    let defaults = read("distance = \"euclidean\"\nopening_steps = 0\nunseen = \"flat\"").unwrap();
    assert_eq!(defaults.hash, plain.hash, "spelled out, the defaults are the same mission");
    let other =
        read("leaving = -100.0\ndistance = \"manhattan\"\ndistance_scale_cells = 20.0\nopening_steps = 1\nunseen = \"ends\"")
            .unwrap();
    let reading = Reading {
        leaving: Some(-100.0),
        distance: DistanceNorm::Manhattan,
        distance_scale_cells: Some(20.0),
        opening_steps: 1,
        unseen: UnseenGround::Ends,
    };
    assert_eq!(other.brief.reading, reading);
    assert_ne!(other.hash, plain.hash);
    assert_eq!(Scenario::parse(&other.resolved, "hard").unwrap().resolve().unwrap(), other);
}

/// P-PATROL-SCENARIO: A patrol's goals and hops are validated, and it has no step limit.
#[test]
fn a_patrol_has_goals_in_turn_and_a_count_of_hops() {
    let patrol = |goals: &str| hilly("goal = [8, 6]", goals).unwrap();
    let world = patrol("goals = [[8, 6], [2, 2], [4, 2]]\nhops_max = 77");
    let (brief, flown) = (&world.brief, world.brief.visits().unwrap());
    assert_eq!(flown.goals(), [Cell::new(8, 6), Cell::new(2, 2), Cell::new(4, 2)]);
    assert_eq!((brief.leg(0).goal, flown.hops_max), (Cell::new(8, 6), 77));
    assert!(brief.limits.steps_max > 1 << 31, "no limit of steps");
    let endless = patrol("goals = [[8, 6], [2, 2]]");
    assert_eq!(endless.brief.visits().unwrap().hops_max, 1 << 32);
    let stated = patrol("goals = [[8, 6], [2, 2]]\nhops_max = 4294967296");
    assert_eq!((stated.hash, &stated.resolved), (endless.hash, &endless.resolved));
    assert_eq!(Scenario::parse(&world.resolved, "again").unwrap().resolve().unwrap(), world);
    let brief = built_in("patrol").brief;
    let built_in = brief.visits().unwrap();
    assert_eq!((built_in.goals().len(), built_in.hops_max), (4, 1_000_000));
}

#[test]
fn overrides_change_profile_budget_and_elevation_file() {
    let folder = Folder::new();
    let path = folder.write("mission.toml", REAL);
    let other = folder.write("other.asc", &grid(|x, _| f64::from(x) * 0.25 - 4000.0));
    let overrides = Overrides {
        profile: Some(Profile::Hopper),
        decision_budget_ns: Some(123_456_789),
        dem: Some(other),
        nodata: None,
        ..Overrides::default()
    };
    let world = load(path.to_str().unwrap()).unwrap().with(&overrides).resolve().unwrap();
    assert_eq!(world.brief.profile, Profile::Hopper);
    assert_eq!(world.brief.limits.decision_budget_ns, 123_456_789);
    assert_eq!(world.terrain.ground(Cell::new(4, 4)).unwrap().gradient, [0.125, 0.0]);
    assert!(world.resolved.contains("other.asc"));

    let refused = load("hard").unwrap().with(&overrides).resolve().unwrap_err().to_string();
    says(&refused, &["--dem", "elevation_file", "generated"]);
}

#[test]
fn the_hash_changes_with_any_cell_and_any_field_but_not_with_folder_or_budget() {
    let (here, there) = (Folder::new(), Folder::new());
    let hash = |folder: &Folder, text: &str| folder.world(text).unwrap().hash;
    let first = hash(&here, REAL);
    assert_eq!(first, hash(&there, REAL), "the same mission in another folder");
    assert_eq!(first, hash(&here, &format!("{REAL}[limits]\ndecision_budget_ms = 1\n")));
    assert_ne!(first, hash(&here, &format!("{REAL}[limits]\nsteps_max = 149\n")));
    assert_ne!(first, hash(&here, &REAL.replace("[brief]", "[brief]\nweights = { safety = 0.4 }")));
    let bumped = grid(|x, y| {
        let bump = if (x, y) == (11, 0) { 1e-6 } else { 0.0 };
        if (x, y) == (6, 4) { 40.0 } else { f64::from(y) * 0.5 - 4000.0 + bump }
    });
    there.write("dem.asc", &bumped);
    assert_ne!(first, hash(&there, REAL), "one cell a micrometre higher");
    assert_eq!(here.world(REAL).unwrap().brief.scenario_hash, first);
}

#[test]
fn priors_and_datum_are_given_or_surveyed() {
    let given = hilly("[brief]", "[brief]\npriors = { safety = [-1, 0], height_m = [0.5, 2] }").unwrap();
    assert_eq!(given.brief.priors.safety, Range { min: -1.0, max: 0.0 });
    assert_eq!(given.brief.priors.height_m, Range { min: 0.5, max: 2.0 });
    let surveyed = hilly("[brief]", "[brief]\npriors = { safety = \"survey\" }").unwrap();
    assert_eq!(surveyed.brief.priors.height_m, surveyed.terrain.height_range());
    assert_eq!(surveyed.brief.priors.safety, surveyed.terrain.safety_range(-5.0));
    let lower = hilly("[brief]", "[brief]\ndatum_m = 100").unwrap();
    assert!((lower.brief.priors.height_m.max - (0.2 - 100.0)).abs() < 1e-12);
    let treasures = |name: &str| scenario::load(name).unwrap().resolve().unwrap().brief.priors.treasures;
    assert_eq!((treasures("hard"), treasures("treasures")), (0, 4));
}

/// A motion table of all classes: each hop lands as aimed with this probability, and stays otherwise.
fn motion_table(aimed: f64) -> String {
    let mut text = "hop_m = 1.0\n".to_owned();
    for soil in ["hard", "sand"] {
        for along in -12..=12 {
            for across in -12..=12 {
                let [along, across] = [along, across].map(|bin| 2.5 * f64::from(bin));
                let stays = 1.0 - aimed;
                text += &format!(
                    "[[classes]]\nsoil = \"{soil}\"\nalong_deg = {along}\nacross_deg = {across}\n\
                     landings = [{{ offset = [1, 0], probability = {aimed} }}, \
                     {{ offset = [0, 0], probability = {stays} }}]\n"
                );
            }
        }
    }
    text
}

/// P-TABLE-SCENARIO: A scenario's hash covers the motion table by its contents and the name of its file, the brief has its fingerprint, and
/// a scenario without one is as before.
#[test]
fn the_motion_table_is_part_of_the_scenario() {
    let folder = Folder::new();
    let text = format!("{HILLY}[brief.motion]\ntable = \"t.toml\"\n");
    folder.write("t.toml", &motion_table(0.75));
    let first = folder.world(&text).unwrap();
    let table = first.table.clone().unwrap();
    assert_eq!(first.brief.motion_table(), table.fingerprint());
    assert!(table.rows().iter().all(|row| row.landings().len() == 2));
    assert!(first.resolved.contains("t.toml"));
    let again = Scenario::parse(&first.resolved, "resolved").unwrap().resolve().unwrap();
    assert_eq!((again.hash, again.brief), (first.hash, first.brief.clone()));
    folder.write("t.toml", &motion_table(0.5));
    let other = folder.world(&text).unwrap();
    assert_ne!(other.hash, first.hash);
    assert_ne!(other.brief.motion_table(), first.brief.motion_table());
    let law = folder.world(&text.replace("table = \"t.toml\"", "")).unwrap();
    assert_eq!((law.brief.motion_table(), law.table.is_none()), (0, true));
    assert!(!law.resolved.contains("motion"));
}
