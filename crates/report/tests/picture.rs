//! The picture is well-formed, complete, bounded.

// Helpers of tests are not recognised as tests.
#![allow(clippy::unwrap_used)]

mod mission;

use contract::{
    Account, Action, Body, Branch, Brief, Cell, Cover, Decision, Detail, Direction, Goal, Ground,
    MotionModel, ObservedMap, PathPoint, PolicyCell, Record, Robot, RobotId, Route, Rover, Sensor, Square,
    Status, Waypoint,
};
use mission::{Step, brief, driver, ground, helicopter, policy, records, with_robots};
use report::{Layer, Picture, PictureGrid, PictureStyle, ReportError, TitledPicture};
use roxmltree::Document;

/// East and north in turn, every seventh hop slips, every eleventh gets nowhere.
fn steps(count: usize) -> Vec<Step> {
    let branch = |n: usize| match n {
        _ if n % 7 == 6 => Branch::Left,
        _ if n % 11 == 10 => Branch::Stayed,
        _ => Branch::Intended,
    };
    let direction = |n: usize| if n.is_multiple_of(2) { Direction::East } else { Direction::North };
    (0..count).map(|n| (Action::Hop(direction(n)), branch(n))).collect()
}

fn svg(
    brief: &Brief,
    terrain: &[Ground],
    map: &ObservedMap,
    policy: Option<&[PolicyCell]>,
    route: &[Record],
) -> String {
    let picture = Picture {
        policy,
        route,
        outcome: Status::Deadlock.into(),
        sensing_radius_m: Some(2.25),
        ..plain(brief, terrain, map)
    };
    picture.svg().unwrap()
}

fn mission_svg(side: u32) -> String {
    let brief = brief(side);
    let (terrain, map) = ground(&brief);
    let route = records(&brief, &steps(2 * side as usize - 8), 4);
    svg(&brief, &terrain, &map, Some(&policy(&brief)), &route)
}

/// A mission under way without hops, policy, treasures or anything that robots told.
fn plain<'a>(brief: &'a Brief, terrain: &'a [Ground], map: &'a ObservedMap) -> Picture<'a> {
    Picture {
        brief,
        terrain,
        treasures: &[],
        map,
        policy: None,
        route: &[],
        outcome: Status::Underway.into(),
        sensing_radius_m: None,
        speeds: &[],
        announced: &[],
        details: &[],
    }
}

#[test]
fn a_tiny_picture_stands_as_drawn() {
    let brief = brief(4);
    let (terrain, map) = ground(&brief);
    let route = records(&brief, &[(Action::Hop(Direction::East), Branch::Intended)], 4);
    insta::assert_snapshot!(svg(&brief, &terrain, &map, Some(&policy(&brief)), &route));
}

/// P-PICTURE-WAYS: Where the motion model tells the way of a hop, the picture has its impacts, what it rolled, and the hopper exactly where
/// it rests; the legend names both. Without a way there is none of it.
#[test]
fn impacts_and_rest_positions_are_drawn_where_they_are_told() {
    let brief = brief(4);
    let (terrain, map) = ground(&brief);
    let east = (Action::Hop(Direction::East), Branch::Intended);
    let route = records(&brief, &[east, (Action::Hop(Direction::East), Branch::Stayed)], 4);
    let point = |seconds, east_m, leaves_mps| PathPoint { seconds, at_m: [east_m, 1.5, 0.0], leaves_mps };
    // Launched at 1.5 m; impacts at 2.25 and 2.5 m; rolled to 2.75 m. The next hop lands where it was launched, without rolling.
    let bounced = Detail {
        model: MotionModel::Contact,
        rest_m: [2.75, 1.5, 0.0],
        figures: [1.0, 2.0, 0.25, 2.0, 1.0, 0.0],
        path: vec![
            point(0.0, 1.5, [0.75, 0.0, 1.0]),
            point(1.0, 2.25, [0.5, 0.0, 0.5]),
            point(1.5, 2.5, [1.0, 0.0, 0.0]),
        ],
    };
    let details = [(Decision(0), bounced.clone()), (Decision(1), bounced.at_rest())];
    let picture = Picture { route: &route, details: &details, ..plain(&brief, &terrain, &map) };
    let text = picture.svg().unwrap();
    let document = Document::parse(&text).unwrap();
    let paths = |wanted: &dyn Fn(&roxmltree::Node<'_, '_>) -> bool| -> Vec<String> {
        let found = document.descendants().filter(|node| node.has_tag_name("path") && wanted(node));
        found.map(|node| node.attribute("d").unwrap().to_owned()).collect()
    };
    let hits = paths(&|node| node.attribute("class") == Some("impacts"));
    assert_eq!(hits.len(), 1);
    let x_of = |path: &str| -> f64 {
        path.trim_start_matches('M').split([' ', 'l', 'L']).next().unwrap().parse().unwrap()
    };
    let hits: Vec<f64> = hits[0].split_inclusive('z').map(x_of).collect();
    assert_eq!(hits.len(), 2, "{hits:?}");
    // Units of the picture a metre, by the two impacts.
    let scale = (hits[1] - hits[0]) / 0.25;
    let hopper = document.descendants().filter(|node| node.attribute("fill") == Some("#ffd400"));
    let at: Vec<f64> = hopper.map(|node| node.attribute("cx").unwrap().parse().unwrap()).collect();
    // The first is that of the map, the second that of the legend; numbers have one decimal place.
    assert!((at[0] - hits[1] - 0.25 * scale).abs() < 0.2, "{at:?} {hits:?}");
    let rolled = paths(&|node| node.attribute("stroke") == Some("#6a2fa0"));
    assert!(rolled.iter().any(|path| (x_of(path) - hits[1]).abs() < 0.2), "{rolled:?}");
    for word in ["impact", "rolled"] {
        assert_eq!(text.matches(&format!(">{word}<")).count(), 1, "{word}");
    }
    let without = Picture { details: &[], ..picture }.svg().unwrap();
    assert!(!without.contains("impacts") && !without.contains("#6a2fa0") && !without.contains(">impact<"));
}

