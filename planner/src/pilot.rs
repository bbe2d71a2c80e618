//! The state machine of a planner process: when to plan, for which term to speak, when to step back.
//!
//! A pilot answers a state only when state and map are of one run and one decision. It speaks for the
//! term in force if it leads, and for the next term if it may take over: nobody leads yet, it was told
//! to (once), its predecessor is known to be dead, or the leader's heartbeat stands still. hopper-sim
//! decides; a pilot that lost the race reads so from the next state. It may command several robots, each under a term of its
//! own: one robot is due at a time, and only for it there is something to plan.
//!
//! If hopper-sim's guard vetoes its command, the same state comes again with the veto, and the pilot plans
//! anew. A planner that insists on what is vetoed stands still.

mod config;
mod due;
mod effect;
mod event;
mod given;
mod knowledge;
mod leadership;

use contract::{Account, Action, Brief, Command, Decision, MonotonicNs, RobotId, RunId, State, Status, Term};
use follow::Replica;

pub use config::PilotConfig;
pub use effect::Effect;
pub use event::Event;
pub use leadership::DEATH_SILENCE_NS;

use crate::others::{occupant, wait_or_hold};
use crate::{Plan, PlanStatus, Situation};
use due::Due;
use knowledge::{Knowledge, Turn};
use leadership::Leadership;

/// An unanswered command is sent again after this long.
pub const RESEND_NS: u64 = 10_000_000;

/// What was planned last; the term is filled in when it is sent.
#[derive(Clone, Copy, Debug)]
struct Planned {
    command: Command,
    due: Due,
    sent: MonotonicNs,
}

/// Commands robots, or stands by.
#[derive(Debug)]
pub struct Pilot {
    config: PilotConfig,
    known: Knowledge,
    leadership: Leadership,
    /// The decision for which a plan was asked and has not been reported.
    planning: Option<Due>,
    planned: Option<Planned>,
    finished: bool,
}

impl Pilot {
    /// A pilot who knows nothing yet.
    #[must_use]
    pub fn new(config: PilotConfig) -> Self {
        Self {
            config,
            known: Knowledge::new(config.robots),
            leadership: Leadership::new(config),
            planning: None,
            planned: None,
            finished: false,
        }
    }

    /// Takes note of `event` at `now` and says what is to be done.
    pub fn on(&mut self, event: Event, now: MonotonicNs) -> Vec<Effect> {
        // Most events ask for nothing; these two for one effect as a rule.
        let mut effects = match event {
            Event::Patch(_) | Event::Planned(..) => Vec::with_capacity(1),
            _ => Vec::new(),
        };
        match event {
            Event::Brief(brief) => self.brief(brief, now, &mut effects),
            // By reference, here as elsewhere: a state is large, and copied once.
            Event::State(ref state) => self.state(state, now, &mut effects),
            Event::Team(team) => {
                self.known.team(team);
                self.note_leaders(now, &mut effects);
            }
            Event::Patch(patch) => effects.extend(self.known.patch(patch, now).map(Effect::RequestMap)),
            Event::Page(page) => effects.extend(self.known.page(&page, now).map(Effect::RequestMap)),
            Event::Prior(page) => self.known.prior(page),
            Event::Table(page) => self.known.table(page),
            Event::Route(page) => self.known.route(page),
            Event::Refused(refusal) => self.known.refuse(&refusal),
            Event::Heartbeat(beat) => self.leadership.heartbeat(beat, now),
            Event::Gone(pid) => self.leadership.gone(pid),
            Event::HandOver => self.leadership.hand_over(),
            Event::Planned(plan, started, ended) => self.planned(&plan, started, ended, now, &mut effects),
            Event::Tick => self.tick(now, &mut effects),
        }
        self.known.refresh();
        self.known.gather(now, &mut effects);
        self.plan(now, &mut effects);
        effects
    }

