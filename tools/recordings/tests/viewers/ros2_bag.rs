//! Recordings as bags of ROS 2, read by packages of PyPI that know nothing of Hopper.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::process::Output;
use std::sync::OnceLock;
use std::time::Duration;

use contract::{
    Announcement, Brief, Decision, Detail, DetailPage, DetailRequest, ObservedMap, Policy, Record, RobotId,
    Route, Soil, State, Team, Waypoint,
};
use follow::Replica;
use recording::{Context, JsonMessage, RecordedMessage, Recorder, Recording};
use serde_json::Value;

use crate::harness::{Mission, json, stderr};
use crate::python;

/// How long rosbags and what it needs, of some twenty megabytes, may take to install.
const PYPI: Duration = Duration::from_secs(600);

fn python() -> &'static Path {
    static PYTHON: OnceLock<PathBuf> = OnceLock::new();
    PYTHON.get_or_init(|| {
        python::environment("ros2", PYPI)
            .unwrap_or_else(|why| panic!("this test reads bags with rosbags and needs PyPI once: {why}"))
    })
}

/// Flies a mission by `hopper run --record a.mcap WORDS`; its summary.
fn fly(mission: &Mission, words: &[&str]) -> Value {
    let mut command =
        mission.hopper(&["run", "--instance", &mission.name, "--format", "json", "--out", "out"]);
    let output = command.args(["--record", "a.mcap"]).args(words).output().unwrap();
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    json(&output)
}

/// `hopper bag export FILE --ros2 FOLDER WORDS`.
fn export(mission: &Mission, file: &str, folder: &str, words: &[&str]) -> Output {
    mission.hopper(&["bag", "export", file, "--ros2", folder]).args(words).output().unwrap()
}

/// What was recorded, without the code that makes bags of it.
struct Flown {
    brief: Brief,
    states: BTreeMap<Decision, State>,
    records: BTreeMap<Decision, Record>,
    teams: BTreeMap<Decision, Team>,
    details: BTreeMap<Decision, Detail>,
    policies: BTreeMap<Decision, Policy>,
    routes: BTreeMap<RobotId, Vec<Route>>,
    /// The map after each change.
    maps: Vec<ObservedMap>,
    /// What is to be added to times of the recording, nanoseconds.
    offset_ns: i128,
}

impl Flown {
    fn read(path: &Path) -> Self {
        let bytes = std::fs::read(path).unwrap();
        let recording = Recording::read(&bytes).unwrap();
        let briefs = recording.messages().filter_map(|message| match message.unwrap().1 {
            RecordedMessage::Brief(brief) => Some(brief),
            _ => None,
        });
        let notes = &recording.metadata["hopper"];
        let (seconds, micros) = notes["started_unix_s"].split_once('.').unwrap();
        let unix_ns = format!("{seconds}{micros}000").parse::<i128>().unwrap();
        let mut flown = Self {
            brief: briefs.last().unwrap(),
            states: BTreeMap::new(),
            records: BTreeMap::new(),
            teams: BTreeMap::new(),
            details: BTreeMap::new(),
            policies: BTreeMap::new(),
            routes: BTreeMap::new(),
            maps: Vec::new(),
            offset_ns: unix_ns - notes["started_ns"].parse::<i128>().unwrap(),
        };
        let mut replica = Replica::new(RobotId(0));
        replica.begin(&flown.brief);
        for entry in recording.entries() {
            match entry.message().unwrap() {
                Some(RecordedMessage::State(state)) => _ = flown.states.insert(state.decision, state),
                Some(RecordedMessage::Past(page)) => {
                    flown.records.extend(page.records.iter().map(|record| (record.decision, *record)));
                }
                Some(RecordedMessage::Policy(policy)) => _ = flown.policies.insert(policy.decision, policy),
                Some(RecordedMessage::Patch(patch)) => _ = replica.patch(patch, entry.logged),
                Some(RecordedMessage::Page(page)) => _ = replica.page(&page, entry.logged),
                _ => {}
            }
            if let Some(map) = replica.map()
                && map.through.is_some()
                && map.seen_cells() > 0
                && flown.maps.last().is_none_or(|last| last.observation() != map.observation())
            {
                flown.maps.push(map.clone());
            }
            if JsonMessage::is_topic_of::<Team>(&entry.topic) {
                let team: Team = serde_json::from_slice(entry.data).unwrap();
                flown.teams.insert(team.decision, team);
            } else if JsonMessage::is_topic_of::<Announcement>(&entry.topic) && entry.known.is_none() {
                let Announcement { robot, route, .. } = serde_json::from_slice(entry.data).unwrap();
                let routes = flown.routes.entry(robot).or_default();
                if routes.last() != Some(&route) {
                    routes.push(route);
                }
            } else if JsonMessage::is_topic_of_answers::<DetailRequest>(&entry.topic) {
                let DetailPage { decision, detail, .. } = serde_json::from_slice(entry.data).unwrap();
                flown.details.insert(decision, detail);
            }
        }
        flown
    }

