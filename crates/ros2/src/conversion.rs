//! Writes a mission as a bag.
//!
//! Messages stand in the order of their times. Landings are complete, however many states were missed, since they follow from
//! the journal's records. Maps and ways are large and grow: they are written as they change, but no more often than fits into
//! [`Conversion::maps_bytes_max`].

use std::collections::BTreeMap;
use std::io::Write;

use contract::{MonotonicNs, PriorCell, RobotId, RouteId};
use recording::view::{self, Point};
use recording::{Entry, RecordedMessage, Recording};

use crate::diagnostics::{self, Processes};
use crate::grid_map::Layers;
use crate::landing::Landing;
use crate::map_follower::MapFollower;
use crate::message::Pose;
use crate::mission::announcement;
use crate::pose::{self, of_robot};
use crate::thinning::Thinning;
use crate::way::{self, POSE_BYTES, POSES_MAX, Way};
use crate::{Bag, BagSummary, Mission, Qos, Ros2Error, occupancy};

/// Ways may take this share of the size of the maps.
const WAYS_SHARE: u64 = 8;

/// What is written, and how much of it.
#[derive(Clone, Copy, Debug)]
pub struct Conversion<'a> {
    /// The expected speeds of every cell of uncertain ground, if they are known.
    pub prior: &'a [PriorCell],
    /// Most bytes that `/map` and `/grid_map` take in all; ways may take an eighth of that besides. The last of each is always
    /// written.
    pub maps_bytes_max: u64,
}

/// What was written.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Converted {
    /// The bag's topics and metadata.
    pub summary: BagSummary,
    /// Maps written, and how often the map changed.
    pub maps: [u64; 2],
}

/// Writes the run of `recording` that was gathered as `mission` to `out`, the file `file_name` of a bag.
///
/// # Errors
/// If it cannot be written.
pub fn convert<W: Write>(
    recording: &Recording<'_>,
    mission: &Mission<'_>,
    conversion: &Conversion<'_>,
    out: W,
    file_name: &str,
) -> Result<Converted, Ros2Error> {
    let notes = BTreeMap::from([
        ("run".to_owned(), mission.brief.run.to_string()),
        ("scenario".to_owned(), mission.brief.scenario.to_string()),
        ("clock_offset_ns".to_owned(), mission.clock.offset_ns.to_string()),
    ]);
    let mut writing = Writing::new(mission, conversion, Bag::new(out, file_name, notes)?);
    for entry in recording.entries() {
        writing.until(entry.logged)?;
        writing.on(&entry)?;
    }
    writing.until(MonotonicNs(u64::MAX))?;
    let maps = [writing.maps_written, mission.changes.len() as u64];
    Ok(Converted { summary: writing.bag.finish()?, maps })
}

/// A bag that is being written.
struct Writing<'a, W: Write> {
    mission: &'a Mission<'a>,
    bag: Bag<W>,
    layers: Layers,
    map: MapFollower,
    map_thinning: Thinning,
    /// Changes of the map so far.
    map_changes: usize,
    maps_written: u64,
    way_thinning: Thinning,
    /// Landings written so far.
    landings: usize,
    ways: BTreeMap<RobotId, Way>,
    /// Robots whose way has changed since it was written.
    moved: Vec<RobotId>,
    routes: BTreeMap<RobotId, RouteId>,
    processes: Processes,
    /// When the last message was written: times do not go back.
    now: MonotonicNs,
    /// Whether the brief of the run was read.
    has_begun: bool,
}

impl<'a, W: Write> Writing<'a, W> {
    fn new(mission: &'a Mission<'a>, conversion: &Conversion<'_>, bag: Bag<W>) -> Self {
        let brief = &mission.brief;
        let layers = Layers::new(brief, conversion.prior);
        let map_bytes = mission.changes.iter().map(|(through, seen)| {
            layers.bytes(seen, mission.has_policy(*through)).saturating_add(brief.grid.cells() as u64)
        });
        let map_thinning = Thinning::of(&map_bytes.collect::<Vec<_>>(), conversion.maps_bytes_max);
        let mut poses: BTreeMap<RobotId, usize> = BTreeMap::new();
        let way_bytes = mission.landings.iter().map(|landing| {
            let count = poses.entry(landing.state.robot).or_insert(1);
            *count = POSES_MAX.min(*count + passed(mission, landing).len());
            *count as u64 * POSE_BYTES
        });
        let way_bytes: Vec<u64> = way_bytes.collect();
        let way_thinning = Thinning::of(&way_bytes, conversion.maps_bytes_max / WAYS_SHARE);
        Self {
            mission,
            bag,
            layers,
            map: MapFollower::new(brief),
            map_thinning,
            map_changes: 0,
            maps_written: 0,
            way_thinning,
            landings: 0,
            ways: BTreeMap::new(),
            moved: Vec::new(),
            routes: BTreeMap::new(),
            processes: Processes::default(),
            now: MonotonicNs(0),
            has_begun: false,
        }
    }

    /// Writes the landings up to `moment`.
    fn until(&mut self, moment: MonotonicNs) -> Result<(), Ros2Error> {
        let mission = self.mission;
        while let Some(landing) =
            mission.landings.get(self.landings).filter(|landing| landing.moment <= moment)
        {
            self.landing(landing)?;
            self.landings += 1;
        }
        Ok(())
    }

