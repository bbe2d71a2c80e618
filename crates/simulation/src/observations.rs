//! What the world notes of every message: for the checker, for the counters of rare events, and for faults.

use std::any::Any;

use contract::limits::PAST_PAGE_RECORDS;
use contract::{
    Action, Announcement, Brief, Command, Control, Heartbeat, Incarnation, MapPage, MapPatch, MapRequest,
    Message, MonotonicNs, Order, Pacing, PastPage, PastRequest, Policy, PriorPage, PriorRequest, Record,
    Role, RoutePage, RouteRequest, State, TablePage, Team, TruthPage, TruthRequest,
};
use planner::Situation;
use recording::{Recording, last_run};

use crate::checker::Known;
use crate::life::Life;
use crate::life::Pass;
use crate::recorded::decisions_recorded;
use crate::setup::Missions;
use crate::stream::Asked;
use crate::stream::Stream;
use crate::world::MS;
use crate::world::World;

mod routes;

impl World {
    /// The checker looks at what the journal has just taken.
    pub fn check_commit(&mut self, life: &Life) {
        let Some(frame) = self.disk.take_write() else { return };
        let Some(record) = hopper_sim::journal::record_of(&frame) else { return };
        let events = self.checker.events(self.setup.missions, &record);
        events.into_iter().for_each(|(group, name)| self.coverage.count(group, name));
        self.checker.executed(&record);
        let treasures = self.checker.treasures_known();
        self.checker.committed(&record);
        if self.checker.model().is_all_waiting() {
            self.coverage.count("ended", "while_all_wait");
        }
        let now = self.monotonic();
        self.checker.launched(&record, now);
        self.checker.passed_over(&record, &self.lives);
        if record.action == Action::Fly && self.checker.treasures_known() > treasures {
            self.coverage.count("scouts", "treasure_spotted");
        }
        self.checker.journalled(&record, &frame);
        let run = self.checker.mission().brief.run;
        let found = self.stamps.appended(life.incarnation, run, &record);
        self.stamped(found);
        self.decisions += 1;
        self.stirred_ns = self.stirred_ns.max(self.time_ns);
        let Record { robot, decision, action, leader, .. } = record;
        if record.origin.is_fallback() {
            self.coverage.count("fallback", record.origin.as_str());
            let origin = record.origin;
            self.note(|| {
                format!("committed: decision {decision}, robot {robot}, {action}, by the fallback ({origin})")
            });
        } else {
            self.note(|| {
                let (planner, term) = (leader.planner, leader.term);
                format!(
                    "committed: decision {decision}, robot {robot}, {action}, by {planner} in term {term}"
                )
            });
        }
    }

    /// The checker looks at what is published.
    pub fn published<M: Message>(&mut self, life: &Life, message: &M) {
        let message = message as &dyn Any;
        let now = self.monotonic();
        if let Some(state) = message.downcast_ref::<State>() {
            self.checker.published(state, now);
            let pace = (!self.setup.control).then_some(self.setup.pace);
            let before = state.decision.0.checked_sub(1);
            let last = before.and_then(|before| self.checker.records().get(before as usize));
            let found = self.stamps.state(life.incarnation, state, pace, last, now);
            self.stamped(found);
            self.count_state(state);
            self.note(|| format!("hopper-sim publishes state {} ({})", state.decision, state.status));
        } else if let Some(team) = message.downcast_ref::<Team>() {
            self.checker.team_published(team);
            self.note(|| format!("hopper-sim publishes robots {}: {} is due", team.decision, team.due));
        } else if let Some(patch) = message.downcast_ref::<MapPatch>() {
            self.checker.mapped(patch);
            let found = self.stamps.patch(life.incarnation, patch, now);
            self.stamped(found);
            // Landings that perception folds from the past are in no patch, and a map that is built anew may be another.
            let follows = self.patched.is_none_or(|(sequence, after)| {
                let again = (patch.sequence, patch.after) == (sequence, after);
                again || (patch.sequence, patch.before) == (sequence + 1, after)
            });
            self.patched = Some((patch.sequence, patch.after));
            if !follows {
                self.lives.iter().for_each(|life| life.disturb_map(self.time_ns));
            }
            self.coverage.count("map", if patch.more > 0 { "part" } else { "landing" });
            self.note(|| {
                let MapPatch { sequence, through, more, .. } = patch;
                let cells = patch.cells.len();
                format!("perception publishes patch {sequence} through {through}, {cells} cells, {more} more")
            });
        } else if let Some(command) = message.downcast_ref::<Command>() {
            self.sent(life, command, now);
            let found = self.stamps.command(life.incarnation, command);
            self.stamped(found);
        } else if let Some(announcement) = message.downcast_ref::<Announcement>() {
            self.checker.announced(announcement);
            self.note(|| {
                let Announcement { robot, route, .. } = announcement;
                let points: Vec<String> = route.waypoints().iter().map(ToString::to_string).collect();
                format!("a route is published for robot {robot}: {}", points.join(", "))
            });
        } else if let Some(pacing) = message.downcast_ref::<Pacing>() {
            self.checker.paced(pacing);
            self.coverage.count("tempo", if pacing.paused { "paused" } else { "running" });
        } else if message.is::<Policy>() {
            let readers = self.readers::<Policy>();
            self.checker.policy_published(readers);
            self.coverage.count("policy", "published");
        } else if let Some(beat) = message.downcast_ref::<Heartbeat>() {
            self.acknowledged(life, beat, now);
        } else if message.is::<Brief>() {
            self.coverage.count("run", "announced");
        }
    }