    /// When each landing was, by the journal, and of the last by its state; as a time of ROS, nanoseconds.
    fn landed_ns(&self, decision: Decision) -> i128 {
        let landed = self.records.get(&decision).map(|record| record.timing.landed);
        let landed = landed.unwrap_or_else(|| self.states[&decision].landed);
        i128::from(landed.0) + self.offset_ns
    }

    /// Moment and place of each landing of a robot.
    fn places(&self, robot: RobotId) -> Vec<(i128, [f64; 3])> {
        let described = self.brief.robots[usize::from(robot.0)];
        let Waypoint { x_m, y_m } = described.start_at;
        let ground = self.maps.last().unwrap().ground(described.start.cell);
        let height_m = ground.map_or(0.0, |ground| ground.height_m);
        let mut places = vec![(self.landed_ns(Decision(0)), [x_m, y_m, height_m])];
        for record in self.records.values().filter(|record| record.robot == robot) {
            let next = record.decision.next();
            let member = self.teams.get(&next).and_then(|team| team.member(robot));
            let middle = Waypoint::middle_of(&self.brief.grid, record.pose.cell);
            let at = member.and_then(|member| member.travel.as_ref()).map_or(middle, |travel| travel.at);
            let rest = self.details.get(&record.decision).map(|detail| detail.rest_m);
            places.push((self.landed_ns(next), rest.unwrap_or([at.x_m, at.y_m, record.pose.height_m])));
        }
        places
    }
}

/// A bag as others read it.
struct Bag(Value);

impl Bag {
    fn read(folder: &Path) -> Self {
        Self(python::read(python(), "read_ros2.py", folder))
    }

    /// The messages of a topic.
    fn of(&self, topic: &str) -> Vec<&Value> {
        let messages = self.0["messages"][topic].as_array();
        messages.map(|messages| messages.iter().map(|message| &message[1]).collect()).unwrap_or_default()
    }

    fn topics(&self) -> BTreeMap<String, String> {
        let topics = self.0["topics"].as_object().unwrap();
        topics.iter().map(|(name, topic)| (name.clone(), topic["type"].as_str().unwrap().into())).collect()
    }
}

fn ns(stamp: &Value) -> i128 {
    i128::from(stamp["sec"].as_i64().unwrap()) * 1_000_000_000
        + i128::from(stamp["nanosec"].as_u64().unwrap())
}

fn place(position: &Value) -> [f64; 3] {
    ["x", "y", "z"].map(|axis| position[axis].as_f64().unwrap())
}

/// The figures of a status of a report.
fn figures(status: &Value) -> BTreeMap<&str, &str> {
    let values = status["values"].as_array().unwrap().iter();
    values.map(|value| (value["key"].as_str().unwrap(), value["value"].as_str().unwrap())).collect()
}

