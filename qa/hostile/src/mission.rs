//! A whole mission, every message of which may be damaged on its way.
//!
//! Arbiter, cartographer, pilot and watcher speak to one another as in a mission; the bytes of the input say
//! who is heard next and which fields of the message are damaged on its way. What is refused is counted, what
//! passes the checks of the wire is acted upon: no machine may panic, whatever passes, and the arbiter
//! executes one command a decision.

use std::collections::VecDeque;

use contract::limits::PAST_PAGE_RECORDS;
use contract::wire::{
    BriefV10, CommandV3, GroundV2, HeartbeatV2, MapPageV2, MapPatchV2, MapRequestV1, PastHeaderV1,
    PastRequestV1, RecordV5, RobotV1, SeenCellV4, StateV4, TruthPageV1, TruthRequestV1, Wire,
    brief_from_wire, map_page_from_wire, page_from_wire, patch_from_wire, truth_page_from_wire,
};
use contract::{
    Command, Decision, Heartbeat, Incarnation, MapPatch, MapRequest, MonotonicNs, PastPage, PastRequest,
    Record, Role, State, TruthPage, TruthRequest,
};
use hopper_sim::{Arbiter, Pace, ROBOT};
use monitor::watcher::{self, Watcher};
use perception::cartographer::{self, Cartographer};
use planner::pilot::{self, Pilot, PilotConfig};
use planner::{Budget, algorithm};

use crate::fixtures;

/// Most turns of one input.
const TURNS_MAX: usize = 96;

/// Work that a plan may take.
const WORK_MAX: u64 = 20_000;

/// Flies the mission that the bytes script.
pub fn read(bytes: &[u8]) {
    let mut processes = Processes::new(bytes);
    for _ in 0..TURNS_MAX {
        let Some(turn) = processes.script.byte() else { break };
        processes.turn(turn);
    }
    let _ = (
        processes.watcher.progress(processes.now),
        processes.watcher.latency(),
        processes.pilot.seen(),
        processes.cartographer.seen(),
    );
}

/// A mission to its end undisturbed, and one with a damaged field now and then.
#[must_use]
pub fn seeds() -> Vec<Vec<u8>> {
    // Header and robots of a brief are damaged apart, by a byte each.
    let honest = |turn: u8| if turn == 0 { vec![0; 3] } else { vec![turn, 0] };
    let round = [0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11];
    let calm: Vec<u8> = round.iter().cycle().take(90).flat_map(|&turn| honest(turn)).collect();
    let rough = round.iter().cycle().take(90).enumerate().flat_map(|(index, &turn)| {
        let damage = [1, (7 * index) as u8, 0, 4, 0, 0, 0, 0];
        if index % 5 == 4 { [turn].into_iter().chain(damage).collect() } else { honest(turn) }
    });
    vec![calm, rough.collect()]
}

/// Takes bytes from the input.
struct Script<'a>(&'a [u8]);

impl Script<'_> {
    fn byte(&mut self) -> Option<u8> {
        let (first, rest) = self.0.split_first()?;
        self.0 = rest;
        Some(*first)
    }

    fn number(&mut self, bytes: usize) -> u64 {
        (0..bytes).fold(0, |number, place| number | u64::from(self.byte().unwrap_or(0)) << (8 * place))
    }

    /// The message with up to three of its words replaced: the next byte says how many.
    fn damaged<W: Wire>(&mut self, message: W) -> W {
        let mut wire = message;
        let bytes = bytemuck::bytes_of_mut(&mut wire);
        for _ in 0..self.byte().unwrap_or(0) % 4 {
            let place = self.number(2) as usize;
            let size = [1, 2, 4, 8][self.number(1) as usize % 4];
            let at = place % bytes.len() / size * size;
            let Some(word) = bytes.get_mut(at..at + size) else { continue };
            word.copy_from_slice(&self.number(size).to_le_bytes()[..size]);
        }
        wire
    }
}

struct Processes<'a> {
    script: Script<'a>,
    now: MonotonicNs,
    arbiter: Arbiter,
    cartographer: Cartographer,
    pilot: Pilot,
    watcher: Watcher,
    records: Vec<Record>,
    commands: VecDeque<Command>,
    patches: VecDeque<MapPatch>,
    map_requests: VecDeque<MapRequest>,
    past_requests: VecDeque<(Role, PastRequest)>,
    truth_requests: VecDeque<TruthRequest>,
}

