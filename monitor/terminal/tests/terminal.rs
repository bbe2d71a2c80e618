//! The terminal's picture of a mission, character by character.

// Helpers of tests are not recognised as tests.
#![allow(clippy::unwrap_used)]

#[path = "../../../crates/report/tests/mission/mod.rs"]
mod mission;

use contract::{
    Account, Action, Branch, Cell, Decision, Detail, DetailPage, Direction, DriveSpeed, ErringCamera,
    Heartbeat, Incarnation, Leader, MapPatch, Member, MonotonicNs, MotionModel, Name, ObservedMap, Pace,
    Pacing, PastPage, PathPoint, Policy, PriorCell, PriorPage, Robot, RobotId, RobotSet, Role, Route,
    RoutePage, SeenCell, Sensor, SpeedPrior, Status, Team, Waypoint,
};
use mission::{Step, brief, driver, ground, helicopter, name, policy, records, with_robots};
use monitor::{Event, History, Input, Watcher};
use ratatui::Terminal;
use ratatui::backend::TestBackend;
use report::Layer;
use terminal::{ViewSettings, draw};

const ROBOT: RobotId = RobotId(0);
const SIDE: u32 = 16;
const NOW: MonotonicNs = MonotonicNs(3_600_000_000_000);

/// East and north in turn, with a hop that gets nowhere and one that slips.
fn steps() -> Vec<Step> {
    let hop = |n: usize| Action::Hop(if n.is_multiple_of(2) { Direction::East } else { Direction::North });
    (0..14)
        .map(|n| {
            let branch = match n {
                4 => Branch::Stayed,
                9 => Branch::Right,
                _ => Branch::Intended,
            };
            (hop(n), branch)
        })
        .collect()
}

/// A mission some way along: a swap after six hops, a perception that fell silent.
fn account() -> History {
    let brief = brief(SIDE);
    let mut account = History::new(ROBOT);
    let mut watcher = Watcher::new(ROBOT);
    account.on(Input::Brief(&brief), NOW);
    watcher.on(Event::Brief(brief.clone()), NOW);
    let lives = [
        (Role::HopperSim, 1, Name::NONE),
        (Role::Perception, 2, Name::NONE),
        (Role::Planner, 3, name("mdp")),
    ];
    for (role, life, planner) in lives {
        let beat = Heartbeat {
            role,
            incarnation: Incarnation(life),
            pid: 100 + life as u32,
            version: name("0.1.0"),
            planner,
            counter: 1,
            run: brief.run,
            decision: Decision(0),
            status: Status::Underway,
            robots: RobotSet::default(),
        };
        let heard = if role == Role::Perception { MonotonicNs(NOW.0 - 2_500_000_000) } else { NOW };
        account.on(Input::Heartbeat(&beat), heard);
    }
    let records = records(&brief, &steps(), 6);
    for record in &records {
        let state = record.state_after(brief.run, record.timing.committed, record.timing.committed);
        let leader = Leader { incarnation: Incarnation(3), ..state.leader };
        account.on(Input::State(&contract::State { leader, ..state }), NOW);
        watcher.on(Event::State(state), NOW);
    }
    let (_, map) = ground(&brief);
    let seen = map.cells().iter().enumerate();
    let cells = seen
        .filter_map(|(index, ground)| Some(SeenCell { index: index as u32, visits: 0, ground: (*ground)? }))
        .collect();
    let patch = MapPatch {
        run: brief.run,
        robot: ROBOT,
        through: Decision(records.len() as u64),
        digest: records.last().unwrap().digest,
        more: 0,
        sequence: 1,
        before: ObservedMap::unseen(brief.run, ROBOT, brief.grid).observation(),
        after: map.observation(),
        sensed: NOW,
        published: NOW,
        grid: brief.grid,
        seen_cells: map.seen_cells() as u32,
        treasures: map.treasures().to_vec(),
        cells,
    };
    assert_eq!(account.on(Input::Patch(patch), NOW), None);
    let (run, robot, decision) = (brief.run, ROBOT, Decision(13));
    let planner = records.last().unwrap().leader.planner;
    account.on(
        Input::Policy(Policy { run, robot, decision, planner, error_bound: 3.1e-7, cells: policy(&brief) }),
        NOW,
    );
    account.on(Input::Pacing(Pacing { run, robot, pace: Pace::Hertz(2.0), paused: false, obeys: true }), NOW);
    account.on(Input::Tick, NOW);
    account.set_progress(watcher.progress(NOW).unwrap());
    account
}