/// The numbers of a grid map: rows from the east, columns from the north.
struct Layers {
    side_m: f64,
    /// Its north-eastern corner, metres.
    corner_m: [f64; 2],
    rows: usize,
    columns: usize,
    numbers: BTreeMap<String, Vec<Option<f64>>>,
}

impl Layers {
    fn of(map: &Value) -> Self {
        let info = &map["info"];
        let side_m = info["resolution"].as_f64().unwrap();
        let middle = place(&info["pose"]["position"]);
        let sides_m = ["length_x", "length_y"].map(|side| info[side].as_f64().unwrap());
        let [rows, columns] = sides_m.map(|length_m| (length_m / side_m).round() as usize);
        let names = map["layers"].as_array().unwrap().iter().map(|name| name.as_str().unwrap().to_owned());
        let numbers = names.zip(map["data"].as_array().unwrap()).map(|(name, array)| {
            let dimensions = array["layout"]["dim"].as_array().unwrap().iter();
            let told = dimensions.map(|dim| {
                (
                    dim["label"].as_str().unwrap(),
                    ["size", "stride"].map(|of| dim[of].as_u64().unwrap() as usize),
                )
            });
            assert_eq!(
                told.collect::<Vec<_>>(),
                [("column_index", [columns, rows * columns]), ("row_index", [rows, rows])]
            );
            let numbers: Vec<Option<f64>> =
                array["data"].as_array().unwrap().iter().map(Value::as_f64).collect();
            assert_eq!(numbers.len(), rows * columns);
            (name, numbers)
        });
        let corner_m = [0, 1].map(|axis| middle[axis] + sides_m[axis] / 2.0);
        Self { side_m, corner_m, rows, columns, numbers: numbers.collect() }
    }

    /// Where the numbers of a point are; `None` outside.
    fn at(&self, Waypoint { x_m, y_m }: Waypoint) -> Option<usize> {
        let [row, column] = [(0, x_m), (1, y_m)]
            .map(|(axis, at): (usize, f64)| ((self.corner_m[axis] - at) / self.side_m).floor());
        let is_within =
            (0.0..self.rows as f64).contains(&row) && (0.0..self.columns as f64).contains(&column);
        is_within.then_some(column as usize * self.rows + row as usize)
    }
}

