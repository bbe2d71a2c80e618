//! What perception, planner and monitor have in common: arguments, patience, and a good end.

use std::collections::BTreeMap;
use std::time::Duration;

use contract::roster::SILENCE_NS;
use contract::{Decision, Heartbeat, Incarnation, MonotonicNs, Name, Refusal, Role, Roster, RunId, Status};

use crate::{Exit, Failure, Instance, Node, version};

/// How long a work loop sleeps at most.
pub const TICK: Duration = Duration::from_millis(10);

/// A wait as long as this is told.
const WORTH_A_LINE_NS: u64 = 300_000_000;

/// A peer that has seen the end of the mission goes on beating this long, so that hopper-sim hears it.
const FAREWELL_NS: u64 = 120_000_000;

/// Arguments of every process that waits for hopper-sim.
#[derive(clap::Args, Clone, Debug)]
pub struct PeerArgs {
    /// Instance to belong to; processes of different instances never meet.
    #[arg(long, env = "HOPPER_INSTANCE", default_value = "hopper", value_name = "NAME")]
    pub instance: String,
    /// Give up with exit code 4 when what is waited for does not come within this time, e.g. 30s
    /// [default: wait forever].
    #[arg(long, value_parser = humantime::parse_duration, value_name = "DURATION")]
    pub wait: Option<Duration>,
    /// Stay when the mission has ended, ready for the next.
    #[arg(long)]
    pub stay: bool,
    /// End when standard input closes: the parent holds its other end.
    #[arg(long, hide = true)]
    pub lifeline: bool,
}

/// The message, or nothing with a word on why it was refused.
pub fn accept<T>(message: Option<Result<T, Refusal>>) -> Option<T> {
    match message? {
        Ok(message) => Some(message),
        Err(refusal) => {
            refuse(&refusal);
            None
        }
    }
}

/// A word on why a message was refused.
pub fn refuse(refusal: &Refusal) {
    tracing::warn!(reason = refusal.reason(), "refused a message: {refusal}");
}

/// Lives that a process remembers the build of.
const LIVES_MAX: usize = 1024;

/// Tells peers of this build from those of another, by the first word of each life. One of another build has
/// usually been refused when it joined; a build that does not know how is heard of here.
#[derive(Clone, Debug, Default)]
pub struct Builds(BTreeMap<Incarnation, Name>);

impl Builds {
    /// Whether a beat is of this build. The first of another is told, with both versions.
    pub fn admit(&mut self, beat: &Heartbeat) -> bool {
        if beat.version != version() && !self.0.contains_key(&beat.incarnation) {
            tracing::error!(
                "{} (process {}) is of version {}, this process is of {}: it is not heard; run all processes of \
                 an instance from one build",
                beat.role,
                beat.pid,
                beat.version,
                version()
            );
        }
        if self.0.len() < LIVES_MAX {
            self.0.entry(beat.incarnation).or_insert(beat.version);
        }
        beat.version == version() && self.refuse(beat.incarnation).is_none()
    }

    /// Why a message of that life is refused, if it is of another build.
    #[must_use]
    pub fn refuse(&self, incarnation: Incarnation) -> Option<Refusal> {
        let got = self.0.get(&incarnation).filter(|got| **got != version())?;
        Some(Refusal::malformed("version", version().as_str(), got))
    }
}

/// Says for whom a process waits, and for how long it will.
#[derive(Debug)]
pub struct Patience {
    limit: Option<Duration>,
    instance: Instance,
    waits: Option<(&'static str, MonotonicNs)>,
    /// What the log has said is waited for.
    told: Option<&'static str>,
}

impl Patience {
    /// Patience in `instance` for at most `limit`; `None` is for ever.
    #[must_use]
    pub fn new(limit: Option<Duration>, instance: &Instance) -> Self {
        Self { limit, instance: instance.clone(), waits: None, told: None }
    }

    /// Takes note of what is waited for at `now`.
    ///
    /// # Errors
    /// Exit code 4 when something was waited for without a break for longer than the limit.
    pub fn check(&mut self, waits_for: Option<&'static str>, now: MonotonicNs) -> Result<(), Failure> {
        let Some(what) = waits_for else {
            self.waits = None;
            if let Some(what) = self.told.take() {
                tracing::info!("no longer waiting for {what}");
            }
            return Ok(());
        };
        let since = self.waits.map_or(now, |(_, since)| since);
        self.waits = Some((what, since));
        // Between two decisions everybody waits a little; only what lasts is worth a line.
        if self.told != Some(what) && now.since_ns(since) >= WORTH_A_LINE_NS {
            self.told = Some(what);
            tracing::info!("waiting for {what}{}", self.namesake());
        }
        match self.limit {
            Some(limit) if u128::from(now.since_ns(since)) >= limit.as_nanos() => Err(Failure::new(
                Exit::Peer,
                format!(
                    "waited {limit:?} for {what}: start it in this instance, or allow more with --wait{}",
                    self.namesake()
                ),
            )),
            _ => Ok(()),
        }
    }

    /// What is waited for may have been started by another user, whom we never meet.
    fn namesake(&self) -> String {
        let Some(user) = self.instance.namesake() else { return String::new() };
        let (name, own) = (self.instance.name(), self.instance.user());
        format!("; user {user} has an instance {name:?} too, closed to user {own}")
    }
}

/// What every peer does beside its own work: knows who lives, beats, waits patiently, and leaves in time.
#[derive(Debug)]
pub struct Attendance {
    roster: Roster,
    builds: Builds,
    patience: Patience,
    stay: bool,
    joined: MonotonicNs,
    ended: Option<MonotonicNs>,
}

impl Attendance {
    /// A peer that has just joined.
    #[must_use]
    pub fn new(args: &PeerArgs, instance: &Instance) -> Self {
        Self {
            roster: Roster::default(),
            builds: Builds::default(),
            patience: Patience::new(args.wait, instance),
            stay: args.stay,
            joined: Node::now(),
            ended: None,
        }
    }

    /// Takes note of a sign of life; `false` if it is of another build, and not to be heard.
    pub fn hear(&mut self, beat: &Heartbeat) -> bool {
        let admitted = self.builds.admit(beat);
        if admitted {
            self.roster.observe(*beat, Node::now());
        }
        admitted
    }

    /// The mission has ended.
    pub fn mission_ended(&mut self, status: Status) {
        tracing::info!("the mission is over: {status}");
        self.ended = Some(Node::now());
    }

    /// Closes one turn of the work loop: beats with what was `seen` last, and says whether to leave.
    ///
    /// `lacks` is what the peer's machine still needs; nothing, but a silent hopper-sim, is waited for too.
    ///
    /// # Errors
    /// If patience has run out (exit code 4) or the beat cannot be sent.
    pub fn close_turn(
        &mut self,
        node: &mut Node,
        (run, decision, status): (RunId, Decision, Status),
        lacks: Option<&'static str>,
    ) -> Result<bool, Failure> {
        let now = Node::now();
        node.beat(run, decision, status)?;
        let silent = !status.is_over()
            && now.since_ns(self.joined) > SILENCE_NS
            && !self.roster.has(Role::HopperSim, now);
        self.patience.check(lacks.or(silent.then_some("hopper-sim: it is silent; holding")), now)?;
        let farewell = self.ended.is_some_and(|ended| now.since_ns(ended) >= FAREWELL_NS);
        Ok(farewell && !self.stay)
    }
}