    /// The first heartbeat of a recording monitor that acknowledges the end of the mission.
    pub fn acknowledged(&mut self, life: &Life, beat: &Heartbeat, now: MonotonicNs) {
        if !beat.status.is_over() || beat.run != self.checker.mission().brief.run {
            return;
        }
        if let Some(recording) = life.recording.take() {
            let decisions = decisions_recorded(&recording.borrow(), beat.run);
            let found = self.check_recording(&recording.borrow());
            self.figured(found);
            self.checker.recorded(life.incarnation, &decisions, now);
            self.coverage.count("recording", "acknowledged");
        }
    }

    /// Every message of a recording has the stamps that it was published with, and the decisions that are read from it those
    /// that they had.
    fn check_recording(&self, bytes: &[u8]) -> Result<(), String> {
        let recording = Recording::read(bytes).map_err(|error| error.to_string())?;
        for entry in recording.entries() {
            let Some(message) = entry.message().map_err(|error| error.to_string())? else { continue };
            self.stamps.recorded(&message)?;
            let need = message.published().unwrap_or(entry.logged);
            if entry.published != need || entry.logged < entry.published {
                let (published, logged) = (entry.published, entry.logged);
                return Err(format!(
                    "a message of {} is recorded as published at {published:?} and logged at {logged:?}, it was \
                     published at {need:?}",
                    entry.topic
                ));
            }
        }
        let flown = last_run(&recording).map_err(|error| error.to_string())?;
        if flown.brief.run != self.checker.run() {
            return Ok(());
        }
        for timed in &flown.decisions {
            let at = timed.decision.0 as usize;
            let record = self.checker.records().get(at..=at);
            let Some(landing) = record.and_then(|record| self.stamps.landings(record)) else { continue };
            if timed.robot != landing[0].robot || !landing[0].timings().any(|timing| timing == timed.timing) {
                return Err(format!("the recording has {timed:?}, of {:?}", landing[0]));
            }
        }
        Ok(())
    }

    pub fn sent(&mut self, life: &Life, command: &Command, now: MonotonicNs) {
        let known = life.state_seen.get().map(|(run, decision, _)| (run, decision));
        let is_known = known == Some((command.run, command.decision));
        // Of several states that came at once the last counts, which need not be the newest: a command for the decision
        // before is refused as one that is repeated.
        let is_behind = known.is_some_and(|(run, due)| run == command.run && command.decision < due);
        let itself =
            contract::Leader { term: command.term, incarnation: command.incarnation, ..Default::default() };
        let of_team = || life.leader_in_team(command);
        let (leader, since) = match (is_known, is_behind, self.setup.missions) {
            (true, _, Missions::Hopper | Missions::Protocol) => life.leader_seen.get(),
            (true, _, _) => of_team().unwrap_or((itself, now)),
            (false, true, _) => (itself, now),
            (false, false, _) => (contract::Leader::default(), life.leader_seen.get().1),
        };
        let leader_lives = self.lives.iter().any(|life| life.pid == leader.pid);
        let leader = Known { leader, since, is_gone: life.blind || !leader_lives };
        if let Some(cause) = self.checker.sent(command, life, leader, now) {
            self.coverage.count("takeover_asked", cause);
        }
        self.note(|| {
            let Command { decision, action, term, planner, incarnation, robot, .. } = command;
            format!(
                "{planner} {incarnation} sends decision {decision}, {action}, term {term} of robot {robot}"
            )
        });
        if self.checker.is_own(life.version) {
            self.commanded = Some(*command);
        }
    }