/// Every place, way and frame is that of the journal.
fn assert_robots(flown: &Flown, bag: &Bag) {
    let transforms = bag.of("/tf");
    assert_eq!(transforms.len(), flown.records.len() + 1, "one for each landing");
    let last = transforms[transforms.len() - 1]["transforms"].as_array().unwrap();
    let frames = bag.of("/tf_static")[0]["transforms"].as_array().unwrap();
    assert_eq!((last.len(), frames.len()), (flown.brief.robots.len(), flown.brief.robots.len()));
    for (robot, described) in flown.brief.robots.numbered() {
        let [odom, base_link] = ["odom", "base_link"].map(|name| format!("robot_{robot}/{name}"));
        let places = flown.places(robot);
        let odometry = bag.of(&format!("/{odom}"));
        let told = odometry.iter().map(|message| {
            let header = &message["header"];
            assert_eq!(
                (&header["frame_id"], &message["child_frame_id"]),
                (&odom.clone().into(), &base_link.clone().into())
            );
            (ns(&header["stamp"]), place(&message["pose"]["pose"]["position"]))
        });
        assert_eq!(told.collect::<Vec<_>>(), places, "robot {robot}");
        let at = usize::from(robot.0);
        assert_eq!(frames[at]["header"]["frame_id"], "map");
        assert_eq!(frames[at]["child_frame_id"], odom);
        assert_eq!(place(&frames[at]["transform"]["translation"]), [0.0; 3]);
        assert_eq!(frames[at]["transform"]["rotation"]["w"], 1.0);
        assert_eq!(
            (&last[at]["header"]["frame_id"], &last[at]["child_frame_id"]),
            (&odom.into(), &base_link.into())
        );
        assert_eq!(place(&last[at]["transform"]["translation"]), places[places.len() - 1].1);
        assert_eq!(
            last[at]["transform"]["rotation"],
            odometry[odometry.len() - 1]["pose"]["pose"]["orientation"]
        );
        if described.body.hops() {
            assert_eq!(last[at]["transform"]["rotation"]["w"], 1.0, "hoppers have no heading");
        }

        // A way ends, at each landing, where the robot rests.
        let paths = bag.of(&format!("/robot_{robot}/path"));
        let way = paths[paths.len() - 1]["poses"].as_array().unwrap();
        let ends: BTreeMap<i128, [f64; 3]> =
            way.iter().map(|pose| (ns(&pose["header"]["stamp"]), place(&pose["pose"]["position"]))).collect();
        let known: BTreeMap<i128, [f64; 3]> = places.iter().copied().collect();
        for (moment_ns, end) in &ends {
            assert_eq!(known.get(moment_ns), Some(end), "robot {robot}");
        }
        let moves = places.windows(2).filter(|pair| pair[0].1[..2] != pair[1].1[..2]).count();
        assert!(ends.len() > moves, "robot {robot}: {} of {moves}", ends.len());

        let plans = bag.of(&format!("/robot_{robot}/plan"));
        let routes = flown.routes.get(&robot).map_or(&[][..], Vec::as_slice);
        assert_eq!(plans.len(), routes.len());
        for (plan, route) in plans.iter().zip(routes) {
            let poses = plan["poses"].as_array().unwrap().iter();
            let points = poses.map(|pose| place(&pose["pose"]["position"])).map(|[x, y, _]| [x, y]);
            let route = route.waypoints().iter().map(|point| [point.x_m, point.y_m]);
            assert!(points.eq(route), "robot {robot}");
        }
    }
}

/// Every cell of every map is that of the recorded map.
fn assert_maps(flown: &Flown, bag: &Bag) {
    let (grids, layered) = (bag.of("/map"), bag.of("/grid_map"));
    assert_eq!((grids.len(), layered.len()), (flown.maps.len(), flown.maps.len()), "one for each change");
    for ((map, grid), layers) in flown.maps.iter().zip(grids).zip(layered) {
        let moment_ns = i128::from(map.published.0) + flown.offset_ns;
        for header in [&grid["header"], &layers["header"]] {
            assert_eq!((ns(&header["stamp"]), &header["frame_id"]), (moment_ns, &"map".into()));
        }
        let info = &grid["info"];
        assert_eq!(
            (info["width"].as_u64(), info["height"].as_u64()),
            (Some(map.grid.width.into()), Some(map.grid.height.into()))
        );
        assert_eq!(info["resolution"].as_f64(), Some(f64::from(map.grid.cell_size_m as f32)));
        assert_eq!(place(&info["origin"]["position"]), [0.0; 3], "the corner of cell (0, 0)");
        let policy = map.through.and_then(|through| flown.policies.get(&through));
        let layers = Layers::of(layers);
        assert_eq!(layers.numbers.contains_key("value"), policy.is_some());
        for (index, (cell, value)) in map.cells().iter().zip(grid["data"].as_array().unwrap()).enumerate() {
            let occupied = cell.map_or(-1, |ground| if ground.passable { 0 } else { 100 });
            assert_eq!(value.as_i64(), Some(occupied), "cell {index}");
            let Some(at) = layers.at(Waypoint::middle_of(&map.grid, map.grid.cell(index))) else {
                assert_eq!(*cell, None, "cell {index} is seen, and outside of the map");
                continue;
            };
            let [gx, gy] = cell.map_or([None; 2], |ground| ground.gradient.map(Some));
            let mut expected = vec![
                ("height", cell.map(|ground| ground.height_m)),
                ("gradient", gx.zip(gy).map(|(gx, gy)| (gx * gx + gy * gy).sqrt())),
                ("gradient_x", gx),
                ("gradient_y", gy),
                ("soil", cell.map(|ground| if ground.soil == Soil::Hard { 1.0 } else { 2.0 })),
                ("passable", cell.map(|ground| f64::from(u8::from(ground.passable)))),
                ("seen", Some(f64::from(u8::from(cell.is_some())))),
            ];
            expected.extend(policy.map(|policy| ("value", Some(policy.cells[index].value))));
            for (layer, value) in expected {
                let value = value.map(|value| f64::from(value as f32));
                assert_eq!(layers.numbers[layer][at], value, "{layer} of cell {index}");
            }
        }
    }
}

