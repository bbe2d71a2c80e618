//! The hopper-sim process: ports and the journal around the [`Arbiter`].

use std::collections::BTreeMap;
use std::time::Duration;

use contract::limits::{PRIOR_PAGE_CELLS, TABLE_PAGE_ROWS, TRUTH_PAGE_CELLS};
use contract::{
    Announcement, Brief, Command, Control, Decision, DetailPage, DetailRequest, Heartbeat, Incarnation,
    MissingPeer, MonotonicNs, Name, Pacing, PastRequest, Policy, PriorRequest, Record, Refusal, RobotId,
    Role, RoutePage, RouteRequest, State, Status, TableRequest, Team, TruthRequest,
};
use process::{
    Exit, Failure, Membership, Ports, Process, Reader, Server, TICK_NS, Terms, Turn, Writer, log_refusal,
};

use crate::record_store::{RecordStore, recall};
use crate::trouble::Trouble;
use crate::{Arbiter, Effect, Event, Fallback, JournalError, Mission, Pace, ROBOT, crash};

/// How long before a landing hopper-sim no longer sleeps, nanoseconds: a sleeping process wakes a tenth of a
/// millisecond late.
const AWAKE_NS: u64 = 300_000;

/// How often the journal is looked for at its path while nothing is appended, nanoseconds.
const CHECK_NS: u64 = 100_000_000;

/// How often the pacing is published again, nanoseconds.
const PACING_NS: u64 = 1_000_000_000;

/// A living planner that has not decided for this long is named, nanoseconds.
const UNDECIDED_NS: u64 = 10_000_000_000;

/// Lives of one role that are remembered for the summary; a mission of any length stays bounded.
const LIVES_MAX: usize = 256;

/// How hopper-sim paces, waits and ends.
#[derive(Clone, Copy, Debug)]
pub struct SimTerms {
    /// How fast landings follow each other.
    pub pace: Pace,
    /// How long the end of the mission is served at most to peers that have not seen it, nanoseconds.
    pub linger_ns: u64,
    /// Whether orders to pause, resume, step or change the pace are obeyed.
    pub control: bool,
    /// Whether the deadline of a decision passes by the clock. Lockstep repeats a mission from its journal instead.
    pub deadlines: bool,
    /// How long it waits for peers.
    pub terms: Terms,
}

/// Executes hops, decides who commands, and keeps the journal. `O` gets every executed decision.
pub struct HopperSim<P: Ports, R: RecordStore, O: FnMut(&Record)> {
    membership: Membership<P>,
    arbiter: Arbiter,
    records: R,
    executed: O,
    /// The first lives heard, by role: at most [`LIVES_MAX`] each.
    lives: BTreeMap<Role, Vec<(Incarnation, u32)>>,
    states: P::Writer<State>,
    briefs: P::Writer<Brief>,
    truths: P::Server<TruthRequest>,
    /// Unless a hopper is alone.
    teams: Option<P::Writer<Team>>,
    /// One for each robot.
    commands: Vec<P::Reader<Command>>,
    /// One for each robot where robots have routes.
    announcements: Vec<P::Reader<Announcement>>,
    /// Serves announced routes, in a mission that has routes.
    routes: Option<P::Server<RouteRequest>>,
    /// Serves what the motion model tells, if it tells more than the outcome.
    details: Option<P::Server<DetailRequest>>,
    /// Serves the prior, in a mission over uncertain ground.
    priors: Option<P::Server<PriorRequest>>,
    /// Serves the motion table, if planners are to believe one.
    tables: Option<P::Server<TableRequest>>,
    controls: P::Reader<Control>,
    pacings: P::Writer<Pacing>,
    /// The pacing published last, and when.
    pacing_sent: Option<(Pacing, MonotonicNs)>,
    /// Read only where there may be a fallback: planners write policies for readers alone.
    policies: Option<P::Reader<Policy>>,
    past: P::Server<PastRequest>,
    assembled: bool,
    /// Whether the last append failed.
    holding: bool,
    /// The journal is not at its path, or not as it was left there.
    displaced: Option<Trouble>,
    /// The past cannot be read.
    unreadable: Option<Trouble>,
    /// How long either is endured, nanoseconds.
    patience_ns: u64,
    /// When the journal was last looked for.
    checked: MonotonicNs,
    finished: Option<Status>,
    /// The decision that is awaited, and after how long it is worth a line in the log, nanoseconds.
    undecided: (Decision, u64),
}

