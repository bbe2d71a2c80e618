//! One life of one simulated process, from its start to its death.

use std::cell::{Cell, RefCell};
use std::collections::BTreeMap;
use std::rc::Rc;

use contract::{
    Command, Decision, Incarnation, Leader, MapPatch, Member, MonotonicNs, Name, RobotId, RobotSet, Role,
    RunId, State, Team, Term,
};

use crate::observed::Seen;
use crate::setup;
use crate::stream::Stream;

/// One life of one process, as the operating system sees it.
#[derive(Debug)]
pub(crate) struct Life {
    pub slot: usize,
    pub role: Role,
    pub incarnation: Incarnation,
    pub pid: u32,
    pub version: Name,
    /// Takes every process for gone, as one in another container would.
    pub blind: bool,
    /// Of a planner: the robots that it serves, and whether it can plan for all of them.
    pub robots: RobotSet,
    pub is_suited: bool,
    /// Of a planner: told to take over at once, and whose successor it is.
    pub takeover: bool,
    pub succeeds_pid: Option<u32>,
    /// When the present sleep ends.
    pub wakes_at: Cell<Option<u64>>,
    pub sleeping: Cell<bool>,
    pub woken: Cell<bool>,
    /// Whether a message came that wakes, while the process was at work.
    pub rung: Cell<bool>,
    pub computed: Cell<bool>,
    pub stopped_until: Cell<Option<u64>>,
    /// Set by a fault that kills it where it is: until it is started again, nanoseconds.
    pub dies: Cell<Option<u64>>,
    /// Of a planner: what it was last given to plan for.
    pub situation: Seen,
    /// Of a monitor that records: the recording so far.
    pub recording: RefCell<Option<Rc<RefCell<Vec<u8>>>>>,
    /// Turns of its work loop so far.
    pub turns: Cell<u64>,
    /// Of a planner: the run whose map it holds.
    pub map_whole: Cell<Option<RunId>>,
    /// Of a planner: whether a patch reached it late, twice, out of order or not at all, or a landing was in no patch.
    pub map_disturbed: Cell<bool>,
    /// Of a planner: whether a request for prior or route, or the answer, was lost or late, so that it may have to ask again.
    pub answers_disturbed: Cell<bool>,
    /// When that of the map was last the case, since the simulation began, nanoseconds.
    pub disturbed_ns: Cell<Option<u64>>,
    /// When a patch was last sent to it twice, since the simulation began, nanoseconds.
    pub repeated_ns: Cell<Option<u64>>,
    /// Of a planner that asks for the map: the pass over its pages, from the first to the last.
    pub pass: Cell<Pass>,
    /// Of a planner: the state it knows, as (run, decision, published), and who leads there since when.
    pub state_seen: Cell<Option<(RunId, Decision, MonotonicNs)>>,
    pub leader_seen: Cell<(Leader, MonotonicNs)>,
    /// Who led there when its present turn began, with the number of the turn: of several states only the last counts.
    pub leader_at_turn: Cell<(u64, (Leader, MonotonicNs))>,
    /// Of a planner of rovers: the decision of the robots it knows, and who leads each since when.
    pub team_seen: RefCell<Option<TeamSeen>>,
    /// When it first heard that somebody leads a robot in some term.
    pub leaders_seen: RefCell<BTreeMap<(RunId, RobotId, Term, Incarnation), MonotonicNs>>,
    /// Since when it has listened without a break, and when it began its last turn.
    pub listening_since: Cell<MonotonicNs>,
    pub turned_at: Cell<MonotonicNs>,
    /// Of a planner: plans that take longer than usual, and how long, nanoseconds.
    pub slow: Cell<(u64, u64)>,
    /// Of a process that stays: the runs it has seen the state of.
    pub runs: RefCell<Vec<RunId>>,
    /// When the message came that ends the present sleep.
    pub message_since: Cell<Option<u64>>,
    /// Sleeps during which a message came that the process waits for, and how many of them went on.
    pub sleeps: Cell<(u64, u64)>,
    /// Of hopper-sim: commands received, and commands executed.
    pub commands: Cell<(u64, u64)>,
}

/// The decision of the robots that are known, and who leads each since when.
type TeamSeen = (RunId, Decision, Vec<(Leader, MonotonicNs)>);

/// How far a planner has come over the pages of the map.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) enum Pass {
    /// It has no page, or has begun again.
    #[default]
    None,
    /// It has received pages, but not the last; whether nothing was disturbed shortly before or since.
    Under { is_clean: bool },
    /// It has received the last page; whether nothing was disturbed but that patches came twice, and in which turn it was.
    Over { is_clean: bool, turn: u64 },
}