/// Every decision is reported as it was journalled.
fn assert_reports(flown: &Flown, bag: &Bag) {
    let reports = bag.of("/diagnostics");
    let landings: Vec<&&Value> =
        reports.iter().filter(|report| report["status"][0]["name"] == "hopper: mission").collect();
    assert_eq!(landings.len(), flown.records.len() + 1);
    for (report, record) in landings.iter().skip(1).zip(flown.records.values()) {
        let mission = figures(&report["status"][0]);
        assert_eq!(mission["digest"], record.digest.to_string());
        assert_eq!(mission["decision"], record.decision.next().to_string());
        assert_eq!(mission["run"], flown.brief.run.to_string());
        assert_eq!(report["status"][0]["message"], record.status.as_str());
        assert_eq!(report["status"][0]["level"], 0, "{report}");
        assert_eq!(ns(&report["header"]["stamp"]), flown.landed_ns(record.decision.next()));
        let decision = figures(&report["status"][1]);
        assert_eq!(report["status"][1]["name"], "hopper: decision");
        assert_eq!(decision["action"], record.action.to_string());
        assert_eq!(decision["to"], format!("{} {}", record.outcome.to.x, record.outcome.to.y));
        assert_eq!(decision["planner"], record.leader.planner.to_string());
        let total_us: f64 = decision["total_us"].parse().unwrap();
        assert_eq!(total_us, record.timing.total_ns() as f64 / 1e3);
        let stages = contract::Stage::ALL.into_iter().zip(record.timing.stages_ns());
        for (stage, stage_ns) in stages {
            assert_eq!(decision[format!("{stage}_us").as_str()], (stage_ns as f64 / 1e3).to_string());
        }
    }
    let processes = |name: &str| reports.iter().filter(|report| report["status"][0]["name"] == name).count();
    for role in ["hopper: hopper-sim", "hopper: perception", "hopper: planner"] {
        assert!(processes(role) > 0, "{role}");
    }
}

