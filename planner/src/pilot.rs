//! The state machine of a planner process: when to plan, for which term to speak, when to step back.
//!
//! A pilot answers a state only when state and map are of one run and one decision. It speaks for the
//! term in force if it leads, and for the next term if it may take over: nobody leads yet, it was told
//! to (once), its predecessor is known to be dead, or the leader's heartbeat stands still. hopper-sim
//! decides; a pilot that lost the race reads so from the next state.
//!
//! If hopper-sim's guard vetoes its command, the same state comes again with the veto, and the pilot plans
//! anew. A planner that insists on what is vetoed stands still.

use contract::peer_table::SILENCE_NS;
use contract::{
    Action, Brief, Command, Decision, Digest, Heartbeat, Incarnation, Leader, MapPage, MapPatch, MapRequest,
    MonotonicNs, Name, PeerTable, Refusal, Replica, RobotId, RunId, State, Status, Term, Timeline, Vetoed,
};

use crate::{Plan, PlanStatus, Situation};

/// An unanswered command is sent again after this long.
pub const RESEND_NS: u64 = 10_000_000;

/// A leader whose process is gone needs to be silent only this long: a process of another container is
/// gone to us though it lives, but it beats.
pub const DEATH_SILENCE_NS: u64 = SILENCE_NS / 5;

/// Who this planner is, and what it may presume.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PilotConfig {
    /// The robot.
    pub robot: RobotId,
    /// This life.
    pub incarnation: Incarnation,
    /// This process; 0 in lockstep.
    pub pid: u32,
    /// The algorithm.
    pub planner: Name,
    /// Take the next term from a living leader, once.
    pub takeover: bool,
    /// A process known to be dead: its term may be taken at once.
    pub succeeds_pid: Option<u32>,
}

/// What a pilot hears.
#[derive(Clone, Debug)]
#[allow(clippy::large_enum_variant, reason = "an event is made, taken, and gone")]
pub enum Event {
    /// The brief; one of a new run drops all that was known.
    Brief(Brief),
    /// The state.
    State(State),
    /// What a landing changed in the observed map.
    Patch(MapPatch),
    /// A page of the observed map that was asked for; after all patches that were there when it came.
    Page(MapPage),
    /// A message about the map was malformed.
    Refused(Refusal),
    /// A sign of life.
    Heartbeat(Heartbeat),
    /// The operating system knows of no process with this number.
    Gone(u32),
    /// This planner shall claim the next term, once, as if it had been told so at its start.
    HandOver,
    /// The plan that was asked for, with the moments at which planning began and ended.
    Planned(Plan, MonotonicNs, MonotonicNs),
    /// Time passes.
    Tick,
}

/// What a pilot wants done.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Effect {
    /// Ask for the observed map.
    RequestMap(MapRequest),
    /// Plan for [`Pilot::situation`], then report [`Event::Planned`]; unless the plan was reported meanwhile
    /// ([`Pilot::awaits_plan`]).
    Plan,
    /// Send the command.
    Send(Command),
    /// This planner now commands, under the given term.
    Leads(Term),
    /// Another planner commands now; this one no longer does.
    StepsBack(Term),
    /// Another planner commands, and this one waits for its end.
    StandsBy(Leader),
    /// The mission is over.
    Finished(Status),
}

/// What was planned last; the term is filled in when it is sent.
#[derive(Clone, Copy, Debug)]
struct Planned {
    command: Command,
    due: Due,
    sent: MonotonicNs,
}

/// What is planned for: a decision, on the timeline of a digest, and what the guard has vetoed there.
type Due = (RunId, Decision, Digest, Vetoed);

