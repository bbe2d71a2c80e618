//! The moments of a mission at which robots rest.

use std::collections::BTreeMap;

use contract::{
    Brief, Decision, Detail, Direction, MonotonicNs, ObservedMap, Record, RobotId, RunId, State, Team,
    Waypoint,
};

use crate::message::Pose;

/// A moment at which all robots rest: before the first decision, and after each.
#[derive(Clone, Debug, PartialEq)]
pub struct Landing {
    /// What the last decision led to; where the recording has no state, what the journal's record says.
    pub state: State,
    /// When the robot of the state came to rest.
    pub moment: MonotonicNs,
    /// Where each robot is, in the order of their numbers.
    pub poses: Vec<Pose>,
}

/// What was recorded of one run, by decision.
#[derive(Clone, Debug, Default)]
pub(crate) struct Decisions {
    pub states: BTreeMap<Decision, State>,
    pub records: BTreeMap<Decision, Record>,
    pub teams: BTreeMap<Decision, Team>,
    pub details: BTreeMap<Decision, Detail>,
}

impl Decisions {
    /// The record of the decision that led to `state`.
    pub fn before(&self, state: &State) -> Option<&Record> {
        let decision = state.decision.0.checked_sub(1).map(Decision)?;
        self.records.get(&decision).filter(|record| record.digest == state.digest)
    }

    /// The robots at `state`, if they were recorded.
    pub fn team(&self, state: &State) -> Option<&Team> {
        self.teams.get(&state.decision).filter(|team| team.is_of(state))
    }

    /// What the motion model told of the decision that led to `state`.
    pub fn detail(&self, state: &State) -> Option<&Detail> {
        let record = self.before(state)?;
        self.details.get(&record.decision).filter(|detail| detail.id() == record.detail)
    }

    /// All landings, in the order of their decisions. `map` is the last of the run: robots that have not acted stand on it.
    pub fn landings(&self, brief: &Brief, map: &ObservedMap) -> Vec<Landing> {
        let mut states = self.states.clone();
        for record in self.records.values() {
            let next = record.decision.next();
            if states.get(&next).is_none_or(|state| state.digest != record.digest) {
                states.insert(next, self.state_of(record, brief.run));
            }
        }
        let mut poses: Vec<Pose> =
            brief.robots.iter().map(|robot| standing(map, robot.start_at, 0.0)).collect();
        let mut landings = Vec::new();
        for state in states.into_values() {
            self.place(brief, &state, map, &mut poses);
            landings.push(Landing { moment: state.landed, poses: poses.clone(), state });
        }
        // Landings of an earlier boot of the machine have times of another clock.
        let mut latest = MonotonicNs(u64::MAX);
        for landing in landings.iter_mut().rev() {
            landing.moment = landing.moment.min(latest);
            latest = landing.moment;
        }
        landings
    }

    /// The state that `record` led to. It landed when the next decision says, or right when it was journalled.
    fn state_of(&self, record: &Record, run: RunId) -> State {
        let next = self.records.get(&record.decision.next());
        let landed = next.map_or(record.timing.committed, |next| next.timing.landed);
        record.state_after(run, landed, landed)
    }

    /// Moves the robots to where they are at `state`.
    fn place(&self, brief: &Brief, state: &State, map: &ObservedMap, poses: &mut [Pose]) {
        let team = self.team(state);
        for ((number, robot), pose) in brief.robots.numbered().zip(poses.iter_mut()) {
            let member = team.and_then(|team| team.member(number));
            let yaw_rad = match member {
                Some(member) if !robot.body.hops() => yaw_rad(member.at.heading),
                Some(_) => 0.0,
                None if robot.body.hops() => 0.0,
                None => yaw_rad(robot.start.heading),
            };
            let travelled = member.and_then(|member| member.travel.as_ref()).map(|travel| travel.at);
            if number == state.robot {
                *pose = self.acted(brief, state, travelled, yaw_rad);
            } else if let Some(at) = travelled {
                *pose = standing(map, at, yaw_rad);
            } else if member.is_some() || state.decision == Decision(0) {
                let [x, y, z] = [pose.position.x, pose.position.y, pose.position.z];
                *pose = Pose::at([x, y, z], yaw_rad);
            }
        }
    }

    /// The pose of the robot that acted last: exactly where it rests, as far as that is told.
    fn acted(&self, brief: &Brief, state: &State, travelled: Option<Waypoint>, yaw_rad: f64) -> Pose {
        if let Some(detail) = self.detail(state) {
            return Pose::at(detail.rest_m, yaw_rad);
        }
        let start = brief.robots.at(state.robot).filter(|_| state.decision == Decision(0));
        let told = travelled.or(start.map(|robot| robot.start_at));
        let at = told.unwrap_or_else(|| Waypoint::middle_of(&brief.grid, state.pose.cell));
        Pose::at([at.x_m, at.y_m, state.pose.height_m], yaw_rad)
    }
}

impl Landing {
    /// The robots that this landing moved: the one that acted, before the first decision all.
    pub(crate) fn actors(&self) -> impl Iterator<Item = (RobotId, &Pose)> {
        let is_actor = |robot: RobotId| self.state.decision == Decision(0) || robot == self.state.robot;
        (0..).map(RobotId).zip(&self.poses).filter(move |(robot, _)| is_actor(*robot))
    }
}

/// On the ground at a point; at the datum where nothing is known of the ground.
fn standing(map: &ObservedMap, at: Waypoint, yaw_rad: f64) -> Pose {
    let height_m = map.ground(at.cell_of(&map.grid)).map_or(0.0, |ground| ground.height_m);
    Pose::at([at.x_m, at.y_m, height_m], yaw_rad)
}

/// Counter-clockwise from east, radians.
fn yaw_rad(heading: Direction) -> f64 {
    use std::f64::consts::{FRAC_PI_2, PI};
    match heading {
        Direction::East => 0.0,
        Direction::North => FRAC_PI_2,
        Direction::West => PI,
        Direction::South => -FRAC_PI_2,
    }
}