fn picture(account: &History, settings: &ViewSettings, columns: u16, rows: u16) -> TestBackend {
    let mut terminal = Terminal::new(TestBackend::new(columns, rows)).unwrap();
    terminal.draw(|frame| draw(frame, account, settings, NOW)).unwrap();
    terminal.backend().clone()
}

/// P-TUI-WAYS: Where the motion model tells the way of a hop, the terminal says how it was launched and how it ended, and marks impacts.
#[test]
fn the_way_of_the_last_hop_is_told_once_it_is_known() {
    let brief = brief(SIDE);
    let point =
        |seconds, east_m| PathPoint { seconds, at_m: [east_m, 1.5, 0.0], leaves_mps: [1.2, 0.0, 0.9] };
    let detail = Detail {
        model: MotionModel::Contact,
        rest_m: [2.5, 1.5, 0.0],
        figures: [2.0, 1.0, 0.25, 1.9, 1.0, 0.0],
        path: vec![point(0.0, 1.5), point(1.0, 5.5)],
    };
    let mut record = records(&brief, &steps()[..1], 6)[0];
    record.detail = detail.id();
    record.digest = record.previous.chain(&record);
    let mut account = History::new(ROBOT);
    account.on(Input::Brief(&brief), NOW);
    account.on(Input::State(&record.state_after(brief.run, NOW, NOW)), NOW);
    let settings = ViewSettings::default();
    let text = |account: &History| picture(account, &settings, 80, 24).to_string();
    let words =
        ["1.50 m/s at 37°, for 1.9 s", "1 impact, rolled 0.25 m", "it was caught (crease, pit or wall)", "◇"];
    assert!(words.iter().all(|word| !text(&account).contains(word)));
    assert!(account.lacks_details());
    account.on(Input::Detail(&DetailPage { run: brief.run, decision: Decision(0), detail }), NOW);
    for word in words {
        assert!(text(&account).contains(word), "{word}: {}", text(&account));
    }
}

/// P-TUI: The terminal view fits on eighty columns by twenty-four rows.
#[test]
fn the_whole_mission_stands_on_eighty_by_twenty_four() {
    let settings = ViewSettings { policy: true, control: true, ..ViewSettings::default() };
    insta::assert_snapshot!("eighty_by_twenty_four", picture(&account(), &settings, 80, 24));
}

/// P-DOCTOR-NEXT: `doctor`, page and terminal say who is missing or hangs, and print the command
/// that fixes it.
#[test]
fn the_command_that_is_waited_for_names_the_instance() {
    let history = account().in_instance(Some("home"));
    let shown = picture(&history, &ViewSettings::default(), 140, 24).to_string();
    assert!(shown.contains("waiting for hopper perception --instance home "), "{shown}");
}

#[test]
fn looking_back_shows_the_mission_as_it_was() {
    let settings = ViewSettings { at: Some(Decision(5)), ..ViewSettings::default() };
    insta::assert_snapshot!("looking_back", picture(&account(), &settings, 100, 30));
}

/// P-TUI-KEYS: The terminal view shows its keys at `?`; Esc leads back from the keys to the hop,
/// and from an earlier hop to now.
#[test]
fn the_keys_are_shown_and_back_leads_from_them_to_the_hop_and_from_there_to_now() {
    let mut settings = ViewSettings { at: Some(Decision(5)), keys: true, ..ViewSettings::default() };
    for (columns, rows) in [(80, 24), (200, 60)] {
        let shown = picture(&account(), &settings, columns, rows).to_string();
        for key in ["one hop back or ahead", "back to now", "hand over (--control)", "these keys", "quit"] {
            assert!(shown.contains(key), "{key}: {shown}");
        }
    }
    settings.back();
    assert_eq!((settings.keys, settings.at), (false, Some(Decision(5))));
    settings.back();
    assert_eq!(settings.at, None);
    settings.back();
    assert_eq!(settings, ViewSettings::default(), "now is as far as it goes");
}

/// A rover and a helicopter whose camera errs, after the helicopter's first two decisions.
fn robots(brief: &contract::Brief, digest: contract::Digest) -> Team {
    let member = |(robot, planner)| {
        let leader = Leader { planner: name(planner), ..Leader::default() };
        Member { leader, ..Member::at_start(robot) }
    };
    let members = brief.robots.iter().zip(["rrt_star_ett", "rrt_star_it"]).map(member).collect();
    Team { run: brief.run, decision: Decision(2), digest, due: RobotId(1), actor: Some(RobotId(1)), members }
}

