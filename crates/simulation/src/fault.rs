//! What goes wrong, and when: a plan of faults drawn from a seed, each of which can be left out alone.

use contract::{Name, Role};
use serde::Serialize;

use crate::chance::Chance;
use crate::setup::long::is_long;
use crate::setup::{Missions, Seat};
use crate::stream::Stream;

const MS: u64 = 1_000_000;

/// Most faults of a plan.
const FAULTS_MAX: u64 = 10;

/// Decisions within which faults begin.
const DECISIONS: u64 = 14;

/// One thing that goes wrong.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Fault {
    /// It begins once this many decisions have been executed, those of earlier runs included …
    pub decision: u64,
    /// … and this much time has passed.
    pub after_ns: u64,
    /// What happens then.
    pub kind: Kind,
}

/// Whom a fault befalls.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Victim {
    /// A process of the role, the first there is.
    Role(Role),
    /// The planner in command.
    Leader,
    /// A planner that is not.
    Rival,
}

/// What can go wrong, with its parameters.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(tag = "kind", rename_all = "snake_case")]
pub enum Kind {
    /// The next messages of a stream reach nobody.
    Lose {
        /// The stream.
        stream: Stream,
        /// How many messages, each reader counted alone.
        messages: u64,
    },
    /// The next messages of a stream come twice.
    Duplicate {
        /// The stream.
        stream: Stream,
        /// How many messages, each reader counted alone.
        messages: u64,
        /// How much later the second time, nanoseconds.
        later_ns: u64,
    },
    /// The next messages of a stream come late.
    Delay {
        /// The stream.
        stream: Stream,
        /// How many messages, each reader counted alone.
        messages: u64,
        /// How late the messages come, nanoseconds.
        ns: u64,
    },
    /// The next messages of a stream come the other way round.
    Reorder {
        /// The stream.
        stream: Stream,
        /// How many messages, each reader counted alone.
        messages: u64,
        /// Nanoseconds between them.
        apart_ns: u64,
    },
    /// kill -9.
    Kill {
        /// The process that is killed.
        victim: Victim,
        /// Until a supervisor starts it again, nanoseconds.
        restart_ns: u64,
        /// Whether the supervisor tells a planner whose successor it is.
        succeeds: bool,
    },
    /// kill -9 at a named point of the shells.
    KillAt {
        /// The point.
        point: &'static str,
        /// Until a supervisor starts it again, nanoseconds.
        restart_ns: u64,
    },
    /// SIGSTOP, then SIGCONT.
    Stop {
        /// The process that is stopped.
        victim: Victim,
        /// For how long it is stopped, nanoseconds.
        ns: u64,
    },
    /// SIGSTOP at a named point of the shells, then SIGCONT.
    StopAt {
        /// The point.
        point: &'static str,
        /// For how long the process is stopped, nanoseconds.
        ns: u64,
    },
    /// kill -9 in the midst of the next write to the journal.
    Tear {
        /// How much of it is written, thousandths; 1000 is all.
        thousandths: u64,
        /// Until a supervisor starts hopper-sim again, nanoseconds.
        restart_ns: u64,
    },
    /// The disk fills up.
    Full {
        /// Bytes that can still be written.
        room: u64,
        /// Whether nothing can be cut off either.
        stubborn: bool,
        /// For how long the disk is full, nanoseconds.
        ns: u64,
    },
    /// Another planner comes.
    Rival {
        /// Its algorithm, and the robots that it commands.
        #[serde(flatten)]
        seat: Seat,
        /// Whether it takes over.
        takeover: bool,
        /// Whether it takes every process for gone, as one in another container would.
        blind: bool,
    },
    /// The wall clock jumps; CLOCK_MONOTONIC does not.
    WallClock {
        /// By how much, nanoseconds.
        ns: i64,
    },
    /// The power goes: everything dies, CLOCK_MONOTONIC begins anew, the disk keeps what was durable
    /// and a part of what was not.
    PowerLoss {
        /// The part, thousandths.
        thousandths: u64,
        /// Until everything starts again, nanoseconds.
        restart_ns: u64,
    },
    /// hopper-sim is ended and started on another mission, with another journal.
    NewRun {
        /// Until it starts, nanoseconds.
        restart_ns: u64,
    },
    /// hopper-sim is killed, and its journal loses its last records; all others live on.
    LoseTail {
        /// How many records are lost.
        records: u64,
        /// Until a supervisor starts it again, nanoseconds.
        restart_ns: u64,
    },
    /// hopper-sim is killed, its journal restored to an earlier decision and flown on elsewhere; all others live on.
    Elsewhere {
        /// How many records are lost.
        records: u64,
        /// Algorithm that flies the restored journal elsewhere.
        planner: Name,
        /// How many decisions are executed there at most.
        hops: u64,
        /// Until hopper-sim is started again here, nanoseconds.
        restart_ns: u64,
    },
    /// The journal's path leads elsewhere for a while, or the disk reports a length that the journal has not.
    Misplaced {
        /// What the disk says.
        place: Place,
        /// For how long the path is misplaced, nanoseconds.
        ns: u64,
    },
    /// The next plans of a planner take long.
    Slow {
        /// The planner whose plans take long.
        victim: Victim,
        /// How many plans take long.
        plans: u64,
        /// How long each plan takes, nanoseconds.
        ns: u64,
    },
    /// A planner of another build comes, and means to take over.
    ForeignBuild {
        /// Its algorithm, and the robots that it means to command.
        #[serde(flatten)]
        seat: Seat,
    },
    /// A rogue sends a command that would be accepted but for one field.
    Forge {
        /// Which field of a sound command is wrong.
        forgery: Forgery,
    },
}