impl<'a> Processes<'a> {
    fn new(bytes: &'a [u8]) -> Self {
        let now = MonotonicNs(1_000_000_000);
        let config = PilotConfig {
            robots: contract::RobotSet::default(),
            incarnation: fixtures::LIFE,
            pid: 100,
            planner: fixtures::heartbeat().planner,
            takeover: false,
            succeeds_pid: None,
        };
        Self {
            script: Script(bytes),
            now,
            arbiter: Arbiter::new(fixtures::mission(), None, Pace::Max, 1_000_000_000, now),
            cartographer: Cartographer::new(ROBOT),
            pilot: Pilot::new(config),
            watcher: Watcher::new(ROBOT),
            records: Vec::new(),
            commands: VecDeque::new(),
            patches: VecDeque::new(),
            map_requests: VecDeque::new(),
            past_requests: VecDeque::new(),
            truth_requests: VecDeque::new(),
        }
    }

    /// One message goes its way, or time passes.
    fn turn(&mut self, turn: u8) {
        self.now = self.now.plus_ns(5_000_000);
        match turn % 13 {
            0 => self.brief(),
            1 => self.truth(),
            2 => self.arbiter(hopper_sim::Event::Tick),
            3 => self.state(Role::Perception),
            4 => self.state(Role::Planner),
            5 => self.state(Role::Monitor),
            6 => self.patch(),
            7 => self.page(),
            8 => self.cartographer(cartographer::Event::Tick),
            9 => self.pilot(pilot::Event::Tick),
            10 => self.command(),
            11 => self.past(),
            _ => self.heartbeat(),
        }
    }

    fn brief(&mut self) {
        let brief = self.arbiter.mission().brief.clone();
        let header = self.script.damaged(BriefV10::from(&brief));
        let robots = brief.robots.iter().map(RobotV1::from).collect();
        if let Ok(brief) = brief_from_wire(&header, &self.one_damaged(robots)) {
            self.cartographer(cartographer::Event::Brief(brief.clone()));
            self.pilot(pilot::Event::Brief(brief.clone()));
            self.watcher(watcher::Event::Brief(brief));
        }
    }

    fn truth(&mut self) {
        let asked = self.truth_requests.pop_front().unwrap_or(TruthRequest { run: fixtures::RUN, from: 0 });
        let wire = self.script.damaged(TruthRequestV1::from(&asked));
        let Ok(request) = TruthRequest::try_from(&wire) else { return };
        let terrain = &self.arbiter.mission().terrain;
        let rest = terrain.cells.get(request.from as usize..).unwrap_or_default();
        let cells = rest[..rest.len().min(16)].to_vec();
        let treasures = terrain.treasures.clone();
        let page = TruthPage { run: fixtures::RUN, grid: terrain.grid, from: request.from, cells, treasures };
        let header = self.script.damaged(TruthPageV1::from(&page));
        let cells: Vec<_> = page.cells.iter().map(GroundV2::from).collect();
        if let Ok(page) = truth_page_from_wire(&header, &self.one_damaged(cells)) {
            self.cartographer(cartographer::Event::Truth(page));
        }
    }

    fn state(&mut self, reader: Role) {
        let wire = self.script.damaged(StateV4::from(self.arbiter.state()));
        match (State::try_from(&wire), reader) {
            (Ok(state), Role::Perception) => self.cartographer(cartographer::Event::State(state)),
            (Ok(state), Role::Planner) => self.pilot(pilot::Event::State(state)),
            (Ok(state), _) => self.watcher(watcher::Event::State(state)),
            (Err(refusal), _) => self.watcher(watcher::Event::Refused(refusal)),
        }
    }

    fn patch(&mut self) {
        let patch = self.patches.pop_front().unwrap_or_else(crate::wire::patch);
        let header = self.script.damaged(MapPatchV2::from(&patch));
        let cells = self.one_damaged(patch.cells.iter().map(SeenCellV4::from).collect());
        match patch_from_wire(&header, &cells) {
            Ok(patch) => {
                self.watcher(watcher::Event::Map(patch.clone()));
                self.pilot(pilot::Event::Patch(patch));
            }
            Err(refusal) => self.pilot(pilot::Event::Refused(refusal)),
        }
    }

    fn page(&mut self) {
        let Some(asked) = self.map_requests.pop_front() else { return };
        let wire = self.script.damaged(MapRequestV1::from(&asked));
        let Ok(request) = MapRequest::try_from(&wire) else { return };
        let page = self.cartographer.page(&request).unwrap_or_else(crate::wire::page);
        let header = self.script.damaged(MapPageV2::from(&page));
        let cells = self.one_damaged(page.cells.iter().map(SeenCellV4::from).collect());
        match map_page_from_wire(&header, &cells) {
            Ok(page) => self.pilot(pilot::Event::Page(page)),
            Err(refusal) => self.pilot(pilot::Event::Refused(refusal)),
        }
    }

    fn command(&mut self) {
        let honest = self.commands.pop_front().unwrap_or_else(|| fixtures::command(self.arbiter.state()));
        let wire = self.script.damaged(CommandV3::from(&honest));
        self.arbiter(hopper_sim::Event::Command(Command::try_from(&wire)));
    }