/// The southern half of the map, read as fast ground.
fn half_read(brief: &contract::Brief, digest: contract::Digest) -> MapPatch {
    let (run, grid) = (brief.run, brief.grid);
    let mut map = ObservedMap::unseen(run, ROBOT, grid);
    let before = map.observation();
    let ground = contract::Ground { reading: Some(DriveSpeed::Fast), ..contract::Ground::FLAT };
    let cells: Vec<SeenCell> =
        (0..grid.cells() as u32 / 2).map(|index| SeenCell { index, visits: 0, ground }).collect();
    cells.iter().for_each(|cell| _ = map.learn(cell.index as usize, cell.ground));
    MapPatch {
        run,
        robot: ROBOT,
        through: Decision(2),
        digest,
        more: 0,
        sequence: 1,
        before,
        after: map.observation(),
        sensed: NOW,
        published: NOW,
        grid,
        seen_cells: map.seen_cells() as u32,
        treasures: Vec::new(),
        cells,
    }
}

/// A rover and a helicopter some way along: the flight was announced, one leg of it flown, and half of the map read.
fn scouting() -> History {
    let at = |x_m, y_m| Waypoint { x_m, y_m };
    let alone = brief(SIDE);
    let sensor = Sensor::ErringCamera(ErringCamera { radius_m: 3.0, accuracy: 0.8 });
    let both = [driver(&alone, at(13.5, 12.5)), Robot { sensor, ..helicopter(&alone) }];
    let brief = with_robots(&alone, Account::Actions, &both);
    let route = Route::new(vec![at(1.5, 1.5), at(6.5, 4.5), at(10.5, 4.5)]).unwrap();
    let mut history = History::new(ROBOT);
    let mut watcher = Watcher::new(ROBOT);
    history.on(Input::Brief(&brief), NOW);
    watcher.on(Event::Brief(brief.clone()), NOW);
    let steps = [Action::Announce(route.id()), Action::Fly].map(|action| (action, Branch::Intended));
    let mut records = records(&brief, &steps, 6);
    for record in &mut records {
        record.robot = RobotId(1);
        record.leader.planner = name("rrt_star_it");
    }
    records[1].outcome.to = Cell::new(6, 4);
    let (run, grid, digest) = (brief.run, brief.grid, records[1].digest);
    let page = PastPage { run, robot: ROBOT, from: Decision(0), records };
    history.on(Input::Past(&page), NOW);
    watcher.on(Event::Past(page), NOW);
    let team = robots(&brief, digest);
    history.on(Input::Team(&team), NOW);
    watcher.on(Event::Team(team), NOW);
    // Columns of 4: impassable, risky, slow, fast.
    let kinds = [[1.0, 0.0, 0.0, 0.0], [0.5, 0.0, 0.0, 0.5], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 0.0, 1.0]];
    let prior = |index: usize| SpeedPrior::new(kinds[index % SIDE as usize / 4]).unwrap();
    let cells = (0..grid.cells()).map(|index| PriorCell { speeds: prior(index), height_m: 0.0 }).collect();
    assert!(history.wanted(NOW).prior.is_some());
    history.on(Input::Prior(PriorPage { run, grid, from: 0, cells }), NOW);
    history.on(Input::Route(&RoutePage { run, route }), NOW);
    assert_eq!(history.on(Input::Patch(half_read(&brief, digest)), NOW), None);
    history.on(Input::Tick, NOW);
    history.set_progress(watcher.progress(NOW).unwrap());
    history
}

/// P-TUI-LAYERS: In the terminal view a key switches between expected speed, spread, heights and
/// visits; shades differ by their characters too.
#[test]
fn a_key_goes_through_the_layers_of_uncertain_ground() {
    let history = scouting();
    let mut settings = ViewSettings::default();
    insta::assert_snapshot!("expected_speed", picture(&history, &settings, 80, 24));
    let brief = history.brief().unwrap().clone();
    let mut titles = Vec::new();
    let layers = Layer::of(&brief).len();
    for _ in 0..=layers {
        titles.push(settings.layer(&brief).definition().title);
        let text = picture(&history, &settings, 80, 24).to_string();
        assert!(text.contains(titles[titles.len() - 1]), "{text}");
        settings.next_layer(&brief);
    }
    assert_eq!(
        (titles[0], titles[1], titles[layers]),
        ("expected speed", "spread of speed", "expected speed")
    );
    assert_eq!(titles.iter().filter(|title| ["ground", "visits"].contains(title)).count(), 2, "{titles:?}");
    let speed = picture(&history, &ViewSettings::default(), 80, 24).to_string();
    // Impassable to fast, seen in the south and only expected in the north; route, field of view, robots, start, goal.
    for character in
        ["██", "█·", "▓▓", "▒·", "░░", " ·", "m/Sol", "∘", "+", "•", "S", "★", "robot 1's turn", "m layer"]
    {
        assert!(speed.contains(character), "{character}: {speed}");
    }
    let spread = ViewSettings { layer: Some(Layer::Spread), ..ViewSettings::default() };
    let spread = picture(&history, &spread, 80, 24).to_string();
    assert!(spread.contains("100 m/Sol"), "{spread}");
    let keys = ViewSettings { keys: true, ..ViewSettings::default() };
    assert!(picture(&history, &keys, 80, 24).to_string().contains("next map layer"));
}