impl<P: Ports, R: RecordStore, O: FnMut(&Record)> HopperSim<P, R, O> {
    /// Joins the instance with `records` open, whose last is `last`, and publishes the brief.
    ///
    /// # Errors
    /// If a port cannot be had, there is no room for the brief, or the records of several robots cannot be read back.
    pub async fn join(
        ports: &mut P,
        mission: Mission,
        (records, last): (R, Option<Record>),
        executed: O,
        terms: SimTerms,
    ) -> Result<Self, Failure> {
        let mut arbiter = Arbiter::new(mission, last.as_ref(), terms.pace, terms.linger_ns, ports.now());
        if terms.control {
            arbiter = arbiter.obeying_orders();
        }
        if !terms.deadlines {
            arbiter = arbiter.without_deadlines();
        }
        recall(&mut arbiter, &records, last.as_ref()).map_err(Failure::run)?;
        Self::open(ports, arbiter, records, executed, terms.terms).await.map_err(Into::into)
    }

    async fn open(
        ports: &mut P,
        arbiter: Arbiter,
        records: R,
        executed: O,
        terms: Terms,
    ) -> Result<Self, P::Error> {
        let may_fall_back = arbiter.mission().brief.guard.deadline_ns > 0;
        let robots = (0..arbiter.robots()).map(RobotId);
        let (has_routes, has_prior) =
            (arbiter.mission().brief.has_routes(), arbiter.mission().brief.sampling.is_some());
        let has_details = !arbiter.mission().dynamics.is_law();
        let mut sim = Self {
            membership: Membership::join(ports, Role::HopperSim, Name::NONE, terms)?,
            briefs: ports.writer(ROBOT)?,
            truths: ports.server(ROBOT)?,
            states: ports.writer(ROBOT)?,
            teams: arbiter.team().map(|_| ports.writer(ROBOT)).transpose()?,
            commands: robots.clone().map(|robot| ports.reader(robot, true)).collect::<Result<_, _>>()?,
            announcements: if has_routes {
                robots.map(|robot| ports.reader(robot, false)).collect::<Result<_, _>>()?
            } else {
                Vec::new()
            },
            routes: has_routes.then(|| ports.server(ROBOT)).transpose()?,
            details: has_details.then(|| ports.server(ROBOT)).transpose()?,
            priors: has_prior.then(|| ports.server(ROBOT)).transpose()?,
            tables: arbiter.mission().table.as_ref().map(|_| ports.server(ROBOT)).transpose()?,
            controls: ports.reader(ROBOT, false)?,
            pacings: ports.writer(ROBOT)?,
            pacing_sent: None,
            policies: may_fall_back.then(|| ports.reader(ROBOT, false)).transpose()?,
            past: ports.server(ROBOT)?,
            arbiter,
            records,
            executed,
            lives: BTreeMap::new(),
            assembled: false,
            holding: false,
            displaced: None,
            unreadable: None,
            patience_ns: u64::MAX,
            checked: ports.now(),
            finished: None,
            undecided: (Decision(0), UNDECIDED_NS),
        };
        sim.announce()?;
        ports.pass(crash::JOINED).await;
        Ok(sim)
    }

    /// This process, which ends with exit code 1 once its journal was displaced, or could not be
    /// read, for `limit` without a break. Until then it holds.
    #[must_use]
    pub fn holding_at_most(self, limit: Duration) -> Self {
        Self { patience_ns: u64::try_from(limit.as_nanos()).unwrap_or(u64::MAX), ..self }
    }