/// What a disk says of the journal's path while it is misplaced.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Place {
    /// There is nothing.
    Nowhere,
    /// There is another file.
    Elsewhere,
    /// It is the journal, with a byte more than was written.
    Longer,
    /// It is the journal, with a byte less.
    Shorter,
}

/// What is wrong with a forged command, which takes over as a rogue otherwise.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Forgery {
    /// Another run.
    Run,
    /// A robot that is none of the mission's.
    Robot,
    /// A robot whose turn it is not.
    NotDue,
    /// The robot that is due, with the next term of another.
    TermOfAnother,
    /// A step to where the rover that is due cannot stand, best of all where another one does; a drive that may be a trap.
    Blocked,
    /// A decision that was executed.
    Repeated,
    /// A decision far ahead.
    Future,
    /// The digest of another past.
    Past,
    /// A term that leaps ahead.
    Leap,
    /// A term that has passed.
    Stale,
    /// The term in force, which is somebody else's.
    Usurped,
    /// No command at all.
    Malformed,
    /// An action that only robots of another body can take.
    Kind,
    /// A route whose points nobody has sent.
    UnknownRoute,
    /// A route, points and all, that begins elsewhere than its robot stands.
    RouteElsewhere,
    /// A flight, points and all, that is longer than the budget.
    BeyondBudget,
}

impl Forgery {
    /// The name under which it is counted.
    #[must_use]
    pub fn as_str(self) -> &'static str {
        match self {
            Forgery::Run => "run",
            Forgery::Robot => "robot",
            Forgery::NotDue => "not_due",
            Forgery::TermOfAnother => "term_of_another",
            Forgery::Blocked => "blocked",
            Forgery::Repeated => "repeated",
            Forgery::Future => "future",
            Forgery::Past => "past",
            Forgery::Leap => "leap",
            Forgery::Stale => "stale",
            Forgery::Usurped => "usurped",
            Forgery::Malformed => "malformed",
            Forgery::Kind => "kind",
            Forgery::UnknownRoute => "unknown_route",
            Forgery::RouteElsewhere => "route_elsewhere",
            Forgery::BeyondBudget => "beyond_budget",
        }
    }

    /// The forgeries that are possible in these missions: some need several robots, and some need
    /// routes.
    #[must_use]
    pub fn of(missions: Missions) -> &'static [Forgery] {
        let count = match missions {
            Missions::Hopper | Missions::Protocol => 9,
            Missions::Rovers => 12,
            Missions::Scouts | Missions::Accompanied | Missions::Mixed => Self::ALL.len(),
        };
        &Self::ALL[..count]
    }

    /// Every one.
    pub const ALL: [Forgery; 16] = [
        Forgery::Run,
        Forgery::Robot,
        Forgery::Repeated,
        Forgery::Future,
        Forgery::Past,
        Forgery::Leap,
        Forgery::Stale,
        Forgery::Usurped,
        Forgery::Malformed,
        Forgery::NotDue,
        Forgery::TermOfAnother,
        Forgery::Blocked,
        Forgery::Kind,
        Forgery::UnknownRoute,
        Forgery::RouteElsewhere,
        Forgery::BeyondBudget,
    ];
}