#[test]
fn a_layer_that_the_mission_lacks_is_not_shown_and_a_single_layer_has_no_key() {
    let history = account();
    let brief = history.brief().unwrap().clone();
    let mut settings = ViewSettings { layer: Some(Layer::Spread), ..ViewSettings::default() };
    assert_eq!(settings.layer(&brief), Layer::Heights);
    settings.next_layer(&brief);
    let layers = Layer::of(&brief);
    assert_eq!(settings.layer(&brief), layers[1 % layers.len()]);
    let has_key = picture(&history, &settings, 80, 24).to_string().contains("m layer");
    assert_eq!(has_key, layers.len() > 1);
}

#[test]
fn a_terminal_too_small_says_what_it_needs_and_nothing_is_drawn_of_nothing() {
    let small = picture(&account(), &ViewSettings::default(), 60, 20).to_string();
    assert!(small.contains("needs 80 x 24, got 60 x 20"), "{small}");
    let nothing = picture(&History::new(ROBOT), &ViewSettings::default(), 80, 24).to_string();
    assert!(nothing.contains("waiting for a mission"), "{nothing}");
}

/// P-TUI-LEGEND: The terminal view says what its symbols stand for: below the map what fits there, with the keys all of them.
#[test]
fn symbols_have_their_meanings_below_the_map_and_with_the_keys() {
    let [narrow, wide] =
        [80, 200].map(|columns| picture(&account(), &ViewSettings::default(), columns, 24).to_string());
    assert!(narrow.contains("@ hopper  ★ goal  S start"), "{narrow}");
    assert!(!narrow.contains("impassable") && wide.contains("## impassable  ░░ sand"), "{wide}");
    let keys = ViewSettings { keys: true, ..ViewSettings::default() };
    let shown = picture(&account(), &keys, 80, 24).to_string();
    let meanings = [
        "hopper",
        "goal",
        "start",
        "way",
        "not seen",
        "slipped",
        "stayed",
        "impassable",
        "sand",
        "treasure",
        "impact",
    ];
    for meaning in meanings {
        assert!(shown.contains(meaning), "{meaning}: {shown}");
    }
    let team = picture(&scouting(), &keys, 80, 24).to_string();
    assert!(team.contains("rim of what is seen") && !team.contains("slipped"), "{team}");
}

/// P-TUI-WHY: Beside the map stand the two hops that are worth most by the policy of the planner that decides.
#[test]
fn the_planner_that_decides_says_what_it_expects_of_its_hops() {
    let shown = picture(&account(), &ViewSettings::default(), 80, 24).to_string();
    let line = shown.lines().find(|line| line.contains("greedy expects ")).unwrap_or_default();
    let hops = ["north ", "east ", "south ", "west "].iter().filter(|hop| line.contains(**hop)).count();
    assert_eq!(hops, 2, "{shown}");
}

/// P-TUI-WIDTH: A small map fills a large terminal: its cells get several characters.
#[test]
fn a_small_map_on_a_large_terminal_has_large_cells() {
    let settings = ViewSettings { policy: true, ..ViewSettings::default() };
    let unseen = |columns, rows| {
        let shown = picture(&account(), &settings, columns, rows).to_string();
        let on_map = |line: &&str| line.starts_with("\"│");
        let lengths = shown.lines().filter(on_map).map(|line| line.chars().take(columns as usize - 40));
        lengths.filter(|line| line.clone().any(|character| "→↑←↓•@".contains(character))).count()
    };
    // Sixteen rows of cells, and three times as many lines where there is room; signs stand once a cell.
    let map_rows = |columns, rows| {
        let buffer = picture(&account(), &settings, columns, rows).buffer().clone();
        let is_ground = |y: u16| (0..columns - 40).any(|x| buffer[(x, y)].bg != ratatui::style::Color::Reset);
        (0..rows).filter(|y| is_ground(*y)).count()
    };
    assert_eq!(map_rows(200, 54), 3 * map_rows(80, 24));
    assert_eq!(unseen(200, 54), unseen(80, 24));
}

