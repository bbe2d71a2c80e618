//! The robots of a mission, whatever they are to do: whose turn it is, where each stands, who commands it.

use contract::{
    Action, Brief, Cell, Decision, Leader, Member, Placement, Robot, RobotId, Standing, State, Team, Travel,
};
use scenario::Fault;

use super::turn_order::{Due, Readiness, TurnOrder};

/// All robots, in the order of their numbers.
#[derive(Clone, Debug)]
pub struct Roster {
    order: TurnOrder,
    entries: Vec<Entry>,
    /// Actions of a robot after which the mission is a deadlock.
    actions_max: u64,
    /// The robot that acted last.
    actor: Option<RobotId>,
    /// When the last action began, nanoseconds of simulated time.
    acted_at_ns: u64,
}

/// What holds of a robot of any kind.
#[derive(Clone, Copy, Debug)]
pub struct Entry {
    pub robot: Robot,
    pub at: Placement,
    pub standing: Standing,
    leader: Leader,
    /// The last decision that was its turn.
    pub last: Option<Decision>,
    actions: u64,
    /// Actions by which it waited for others.
    waits: u64,
    /// The number of the action, from 1, at which it fails.
    fails_at: Option<u64>,
}

/// What a robot does at a decision, and under whom.
#[derive(Clone, Copy, Debug)]
pub struct Act {
    pub robot: RobotId,
    pub decision: Decision,
    pub leader: Leader,
    pub action: Action,
}

/// What a turn does to the order of the next ones.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Turn {
    /// The robot is busy for so many nanoseconds of simulated time.
    Lasts(u64),
    /// It waits for another one to act.
    Waits,
    /// It acts no more.
    Ends,
}

impl Roster {
    /// The robots before their first action; some will fail.
    #[must_use]
    pub fn new(brief: &Brief, faults: &[Fault]) -> Self {
        let entry = |(number, robot): (u16, &Robot)| Entry {
            robot: *robot,
            at: robot.start,
            standing: Standing::Active,
            leader: Leader::default(),
            last: None,
            actions: 0,
            waits: 0,
            fails_at: faults.iter().find(|fault| fault.robot == RobotId(number)).map(|fault| fault.action),
        };
        let entries: Vec<Entry> = (0..).zip(brief.robots.iter()).map(entry).collect();
        let order = TurnOrder::new(entries.len() as u16);
        Self { order, entries, actions_max: brief.limits.steps_max, actor: None, acted_at_ns: 0 }
    }

    /// Whose turn it is; `None` once nobody acts any more.
    #[must_use]
    pub fn due(&self) -> Option<RobotId> {
        match self.order.due() {
            Due::Robot(robot) => Some(robot),
            Due::Deadlock | Due::AllDone => None,
        }
    }

    /// How many there are.
    #[must_use]
    pub fn count(&self) -> u16 {
        self.entries.len() as u16
    }

    /// What holds of `robot`.
    ///
    /// # Panics
    /// If the mission has no such robot; so for all robots named here.
    #[must_use]
    pub fn entry(&self, robot: RobotId) -> &Entry {
        &self.entries[usize::from(robot.0)]
    }

    /// All of them, in the order of their numbers.
    pub fn entries(&self) -> impl Iterator<Item = (RobotId, &Entry)> {
        (0..).map(RobotId).zip(&self.entries)
    }

    /// A robot other than `robot` that takes up `cell`, if one does.
    #[must_use]
    pub fn other_on_ground(&self, robot: RobotId, cell: Cell) -> Option<RobotId> {
        let others = self.entries().filter(|(other, _)| *other != robot);
        let mut there = others.filter(|(_, entry)| entry.at.cell == cell && entry.robot.body.is_on_ground());
        there.next().map(|(other, _)| other)
    }

    /// Who commands `robot`.
    #[must_use]
    pub fn leader(&self, robot: RobotId) -> Leader {
        self.entry(robot).leader
    }

    /// Whether `robot` fails at its next action.
    #[must_use]
    pub fn fails_now(&self, robot: RobotId) -> bool {
        let entry = self.entry(robot);
        entry.fails_at == Some(entry.actions + 1)
    }

