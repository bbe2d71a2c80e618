//! Who leads each robot, and for which term a pilot may speak.

use contract::protocol::peer_table::SILENCE_NS;
use contract::{Heartbeat, Leader, MonotonicNs, PeerTable, RobotId, RunId, Status, Term};

use super::config::PilotConfig;
use super::effect::Effect;

/// A leader whose process is gone needs to be silent only this long: a process of another container is
/// gone to us though it lives, but it beats.
pub const DEATH_SILENCE_NS: u64 = SILENCE_NS / 5;

/// What is known of who leads one robot, and what was asked for.
#[derive(Clone, Copy, Debug)]
struct RobotView {
    /// Who led it when it was last heard of, and in which run.
    leader: Option<(RunId, Leader)>,
    /// When that leader was first heard of as such.
    leader_since: MonotonicNs,
    takeover: bool,
    leads: bool,
    /// The term last spoken for in this run.
    asked: Option<Term>,
}

/// Who leads the robots that a pilot may command.
#[derive(Debug)]
pub(super) struct Leadership {
    config: PilotConfig,
    peer_table: PeerTable,
    /// One for each robot, up to the last that it may command.
    views: Vec<RobotView>,
    /// A process that no longer exists.
    gone: Option<u32>,
    /// When time last passed: a pilot that was stopped itself has missed the leader's beats.
    ticked: MonotonicNs,
}

impl Leadership {
    /// Nobody is known to lead.
    pub fn new(config: PilotConfig) -> Self {
        let view = RobotView {
            leader: None,
            leader_since: MonotonicNs(0),
            takeover: config.takeover,
            leads: false,
            asked: None,
        };
        Self {
            config,
            peer_table: PeerTable::default(),
            views: vec![view; config.robots.iter().last().map_or(0, |last| usize::from(last.0) + 1)],
            gone: None,
            ticked: MonotonicNs(0),
        }
    }

    /// A new run begins: its robots are led by nobody.
    pub fn begin_run(&mut self) {
        for view in &mut self.views {
            (view.leads, view.asked) = (false, None);
        }
    }

    /// Takes a sign of life.
    pub fn heartbeat(&mut self, beat: Heartbeat, now: MonotonicNs) {
        self.peer_table.observe(beat, now);
    }

    /// Takes note that no process has this number.
    pub fn gone(&mut self, pid: u32) {
        self.gone = Some(pid);
    }

    /// Claims the next term of each robot that is not led from here, once.
    pub fn hand_over(&mut self) {
        for robot in self.config.robots.iter() {
            let view = &mut self.views[usize::from(robot.0)];
            if !view.leads {
                (view.takeover, view.asked) = (true, None);
            }
        }
    }

    /// Lets time pass.
    pub fn tick(&mut self, now: MonotonicNs) {
        if now.since_ns(self.ticked) > SILENCE_NS / 2 {
            self.views.iter_mut().for_each(|view| view.leader_since = now);
        }
        self.ticked = now;
    }

    /// Takes note of who leads `robot` in `run`, whose mission stands at `status`.
    pub fn note(
        &mut self,
        robot: RobotId,
        leader: Leader,
        (run, status): (RunId, Status),
        now: MonotonicNs,
        effects: &mut Vec<Effect>,
    ) {
        let view = &mut self.views[usize::from(robot.0)];
        let news = view.leader != Some((run, leader));
        if news {
            (view.leader, view.leader_since) = (Some((run, leader)), now);
        }
        let led = view.leads;
        view.leads = leader.incarnation == self.config.incarnation;
        if view.asked.is_some_and(|asked| asked < leader.term) {
            // That term has come and gone, and may have been ours: what fires once is not tried again.
            view.takeover = false;
        }
        let leads = view.leads;
        if leads && !led {
            view.takeover = false;
            effects.push(Effect::Leads(leader.term));
        }
        if led && !leads {
            effects.push(Effect::StepsBack(leader.term));
        } else if news && !status.is_over() && self.term_for(robot, leader, now).is_none() {
            effects.push(Effect::StandsBy(leader));
        }
    }

    /// The term that may be spoken for at `now` for `robot`, which `leader` leads; `None` while this pilot stands by.
    pub fn term_for(&self, robot: RobotId, leader: Leader, now: MonotonicNs) -> Option<Term> {
        let view = self.views.get(usize::from(robot.0))?;
        if leader.incarnation == self.config.incarnation {
            return Some(leader.term);
        }
        let vacant = leader.term == Term(0);
        let bereft = self.config.succeeds_pid.is_some_and(|pid| pid == leader.pid);
        (vacant || view.takeover || bereft || self.leader_is_silent(leader, view, now))
            .then(|| leader.term.next())
    }

    /// Takes note that a command for `robot` is sent under `term`.
    pub fn asked(&mut self, robot: RobotId, term: Term) {
        self.views[usize::from(robot.0)].asked = Some(term);
    }

    fn leader_is_silent(&self, leader: Leader, view: &RobotView, now: MonotonicNs) -> bool {
        let heard = self.peer_table.peer(leader.incarnation).map_or(view.leader_since, |peer| peer.advanced);
        let limit_ns = if self.gone == Some(leader.pid) { DEATH_SILENCE_NS } else { SILENCE_NS };
        now.since_ns(heard.max(view.leader_since)) > limit_ns
    }
}