/// P-TUI-END: When the view ends, its last picture stays on the terminal, without the keys.
#[test]
fn the_last_picture_stays_on_the_terminal() {
    let shown = picture(&account(), &ViewSettings::default(), 80, 24);
    let mut left = Vec::new();
    terminal::scrollback::leave_behind(shown.buffer(), &mut left).unwrap();
    let left = String::from_utf8(left).unwrap();
    let plain: Vec<String> = left.lines().map(without_colours).collect();
    let row = |y: u16| (0..80).map(|x| shown.buffer()[(x, y)].symbol()).collect::<String>();
    assert_eq!(plain, (0..23).map(row).collect::<Vec<_>>());
    assert!(left.contains("\u{1b}[") && !left.contains("q quit"), "{left}");
}

/// A line without the sequences `ESC [ … m`.
fn without_colours(line: &str) -> String {
    let mut parts = line.split("\u{1b}[");
    let first = parts.next().unwrap_or_default().to_owned();
    parts.fold(first, |text, part| text + part.split_once('m').map_or("", |(_, rest)| rest))
}

#[test]
fn every_size_of_terminal_and_every_moment_can_be_drawn() {
    let account = account();
    for (columns, rows) in [(80, 24), (81, 25), (120, 40), (300, 100), (80, 200), (500, 24)] {
        for at in [None, Some(Decision(0)), Some(Decision(3)), Some(Decision(999))] {
            for follow in [false, true] {
                let settings = ViewSettings { at, follow, policy: true, ..ViewSettings::default() };
                let text = picture(&account, &settings, columns, rows).to_string();
                assert!(text.contains('@'), "{columns} x {rows} at {at:?}: {text}");
            }
        }
    }
}

#[test]
fn time_goes_back_and_ahead_to_now() {
    let mut settings = ViewSettings::default();
    settings.go(-1, Decision(14));
    assert_eq!(settings.at, Some(Decision(13)));
    settings.go(-100, Decision(14));
    assert_eq!(settings.at, Some(Decision(0)));
    settings.go(10, Decision(14));
    assert_eq!(settings.at, Some(Decision(10)));
    settings.go(10, Decision(14));
    assert_eq!(settings.at, None, "now again");
}

/// P-TUI-NO-COLOR: Without colours (`NO_COLOR`) every symbol, arrow, soil and stage of the terminal
/// view has a character of its own.
#[test]
fn without_colours_every_meaning_has_a_character_of_its_own() {
    let account = account();
    let drawn = |policy: bool| {
        let settings = ViewSettings { policy, ..ViewSettings::default() };
        let buffer = picture(&account, &settings, 80, 24).buffer().clone();
        let row = |y| (0..80).map(|x| buffer[(x, y)].symbol()).collect::<String>();
        (0..24).map(row).collect::<Vec<_>>().join("\n")
    };
    let plain = drawn(false);
    for (meaning, character) in [
        ("hopper", "@"),
        ("goal", "★"),
        ("start", "S"),
        ("route", "•"),
        ("slipped", "×"),
        ("sand", "░░"),
        ("impassable", "##"),
        ("not seen", "· "),
    ] {
        assert!(plain.contains(character), "{meaning}: {plain}");
    }
    let arrows = drawn(true);
    assert!(["↑", "→", "↓", "←"].iter().filter(|arrow| arrows.contains(**arrow)).count() >= 2, "{arrows}");
    let texture =
        |stage: &str| plain.split(&format!(" {stage}")).next().and_then(|before| before.chars().last());
    let textures: Vec<_> = ["state", "sense", "deliver", "plan", "commit"].map(texture).into();
    assert_eq!(textures, ["█", "▓", "░", "▞", "▥"].map(|texture| texture.chars().next()), "{plain}");
}

/// P-CONTRAST. In the terminal, hopper and goal have a background of their own with a contrast of
/// at least 3:1.
#[test]
fn hopper_and_goal_stand_out_in_the_terminal() {
    use ratatui::style::Color;
    let buffer = picture(&account(), &ViewSettings::default(), 80, 24).buffer().clone();
    let rgb = |colour: Color| match colour {
        Color::Rgb(r, g, b) => [r, g, b],
        other => panic!("{other} has no value of its own"),
    };
    for symbol in ["@", "★"] {
        // The text beside the ground has a star too, without a ground of its own.
        let mut on_ground = buffer.content().iter().filter(|cell| cell.bg != Color::Reset);
        let cell = on_ground.find(|cell| cell.symbol() == symbol).unwrap();
        let contrast = report::colour::contrast(rgb(cell.fg), rgb(cell.bg));
        assert!(contrast >= 3.0, "{symbol}: {contrast:.2}");
    }
}