/// A tiny mission after two of its decisions, in one picture grid.
fn tiny_plate() -> String {
    let brief = brief(4);
    let (terrain, map) = ground(&brief);
    let route = records(&brief, &[(Action::Hop(Direction::East), Branch::Intended)], 4);
    let policy = policy(&brief);
    let before = Picture { sensing_radius_m: Some(2.0), ..plain(&brief, &terrain, &map) };
    let after = Picture { policy: Some(&policy), route: &route, sensing_radius_m: Some(2.5), ..before };
    let views = vec![
        TitledPicture { heading: "before".into(), picture: before, layer: Layer::Heights },
        TitledPicture { heading: "after".into(), picture: after, layer: Layer::Heights },
    ];
    PictureGrid { title: "A hop".into(), caption: "east".into(), columns: 2, views }.svg().unwrap()
}

#[test]
fn a_tiny_plate_stands_as_drawn() {
    insta::assert_snapshot!(tiny_plate());
}

#[test]
fn views_on_a_plate_share_ground_legend_and_scale_and_no_id() {
    let text = tiny_plate();
    let document = Document::parse(&text).unwrap();
    let ids: Vec<&str> = document.descendants().filter_map(|node| node.attribute("id")).collect();
    let distinct: std::collections::BTreeSet<&&str> = ids.iter().collect();
    assert_eq!(ids.len(), distinct.len(), "{ids:?}");
    assert_eq!(text.matches("id=\"ground-").count(), 1, "the same ground is drawn once");
    assert_eq!(text.matches("href=\"#ground-0\"").count(), 1);
    for word in ["start", "goal", "hopper, disc it senses", "hop as intended", "policy N, S, E, W"] {
        assert_eq!(text.matches(&format!(">{word}<")).count(), 1, "{word}");
    }
    assert_eq!(text.matches(">height above datum (m)<").count(), 1);
}

#[test]
fn every_size_is_xml_below_two_megabytes() {
    for side in [1, 2, 20, 50, 200, 1024] {
        let text = if side < 4 {
            let brief = brief(side);
            let map = ObservedMap::unseen(brief.run, RobotId(0), brief.grid);
            svg(&brief, &[], &map, None, &[])
        } else {
            mission_svg(side)
        };
        assert!(text.len() < 2_000_000, "{side}: {} bytes", text.len());
        assert!(!text.contains("NaN") && !text.contains("inf"), "{side}");
        let document = Document::parse(&text).unwrap_or_else(|error| panic!("{side}: {error}"));
        assert_eq!(document.root_element().tag_name().name(), "svg");
    }
}

#[test]
fn rough_ground_of_200_cells_a_side_stays_below_two_megabytes() {
    let brief = brief(200);
    let (mut terrain, _) = ground(&brief);
    let mut map = ObservedMap::unseen(brief.run, RobotId(0), brief.grid);
    let mut noise = 1_u32;
    for (index, ground) in terrain.iter_mut().enumerate() {
        noise = noise.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        ground.height_m = f64::from(noise >> 8);
        if noise >> 30 > 1 {
            map.learn(index, *ground);
        }
    }
    let text = svg(&brief, &terrain, &map, Some(&policy(&brief)), &[]);
    assert!(text.len() < 2_000_000, "{} bytes", text.len());
}