    fn past(&mut self) {
        let (run, robot) = (fixtures::RUN, ROBOT);
        let asked = self.past_requests.pop_front();
        let (reader, asked) = asked.unwrap_or((Role::Monitor, PastRequest { run, robot, from: Decision(0) }));
        let wire = self.script.damaged(PastRequestV1::from(&asked));
        let Ok(request) = PastRequest::try_from(&wire) else { return };
        let from = usize::try_from(request.from.0).unwrap_or(usize::MAX).min(self.records.len());
        let until = (from + PAST_PAGE_RECORDS).min(self.records.len());
        let page = PastPage { run, robot, from: request.from, records: self.records[from..until].to_vec() };
        let header = self.script.damaged(PastHeaderV1::from(&page));
        let records = self.one_damaged(page.records.iter().map(RecordV5::from).collect());
        match (page_from_wire(&header, &records), reader) {
            (Ok(page), Role::Perception) => self.cartographer(cartographer::Event::Past(page)),
            (Ok(page), _) => self.watcher(watcher::Event::Past(page)),
            (Err(refusal), _) => self.watcher(watcher::Event::Refused(refusal)),
        }
    }

    fn heartbeat(&mut self) {
        let life = self.script.byte().unwrap_or(0);
        let honest = Heartbeat {
            role: Role::ALL[usize::from(life) % Role::ALL.len()],
            incarnation: Incarnation(1 + u64::from(life)),
            counter: self.now.0,
            ..fixtures::heartbeat()
        };
        let wire = self.script.damaged(HeartbeatV2::from(&honest));
        if let Ok(beat) = Heartbeat::try_from(&wire) {
            self.arbiter(hopper_sim::Event::Heartbeat(beat));
            self.pilot(pilot::Event::Heartbeat(beat));
            self.watcher(watcher::Event::Heartbeat(beat));
        }
    }

    /// The cells of a message, one of them damaged.
    fn one_damaged<C: Wire>(&mut self, mut cells: Vec<C>) -> Vec<C> {
        let which = self.script.byte().unwrap_or(0);
        if which > 0 && !cells.is_empty() {
            let which = usize::from(which) % cells.len();
            cells[which] = self.script.damaged(cells[which]);
        }
        cells
    }

    fn arbiter(&mut self, event: hopper_sim::Event) {
        let before = *self.arbiter.state();
        let mut events = vec![event];
        while let Some(event) = events.pop() {
            for effect in self.arbiter.on(event, self.now) {
                if let hopper_sim::Effect::Append(record) = effect {
                    assert_eq!((record.decision, record.previous), (before.decision, before.digest));
                    self.records.push(record);
                    events.push(hopper_sim::Event::Appended);
                }
            }
        }
        let after = self.arbiter.state();
        assert!(after.leader.term >= before.leader.term, "terms only rise");
        assert_eq!(after.decision.0, self.records.len() as u64, "one command a decision");
    }

    fn cartographer(&mut self, event: cartographer::Event) {
        for effect in self.cartographer.on(event, self.now) {
            match effect {
                cartographer::Effect::RequestPast(request) => {
                    self.past_requests.push_back((Role::Perception, request))
                }
                cartographer::Effect::RequestTruth(request) => self.truth_requests.push_back(request),
                cartographer::Effect::PublishMap => {
                    let now = self.now;
                    self.patches.extend(self.cartographer.patches(now, &mut || now));
                }
                cartographer::Effect::RequestRoute(_)
                | cartographer::Effect::Refused(_)
                | cartographer::Effect::Finished(_) => {}
            }
        }
    }

    fn pilot(&mut self, event: pilot::Event) {
        let mut events = vec![event];
        while let Some(event) = events.pop() {
            for effect in self.pilot.on(event, self.now) {
                match effect {
                    pilot::Effect::RequestMap(request) => self.map_requests.push_back(request),
                    pilot::Effect::Send(command) => self.commands.push_back(command),
                    pilot::Effect::Plan => events.extend(self.plan()),
                    _ => {}
                }
            }
        }
    }

    /// Plans with whatever algorithm the script names, for whatever situation hostile messages make.
    fn plan(&mut self) -> Option<pilot::Event> {
        let which = usize::from(self.script.byte().unwrap_or(0)) % planner::ALGORITHMS.len();
        let mut planner = algorithm(planner::ALGORITHMS[which]).expect("a built-in algorithm");
        let situation = self.pilot.situation()?;
        if situation.brief.grid.cells() > 4096 {
            return None;
        }
        let plan = planner.plan(&situation, &Budget::of(Some(WORK_MAX)));
        Some(pilot::Event::Planned(plan, self.now, self.now))
    }

    fn watcher(&mut self, event: watcher::Event) {
        for effect in self.watcher.on(event, self.now) {
            if let watcher::Effect::RequestPast(request) = effect {
                self.past_requests.push_back((Role::Monitor, request));
            }
        }
    }
}
