//! What viewers are shown of a mission: folded from its messages, drawn when it is due.

use std::collections::BTreeMap;

use contract::{
    Account, Announcement, Brief, Cell, Detail, MonotonicNs, ObservedMap, Policy, PriorCell, Record, RobotId,
    Route, State, Team, Waypoint,
};
use prost::Message as _;
use report::Layer;
use report::colour;
use report::layers::{Look, Value};

use super::point_cloud::{Cloud, Point};
use super::speeds::Speeds;
use super::trail::{Part, Trail, between};
use super::{FRAME, arrows, ground, markers, middle, stamp, unturned, values};
use crate::Channel;
use crate::proto::foxglove::{FrameTransform, FrameTransforms, Vector3};

/// Time between two clouds of one channel, nanoseconds.
const PERIOD_NS: u64 = 1_000_000_000;

/// Time added to it for each seen cell of the map, nanoseconds: the clouds of large maps take megabytes.
const CELL_NS: u64 = 40_000;

/// Height of a robot's marker: so many cells, and at least this share of the longer side of the map.
const MARKER_CELLS: f64 = 1.5;
const MARKER_SHARE: f64 = 0.03;

/// Points of an announced route in each cell of its length.
const ROUTE_POINTS_PER_CELL: f64 = 2.0;

/// A message for viewers: its channel, its bytes, and the moment that it shows.
pub type ViewMessage = (Channel, Vec<u8>, MonotonicNs);

/// The robots, their ways and plans, as far as they are known.
#[derive(Debug, Default)]
pub struct Views {
    brief: Option<Brief>,
    team: Option<Team>,
    places: BTreeMap<RobotId, Point>,
    trails: BTreeMap<RobotId, Trail>,
    routes: BTreeMap<RobotId, Route>,
    policy: Option<Policy>,
    /// The prior of uncertain ground, until the map is known too.
    prior: Vec<PriorCell>,
    speeds: Option<Speeds>,
    /// Where the robot of the last state was, and its goals visited.
    here: Cell,
    visits: u64,
    map: Due,
    speed: Due,
    values: Due,
    plan: Due,
    route: Due,
}

/// When something was drawn last, and whether it has changed since.
#[derive(Clone, Copy, Debug, Default)]
struct Due {
    drawn: Option<MonotonicNs>,
    /// Fingerprint of the map that was drawn.
    observation: u64,
    has_changed: bool,
}

impl Due {
    /// Whether to draw now; then it counts as drawn.
    fn is_now(&mut self, now: MonotonicNs, period_ns: u64, ends: bool) -> bool {
        let is_due = ends || self.drawn.is_none_or(|drawn| now.since_ns(drawn) >= period_ns);
        let draws = self.has_changed && is_due;
        if draws {
            (self.has_changed, self.drawn) = (false, Some(now));
        }
        draws
    }
}

impl Views {
    /// Another run begins.
    pub fn begin(&mut self, brief: &Brief) {
        *self = Self { brief: Some(brief.clone()), ..Self::default() };
    }

    /// The past is read again from its beginning.
    pub fn forget_past(&mut self) {
        self.trails.clear();
        self.route.has_changed = true;
    }

    /// All robots at one moment, published before the state of that moment.
    pub fn team(&mut self, team: &Team, map: Option<&ObservedMap>) {
        let Some(brief) = &self.brief else { return };
        for (number, member) in (0..).map(RobotId).zip(team.members.iter()) {
            let cell = middle(brief, member.at.cell, 0.0);
            let at = member.travel.as_ref().map_or(cell, |travel| at(travel.at));
            let known = self.places.get(&number).map_or(0.0, |place| place.z);
            let z = map.and_then(|map| map.ground(member.at.cell)).map_or(known, |ground| ground.height_m);
            self.places.insert(number, Point { z, ..at });
        }
        self.team = Some(team.clone());
    }

    /// The prior of uncertain ground, of every cell.
    pub fn prior(&mut self, cells: &[PriorCell]) {
        self.prior = cells.to_vec();
    }

    /// Where the robot goes that announced it.
    pub fn announcement(&mut self, announcement: &Announcement) {
        let known = self.routes.get(&announcement.robot);
        if known.is_none_or(|route| route.id() != announcement.route.id()) {
            self.routes.insert(announcement.robot, announcement.route.clone());
            self.plan.has_changed = true;
        }
    }

    /// The policy that the next decision is made by.
    pub fn policy(&mut self, policy: Policy) {
        self.policy = Some(policy);
        self.plan.has_changed = true;
    }

    /// An executed decision, in the order of the decisions, with what the motion model told of it.
    pub fn record(&mut self, record: &Record, detail: Option<&Detail>) {
        let Some(brief) = &self.brief else { return };
        let trail = self.trails.entry(record.robot).or_default();
        match detail {
            Some(detail) => trail.add_way(record, detail),
            None => trail.add(brief, record),
        }
        self.route.has_changed = true;
    }