    fn landing(&mut self, landing: &Landing) -> Result<(), Ros2Error> {
        let (mission, clock) = (self.mission, &self.mission.clock);
        let moment = landing.moment;
        self.now = self.now.max(moment);
        let logged_ns = clock.ns(self.now);
        if self.landings == 0 {
            let frames = pose::static_transforms(mission.brief.robots.count(), moment, clock);
            self.bag.write("/tf_static", Qos::Latched, logged_ns, &frames)?;
        }
        for (robot, pose) in landing.actors() {
            let odometry = pose::odometry(robot, *pose, moment, clock);
            self.bag.write(&topic(robot, "odom"), Qos::Volatile, logged_ns, &odometry)?;
        }
        self.bag.write("/tf", Qos::Volatile, logged_ns, &pose::transforms(landing, clock))?;
        let (record, team) =
            (mission.decisions.before(&landing.state), mission.decisions.team(&landing.state));
        let report = diagnostics::of_landing(&mission.brief, landing, record, team, clock);
        self.bag.write("/diagnostics", Qos::Volatile, logged_ns, &report)?;
        self.way(landing, logged_ns)
    }

    /// Adds the way that led to a landing, and writes the ways that have changed if they are due.
    fn way(&mut self, landing: &Landing, logged_ns: u64) -> Result<(), Ros2Error> {
        let (mission, clock) = (self.mission, &self.mission.clock);
        if self.landings == 0 {
            // Ways begin where the robots are then.
            for (robot, pose) in (0..).map(RobotId).zip(&landing.poses) {
                self.ways.entry(robot).or_default().push(landing.moment, point(pose));
                self.moved.push(robot);
            }
        } else {
            let robot = landing.state.robot;
            let points = passed(mission, landing);
            if !points.is_empty() && !self.moved.contains(&robot) {
                self.moved.push(robot);
            }
            let way = self.ways.entry(robot).or_default();
            points.into_iter().for_each(|point| way.push(landing.moment, point));
        }
        if self.way_thinning.keeps(self.landings) {
            for robot in std::mem::take(&mut self.moved) {
                let path = self.ways.entry(robot).or_default().path(landing.moment, clock);
                self.bag.write(&topic(robot, "path"), Qos::Latched, logged_ns, &path)?;
            }
        }
        Ok(())
    }

    /// Takes a message of the recording.
    fn on(&mut self, entry: &Entry<'_>) -> Result<(), Ros2Error> {
        let (mission, clock) = (self.mission, &self.mission.clock);
        if let Some(announcement) = announcement(entry, &mission.brief) {
            let (robot, id) = (announcement.robot, announcement.route.id());
            if self.routes.insert(robot, id) != Some(id) {
                self.now = self.now.max(entry.logged);
                let map = self.map.map().map(|(map, _)| map);
                let plan = way::plan(&announcement.route, map, entry.logged, clock);
                return self.bag.write(&topic(robot, "plan"), Qos::Latched, clock.ns(self.now), &plan);
            }
            return Ok(());
        }
        let Ok(Some(message)) = entry.message() else { return Ok(()) };
        match message {
            RecordedMessage::Brief(brief) => {
                self.has_begun = brief.run == mission.brief.run;
                Ok(())
            }
            RecordedMessage::Heartbeat(beat) if self.has_begun => {
                let Some(report) = self.processes.on(&beat, entry.logged, clock) else { return Ok(()) };
                self.now = self.now.max(entry.logged);
                self.bag.write("/diagnostics", Qos::Volatile, clock.ns(self.now), &report)
            }
            message => {
                if self.has_begun && self.map.on(message, entry.logged) {
                    self.map_changes += 1;
                    if self.map_thinning.keeps(self.map_changes - 1) {
                        return self.maps(entry.logged);
                    }
                }
                Ok(())
            }
        }
    }

    /// Writes the map as it is.
    fn maps(&mut self, logged: MonotonicNs) -> Result<(), Ros2Error> {
        let (mission, clock) = (self.mission, &self.mission.clock);
        let Some((map, seen)) = self.map.map() else { return Ok(()) };
        self.now = self.now.max(logged);
        let logged_ns = clock.ns(self.now);
        let began = mission.landings.first().map_or(map.published, |first| first.moment);
        self.bag.write("/map", Qos::Latched, logged_ns, &occupancy::grid(map, began, clock))?;
        let policy = map.through.and_then(|through| mission.policy(through));
        if let Some(layers) = self.layers.map(map, seen, policy.as_ref(), clock) {
            self.bag.write("/grid_map", Qos::Latched, logged_ns, &layers)?;
        }
        self.maps_written += 1;
        Ok(())
    }
}

fn topic(robot: RobotId, name: &str) -> String {
    format!("/{}", of_robot(robot, name))
}

/// The points that the robot of a landing passed on its way there from where it was before. A robot that goes from point to point comes
/// straight.
fn passed(mission: &Mission<'_>, landing: &Landing) -> Vec<Point> {
    let state = &landing.state;
    let Some(rest) = landing.poses.get(usize::from(state.robot.0)).map(point) else { return Vec::new() };
    let Some(record) = mission.decisions.before(state) else { return vec![rest] };
    let member = mission.decisions.team(state).and_then(|team| team.member(state.robot));
    if member.is_some_and(|member| member.travel.is_some()) {
        return vec![rest];
    }
    let way = view::way(&mission.brief, record, mission.decisions.detail(state));
    // Its first point is where the last way ended; it ends where the robot rests, to the bit.
    let mut points: Vec<Point> = way.into_iter().skip(1).collect();
    if let Some(last) = points.last_mut() {
        *last = rest;
    }
    points
}

fn point(pose: &Pose) -> Point {
    Point { x: pose.position.x, y: pose.position.y, z: pose.position.z }
}