    /// Actions of `robot` so far.
    #[must_use]
    pub fn actions(&self, robot: RobotId) -> u64 {
        self.entry(robot).actions
    }

    /// Whether `robot` has used up its actions. To wait for others uses up none.
    #[must_use]
    pub fn is_spent(&self, robot: RobotId) -> bool {
        let entry = self.entry(robot);
        entry.actions - entry.waits >= self.actions_max
    }

    /// Actions of the robot that has acted most.
    #[must_use]
    pub fn steps(&self) -> u64 {
        self.entries.iter().map(|entry| entry.actions).max().unwrap_or_default()
    }

    /// The most actions of a robot, not counting those by which it waited for others.
    #[must_use]
    pub fn steps_without_waits(&self) -> u64 {
        self.entries.iter().map(|entry| entry.actions - entry.waits).max().unwrap_or_default()
    }

    /// Simulated time from the beginning of the last action to that of the next, nanoseconds: less than the action lasts if
    /// another robot acts meanwhile.
    #[must_use]
    pub fn elapsed_ns(&self) -> u64 {
        let next = self.due().or(self.actor).map(|robot| self.order.ready_at_ns(robot));
        next.map_or(0, |next_ns| next_ns.saturating_sub(self.acted_at_ns))
    }

    /// The robot whose turn it was has acted.
    ///
    /// # Panics
    /// If it was another robot's turn.
    pub fn act(&mut self, act: &Act, turn: Turn) {
        let Act { robot, decision, leader, .. } = *act;
        self.acted_at_ns = self.order.ready_at_ns(robot);
        match turn {
            Turn::Lasts(ns) => self.order.act(robot, ns),
            Turn::Waits => self.order.park(robot),
            Turn::Ends => self.give_up(robot),
        }
        self.actor = Some(robot);
        let entry = self.entry_mut(robot);
        (entry.last, entry.leader) = (Some(decision), leader);
        entry.actions += 1;
        entry.waits += u64::from(turn == Turn::Waits);
    }

    /// `robot`, a hopper alone, has acted so often before.
    pub fn resume(&mut self, robot: RobotId, actions: u64) {
        self.entry_mut(robot).actions = actions;
    }

    /// Puts `robot` elsewhere.
    pub fn place(&mut self, robot: RobotId, at: Placement) {
        self.entry_mut(robot).at = at;
    }

    /// When `robot` is ready to act, nanoseconds of simulated time since the mission began.
    #[must_use]
    pub fn ready_at_ns(&self, robot: RobotId) -> u64 {
        self.order.ready_at_ns(robot)
    }

    /// `robot` does not act before that moment.
    pub fn put_off(&mut self, robot: RobotId, ready_at_ns: u64) {
        self.order.put_off(robot, ready_at_ns);
    }

    /// `robot` acts no more, and is not where its task is done. A helicopter's never is.
    pub fn give_up(&mut self, robot: RobotId) {
        let is_on_ground = self.entry(robot).robot.body.is_on_ground();
        self.end(robot, if is_on_ground { Standing::GaveUp } else { Standing::Done });
    }

    /// `robot` acts no more, whoever's turn it is.
    pub fn end(&mut self, robot: RobotId, standing: Standing) {
        self.entry_mut(robot).standing = standing;
        self.order.finish(robot);
    }

    /// All of them, as published with `state`; `travel` is that of a robot which goes from point to point.
    #[must_use]
    pub fn team(&self, state: &State, travel: impl Fn(RobotId) -> Option<Travel>) -> Team {
        let member = |(robot, entry): (RobotId, &Entry)| Member {
            at: entry.at,
            ready_at_ns: self.order.ready_at_ns(robot),
            standing: entry.standing,
            leader: entry.leader,
            last: entry.last,
            waits: self.order.readiness(robot) == Readiness::Parked,
            travel: travel(robot),
        };
        Team {
            run: state.run,
            decision: state.decision,
            digest: state.digest,
            due: self.due().or(self.actor).unwrap_or_default(),
            actor: self.actor,
            members: self.entries().map(member).collect(),
        }
    }

    fn entry_mut(&mut self, robot: RobotId) -> &mut Entry {
        &mut self.entries[usize::from(robot.0)]
    }
}
