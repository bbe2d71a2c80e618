//! The robots of a mission that is not a single hopper's, as the checker knows them.

use contract::{
    Action, Brief, Decision, Digest, Leader, Origin, Record, RobotId, RunId, State, Team, Vetoed,
};
use hopper_sim::Mission;
use hopper_sim::dynamics::Execution;
use terrain::Terrain;

use crate::expected::Expected;
use crate::rovers::Rovers;
use crate::scouts::Scouts;

/// The robots after some decisions.
#[derive(Clone, Debug)]
pub(crate) enum Robots {
    /// They cover ground.
    Rovers(Rovers),
    /// A rover drives to a goal, or a hopper hops, and helicopters look ahead for it.
    Scouts(Box<Scouts>),
}

impl Robots {
    /// Before the first decision; `None` if the mission is that of a hopper that is alone.
    pub fn begin(mission: &Mission) -> Option<Self> {
        let scouts = Scouts::begin(mission).map(|scouts| Self::Scouts(Box::new(scouts)));
        scouts.or_else(|| Rovers::begin(mission).map(Self::Rovers))
    }

    /// Those of a mission with helicopters.
    pub fn scouts(&self) -> Option<&Scouts> {
        match self {
            Self::Rovers(_) => None,
            Self::Scouts(scouts) => Some(scouts),
        }
    }

    /// As [`Robots::scouts`].
    pub fn scouts_mut(&mut self) -> Option<&mut Scouts> {
        match self {
            Self::Rovers(_) => None,
            Self::Scouts(scouts) => Some(scouts),
        }
    }

    /// Who acts next; once nobody does, who acted last.
    pub fn due(&self) -> RobotId {
        match self {
            Self::Rovers(rovers) => rovers.due(),
            Self::Scouts(scouts) => scouts.due(),
        }
    }

    pub fn leader(&self, robot: RobotId) -> Leader {
        match self {
            Self::Rovers(rovers) => rovers.leader(robot),
            Self::Scouts(scouts) => scouts.leader(robot),
        }
    }

    /// What the guard should veto of the robot that is due.
    pub fn blocked(&self, mission: &Mission) -> Vetoed {
        match self {
            Self::Rovers(rovers) => rovers.blocked(mission),
            Self::Scouts(scouts) => scouts.blocked(),
        }
    }

    /// An action that the guard should veto, if there is one.
    pub fn blocked_action(&self, mission: &Mission) -> Option<Action> {
        match self {
            Self::Rovers(rovers) => rovers.blocked_step(mission),
            Self::Scouts(scouts) => scouts.blocked().has(Action::Drive).then_some(Action::Drive),
        }
    }

    /// What is done at the deadline.
    pub fn fallback(&self) -> (Action, Origin) {
        match self {
            Self::Rovers(_) => (Action::Hold, Origin::Hold),
            Self::Scouts(scouts) => scouts.fallback(),
        }
    }

    /// How the due robot's `action` comes out; `None` if it must be refused.
    pub fn execute(&self, mission: &Mission, before: &State, action: Action) -> Option<(RobotId, Execution)> {
        match self {
            Self::Rovers(rovers) => rovers.execute(mission, action),
            Self::Scouts(scouts) => scouts.execute(mission, before, action),
        }
    }

    /// A record was committed.
    pub fn committed(&mut self, mission: &Mission, record: &Record) {
        match self {
            Self::Rovers(rovers) => rovers.committed(mission, record),
            Self::Scouts(scouts) => scouts.committed(record),
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
        }
    }

    /// The message about all robots as of the state of `decision` with `digest`.
    pub fn team(&self, run: RunId, decision: Decision, digest: Digest) -> Team {
        match self {
            Self::Rovers(rovers) => rovers.team(run, decision, digest),
            Self::Scouts(scouts) => scouts.team(run, decision, digest),
        }
    }
}