/// Commands one robot, or stands by.
#[derive(Debug)]
pub struct Pilot {
    config: PilotConfig,
    brief: Option<Brief>,
    /// The brief of the leg of the present state.
    leg: Option<Brief>,
    state: Option<State>,
    map: Replica,
    peer_table: PeerTable,
    /// When the present leader was first heard of as such.
    leader_since: MonotonicNs,
    /// A process that no longer exists.
    gone: Option<u32>,
    /// When time last passed: a pilot that was stopped itself has missed the leader's beats.
    ticked: MonotonicNs,
    takeover: bool,
    leads: bool,
    /// The term last asked for in this run.
    asked: Option<Term>,
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
            brief: None,
            leg: None,
            state: None,
            map: Replica::new(config.robot),
            peer_table: PeerTable::default(),
            leader_since: MonotonicNs(0),
            gone: None,
            ticked: MonotonicNs(0),
            takeover: config.takeover,
            leads: false,
            asked: None,
            planning: None,
            planned: None,
            finished: false,
        }
    }

    /// Takes note of `event` at `now` and says what is to be done.
    pub fn on(&mut self, event: Event, now: MonotonicNs) -> Vec<Effect> {
        let mut effects = Vec::new();
        let leg_may_change = matches!(event, Event::Brief(_) | Event::State(_));
        match event {
            Event::Brief(brief) => self.brief(brief),
            Event::State(state) => self.state(state, now, &mut effects),
            Event::Patch(patch) => effects.extend(self.map.patch(patch, now).map(Effect::RequestMap)),
            Event::Page(page) => effects.extend(self.map.page(&page, now).map(Effect::RequestMap)),
            Event::Refused(refusal) => self.map.refuse(&refusal),
            Event::Heartbeat(beat) => self.peer_table.observe(beat, now),
            Event::Gone(pid) => self.gone = Some(pid),
            Event::HandOver => self.hand_over(),
            Event::Planned(plan, started, ended) => self.planned(&plan, started, ended, now, &mut effects),
            Event::Tick => self.tick(now, &mut effects),
        }
        if leg_may_change {
            self.leg = self.brief.as_ref().zip(self.state).map(|(brief, state)| brief.leg(state.visits));
        }
        self.plan(now, &mut effects);
        effects
    }

    /// What there is to plan for; `None` unless brief, state and map agree and a decision is due.
    #[must_use]
    pub fn situation(&self) -> Option<Situation<'_>> {
        match (&self.leg, &self.state, self.map.map()) {
            (Some(brief), Some(state), Some(map))
                if brief.run == state.run
                    && map.run == state.run
                    && map.through == Some(state.decision)
                    && !state.status.is_over() =>
            {
                Some(Situation { brief, map, state })
            }
            _ => None,
        }
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
        match (&self.brief, &self.state) {
            (Some(brief), Some(state)) if brief.run == state.run => (state.run, state.decision, state.status),
            _ => (RunId::default(), Decision(0), Status::Underway),
        }
    }

    /// The process of the planner in command, if it is another one.
    #[must_use]
    pub fn rival_pid(&self) -> Option<u32> {
        let leader = self.state?.leader;
        (leader.term > Term(0) && leader.incarnation != self.config.incarnation).then_some(leader.pid)
    }

    /// Whether this planner is in command.
    #[must_use]
    pub fn leads(&self) -> bool {
        self.leads
    }

    /// What this planner holds of the observed map, and how it came by it.
    #[must_use]
    pub fn map(&self) -> &Replica {
        &self.map
    }

    /// What is missing, if anything.
    #[must_use]
    pub fn waits_for(&self) -> Option<&'static str> {
        let (Some(brief), Some(state)) = (&self.brief, &self.state) else {
            return Some("hopper-sim: no brief or no state yet");
        };
        if brief.run != state.run {
            return Some("hopper-sim: brief and state of one run");
        }
        let current =
            |map: &contract::ObservedMap| map.run == state.run && map.through == Some(state.decision);
        let behind = !self.map.map().is_some_and(current);
        (behind && !state.status.is_over()).then_some("perception: no map of this decision yet")
    }

    fn hand_over(&mut self) {
        if !self.leads {
            (self.takeover, self.asked) = (true, None);
        }
    }

    fn brief(&mut self, brief: Brief) {
        if self.brief.is_none_or(|known| known.run != brief.run) {
            self.planned = None;
            self.finished = false;
            self.leads = false;
            self.asked = None;
        }
        self.brief = Some(brief);
        self.map.begin(brief.run, brief.grid);
    }

    fn state(&mut self, state: State, now: MonotonicNs, effects: &mut Vec<Effect>) {
        let known = self.state.filter(|known| known.run == state.run);
        if state.robot != self.config.robot || known.is_some_and(|known| state.is_older_than(&known)) {
            return;
        }
        if known.is_some_and(|known| Timeline::through(&known).is_contradicted_by(&state)) {
            // The map may hold cells that were seen on hops which never were.
            self.map.begin_anew();
        }
        let same = known.filter(|known| (known.decision, known.digest) == (state.decision, state.digest));
        // A veto stands, though an older copy of the state or another life of hopper-sim may not tell of it.
        let vetoed = state.vetoed.union(same.map_or(Vetoed::NONE, |known| known.vetoed));
        let state = State { vetoed, ..state };
        let news = known.is_none_or(|known| known.leader != state.leader);
        if news {
            self.leader_since = now;
        }
        self.state = Some(state);
        let led = self.leads;
        self.leads = state.leader.incarnation == self.config.incarnation;
        if self.asked.is_some_and(|asked| asked < state.leader.term) {
            // That term has come and gone, and may have been ours: what fires once is not tried again.
            self.takeover = false;
        }
        if self.leads && !led {
            self.takeover = false;
            effects.push(Effect::Leads(state.leader.term));
        }
        if led && !self.leads {
            effects.push(Effect::StepsBack(state.leader.term));
        } else if news && !state.status.is_over() && self.term(now).is_none() {
            effects.push(Effect::StandsBy(state.leader));
        }
        if state.status.is_over() && !self.finished && self.brief.is_some_and(|brief| brief.run == state.run)
        {
            self.finished = true;
            effects.push(Effect::Finished(state.status));
        }
    }

    /// The term this pilot may speak for at `now`; `None` while it stands by.
    fn term(&self, now: MonotonicNs) -> Option<Term> {
        let leader = self.state?.leader;
        if leader.incarnation == self.config.incarnation {
            return Some(leader.term);
        }
        let vacant = leader.term == Term(0);
        let bereft = self.config.succeeds_pid.is_some_and(|pid| pid == leader.pid);
        (vacant || self.takeover || bereft || self.leader_is_silent(now)).then(|| leader.term.next())
    }

    fn leader_is_silent(&self, now: MonotonicNs) -> bool {
        let leader = self.state.map_or_else(Leader::default, |state| state.leader);
        let heard = self.peer_table.peer(leader.incarnation).map_or(self.leader_since, |peer| peer.advanced);
        let limit_ns = if self.gone == Some(leader.pid) { DEATH_SILENCE_NS } else { SILENCE_NS };
        now.since_ns(heard.max(self.leader_since)) > limit_ns
    }

    fn planned_for(&self) -> Option<Due> {
        self.planned.map(|planned| planned.due)
    }

    /// Asks for a plan if one is due.
    fn plan(&mut self, now: MonotonicNs, effects: &mut Vec<Effect>) {
        let Some(state) = self.situation().map(|situation| *situation.state) else {
            // Whoever was asked for a plan may have found nothing to plan for.
            self.planning = None;
            return;
        };
        let due = due(&state);
        if self.planned_for() == Some(due) || self.planning == Some(due) || self.term(now).is_none() {
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
        let Some(situation) = self.situation() else { return };
        let (due, vetoed) = (due(situation.state), situation.state.vetoed);
        if asked != Some(due) {
            return;
        }
        let command = Command {
            run: situation.state.run,
            robot: self.config.robot,
            decision: situation.state.decision,
            term: Term(0),
            action: if vetoed.has(plan.action) { Action::Hold } else { plan.action },
            observation: situation.map.observation(),
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

    /// Sends what was planned for the decision that is due, under the term that may be spoken for.
    fn send(&mut self, now: MonotonicNs, effects: &mut Vec<Effect>) {
        let Some(term) = self.term(now) else { return };
        let Some(state) = self.situation().map(|situation| *situation.state) else { return };
        if self.planned_for() != Some(due(&state)) {
            return;
        }
        if term > state.leader.term {
            self.asked = Some(term);
        }
        let Some(planned) = &mut self.planned else { return };
        planned.sent = now;
        effects.push(Effect::Send(Command { term, ..planned.command }));
    }

    fn tick(&mut self, now: MonotonicNs, effects: &mut Vec<Effect>) {
        if now.since_ns(self.ticked) > SILENCE_NS / 2 {
            self.leader_since = now;
        }
        self.ticked = now;
        effects.extend(self.map.ask(now).map(Effect::RequestMap));
        self.resend(now, effects);
    }

    fn resend(&mut self, now: MonotonicNs, effects: &mut Vec<Effect>) {
        if self.planned.is_some_and(|planned| now.since_ns(planned.sent) >= RESEND_NS) {
            self.send(now, effects);
        }
    }
}

fn due(state: &State) -> Due {
    (state.run, state.decision, state.digest, state.vetoed)
}