#[test]
fn the_same_mission_gives_the_same_bytes() {
    assert_eq!(mission_svg(20), mission_svg(20));
}

#[test]
fn the_legend_names_what_is_drawn_and_nothing_else() {
    let full = mission_svg(20);
    let words =
        ["start", "goal", "hopper, sensing 2.2 m", "hop as intended", "stray hop", "not seen", "sand"];
    for word in
        words.into_iter().chain(["impassable", "policy N, S, E, W", "height above datum (m)", "x, east (m)"])
    {
        assert!(full.contains(&format!(">{word}<")), "{word}");
    }
    let brief = brief(4);
    let flat = vec![Ground::FLAT; brief.grid.cells()];
    let seen: Vec<_> = flat.iter().copied().map(Some).collect();
    let map = ObservedMap::of_cells(brief.run, RobotId(0), brief.grid, &seen);
    let plain = svg(&brief, &flat, &map, None, &[]);
    for word in ["hop as intended", "stray hop", "not seen", "sand", "impassable", "policy N, S, E, W"] {
        assert!(!plain.contains(&format!(">{word}<")), "{word}");
    }
}

#[test]
fn arrows_thin_out_on_large_maps() {
    // Every arrow begins with "M" and its head is closed with "z".
    let arrows = |side: u32| {
        let text = mission_svg(side);
        let document = Document::parse(&text).unwrap();
        let inks = ["#0050d8", "#7a0f6e", "#c8102e", "#111111"];
        let paths = document.descendants().filter(|node| {
            node.attribute("fill-opacity").is_some()
                && node.attribute("fill").is_some_and(|ink| inks.contains(&ink))
        });
        paths.map(|path| path.attribute("d").unwrap().matches('z').count()).sum::<usize>()
    };
    assert!((350..=400).contains(&arrows(20)), "{}", arrows(20));
    assert!((800..=1600).contains(&arrows(200)), "{}", arrows(200));
}

#[test]
fn a_hop_off_the_map_is_drawn_just_beyond_its_edge() {
    let brief = brief(4);
    let (terrain, map) = ground(&brief);
    let south = (Action::Hop(Direction::South), Branch::Intended);
    let route = records(&brief, &[south, south], 4);
    assert_eq!(route[1].status, Status::LeftMap);
    let text = svg(&brief, &terrain, &map, None, &route);
    assert!(text.contains("L359 851"), "the frame ends at 842: {text}");
}

#[test]
fn a_layer_that_does_not_cover_the_grid_is_refused() {
    let brief = brief(4);
    let (terrain, map) = ground(&brief);
    let picture = Picture { outcome: Status::Goal.into(), ..plain(&brief, &terrain[1..], &map) };
    assert_eq!(picture.svg(), Err(ReportError::Cells { layer: "terrain", need: 16, got: 15 }));
}

/// P-PAPER-PICTURE: A picture for a paper is one column wide, has no title, hatches sand and draws
/// arrows only where the ground was seen.
#[test]
fn a_picture_for_a_paper_is_a_column_without_title_and_with_hatched_sand() {
    let brief = brief(24);
    let (terrain, map) = ground(&brief);
    let (route, policy) = (records(&brief, &steps(40), 4), policy(&brief));
    let picture = Picture {
        policy: Some(&policy),
        route: &route,
        outcome: Status::Deadlock.into(),
        sensing_radius_m: Some(2.25),
        ..plain(&brief, &terrain, &map)
    };
    let (screen, paper) =
        (picture.svg_in(PictureStyle::Screen).unwrap(), picture.svg_in(PictureStyle::Paper).unwrap());
    assert_eq!(screen, picture.svg().unwrap());
    let read = Document::parse(&paper).unwrap();
    assert_eq!(read.root_element().attribute("width"), Some("85mm"));
    let texts = |document: &Document<'_>| -> Vec<String> {
        let texts = document.descendants().filter(|node| node.has_tag_name("text"));
        texts.filter_map(|node| node.text().map(str::to_owned)).collect()
    };
    let words = texts(&read);
    assert!(
        !words.iter().any(|word| word.contains("Scenario") || word.contains("sand")),
        "no title, no legend: {words:?}"
    );
    for number in ["10", "20", "30", "40"] {
        assert!(words.iter().any(|word| word == number), "hop {number} is numbered: {words:?}");
    }
    assert!(paper.contains("url(#sand-hatch-0)") && !paper.contains("fill=\"#7d8288\""), "sand is hatched");
    assert!(
        screen.contains("fill-opacity=\".4\"") && !paper.contains("fill-opacity=\".4\""),
        "arrows where it was seen"
    );
}

