//! The robots of a mission that is not a single hopper's, as the checker knows them.

use contract::{
    Action, Announcement, Brief, Decision, Digest, Leader, Origin, Record, RobotId, RunId, State, Team,
    Vetoed,
};
use hopper_sim::Mission;
use hopper_sim::dynamics::Execution;
use terrain::Terrain;

use crate::expected::Expected;
use crate::rovers::Rovers;
use crate::scouts::Scouts;
use crate::scouts::mixed::Mixed;

/// The robots after some decisions.
#[derive(Clone, Debug)]
pub(crate) enum Robots {
    /// They cover ground.
    Rovers(Rovers),
    /// A rover drives to a goal, or a hopper hops, and helicopters look ahead for it.
    Scouts(Box<Scouts>),
    /// Each has a task of its own.
    Mixed(Box<Mixed>),
}

impl Robots {
    /// Before the first decision; `None` if the mission is that of a hopper that is alone.
    pub fn begin(mission: &Mission) -> Option<Self> {
        if let Some(mixed) = Mixed::begin(mission) {
            return Some(Self::Mixed(Box::new(mixed)));
        }
        let scouts = Scouts::begin(mission).map(|scouts| Self::Scouts(Box::new(scouts)));
        scouts.or_else(|| Rovers::begin(mission).map(Self::Rovers))
    }

    /// The robots of a mixed mission; `None` in other missions.
    pub fn mixed(&self) -> Option<&Mixed> {
        match self {
            Self::Mixed(mixed) => Some(mixed),
            Self::Rovers(_) | Self::Scouts(_) => None,
        }
    }

    /// The robots that go from point to point; `None` in a mission without any.
    pub fn scouts(&self) -> Option<&Scouts> {
        match self {
            Self::Rovers(_) => None,
            Self::Scouts(scouts) => Some(scouts),
            Self::Mixed(mixed) => Some(mixed.scouts()),
        }
    }

    /// As [`Robots::scouts`].
    pub fn scouts_mut(&mut self) -> Option<&mut Scouts> {
        match self {
            Self::Rovers(_) => None,
            Self::Scouts(scouts) => Some(scouts),
            Self::Mixed(mixed) => Some(mixed.scouts_mut()),
        }
    }

    /// A planner publishes the points of a route.
    pub fn announce(&mut self, announcement: &Announcement) {
        if let Some(scouts) = self.scouts_mut() {
            scouts.announce(announcement);
        }
    }

    /// Who acts next; once nobody does, who acted last.
    pub fn due(&self) -> RobotId {
        match self {
            Self::Rovers(rovers) => rovers.due(),
            Self::Scouts(scouts) => scouts.due(),
            Self::Mixed(mixed) => mixed.scouts().due(),
        }
    }

    pub fn leader(&self, robot: RobotId) -> Leader {
        match self {
            Self::Rovers(rovers) => rovers.leader(robot),
            Self::Scouts(scouts) => scouts.leader(robot),
            Self::Mixed(mixed) => mixed.leader(robot),
        }
    }

    /// Simulated time from the beginning of the last action to that of the next, nanoseconds.
    pub fn lasts_ns(&self) -> u64 {
        match self {
            Self::Rovers(rovers) => rovers.lasts_ns(),
            Self::Scouts(scouts) => scouts.lasts_ns(),
            Self::Mixed(mixed) => mixed.scouts().lasts_ns(),
        }
    }

    /// What the guard should veto of the robot that is due; of a hopper, only that others are where it would go.
    pub fn blocked(&self, mission: &Mission) -> Vetoed {
        match self {
            Self::Rovers(rovers) => rovers.blocked(mission),
            Self::Scouts(scouts) => scouts.blocked(),
            Self::Mixed(mixed) => mixed.blocked(mission),
        }
    }

    /// An action that the guard should veto, if there is one.
    pub fn blocked_action(&self, mission: &Mission) -> Option<Action> {
        match self {
            Self::Rovers(rovers) => rovers.blocked_step(mission),
            Self::Scouts(scouts) => scouts.blocked().has(Action::Drive).then_some(Action::Drive),
            Self::Mixed(mixed) => mixed.blocked_action(mission),
        }
    }

    /// What is done at the deadline.
    pub fn fallback(&self, mission: &Mission) -> (Action, Origin) {
        match self {
            Self::Rovers(_) => (Action::Hold, Origin::Hold),
            Self::Scouts(scouts) => scouts.fallback(),
            Self::Mixed(mixed) => mixed.fallback(mission),
        }
    }

    /// How the due robot's `action` comes out; `None` if it must be refused.
    pub fn execute(&self, mission: &Mission, before: &State, action: Action) -> Option<(RobotId, Execution)> {
        match self {
            Self::Rovers(rovers) => rovers.execute(mission, action),
            Self::Scouts(scouts) => scouts.execute(mission, before, action),
            Self::Mixed(mixed) => mixed.execute(mission, before, action),
        }
    }

    /// A record was committed.
    pub fn committed(&mut self, mission: &Mission, record: &Record) {
        match self {
            Self::Rovers(rovers) => rovers.committed(mission, record),
            Self::Scouts(scouts) => scouts.committed(record),
            Self::Mixed(mixed) => mixed.committed(mission, record),
        }
    }

    /// What all see from their starts.
    pub fn open(&self, brief: &Brief, terrain: &Terrain, expected: &mut Expected) {
        match self {
            Self::Rovers(rovers) => expected.enter(brief, terrain, &rovers.views()),
            Self::Scouts(scouts) => {
                expected.reveal(brief, terrain, scouts.shown());
                if let Some(start) = scouts.hopper_start(terrain) {
                    expected.land(brief, terrain, start);
                }
            }
            Self::Mixed(mixed) => {
                mixed.rover_starts().for_each(|cell| expected.visit(brief, cell));
                expected.reveal(brief, terrain, mixed.scouts().shown());
            }
        }
    }

    /// Whether it is the turn of a hopper, which is guarded as one that is alone.
    pub fn is_turn_of_hopper(&self) -> bool {
        self.scouts().is_some_and(|scouts| scouts.is_hopper(scouts.due()))
    }

    /// What is seen after `record`, which was committed.
    pub fn see(&self, brief: &Brief, terrain: &Terrain, record: &Record, expected: &mut Expected) {
        match self {
            Self::Rovers(rovers) => expected.enter(brief, terrain, rovers.view_after(record).as_slice()),
            Self::Scouts(scouts) if scouts.is_hopper(record.robot) => {
                expected.land(brief, terrain, record.pose)
            }
            Self::Scouts(scouts) => expected.reveal(brief, terrain, scouts.shown()),
            Self::Mixed(mixed) => {
                mixed.entered(record).into_iter().for_each(|cell| expected.visit(brief, cell));
                expected.reveal(brief, terrain, mixed.scouts().shown());
                if mixed.scouts().is_hopper(record.robot) {
                    expected.collect(record.pose.cell);
                }
            }
        }
    }

    /// The message about all robots as of the state of `decision` with `digest`.
    pub fn team(&self, run: RunId, decision: Decision, digest: Digest) -> Team {
        match self {
            Self::Rovers(rovers) => rovers.team(run, decision, digest),
            Self::Scouts(scouts) => scouts.team(run, decision, digest),
            Self::Mixed(mixed) => mixed.team(run, decision, digest),
        }
    }
}