    /// What there is to plan for; `None` unless brief, state and map agree and a decision is due.
    #[must_use]
    pub fn situation(&self) -> Option<Situation<'_>> {
        self.known.situation()
    }

    /// Whether a plan was asked for that has not been reported, and still can be made. What is heard between
    /// two plans may ask for a plan twice: the second is that of the first.
    #[must_use]
    pub fn awaits_plan(&self) -> bool {
        self.planning.is_some()
    }

    /// The run, decision and status last seen, for the heartbeat.
    #[must_use]
    pub fn seen(&self) -> (RunId, Decision, Status) {
        self.known.seen()
    }

    /// The process of the planner in command, if it is another one.
    #[must_use]
    pub fn rival_pid(&self) -> Option<u32> {
        let leader = self.known.turn()?.leader;
        (leader.term > Term(0) && leader.incarnation != self.config.incarnation).then_some(leader.pid)
    }

    /// The brief that was heard last.
    #[must_use]
    pub fn known_brief(&self) -> Option<&Brief> {
        self.known.known_brief()
    }

    /// What this planner holds of the observed map, and how it came by it.
    #[must_use]
    pub fn map(&self) -> &Replica {
        self.known.map()
    }

    /// What is missing, if anything.
    #[must_use]
    pub fn waits_for(&self) -> Option<&'static str> {
        self.known.waits_for()
    }

    /// Whose turn it is, if that robot may be commanded.
    fn own_turn(&self) -> Option<Turn> {
        self.known.turn().filter(|turn| self.config.robots.has(turn.robot))
    }

    /// Takes note of who leads the robots that this pilot may command.
    fn note_leaders(&mut self, now: MonotonicNs, effects: &mut Vec<Effect>) {
        let Some(&State { run, status, .. }) = self.known.known_state() else { return };
        for robot in self.config.robots.iter() {
            if let Some(leader) = self.known.leader_of(robot) {
                self.leadership.note(robot, leader, (run, status), now, effects);
            }
        }
    }

    fn brief(&mut self, brief: Brief, now: MonotonicNs, effects: &mut Vec<Effect>) {
        if self.known.brief(brief) {
            self.planned = None;
            self.finished = false;
            self.leadership.begin_run();
        }
        // Who leads the robots of the state may have been told before it was known which robots there are.
        if self.known.state_of_run().is_some() {
            self.note_leaders(now, effects);
        }
    }

    fn state(&mut self, state: &State, now: MonotonicNs, effects: &mut Vec<Effect>) {
        if !self.known.state(state) {
            return;
        }
        self.note_leaders(now, effects);
        if state.status.is_over() && !self.finished && self.known.state_of_run().is_some() {
            self.finished = true;
            effects.push(Effect::Finished(state.status));
        }
    }

    /// The term this pilot may speak for at `now`; `None` while it stands by.
    fn term(&self, now: MonotonicNs) -> Option<Term> {
        let Turn { robot, leader } = self.own_turn()?;
        self.leadership.term_for(robot, leader, now)
    }

    /// Asks for a plan if one is due.
    fn plan(&mut self, now: MonotonicNs, effects: &mut Vec<Effect>) {
        let planned = self.planned.as_ref().zip(self.known.known_state());
        if self.planning.is_none() && planned.is_some_and(|(planned, state)| planned.due.is_of(state)) {
            return;
        }
        let Some(due) = self.situation().map(|situation| Due::of(situation.state)) else {
            // Whoever was asked for a plan may have found nothing to plan for.
            self.planning = None;
            return;
        };
        let is_planned = self.planned.as_ref().is_some_and(|planned| planned.due == due);
        if is_planned || self.planning == Some(due) || self.term(now).is_none() {
            return;
        }
        self.planning = Some(due);
        effects.push(Effect::Plan);
    }

    fn planned(
        &mut self,
        plan: &Plan,
        started: MonotonicNs,
        ended: MonotonicNs,
        now: MonotonicNs,
        effects: &mut Vec<Effect>,
    ) {
        let asked = self.planning.take();
        let (Some(situation), Some(map)) = (self.situation(), self.map().map()) else { return };
        let due = Due::of(situation.state);
        if asked != Some(due) {
            return;
        }
        let command = Command {
            run: situation.state.run,
            robot: situation.team.map_or(RobotId(0), |team| team.due),
            decision: situation.state.decision,
            digest: situation.state.digest,
            term: Term(0),
            action: among_others(&situation, plan.action),
            // Of the map as it is, whatever the planner was given.
            observation: map.observation(),
            planner: self.config.planner,
            incarnation: self.config.incarnation,
            pid: self.config.pid,
            work: plan.work,
            cut: plan.status == PlanStatus::Cut,
            sensed: situation.map.sensed,
            map_published: situation.map.published,
            planning_started: started,
            planning_ended: ended,
        };
        self.planned = Some(Planned { command, due, sent: now });
        self.send(now, effects);
    }

    /// Sends what was planned, under the term that may be spoken for.
    fn send(&mut self, now: MonotonicNs, effects: &mut Vec<Effect>) {
        let Some(Turn { robot, leader }) = self.own_turn() else { return };
        let Some(term) = self.leadership.term_for(robot, leader, now) else { return };
        self.leadership.asked(robot, term);
        let Some(planned) = &mut self.planned else { return };
        planned.sent = now;
        effects.push(Effect::Send(Command { term, ..planned.command }));
    }

    fn tick(&mut self, now: MonotonicNs, effects: &mut Vec<Effect>) {
        self.leadership.tick(now);
        effects.extend(self.known.ask_for_map(now).map(Effect::RequestMap));
        self.resend(now, effects);
    }

    fn resend(&mut self, now: MonotonicNs, effects: &mut Vec<Effect>) {
        let Some(planned) = self.planned.as_ref().filter(|planned| now.since_ns(planned.sent) >= RESEND_NS)
        else {
            return;
        };
        if self.situation().is_some_and(|situation| planned.due.is_of(situation.state)) {
            self.send(now, effects);
        }
    }
}

/// What is commanded of what was planned: nothing that is vetoed, or not for a robot of that kind. The planner of a hopper among
/// other robots knows of none of them. So where it holds, or would have the hopper hop onto its goal while another robot is there,
/// the hopper waits for the others.
fn among_others(situation: &Situation<'_>, planned: Action) -> Action {
    let Situation { brief, state, team, .. } = *situation;
    let may = fits(situation, planned) && !state.vetoed.has(planned);
    let action = if may { planned } else { Action::Hold };
    let (Some(team), Some(leg)) = (team, situation.leg) else { return action };
    if brief.account == Account::Hopper {
        // Others look ahead for it, and are never in its way.
        return action;
    }
    let is_in_vain = match action.hop() {
        Some(direction) => {
            let aim = leg.grid.hop(state.pose.cell, direction);
            aim == leg.goal && occupant(brief, team, aim).is_some()
        }
        None => action == Action::Hold,
    };
    if is_in_vain { wait_or_hold(team) } else { action }
}

/// Whether the robot that is due could ever do that: a planner may be told to command a robot of another kind.
fn fits(situation: &Situation<'_>, action: Action) -> bool {
    let due = situation.team.and_then(|team| situation.brief.robots.at(team.due));
    let Some(due) = due else { return true };
    action == Action::Hold || due.body.hops() == action.hop().is_some()
}