/// P-PAPER-NUMBERS: Numbers of hops never stand on each other, though the hopper comes back to where it was.
#[test]
fn numbers_of_hops_stand_apart_where_the_hopper_comes_back() {
    let brief = brief(12);
    let (terrain, map) = ground(&brief);
    // There and back, so that every tenth hop lands on the same cell.
    let there_and_back = |n: usize| if n.is_multiple_of(2) { Direction::East } else { Direction::West };
    let steps: Vec<Step> = (0..60).map(|n| (Action::Hop(there_and_back(n)), Branch::Intended)).collect();
    let route = records(&brief, &steps, 60);
    let picture =
        Picture { route: &route, outcome: Status::Deadlock.into(), ..plain(&brief, &terrain, &map) };
    let paper = picture.svg_in(PictureStyle::Paper).unwrap();
    let read = Document::parse(&paper).unwrap();
    let is_number = |text: &str| text.parse::<u32>().is_ok_and(|number| number.is_multiple_of(10));
    let numbers = read.descendants().filter(|node| {
        node.has_tag_name("text")
            && node.attribute("paint-order").is_some()
            && node.text().is_some_and(is_number)
    });
    let place =
        |name: &str, node: &roxmltree::Node<'_, '_>| node.attribute(name).unwrap().parse::<f64>().unwrap();
    let places: Vec<_> = numbers.map(|node| (place("x", &node), place("y", &node))).collect();
    assert_eq!(places.len(), 4, "six hops end there, and four numbers have room: {places:?}");
    for (n, (x, y)) in places.iter().enumerate() {
        let is_apart = |other: &(f64, f64)| (x - other.0).abs() >= 17.0 || (y - other.1).abs() >= 14.0;
        assert!(places[n + 1..].iter().all(is_apart), "{places:?}");
    }
}

/// P-ACCOMPANIED-PICTURE: The picture of a hopper with a helicopter shows the hops, start and goal,
/// and the flight in its own colour.
#[test]
fn a_picture_of_a_hopper_with_a_helicopter_shows_the_hops_and_the_flight() {
    let alone = brief(12);
    let brief = with_robots(&alone, Account::Hopper, &[alone.robots[0], helicopter(&alone)]);
    let (terrain, map) = ground(&brief);
    let mut route = records(&brief, &steps(8), 4);
    for record in route.iter_mut().skip(1).step_by(2) {
        record.robot = RobotId(1);
    }
    let drawn = svg(&brief, &terrain, &map, None, &route);
    let read = Document::parse(&drawn).unwrap();
    let texts: Vec<&str> =
        read.descendants().filter(|node| node.has_tag_name("text")).filter_map(|node| node.text()).collect();
    for word in ["start", "goal", "hop as intended", "helicopter 1", "1"] {
        assert!(texts.contains(&word), "{word}: {texts:?}");
    }
    assert!(texts.iter().any(|text| text.contains("4 hops")), "the helicopter does not hop: {texts:?}");
    assert!(!texts.contains(&"visited, darker the more often"));
}

/// A rover and a helicopter that have gone their announced routes, on ground half of which was seen.
struct Scouted {
    brief: Brief,
    terrain: Vec<Ground>,
    map: ObservedMap,
    route: Vec<Record>,
    announced: [Route; 2],
    speeds: Vec<[f64; 2]>,
}

impl Scouted {
    fn new() -> Self {
        let at = |x_m, y_m| Waypoint { x_m, y_m };
        let alone = brief(12);
        let robots = [driver(&alone, at(10.4, 10.6)), helicopter(&alone)];
        let brief = with_robots(&alone, Account::Actions, &robots);
        let (terrain, map) = ground(&brief);
        let way = |to| Route::new(vec![at(1.5, 1.5), to]).unwrap();
        let announced = [way(at(10.4, 10.6)), way(at(6.5, 2.5))];
        let [drive, flight] = [0, 1].map(|route| Action::Announce(announced[route].id()));
        let steps = [drive, flight, Action::Fly, Action::Drive].map(|action| (action, Branch::Intended));
        let mut route = records(&brief, &steps, 4);
        for (record, (robot, to)) in
            route.iter_mut().zip([(0, (1, 1)), (1, (1, 1)), (1, (6, 2)), (0, (10, 10))])
        {
            record.robot = RobotId(robot);
            (record.outcome.from, record.outcome.to) = (Cell::new(1, 1), Cell::new(to.0, to.1));
        }
        let speed = |seen: &Option<Ground>| if seen.is_some() { [200.0, 0.0] } else { [100.0, 100.0] };
        let speeds = map.cells().iter().map(speed).collect();
        Self { brief, terrain, map, route, announced, speeds }
    }