    /// A state of another decision: where the robots and their goals are.
    pub fn state(&mut self, state: &State) -> Vec<ViewMessage> {
        let Some(brief) = &self.brief else { return Vec::new() };
        let place = middle(brief, state.pose.cell, state.pose.height_m);
        let exact = self.team.as_ref().filter(|team| team.is_of(state)).and_then(|team| {
            let member = team.member(state.robot)?;
            member.travel.as_ref().map(|travel| at(travel.at))
        });
        let place = exact.map_or(place, |exact| Point { z: place.z, ..exact });
        self.places.insert(state.robot, place);
        (self.here, self.visits) = (state.pose.cell, state.visits);
        self.placed(brief, state)
    }

    /// Where exactly the robot of a state rests, metres.
    pub fn rest(&mut self, state: &State, [x, y, z]: [f64; 3]) -> Vec<ViewMessage> {
        let Some(brief) = &self.brief else { return Vec::new() };
        if !brief.grid.contains(state.pose.cell) {
            return Vec::new();
        }
        self.places.insert(state.robot, Point { x, y, z });
        self.placed(brief, state)
    }

    /// Where the robots are.
    fn placed(&self, brief: &Brief, state: &State) -> Vec<ViewMessage> {
        vec![
            (Channel::ViewTransforms, self.transforms(state.published).encode_to_vec(), state.published),
            (Channel::ViewRobots, self.robots(brief, state.published), state.published),
        ]
    }

    /// What is due to be drawn again at `now`, or all that has changed if the file ends.
    pub fn draw(&mut self, map: Option<&ObservedMap>, now: MonotonicNs, ends: bool) -> Vec<ViewMessage> {
        let Some(brief) = self.brief.clone() else { return Vec::new() };
        let mut messages = Vec::new();
        if let Some(map) = map {
            self.map.has_changed |= map.observation() != self.map.observation;
            let period_ns = PERIOD_NS + CELL_NS * map.seen_cells() as u64;
            if self.map.is_now(now, period_ns, ends) {
                self.map.observation = map.observation();
                messages.extend(relief(map));
            }
            messages.extend(self.speeds(map, now, ends));
            messages.extend(self.values(&brief, map, now, ends));
            if self.plan.is_now(now, PERIOD_NS, ends) {
                messages.push((Channel::ViewPlan, self.plan(&brief, map, now), now));
            }
        }
        if self.route.is_now(now, PERIOD_NS, ends) {
            messages.push((Channel::ViewRoute, self.route(now), now));
        }
        messages
    }

    /// Expected speeds and their spread, if they are due. Every cell has them, so on large maps they are seldom drawn.
    fn speeds(&mut self, map: &ObservedMap, now: MonotonicNs, ends: bool) -> Vec<ViewMessage> {
        let Some(brief) = &self.brief else { return Vec::new() };
        if self.prior.len() == map.grid.cells() {
            self.speeds = Some(Speeds::new(&self.prior, &brief.robots, &scales(brief)));
            (self.prior, self.speed.has_changed) = (Vec::new(), true);
        }
        let Some(speeds) = &self.speeds else { return Vec::new() };
        self.speed.has_changed |= map.observation() != self.speed.observation;
        if !self.speed.is_now(now, PERIOD_NS + 2 * CELL_NS * map.grid.cells() as u64, ends) {
            return Vec::new();
        }
        self.speed.observation = map.observation();
        let clouds = speeds.clouds(map, map.published).into_iter();
        clouds
            .map(|(layer, cloud)| (Channel::ViewLayer(layer), cloud.encode_to_vec(), map.published))
            .collect()
    }

    /// The layers with values of seen ground, if they are due.
    fn values(&mut self, brief: &Brief, map: &ObservedMap, now: MonotonicNs, ends: bool) -> Vec<ViewMessage> {
        self.values.has_changed |= map.observation() != self.values.observation;
        let period_ns = PERIOD_NS + CELL_NS * map.seen_cells() as u64;
        if !self.values.is_now(now, period_ns, ends) {
            return Vec::new();
        }
        self.values.observation = map.observation();
        let mut messages = Vec::new();
        for (layer, east_m) in scales(brief) {
            if let Some(scale) = layer.scale()
                && let Value::Ground { of, .. } = scale.value
            {
                let cloud = values::cloud(map, layer, &scale, of, east_m);
                messages.push((Channel::ViewLayer(layer), cloud.encode_to_vec(), map.published));
            }
        }
        messages
    }

    fn transforms(&self, moment: MonotonicNs) -> FrameTransforms {
        let transform = |(robot, at): (&RobotId, &Point)| FrameTransform {
            timestamp: stamp(moment),
            parent_frame_id: FRAME.into(),
            child_frame_id: format!("r{robot}"),
            translation: Some(Vector3 { x: at.x, y: at.y, z: at.z }),
            rotation: unturned(),
        };
        FrameTransforms { transforms: self.places.iter().map(transform).collect() }
    }