    /// The checker looks at what is received.
    pub fn received<M: Message>(&mut self, life: &Life, message: &M) {
        let message = message as &dyn Any;
        let now = self.monotonic();
        if let Some(command) = message.downcast_ref::<Command>()
            && life.role == Role::HopperSim
        {
            let (received, executed) = life.commands.get();
            life.commands.set((received + 1, executed));
            self.stamps.heard(life.incarnation, now);
            self.count_lost_announcement(life, command);
            self.checker.judged(command, now);
        } else if let Some(policy) = message.downcast_ref::<Policy>()
            && life.role == Role::HopperSim
        {
            self.checker.advised(policy);
        } else if let Some(brief) = message.downcast_ref::<Brief>() {
            self.stamps.briefed(life.incarnation, brief.run);
        } else if let Some(state) = message.downcast_ref::<State>() {
            self.knows(life, state, now);
        } else if let Some(team) = message.downcast_ref::<Team>() {
            life.knows_team(team, now);
        } else if let Some(announcement) = message.downcast_ref::<Announcement>() {
            self.route_memory.heard(life, announcement);
            if life.role == Role::HopperSim {
                self.checker.offered(announcement);
            }
        } else if message.is::<MapPatch>() && life.role == Role::Planner {
            if let Pass::Under { .. } = life.pass.get() {
                self.coverage.count("map", "patch_between_pages");
            }
        } else if let Some(beat) = message.downcast_ref::<Heartbeat>() {
            if beat.incarnation != life.incarnation {
                self.checker.heard(life, beat, now);
            }
        } else if let Some(control) = message.downcast_ref::<Control>() {
            self.checker.ordered(life, control, now);
            self.note(|| {
                format!("{} {} receives the order {:?}", life.role, life.incarnation, control.order)
            });
            if life.role == Role::HopperSim {
                self.coverage.count(
                    "order",
                    match control.order {
                        Order::Pause => "pause",
                        Order::Resume => "resume",
                        Order::Step => "step",
                        Order::Pace(_) => "pace",
                        Order::HandOver(_) => "hand_over",
                    },
                );
            }
        }
    }

    /// What a process knows of the mission from now on.
    pub fn knows(&mut self, life: &Life, state: &State, now: contract::MonotonicNs) {
        let known = life.state_seen.get().filter(|(run, ..)| *run == state.run);
        let is_old = known.is_some_and(|(_, decision, published)| {
            state.decision < decision && state.published <= published
        });
        if is_old {
            return;
        }
        life.state_seen.set(Some((state.run, state.decision, state.published)));
        let turn = life.turns.get() + 1;
        if life.leader_at_turn.get().0 != turn {
            life.leader_at_turn.set((turn, life.leader_seen.get()));
        }
        let (_, before) = life.leader_at_turn.get();
        if known.is_some() && before.0 == state.leader {
            life.leader_seen.set(before);
        } else if life.leader_seen.get().0 != state.leader || known.is_none() {
            life.leader_seen.set((state.leader, now));
        }
        let mut runs = life.runs.borrow_mut();
        if !runs.contains(&state.run) {
            runs.push(state.run);
            if runs.len() > 1 {
                self.coverage.count("stayed", life.role.as_str());
            }
        }
    }

    /// Rare events that a published state shows.
    pub fn count_state(&mut self, state: &State) {
        if let [.., before, last] = self.checker.disc_cells()
            && before != last
            && state.decision.0 > 0
        {
            self.coverage.count("map", "discs_differ");
        }
    }

    /// A planner receives a page of the map.
    pub fn paged(&mut self, life: &Life, page: &MapPage) {
        // What was disturbed may be under way for half a second, and lie unread for another half.
        const UNDISTURBED_NS: u64 = 1_100 * MS;
        let awake_ns = self.monotonic().since_ns(life.listening_since.get());
        let is_past = |at_ns: u64| self.time_ns > at_ns + UNDISTURBED_NS;
        // A life to which that never happened has nothing under way from before its birth.
        let quiet = life.disturbed_ns.get().is_none_or(|at_ns| is_past(at_ns) && awake_ns > UNDISTURBED_NS);
        let once = life.repeated_ns.get().is_none_or(is_past);
        let is_clean = match life.pass.get() {
            Pass::Under { is_clean } => is_clean && page.from > 0,
            Pass::None | Pass::Over { .. } => quiet && page.from == 0,
        };
        if (page.next as usize) < page.grid.cells() {
            return life.pass.set(Pass::Under { is_clean: is_clean || quiet && page.from == 0 });
        }
        life.pass.set(Pass::Over { is_clean, turn: life.turns.get() });
        let name = match (is_clean, once) {
            (true, true) => "pass_undisturbed",
            (true, false) => "pass_repeated",
            (false, _) => "pass_disturbed",
        };
        self.coverage.count("map", name);
        if is_clean && once {
            // The map is whole now, whatever was disturbed before: nothing may be asked for any more.
            life.map_whole.set(Some(page.run));
            life.map_disturbed.set(false);
        }
    }