    fn picture(&self) -> Picture<'_> {
        Picture {
            route: &self.route,
            outcome: Status::Goal.into(),
            speeds: &self.speeds,
            announced: &self.announced,
            ..plain(&self.brief, &self.terrain, &self.map)
        }
    }
}

/// P-SPEED-PICTURE: A picture of uncertain ground shows expected speed and spread, each with its
/// scale, beneath announced and travelled routes.
#[test]
fn a_picture_of_uncertain_ground_shows_expected_speed_and_spread_beneath_the_routes() {
    use report::colour::{SPEEDS, SPREADS, ramp};
    let scouted = Scouted::new();
    let picture = scouted.picture();
    let drawn = picture.svg().unwrap();
    let read = Document::parse(&drawn).unwrap();
    let texts: Vec<&str> =
        read.descendants().filter(|node| node.has_tag_name("text")).filter_map(|node| node.text()).collect();
    for word in [
        "Expected speed at the end",
        "Spread of the speed at the end",
        "expected speed (m/Sol)",
        "standard deviation of speed (m/Sol)",
        "rover 0",
        "helicopter 1",
        "travelled",
        "announced",
        "field of view",
        "start",
        "goal",
    ] {
        assert!(texts.contains(&word), "{word}: {texts:?}");
    }
    assert_eq!(drawn.matches("stroke-dasharray=\"7 7\"").count(), 4, "two announced routes on two plots");
    // A ring of three cells around the helicopter, with a rim, on both plots, which are 520 units wide.
    let ring = format!("r=\"{}\" fill=\"none\"", 3.0 * 520.0 / 12.0);
    assert_eq!(drawn.matches(&ring).count(), 4, "{ring}");
    // Forty shades: the middles of the last, of the one from 100 to 105 m/Sol, of the first.
    for (colours, shade) in [(&SPEEDS[..], 39.5), (&SPEEDS, 20.5), (&SPREADS, 0.5), (&SPREADS, 39.5)] {
        let [r, g, b] = ramp(colours, shade / 40.0);
        let fill = format!("fill=\"#{r:02x}{g:02x}{b:02x}\"");
        assert!(drawn.matches(&fill).count() >= 2, "on the plot and in its scale: {fill}");
    }
    let paper = picture.svg_in(PictureStyle::Paper).unwrap();
    assert!(paper.contains("expected speed (m/Sol)") && !paper.contains("height above datum"), "one plot");
    let short = Picture { speeds: &scouted.speeds[1..], ..picture };
    assert_eq!(short.svg(), Err(ReportError::Cells { layer: "speeds", need: 144, got: 143 }));
}

/// P-TEAM-PICTURE: A picture of several robots shows each with its colour and number, and how often
/// cells were visited.
#[test]
fn a_picture_of_a_team_shows_each_robot_and_the_visits() {
    let alone = brief(12);
    let rover = Robot {
        body: Body::Rover(Rover { speed_mps: 1.0 }),
        sensor: Sensor::Square(Square { range_cells: 1 }),
        goal: Goal::Cover(Cover::default()),
        ..alone.robots[0]
    };
    let brief = with_robots(&alone, Account::ActionsWithoutWaits, &[rover, rover]);
    let (terrain, map) = ground(&brief);
    let mut route = records(&alone, &steps(8), 4);
    for (number, record) in route.iter_mut().enumerate() {
        record.robot = RobotId((number % 2) as u16);
    }
    let drawn = svg(&brief, &terrain, &map, None, &route);
    let read = Document::parse(&drawn).unwrap();
    let texts: Vec<&str> =
        read.descendants().filter(|node| node.has_tag_name("text")).filter_map(|node| node.text()).collect();
    for word in ["0", "1", "robot 0", "robot 1", "visited, darker the more often"] {
        assert!(texts.contains(&word), "{word}: {texts:?}");
    }
    for colour in [report::colour::robot(0), report::colour::robot(1)] {
        assert!(drawn.contains(&colour), "{colour}");
    }
    assert!(!texts.contains(&"goal"), "rovers that cover ground have none");
}