    /// The arbiter, for its state and refusals.
    #[must_use]
    pub fn arbiter(&self) -> &Arbiter {
        &self.arbiter
    }

    /// What was executed.
    #[must_use]
    pub fn records(&self) -> &R {
        &self.records
    }

    /// Lives of other processes heard so far, with their process numbers.
    pub fn lives(&self) -> impl Iterator<Item = (Role, u32)> + '_ {
        self.lives.iter().flat_map(|(role, lives)| lives.iter().map(|(_, pid)| (*role, *pid)))
    }

    /// Does what the fallback did at the decision that is due when this mission was flown before.
    ///
    /// # Errors
    /// As a turn.
    pub async fn repeat(&mut self, fallback: Fallback, ports: &mut P) -> Result<(), P::Error> {
        self.feed(Event::Repeat(fallback), ports).await
    }

    /// Publishes the brief: once, and again when a peer has missed it.
    fn announce(&mut self) -> Result<(), P::Error> {
        self.briefs.publish(self.arbiter.mission().brief.clone())
    }

    /// Everything that came since, and the passing of time.
    async fn receive(&mut self, ports: &mut P) -> Result<(), P::Error> {
        // Before the commands: nobody is obeyed whose build is not known.
        for _ in 0..self.membership.depth() {
            let Some(beat) = self.membership.hear(ports.now()) else { break };
            match beat {
                Ok(beat) => {
                    self.remember(&beat);
                    self.feed(Event::Heartbeat(beat), ports).await?;
                }
                Err(refusal) => self.refused(refusal, ports).await?,
            }
        }
        for robot in 0..self.commands.len() {
            self.receive_announcements(robot, ports).await?;
            self.receive_commands(robot, ports).await?;
        }
        for _ in 0..self.controls.depth() {
            let Some(control) = self.controls.receive() else { break };
            self.feed(Event::Control(control), ports).await?;
        }
        match self.policies.as_mut().and_then(Reader::newest) {
            Some(Ok(policy)) => self.feed(Event::Policy(policy), ports).await?,
            Some(Err(refusal)) => self.refused(refusal, ports).await?,
            None => {}
        }
        if self.is_assembled(ports.now()) {
            let effects = self.arbiter.on(Event::Tick, ports.now());
            // Most ticks ask for nothing.
            if !effects.is_empty() {
                self.carry_out(effects, ports).await?;
            }
        }
        Ok(())
    }

    /// The commands of one robot's service. Which robot a command is for it says itself, and the arbiter judges that.
    async fn receive_commands(&mut self, robot: usize, ports: &mut P) -> Result<(), P::Error> {
        for _ in 0..self.commands[robot].depth() {
            let Some(command) = self.commands[robot].receive() else { break };
            let builds = self.membership.builds();
            let command =
                command.and_then(|command| builds.refuse(command.incarnation).map_or(Ok(command), Err));
            let event = match command {
                Ok(command) if !builds.knows(command.incarnation) => Event::Stranger(command),
                command => Event::Command(command),
            };
            self.feed(event, ports).await?;
        }
        Ok(())
    }

    /// The routes that planners are about to announce for one robot: before the commands that name them.
    async fn receive_announcements(&mut self, robot: usize, ports: &mut P) -> Result<(), P::Error> {
        let Some(depth) = self.announcements.get(robot).map(Reader::depth) else { return Ok(()) };
        for _ in 0..depth {
            let Some(announcement) = self.announcements[robot].receive() else { break };
            self.feed(Event::Announcement(announcement), ports).await?;
        }
        Ok(())
    }

    /// Answers the requests for the past, the truth and details, and where robots have routes those for routes and the prior.
    async fn serve(&mut self, ports: &mut P) -> Result<(), P::Error> {
        let (due, now) = (self.arbiter.state().decision, ports.now());
        let Self { past, records, unreadable, .. } = self;
        let mut refusals = past.serve(|request: &PastRequest| {
            if (request.run, request.robot) != (records.run(), ROBOT) {
                return None;
            }
            let mut page = match records.page(request.from) {
                Ok(page) => page,
                Err(error) => {
                    if Trouble::note(unreadable, &error, now) {
                        tracing::error!("the past cannot be served: {error}");
                    }
                    return None;
                }
            };
            *unreadable = None;
            // A hop that is still in the air has not been seen to land.
            page.records.retain(|record| record.decision < due);
            Some(page)
        })?;
        if let Some(details) = &mut self.details {
            let records = &self.records;
            refusals.extend(details.serve(|request: &DetailRequest| {
                let DetailRequest { run, decision } = *request;
                if run != records.run() || decision >= due {
                    return None;
                }
                match records.detail(decision) {
                    Ok(detail) => detail.map(|detail| DetailPage { run, decision, detail }),
                    Err(error) => {
                        if Trouble::note(&mut self.unreadable, &error, now) {
                            tracing::error!("details cannot be served: {error}");
                        }
                        None
                    }
                }
            })?);
        }
        let Self { truths, arbiter, .. } = self;
        let page = |request: &TruthRequest| arbiter.mission().truth_page(request, TRUTH_PAGE_CELLS);
        refusals.extend(truths.serve(page)?);
        let Self { routes, priors, arbiter, .. } = self;
        if let Some(routes) = routes {
            let run = arbiter.state().run;
            let page = |request: &RouteRequest| {
                if request.run != run {
                    return None;
                }
                let route = arbiter.committed_route(request.id)?;
                Some(RoutePage { run, route: route.clone() })
            };
            refusals.extend(routes.serve(page)?);
        }
        if let Some(priors) = priors {
            let page = |request: &PriorRequest| arbiter.mission().prior_page(request, PRIOR_PAGE_CELLS);
            refusals.extend(priors.serve(page)?);
        }
        if let Some(tables) = &mut self.tables {
            let mission = self.arbiter.mission();
            refusals.extend(tables.serve(|request| mission.table_page(request, TABLE_PAGE_ROWS))?);
        }
        for refusal in refusals {
            self.refused(refusal, ports).await?;
        }
        Ok(())
    }

    /// Logs a malformed message, and counts it.
    async fn refused(&mut self, refusal: Refusal, ports: &mut P) -> Result<(), P::Error> {
        log_refusal(&refusal);
        self.feed(Event::Refused(refusal), ports).await
    }

    /// The mission begins once somebody can sense and somebody plans for the robot that is due, so that no decision's time counts the
    /// wait for processes to start, or for perception to gather the truth. A mission that is over is served to
    /// every peer that joins, and one that was under way with a fallback goes on at once.
    fn is_assembled(&mut self, now: MonotonicNs) -> bool {
        self.assembled = self.assembled || self.arbiter.is_manned(self.membership.peer_table(), now);
        self.assembled
    }

    /// Tells the arbiter at once, and carries out what it wants: the future does not hold the event, which is large.
    fn feed<'a>(
        &'a mut self,
        event: Event,
        ports: &'a mut P,
    ) -> impl Future<Output = Result<(), P::Error>> + 'a {
        let effects = self.arbiter.on(event, ports.now());
        self.carry_out(effects, ports)
    }

    /// Carries out what the arbiter wants, in order.
    async fn carry_out(&mut self, mut effects: Vec<Effect>, ports: &mut P) -> Result<(), P::Error> {
        let mut next = 0;
        while let Some(effect) = effects.get(next) {
            next += 1;
            match effect {
                Effect::Append(record) => {
                    let more = self.append(record, ports).await;
                    // An append is the last thing asked for: the list is taken as it is.
                    if next == effects.len() { (effects, next) = (more, 0) } else { effects.extend(more) }
                }
                Effect::Announce => self.announce()?,
                Effect::Publish(state) => {
                    if let (Some(teams), Some(team)) = (&mut self.teams, self.arbiter.team()) {
                        teams.publish(team.clone())?;
                    }
                    self.states.publish(*state)?;
                    ports.pass(crash::PUBLISHED).await;
                }
                Effect::Refused(refusal) => tracing::debug!(reason = refusal.reason(), "refused: {refusal}"),
                Effect::Finished(status) => self.finished = Some(*status),
            }
        }
        Ok(())
    }

    /// The commit point.
    async fn append(&mut self, record: &Record, ports: &mut P) -> Vec<Effect> {
        ports.pass(crash::BEFORE_APPEND).await;
        let attachment = self.arbiter.attachment(record);
        match self.records.append(record, attachment.as_ref()) {
            Ok(()) => {
                ports.pass(crash::APPENDED).await;
                let now = ports.now();
                let mut committed = *record;
                committed.timing.committed = now;
                (self.executed)(&committed);
                if record.origin.is_fallback() {
                    let (decision, action, origin) = (record.decision, record.action, record.origin);
                    tracing::warn!(
                        "no acceptable command for decision {decision}: fell back to {action}, by {origin}"
                    );
                }
                if std::mem::take(&mut self.holding) {
                    tracing::info!("the journal took decision {}: going on", record.decision);
                }
                self.arbiter.on(Event::Appended, now)
            }
            Err(error) => {
                ports.pass(crash::APPEND_FAILED).await;
                // Every tick tries again: log it once.
                let now = ports.now();
                let is_news = match error {
                    JournalError::Displaced { .. } => Trouble::note(&mut self.displaced, &error, now),
                    _ => !std::mem::replace(&mut self.holding, true),
                };
                if is_news {
                    tracing::error!("holding at decision {}: {error}", record.decision);
                }
                self.arbiter.on(Event::AppendFailed, now)
            }
        }
    }

    fn remember(&mut self, beat: &Heartbeat) {
        let lives = self.lives.entry(beat.role).or_default();
        let is_known = lives.iter().any(|(incarnation, _)| *incarnation == beat.incarnation);
        if !is_known && lives.len() < LIVES_MAX {
            lives.push((beat.incarnation, beat.pid));
        }
    }

    /// Publishes the pacing when it has changed, and again now and then: a screen that missed a pause would never
    /// offer to resume.
    fn publish_pacing(&mut self, now: MonotonicNs) -> Result<(), P::Error> {
        let pacing = self.arbiter.pacing();
        // Whose turn it is does not matter.
        let is_same = |(sent, _): (Pacing, _)| Pacing { robot: pacing.robot, ..sent } == pacing;
        let changed = !self.pacing_sent.is_some_and(is_same);
        if changed && self.pacing_sent.is_some() {
            tracing::info!(paused = pacing.paused, pace = %pacing.pace, "ordered to change the pacing");
        }
        if changed || self.pacing_sent.is_some_and(|(_, at)| now.since_ns(at) >= PACING_NS) {
            self.pacing_sent = Some((pacing, now));
            self.pacings.publish(pacing)?;
        }
        self.pacings.idle();
        Ok(())
    }

    /// Looks for the journal every [`CHECK_NS`], and before leaving: no outcome is reported that it does not hold.
    ///
    /// # Errors
    /// Exit code 1 if it is displaced, or its past cannot be read, for longer than patience lasts.
    fn check_records(&mut self, now: MonotonicNs) -> Result<(), Failure> {
        if self.finished.is_some() || now.since_ns(self.checked) >= CHECK_NS {
            self.checked = now;
            match self.records.check() {
                Err(error) => {
                    if Trouble::note(&mut self.displaced, &error, now) {
                        tracing::error!("holding at decision {}: {error}", self.arbiter.state().decision);
                    }
                }
                Ok(()) if self.displaced.take().is_some() => {
                    tracing::info!("the journal is back: going on");
                }
                Ok(()) => {}
            }
        }
        let endured = |trouble: &&Trouble| trouble.lasted_ns() >= self.patience_ns;
        match self.displaced.iter().chain(&self.unreadable).find(endured) {
            Some(trouble) => {
                let patience = Duration::from_nanos(self.patience_ns);
                Err(Failure::run(format!("held for {patience:?}: {}", trouble.why())))
            }
            None => Ok(()),
        }
    }

    /// What is missing, and the command that starts it. A planner is asked for as soon as it is missing, not only when the
    /// turn of its robot comes.
    fn waits_for(&self, instance: Option<&str>, now: MonotonicNs) -> Option<String> {
        if self.arbiter.falls_back() {
            return None;
        }
        let alive = self.membership.peer_table().live(now).map(|peer| peer.beat);
        let missing = MissingPeer::among(self.arbiter.acting(), alive)?;
        Some(format!("{missing} ({}{})", missing.command(instance), missing.and_others()))
    }

    /// Names the living planners that have not decided for long, at times that double: a mission may wait for them for ever.
    fn name_undecided(&mut self, now: MonotonicNs) {
        let State { decision, published, .. } = *self.arbiter.state();
        let (known, due_ns) = self.undecided;
        if known != decision {
            self.undecided = (decision, UNDECIDED_NS);
        }
        // Before all are there, hopper-sim says for whom it waits.
        let waited_ns = if self.assembled { now.since_ns(published) } else { 0 };
        if known != decision || waited_ns < due_ns {
            return;
        }
        let Some(robot) = self.arbiter.awaited() else { return };
        self.undecided = (decision, 2 * waited_ns);
        let alive = self.membership.peer_table().live(now).map(|peer| peer.beat);
        let planners = alive.filter(|beat| beat.role == Role::Planner && beat.robots.has(robot));
        let names: Vec<String> =
            planners.map(|beat| format!("{} (process {})", beat.planner, beat.pid)).collect();
        if !names.is_empty() {
            tracing::warn!(
                "robot {robot} has waited {:.0} s for decision {decision} of {}, which lives and has not decided",
                waited_ns as f64 / 1e9,
                names.join(" or ")
            );
        }
    }

    /// Until the next moment that matters: a tick, or shortly before the landing, which is then awaited awake.
    fn sleep_ns(&self, now: MonotonicNs) -> u64 {
        if !self.assembled {
            return TICK_NS;
        }
        let due_ns = self.arbiter.wake_at().map(|at| at.since_ns(now));
        due_ns.map_or(TICK_NS, |due_ns| due_ns.saturating_sub(AWAKE_NS).min(TICK_NS))
    }
}

impl<P: Ports, R: RecordStore, O: FnMut(&Record)> Process<P> for HopperSim<P, R, O> {
    async fn turn(&mut self, ports: &mut P) -> Result<Turn, Failure> {
        self.receive(ports).await.map_err(Into::into)?;
        self.serve(ports).await.map_err(Into::into)?;
        self.states.idle();
        self.teams.iter_mut().for_each(Writer::idle);
        self.briefs.idle();
        self.publish_pacing(ports.now()).map_err(Into::into)?;
        let State { run, decision, status, .. } = *self.arbiter.state();
        self.membership.tell_robots(self.arbiter.acting());
        self.membership.beat((run, decision, status), ports.now()).map_err(Into::into)?;
        self.check_records(ports.now())?;
        if self.displaced.is_none()
            && let Some(status) = self.finished
        {
            return Ok(Turn::Leave(if status == Status::Goal { Exit::Done } else { Exit::Failed }));
        }
        let now = ports.now();
        self.name_undecided(now);
        let waits_for = self.waits_for(ports.instance_name(), now);
        self.membership.wait_for(waits_for, ports)?;
        Ok(Turn::Sleep(self.sleep_ns(ports.now())))
    }
}