/// P-ROS2: A recording becomes a bag of ROS 2 that PyPI's `rosbags` and `mcap-ros2-support` read alike, and every place, way, frame,
/// cell, value and report in it is the recorded one to the bit, of one robot and of several.
#[test]
fn a_bag_of_ros_2_holds_the_recorded_values() {
    for (name, words) in [
        ("ros2-hard", &["--seed", "7", "--pace", "20", "--record-policies"][..]),
        ("ros2-contact", &["--seed", "7", "--pace", "20", "--dynamics", "contact"]),
        ("ros2-team", &["--scenario", "coverage", "--seed", "3", "--pace", "100"]),
        ("ros2-routes", &["--scenario", "rover-helicopter", "--seed", "3", "--pace", "20"]),
    ] {
        let mission = Mission::new(name);
        let summary = fly(&mission, words);
        let exported = export(&mission, "a.mcap", "bag", &[]);
        assert_eq!(exported.status.code(), Some(0), "{}", stderr(&exported));
        assert!(exported.stdout.is_empty());
        let (flown, bag) = (Flown::read(&mission.path("a.mcap")), Bag::read(&mission.path("bag")));
        assert_eq!(bag.0["profile"], "ros2");
        assert_eq!(bag.0["notes"]["hopper"]["clock_offset_ns"], flown.offset_ns.to_string());
        assert_eq!(summary["decisions"].as_u64(), Some(flown.records.len() as u64));
        assert_robots(&flown, &bag);
        assert_maps(&flown, &bag);
        assert_reports(&flown, &bag);
        let last = bag
            .of("/diagnostics")
            .into_iter()
            .rfind(|report| report["status"][0]["name"] == "hopper: mission");
        assert_eq!(figures(&last.unwrap()["status"][0])["digest"], summary["digest"]);
        let has_policies = flown.policies.len() > 1;
        assert_eq!(has_policies, name == "ros2-hard");
        assert_eq!(flown.details.is_empty(), name != "ros2-contact");
        let layers = bag.of("/grid_map")[0]["layers"].clone();
        let layers: Vec<&str> =
            layers.as_array().unwrap().iter().map(|layer| layer.as_str().unwrap()).collect();
        let has = |layer: &str| layers.contains(&layer);
        assert_eq!(has("speed") && has("spread"), name == "ros2-routes", "{layers:?}");
        let mut expected: BTreeMap<String, String> = [
            ("/diagnostics", "diagnostic_msgs/msg/DiagnosticArray"),
            ("/grid_map", "grid_map_msgs/msg/GridMap"),
            ("/map", "nav_msgs/msg/OccupancyGrid"),
            ("/tf", "tf2_msgs/msg/TFMessage"),
            ("/tf_static", "tf2_msgs/msg/TFMessage"),
        ]
        .map(|(topic, kind)| (topic.to_owned(), kind.to_owned()))
        .into();
        for (robot, _) in flown.brief.robots.numbered() {
            expected.insert(format!("/robot_{robot}/odom"), "nav_msgs/msg/Odometry".into());
            expected.insert(format!("/robot_{robot}/path"), "nav_msgs/msg/Path".into());
            if flown.routes.contains_key(&robot) {
                expected.insert(format!("/robot_{robot}/plan"), "nav_msgs/msg/Path".into());
            }
        }
        assert_eq!(bag.topics(), expected);
        for (topic, qos) in [("/tf", [1, 10, 1, 2]), ("/tf_static", [1, 1, 1, 1]), ("/map", [1, 1, 1, 1])] {
            assert_eq!(bag.0["topics"][topic]["qos"], serde_json::json!(qos), "{topic}");
        }
    }
}

/// P-ROS2-SIZE: The maps of a bag keep within the size that is asked for, and the last map and way are always there.
#[test]
fn maps_keep_within_their_size_and_the_last_is_there() {
    let mission = Mission::new("ros2-size");
    fly(&mission, &["--scenario", "coverage", "--seed", "3", "--pace", "100"]);
    let bags = ["0", "1", "256"].map(|mib| {
        let exported = export(&mission, "a.mcap", mib, &["--maps-mib", mib]);
        assert_eq!(exported.status.code(), Some(0), "{}", stderr(&exported));
        Bag::read(&mission.path(mib))
    });
    let counts = bags.each_ref().map(|bag| bag.of("/grid_map").len());
    assert!(counts[0] == 1 && counts[1] > 1 && counts[1] < counts[2], "{counts:?}");
    let bytes = |mib: &str| std::fs::metadata(mission.path(mib).join(format!("{mib}_0.mcap"))).unwrap().len();
    let [_, some, all] = &bags;
    let numbers: usize = some.of("/grid_map").iter().map(|map| numbers(map)).sum();
    assert!(4 * numbers < 1 << 20, "{numbers} numbers");
    assert!(bytes("0") < bytes("1") && bytes("1") < bytes("256"));
    for (topic, field) in
        [("/map", "data"), ("/grid_map", "data"), ("/robot_0/path", "poses"), ("/robot_3/path", "poses")]
    {
        let last = |bag: &Bag| bag.of(topic).last().map(|message| message[field].clone()).unwrap();
        assert!(bags.iter().all(|bag| last(bag) == last(all)), "{topic}");
    }
    // What is small is whole, whatever the size.
    for topic in ["/tf", "/diagnostics", "/robot_0/odom"] {
        assert!(bags.iter().all(|bag| bag.0["messages"][topic] == all.0["messages"][topic]), "{topic}");
    }
}