/// The faults of one seed.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Plan {
    /// The missions that the faults are made for.
    pub missions: Missions,
    /// The seed, which also gives the setup and every small delay.
    pub seed: u64,
    /// What goes wrong, in the order of decisions.
    pub faults: Vec<Fault>,
}

impl Plan {
    /// The plan of a seed.
    #[must_use]
    pub fn of(missions: Missions, seed: u64) -> Self {
        let mut chance = Chance::new(seed, "faults");
        let count = chance.between(1, FAULTS_MAX);
        let mut faults: Vec<Fault> = (0..count).map(|_| fault(missions, seed, &mut chance)).collect();
        let mut follow = Chance::new(seed, "follow");
        let after: Vec<Fault> = faults.iter().filter_map(|fault| follow_up(&mut follow, fault)).collect();
        let mut power = Chance::new(seed, "power");
        let losses: Vec<Fault> = faults.iter().flat_map(|fault| power_losses(&mut power, fault)).collect();
        faults.extend(after);
        faults.extend(losses);
        if is_long(seed) {
            stretch(&mut Chance::new(seed, "long faults"), &mut faults);
        }
        faults.sort_by_key(|fault| fault.decision);
        Self { missions, seed, faults }
    }
}

/// Every named point of the shells at which a process may die or be stopped.
pub fn points() -> Vec<&'static str> {
    [
        hopper_sim::CRASH_POINTS,
        perception::process::CRASH_POINTS,
        planner::process::CRASH_POINTS,
        monitor::process::CRASH_POINTS,
    ]
    .concat()
}

fn fault(missions: Missions, seed: u64, chance: &mut Chance) -> Fault {
    let after_ns = if chance.one_in(2) { 0 } else { chance.duration_ns(1_000, 200 * MS) };
    Fault { decision: chance.below(DECISIONS), after_ns, kind: kind(missions, seed, chance) }
}

/// Spreads faults over a mission of many decisions, and has every process begin anew once the past needs several pages.
fn stretch(chance: &mut Chance, faults: &mut Vec<Fault>) {
    for fault in faults.iter_mut() {
        fault.decision *= chance.between(20, 50);
        if let Kind::LoseTail { records, .. } | Kind::Elsewhere { records, .. } = &mut fault.kind {
            *records *= chance.between(1, 50);
        }
    }
    for role in [Role::HopperSim, Role::Perception, Role::Planner, Role::Monitor] {
        let (victim, restart_ns) = (Victim::Role(role), chance.duration_ns(MS, 100 * MS));
        let decision = chance.between(260, 400);
        let kind = Kind::Kill { victim, restart_ns, succeeds: chance.one_in(2) };
        faults.push(Fault { decision, after_ns: 0, kind });
    }
}

/// What follows a fault now and then: two that matter together hardly ever meet by chance.
fn follow_up(chance: &mut Chance, fault: &Fault) -> Option<Fault> {
    match fault.kind {
        // A record that is on the disk, but not durable, is published again by the next life; then the power goes.
        Kind::Tear { restart_ns, .. } if chance.one_in(2) => Some(Fault {
            decision: fault.decision,
            after_ns: fault.after_ns + restart_ns + chance.duration_ns(MS, 30 * MS),
            kind: Kind::PowerLoss { thousandths: 0, restart_ns: chance.duration_ns(MS, 100 * MS) },
        }),
        _ => None,
    }
}

/// Losses of power around the cut of a torn tail, now and then: one that leaves a part of the tail on the disk, and one between
/// its cut and the next append; or one while an append that failed is still to be cut.
fn power_losses(chance: &mut Chance, fault: &Fault) -> Vec<Fault> {
    if !chance.one_in(3) {
        return Vec::new();
    }
    let restart_ns = chance.duration_ns(MS, 20 * MS);
    let mut loss = |after_ns: u64| Fault {
        decision: fault.decision,
        after_ns: fault.after_ns + after_ns,
        kind: Kind::PowerLoss { thousandths: chance.between(0, 1000), restart_ns },
    };
    match fault.kind {
        Kind::Tear { .. } => {
            let torn_ns = 6 * MS;
            // Whoever dies by it begins again within 30 ms of its end; the next decision takes longer.
            vec![loss(torn_ns), loss(torn_ns + restart_ns + 32 * MS)]
        }
        Kind::Full { ns, .. } => vec![loss(ns / 2)],
        _ => Vec::new(),
    }
}