    fn robots(&self, brief: &Brief, moment: MonotonicNs) -> Vec<u8> {
        let height_m = marker_m(brief);
        let mut cloud = Cloud::default();
        for (robot, place) in &self.places {
            let flies = brief.robots.at(*robot).is_some_and(|robot| !robot.body.is_on_ground());
            let lift_m = if flies { height_m } else { 0.0 };
            markers::robot(&mut cloud, Point { z: place.z + lift_m, ..*place }, robot.0, height_m);
        }
        let here = self.places.values().next().map_or(0.0, |place| place.z);
        for goal in self.goals(brief) {
            markers::goal(&mut cloud, Point { z: here, ..goal }, height_m);
        }
        cloud.into_message(moment).encode_to_vec()
    }

    /// Where robots are to go; in a hopper's mission, only the goal in force. Robots that cover ground or look ahead have no such place.
    fn goals(&self, brief: &Brief) -> Vec<Point> {
        if brief.account == Account::Hopper {
            let goal = brief.goal_after(self.visits);
            return goal.into_iter().map(|goal| middle(brief, goal, 0.0)).collect();
        }
        let goals = brief.robots.iter().flat_map(|robot| robot.goal.points(&brief.grid));
        goals.map(at).collect()
    }

    fn route(&self, now: MonotonicNs) -> Vec<u8> {
        let points = self.trails.values().map(|trail| trail.points().len()).sum();
        let mut cloud = Cloud::with(["robot", "strayed"], points);
        for (robot, trail) in &self.trails {
            let colours = colour::ROBOTS[usize::from(robot.0) % colour::ROBOTS.len()];
            let own = if self.trails.len() == 1 { colour::rgb(colour::ROUTE) } else { colours };
            for (point, ink) in trail.points() {
                let shade = match (ink.part, ink.strayed) {
                    (Part::Flight, false) => own,
                    (Part::Flight, true) => colour::rgb(colour::STRAY),
                    (Part::Rolled, _) => colour::rgb(colour::ROLLED),
                    (Part::Impact, _) => colour::rgb(colour::IMPACT),
                };
                cloud.push_with(*point, shade, [robot.0.min(255) as u8, u8::from(ink.strayed)]);
            }
        }
        cloud.into_message(now).encode_to_vec()
    }

    /// The policy's arrows, and the routes that were announced.
    fn plan(&self, brief: &Brief, map: &ObservedMap, now: MonotonicNs) -> Vec<u8> {
        let mut cloud = Cloud::default();
        if let Some(policy) = &self.policy {
            arrows::arrows(&mut cloud, brief, map, policy, self.here);
        }
        for (robot, route) in &self.routes {
            let shade = colour::ROBOTS[usize::from(robot.0) % colour::ROBOTS.len()];
            for leg in route.waypoints().windows(2) {
                let cells = leg[0].distance_m(leg[1]) / brief.grid.cell_size_m;
                let count = (cells * ROUTE_POINTS_PER_CELL).ceil().clamp(1.0, 256.0) as u32;
                for n in 0..count {
                    let point = between(at(leg[0]), at(leg[1]), f64::from(n) / f64::from(count));
                    let cell = |metres: f64| (metres / brief.grid.cell_size_m).floor() as i32;
                    let ground = map.ground(Cell { x: cell(point.x), y: cell(point.y) });
                    let z = ground.map_or(0.0, |ground| ground.height_m) + 0.2 * brief.grid.cell_size_m;
                    cloud.push(Point { z, ..point }, shade);
                }
            }
        }
        cloud.into_message(now).encode_to_vec()
    }
}

/// The layers of a mission with a scale, each with how far to the east of the map it lies, metres.
fn scales(brief: &Brief) -> Vec<(Layer, f64)> {
    super::scales(&Layer::of(brief), Layer::first(brief), &brief.grid)
}

/// The relief, which every map has.
fn relief(map: &ObservedMap) -> impl Iterator<Item = ViewMessage> {
    let reliefs = Layer::ALL.iter().filter(|layer| matches!(layer.definition().look, Look::Relief));
    reliefs.map(|layer| (Channel::ViewLayer(*layer), ground::ground(map).encode_to_vec(), map.published))
}

/// Height of a robot's marker, metres.
fn marker_m(brief: &Brief) -> f64 {
    let side_m = f64::from(brief.grid.width.max(brief.grid.height)) * brief.grid.cell_size_m;
    (MARKER_CELLS * brief.grid.cell_size_m).max(MARKER_SHARE * side_m)
}

fn at(waypoint: Waypoint) -> Point {
    Point { x: waypoint.x_m, y: waypoint.y_m, z: 0.0 }
}