/// How many numbers a grid map holds.
fn numbers(map: &Value) -> usize {
    map["data"].as_array().unwrap().iter().map(|layer| layer["data"].as_array().unwrap().len()).sum()
}

/// P-ROS2-INPUT: What cannot become a bag is refused with one error, exit code 2, and leaves nothing behind: files that are no recording
/// of Hopper, recordings that were cut or have no map, folders that are there already.
#[test]
fn what_cannot_become_a_bag_is_refused_and_leaves_nothing() {
    let mission = Mission::new("ros2-input");
    let golden = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../tests/golden/hard.mcap");
    let whole = std::fs::read(golden).unwrap();
    std::fs::write(mission.path("whole.mcap"), &whole).unwrap();
    std::fs::write(mission.path("cut.mcap"), &whole[..whole.len() / 2]).unwrap();
    std::fs::write(mission.path("text.mcap"), "no recording").unwrap();
    let mut recorder = Recorder::new(&Context::new(), contract::MonotonicNs(1)).unwrap();
    let without_map = hostile::recording::messages()
        .into_iter()
        .filter(|message| !matches!(message, RecordedMessage::Patch(_) | RecordedMessage::Page(_)));
    for message in without_map {
        recorder.on(message, contract::MonotonicNs(2)).unwrap();
    }
    recorder.finish(contract::MonotonicNs(3)).unwrap();
    std::fs::write(mission.path("blind.mcap"), recorder.bytes()).unwrap();
    let made = export(&mission, "whole.mcap", "bag", &[]);
    assert_eq!(made.status.code(), Some(0), "{}", stderr(&made));
    std::fs::copy(mission.path("bag/bag_0.mcap"), mission.path("foreign.mcap")).unwrap();
    let before = names(&mission);
    for (words, need) in [
        (&["foreign.mcap", "--ros2", "new"][..], "needs a brief on hop/brief"),
        (&["text.mcap", "--ros2", "new"], "needs to begin with"),
        (&["nothing.mcap", "--ros2", "new"], "cannot be read"),
        (&["cut.mcap", "--ros2", "new"], "hopper bag recover cut.mcap whole.mcap"),
        (&["blind.mcap", "--ros2", "new"], "needs a map"),
        (&["whole.mcap", "--ros2", "bag"], "bag exists already: name another folder"),
        (&["whole.mcap", "--ros2", "cut.mcap"], "exists already"),
        (&["whole.mcap", "--ros2", "nowhere/new"], "need a folder that exists, got nowhere"),
        (&["whole.mcap", "--ros2", "cut.mcap/new"], "need a folder, got the file cut.mcap"),
        (&["whole.mcap", "--ros2", "new", "--topic", "hop/state"], "--topic"),
        (&["whole.mcap", "--ros2", "new", "--full"], "--full"),
        (&["whole.mcap", "--maps-mib", "3"], "--ros2"),
        (&["whole.mcap", "--ros2", "new", "--maps-mib", "many"], "--maps-mib"),
    ] {
        let output = mission.hopper(&["bag", "export"]).args(words).output().unwrap();
        let told = stderr(&output);
        assert_eq!(output.status.code(), Some(2), "{words:?}: {told}");
        assert!(told.contains(need), "{words:?}: {told}");
        assert!(output.stdout.is_empty(), "{words:?}");
        assert_eq!(told.matches("ERROR").count().max(1), 1, "{words:?}: {told}");
        assert_eq!(names(&mission), before, "{words:?}");
    }
}

/// The names of what is in the mission's folder.
fn names(mission: &Mission) -> Vec<String> {
    let entries = std::fs::read_dir(mission.path(".")).unwrap();
    let mut names: Vec<String> =
        entries.map(|entry| entry.unwrap().file_name().into_string().unwrap()).collect();
    names.sort();
    names
}