    /// The checker looks at what is asked.
    pub fn asked<Q: 'static>(&mut self, life: &Life, request: &Q) {
        if let Some(request) = (request as &dyn Any).downcast_ref::<RouteRequest>() {
            self.checker.route_asked(request);
            self.count_route_request(life, request);
        }
        if let Pass::Over { turn, .. } = life.pass.get()
            && turn == life.turns.get()
        {
            // The page is received, and not folded in yet: what comes before it may ask once more.
            return;
        }
        if let Some(request) = (request as &dyn Any).downcast_ref::<MapRequest>()
            && life.role == Role::Planner
            && request.from == 0
            && let Pass::Over { is_clean, .. } = life.pass.replace(Pass::None)
        {
            self.coverage.count("map", "asked_again");
            // Where nobody has driven or flown yet the whole map is empty.
            let due = life.state_seen.get().map(|(_, decision, _)| decision);
            let is_empty = request.observation == 0 && self.checker.had_seen(due);
            if is_clean && is_empty && !self.is_another_mission {
                let incarnation = life.incarnation;
                self.checker
                    .violate("a pass over the pages that missed no patch makes the whole map", || {
                        format!("planner {incarnation} asks for all of it again")
                    });
            }
        }
        if let Some(request) = (request as &dyn Any).downcast_ref::<MapRequest>()
            && life.role == Role::Planner
            && life.map_whole.get() == Some(request.run)
            && !life.map_disturbed.get()
            && !self.is_another_mission
        {
            let incarnation = life.incarnation;
            self.checker.violate("who receives every patch asks for no page", || {
                format!("planner {incarnation} asks for the map from cell {}", request.from)
            });
        }
    }

    /// A process takes the answer of a life.
    pub fn answered_to(&mut self, life: &Life, response: &dyn Any, server: Incarnation) {
        if let Some(page) = response.downcast_ref::<PriorPage>() {
            self.count_prior_page(life, page, server);
        }
    }

    /// The checker looks at an answer.
    pub fn answered<Q: 'static, R: 'static>(&mut self, request: &Q, response: &R) {
        let request = request as &dyn Any;
        let response = response as &dyn Any;
        if let Some(page) = response.downcast_ref::<PastPage>() {
            self.checker.served(page);
            if page.from.0 >= PAST_PAGE_RECORDS as u64 && !page.records.is_empty() {
                self.coverage.count("past", "page_beyond_the_first");
            }
            self.coverage.count(Stream::of::<Asked<PastRequest>>().as_str(), "answered");
        } else if let Some(page) = response.downcast_ref::<MapPage>() {
            self.checker.paged(page);
            self.coverage.count(Stream::of::<Asked<MapRequest>>().as_str(), "answered");
        } else if let Some(page) = response.downcast_ref::<PriorPage>() {
            self.checker.prior_served(page);
            self.coverage.count(Stream::of::<Asked<PriorRequest>>().as_str(), "answered");
        } else if let Some(page) = response.downcast_ref::<TablePage>() {
            self.checker.table_served(page);
        } else if let (Some(request), Some(page)) =
            (request.downcast_ref::<RouteRequest>(), response.downcast_ref::<RoutePage>())
        {
            self.checker.route_served(request, page);
            self.coverage.count(Stream::of::<Asked<RouteRequest>>().as_str(), "answered");
        } else if response.is::<TruthPage>() {
            self.coverage.count(Stream::of::<Asked<TruthRequest>>().as_str(), "answered");
        }
    }

    /// Where a planner stands when it plans.
    pub fn plans(&mut self, life: &Life, situation: &Situation<'_>) {
        self.checker.plans(situation);
        let (map, now) = (situation.map, self.monotonic());
        let found = self.stamps.plans(life.incarnation, situation.state, [map.sensed, map.published], now);
        self.stamped(found);
        let state = situation.state;
        life.map_whole.set(Some(state.run));
    }
}