// Long: an arm for each kind.
fn kind(missions: Missions, seed: u64, chance: &mut Chance) -> Kind {
    let stream = chance.pick(&Stream::all(missions));
    let messages = chance.between(1, 12);
    let restart_ns = chance.duration_ns(MS, 1500 * MS);
    let ns = chance.duration_ns(MS, 3000 * MS);
    let point = chance.pick(&points());
    let victim = chance.pick(&[
        Victim::Role(Role::HopperSim),
        Victim::Role(Role::Perception),
        Victim::Role(Role::Planner),
        Victim::Role(Role::Monitor),
        Victim::Leader,
        Victim::Leader,
        Victim::Rival,
    ]);
    match chance.below(41) {
        0..4 => Kind::Lose { stream, messages },
        4..6 => Kind::Duplicate { stream, messages, later_ns: chance.duration_ns(10_000, 500 * MS) },
        6..9 => Kind::Delay { stream, messages, ns: chance.duration_ns(10_000, 500 * MS) },
        9..11 => Kind::Reorder { stream, messages, apart_ns: chance.duration_ns(10_000, 30 * MS) },
        11..14 => Kind::Kill { victim, restart_ns, succeeds: chance.one_in(2) },
        14..17 => Kind::KillAt { point, restart_ns },
        17..19 => Kind::Stop { victim, ns },
        19..21 => Kind::StopAt { point, ns },
        21 => Kind::Tear { thousandths: chance.between(0, 1250).min(1000), restart_ns },
        22 => Kind::Full { room: chance.below(600), stubborn: chance.one_in(2), ns },
        23..27 => Kind::Rival {
            seat: missions.seat(seed, chance),
            takeover: !chance.one_in(3),
            blind: chance.one_in(4),
        },
        27 => Kind::WallClock { ns: chance.pick(&[-1, 1]) * chance.duration_ns(MS, 1 << 50) as i64 },
        28 => Kind::PowerLoss { thousandths: chance.between(0, 1000), restart_ns },
        29 => Kind::NewRun { restart_ns },
        30 => Kind::ForeignBuild { seat: missions.seat(seed, chance) },
        33 | 34 => Kind::LoseTail { records: chance.between(1, 6), restart_ns },
        // Flown on elsewhere is a hopper's journal only: each robot would need a planner and a term of its own there.
        35 | 36 if ![Missions::Hopper, Missions::Protocol].contains(&missions) => {
            Kind::LoseTail { records: chance.between(1, 6), restart_ns }
        }
        35 | 36 => Kind::Elsewhere {
            records: chance.between(1, 6),
            planner: missions.algorithm(chance),
            hops: chance.between(1, 8),
            restart_ns,
        },
        39 | 40 => Kind::Misplaced {
            place: chance.pick(&[Place::Nowhere, Place::Elsewhere, Place::Longer, Place::Shorter]),
            ns,
        },
        37 | 38 => Kind::Slow {
            victim: chance.pick(&[Victim::Leader, Victim::Rival]),
            plans: chance.between(1, 3),
            ns: chance.between(300 * MS, 1800 * MS),
        },
        _ => Kind::Forge { forgery: chance.pick(Forgery::of(missions)) },
    }
}

impl Kind {
    /// The name under which it is counted.
    #[must_use]
    pub fn as_str(&self) -> &'static str {
        match self {
            Kind::Lose { .. } => "lose",
            Kind::Duplicate { .. } => "duplicate",
            Kind::Delay { .. } => "delay",
            Kind::Reorder { .. } => "reorder",
            Kind::Kill { .. } => "kill",
            Kind::KillAt { .. } => "kill_at",
            Kind::Stop { .. } => "stop",
            Kind::StopAt { .. } => "stop_at",
            Kind::Tear { .. } => "tear",
            Kind::Full { .. } => "full",
            Kind::Rival { .. } => "rival",
            Kind::WallClock { .. } => "wall_clock",
            Kind::PowerLoss { .. } => "power_loss",
            Kind::NewRun { .. } => "new_run",
            Kind::Forge { .. } => "forge",
            Kind::ForeignBuild { .. } => "foreign_build",
            Kind::LoseTail { .. } => "lose_tail",
            Kind::Elsewhere { .. } => "elsewhere",
            Kind::Slow { .. } => "slow",
            Kind::Misplaced { .. } => "misplaced",
        }
    }
}
