//! What every process does beside its own work: it beats, knows who lives, waits, and leaves in time.

use std::borrow::Cow;
use std::time::Duration;

use contract::protocol::peer_table::{BEAT_PERIOD_NS, SILENCE_NS};
use contract::{
    Decision, Heartbeat, MonotonicNs, Name, PeerTable, Refusal, RobotId, RobotSet, Role, RunId, Status,
};

use crate::{Builds, Failure, Patience, Ports, Reader, TICK_NS, Turn, Writer};

/// A peer that has seen the end of the mission goes on beating this long, so that hopper-sim hears it.
const FAREWELL_NS: u64 = 120_000_000;

/// A process that is still asked for something after the end, or may be, stays no longer than this.
const STAY_MAX_NS: u64 = 5_000_000_000;

/// How long a process waits and whether it stays.
#[derive(Clone, Copy, Debug, Default)]
pub struct Terms {
    /// Longest wait for a peer; `None` waits forever.
    pub wait: Option<Duration>,
    /// Stay when the mission has ended, ready for the next.
    pub stay: bool,
}

/// The membership of one process in its instance.
pub struct Membership<P: Ports> {
    writer: P::Writer<Heartbeat>,
    reader: P::Reader<Heartbeat>,
    last: Heartbeat,
    /// What the next heartbeat tells of robots: see [`Heartbeat::robots`].
    robots: RobotSet,
    sent: Option<MonotonicNs>,
    peer_table: PeerTable,
    builds: Builds,
    patience: Patience,
    stay: bool,
    joined: MonotonicNs,
    ended: Option<MonotonicNs>,
    /// When it was asked for something last, after the end.
    asked: Option<MonotonicNs>,
}

impl<P: Ports> Membership<P> {
    /// Joins in a role, as a planner with its algorithm's name; [`Name::NONE`] for others.
    ///
    /// # Errors
    /// If there is no place among those who beat.
    pub fn join(ports: &mut P, role: Role, planner: Name, terms: Terms) -> Result<Self, P::Error> {
        // Heartbeats are of the mission, not of one robot.
        let robot = RobotId(0);
        Ok(Self {
            writer: ports.writer(robot)?,
            reader: ports.reader(robot, false)?,
            last: Heartbeat {
                role,
                incarnation: ports.incarnation(),
                pid: ports.pid(),
                version: ports.version(),
                planner,
                counter: 0,
                run: RunId(0),
                decision: Decision(0),
                status: Status::Underway,
                robots: RobotSet::NONE,
            },
            robots: RobotSet::NONE,
            sent: None,
            peer_table: PeerTable::default(),
            builds: Builds::new(ports.version()),
            patience: Patience::new(terms.wait),
            stay: terms.stay,
            joined: ports.now(),
            ended: None,
            asked: None,
        })
    }

    /// The next heartbeat of a peer of this build, or the refusal of a malformed one. Own heartbeats and those of
    /// other builds are passed over.
    pub fn hear(&mut self, now: MonotonicNs) -> Option<Result<Heartbeat, Refusal>> {
        for _ in 0..self.reader.depth() {
            let beat = match self.reader.receive()? {
                Ok(beat) => beat,
                Err(refusal) => return Some(Err(refusal)),
            };
            if beat.incarnation != self.last.incarnation && self.builds.admit(&beat, now) {
                self.peer_table.observe(beat, now);
                return Some(Ok(beat));
            }
        }
        None
    }

    /// Heartbeats that can be there at once.
    #[must_use]
    pub fn depth(&self) -> usize {
        self.reader.depth()
    }

    /// Processes whose heartbeat has not run out.
    #[must_use]
    pub fn peer_table(&self) -> &PeerTable {
        &self.peer_table
    }

    /// Who is of which build.
    #[must_use]
    pub fn builds(&self) -> &Builds {
        &self.builds
    }

    /// The mission has ended.
    pub fn mission_ended(&mut self, status: Status, now: MonotonicNs) {
        tracing::info!("the mission is over: {status}");
        self.ended = Some(now);
    }

    /// Whether a monitor lives that has not taken account of the end of the mission: it may still ask for something.
    #[must_use]
    pub fn is_watched(&self, now: MonotonicNs) -> bool {
        let run = self.last.run;
        let mut beats = self.peer_table.live(now).map(|peer| &peer.beat);
        beats.any(|beat| beat.role == Role::Monitor && beat.run == run && !beat.status.is_over())
    }

    /// Somebody still asks this process for something, or may: once the mission has ended, it stays as long again, for five
    /// seconds at most.
    pub fn stay_a_moment(&mut self, now: MonotonicNs) {
        if self.ended.is_some_and(|ended| now.since_ns(ended) < STAY_MAX_NS) {
            self.asked = Some(now);
        }
    }

    /// From now on the heartbeats tell of these robots: see [`Heartbeat::robots`].
    pub fn tell_robots(&mut self, robots: RobotSet) {
        self.robots = robots;
    }

    /// Beats if the last heartbeat is [`BEAT_PERIOD_NS`] old, or if the run, its status or the robots have changed.
    ///
    /// # Errors
    /// If there is no room for the heartbeat.
    pub fn beat(
        &mut self,
        (run, decision, status): (RunId, Decision, Status),
        now: MonotonicNs,
    ) -> Result<(), P::Error> {
        let due = self.sent.is_none_or(|sent| now.since_ns(sent) >= BEAT_PERIOD_NS);
        let robots = self.robots;
        let news = (run, status, robots) != (self.last.run, self.last.status, self.last.robots);
        if !due && !news {
            return Ok(());
        }
        self.last = Heartbeat { counter: self.last.counter + 1, run, decision, status, robots, ..self.last };
        self.sent = Some(now);
        self.writer.publish(self.last)
    }

    /// Ends the process with exit code 4 once `waits_for` has lasted longer than the limit.
    ///
    /// # Errors
    /// See [`Patience::check`].
    pub fn wait_for(
        &mut self,
        waits_for: Option<impl Into<Cow<'static, str>>>,
        ports: &mut P,
    ) -> Result<(), Failure> {
        self.patience.check(waits_for, ports)
    }

    /// Closes a turn of a process other than hopper-sim: beats with what was `seen` last, and says what follows.
    /// `lacks` is what the engine still needs; if nothing, a silent hopper-sim is waited for too.
    ///
    /// # Errors
    /// If patience has run out (exit code 4), or there is no room for the heartbeat.
    pub fn close_turn(
        &mut self,
        ports: &mut P,
        seen: (RunId, Decision, Status),
        lacks: Option<&'static str>,
    ) -> Result<Turn, Failure> {
        let now = ports.now();
        self.beat(seen, now).map_err(Into::into)?;
        let (_, _, status) = seen;
        let silent = !status.is_over()
            && now.since_ns(self.joined) > SILENCE_NS
            && !self.peer_table.has(Role::HopperSim, now);
        self.wait_for(lacks.or(silent.then_some("hopper-sim: it is silent; holding")), ports)?;
        let since = self.ended.map(|ended| self.asked.map_or(ended, |asked| asked.max(ended)));
        let farewell = since.is_some_and(|since| now.since_ns(since) >= FAREWELL_NS);
        Ok(if farewell && !self.stay { Turn::Leave(crate::Exit::Done) } else { Turn::Sleep(TICK_NS) })
    }
}