impl Life {
    /// The life with that number in a slot, of this build; the plans of a planner take as long as `slow` says.
    pub fn new(slot: usize, role: Role, incarnation: Incarnation, slow: (u64, u64)) -> Self {
        Self {
            slot,
            role,
            incarnation,
            pid: incarnation.0 as u32 + 1000,
            version: setup::version(),
            blind: false,
            robots: RobotSet::NONE,
            is_suited: false,
            takeover: false,
            succeeds_pid: None,
            wakes_at: Cell::new(None),
            sleeping: Cell::new(false),
            woken: Cell::new(false),
            rung: Cell::new(false),
            computed: Cell::new(false),
            stopped_until: Cell::new(None),
            dies: Cell::new(None),
            situation: Seen::default(),
            recording: RefCell::new(None),
            turns: Cell::new(0),
            map_whole: Cell::new(None),
            map_disturbed: Cell::new(false),
            answers_disturbed: Cell::new(false),
            disturbed_ns: Cell::new(None),
            repeated_ns: Cell::new(None),
            pass: Cell::default(),
            state_seen: Cell::new(None),
            leader_seen: Cell::default(),
            leader_at_turn: Cell::default(),
            team_seen: RefCell::default(),
            leaders_seen: RefCell::default(),
            listening_since: Cell::default(),
            turned_at: Cell::default(),
            slow: Cell::new(slow),
            runs: RefCell::default(),
            message_since: Cell::new(None),
            sleeps: Cell::new((0, 0)),
            commands: Cell::new((0, 0)),
        }
    }

    /// A message about the map was or may have been lost, repeated or late.
    pub fn disturb_map(&self, now_ns: u64) {
        self.map_disturbed.set(true);
        self.disturbed_ns.set(Some(now_ns));
        self.pass.set(match self.pass.get() {
            Pass::None => Pass::None,
            Pass::Under { .. } => Pass::Under { is_clean: false },
            Pass::Over { turn, .. } => Pass::Over { is_clean: false, turn },
        });
    }

    /// A patch comes twice. Its second copy may be taken for a gap once the map is whole, but spoils no pass over the pages.
    pub fn repeat_patch(&self, now_ns: u64) {
        self.map_disturbed.set(true);
        self.repeated_ns.set(Some(now_ns));
    }

    /// What is known of the robots' leaders from `team` on, which has come at `now`. Who led before, and leads again by a
    /// message that was late or after a journal lost its tail, is known since the first time.
    pub fn knows_team(&self, team: &Team, now: MonotonicNs) {
        let mut known = self.leaders_seen.borrow_mut();
        let since = |(robot, member): (u16, &Member)| {
            let Leader { term, incarnation, .. } = member.leader;
            (member.leader, *known.entry((team.run, RobotId(robot), term, incarnation)).or_insert(now))
        };
        let leaders = (0..).zip(team.members.iter()).map(since).collect();
        self.team_seen.replace(Some((team.run, team.decision, leaders)));
    }

    /// Who leads the robot of `command`, and since when, by the message about the robots that it answers.
    pub fn leader_in_team(&self, command: &Command) -> Option<(Leader, MonotonicNs)> {
        let seen = self.team_seen.borrow();
        let (run, decision, leaders) = seen.as_ref()?;
        if (*run, *decision) != (command.run, command.decision) {
            return None;
        }
        leaders.get(usize::from(command.robot.0)).copied()
    }

    /// Whether it could plan for `decision` of the run, and sits idle instead.
    pub fn sits_idle(&self, run: RunId, decision: Decision) -> bool {
        let knows = self.state_seen.get().is_some_and(|(of, due, _)| (of, due) == (run, decision));
        let has_map = self.map_whole.get() == Some(run) && !self.map_disturbed.get();
        let can_plan = knows && has_map && !self.answers_disturbed.get() && self.is_suited;
        can_plan && self.sleeping.get() && self.stopped_until.get().is_none()
    }

    /// Whether a message of `stream` is to wake this process: the pipeline from state to map to command.
    pub fn waits_for(&self, stream: Stream) -> bool {
        match self.role {
            Role::HopperSim => stream == Stream::of::<Command>(),
            Role::Perception => stream == Stream::of::<State>(),
            Role::Planner => stream == Stream::of::<MapPatch>(),
            Role::Monitor => false,
        }
    }
}
