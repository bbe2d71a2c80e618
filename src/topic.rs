//! `hopper topic`: the messages of a running instance, typed.

use std::fmt::Write as _;
use std::io::{self, ErrorKind, Write as _};
use std::str::FromStr;
use std::time::Duration;

use contract::service;
use contract::{Gathering, MapPage, MapPatch, MonotonicNs, Policy, Refusal, RobotId, Role, Roster, Truth};
use node::inspect::services;
use node::peer::{Patience, TICK};
use node::{Exit, Failure, Instance, Node, NodeError, Plain, Reader, Sheet, SheetReader, Stop, Vigil};
use report::{Format, table};
use serde::Serialize;
use serde_json::{Map, Value, json};

/// Looks at the messages of a running instance.
#[derive(clap::Subcommand, Clone, Debug)]
pub enum Command {
    /// List the services with their types and qualities.
    List(Target),
    /// Print messages as they come, one line a message.
    Echo(Echo),
    /// Measure how often messages come, one line a second.
    Hz(Hz),
}

/// Which instance, and how to tell.
#[derive(clap::Args, Clone, Debug)]
pub struct Target {
    /// Instance to look at.
    #[arg(long, env = "HOPPER_INSTANCE", default_value = "hopper", value_name = "NAME")]
    instance: String,
    /// Give up with exit code 4 when no hopper-sim is heard for this long.
    #[arg(long, default_value = "10s", value_parser = humantime::parse_duration, value_name = "DURATION")]
    wait: Duration,
    /// Form of the lines on standard output: text or json.
    #[arg(long, default_value_t)]
    format: Format,
}

/// Arguments of `hopper topic echo`.
#[derive(clap::Args, Clone, Debug)]
pub struct Echo {
    /// brief, truth, state, map, command, policy, control, tempo or heartbeat; or a service name such as hop/r0/state.
    topic: Topic,
    #[command(flatten)]
    target: Target,
    /// End after so many messages [default: when the mission is over].
    #[arg(long, value_name = "N")]
    count: Option<u64>,
    /// Print the cells of maps, policies and the truth too.
    #[arg(long)]
    full: bool,
}

/// Arguments of `hopper topic hz`.
#[derive(clap::Args, Clone, Debug)]
pub struct Hz {
    /// brief, truth, state, map, command, policy, control, tempo or heartbeat; or a service name such as hop/r0/state.
    topic: Topic,
    #[command(flatten)]
    target: Target,
    /// End after so many seconds [default: when the mission is over].
    #[arg(long, value_name = "N")]
    count: Option<u64>,
}

/// A topic that can be looked at.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Topic {
    kind: Kind,
    robot: RobotId,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Kind {
    Brief,
    Truth,
    State,
    Map,
    Command,
    Policy,
    Control,
    Tempo,
    Heartbeat,
}

const KINDS: [(Kind, &str); 9] = [
    (Kind::Brief, "brief"),
    (Kind::Truth, "truth"),
    (Kind::State, "state"),
    (Kind::Map, "map"),
    (Kind::Command, "command"),
    (Kind::Policy, "policy"),
    (Kind::Control, "control"),
    (Kind::Tempo, "tempo"),
    (Kind::Heartbeat, "heartbeat"),
];

impl Topic {
    /// Name of its service.
    fn name(&self) -> String {
        self.service().map_or_else(|| service::truth().name, |topic| topic.name)
    }

    /// Its publish-subscribe service; the truth is asked for instead.
    fn service(&self) -> Option<service::Topic> {
        Some(match self.kind {
            Kind::Truth => return None,
            Kind::Brief => service::brief(),
            Kind::State => service::state(self.robot),
            Kind::Map => service::map(self.robot),
            Kind::Command => service::command(self.robot),
            Kind::Policy => service::policy(self.robot),
            Kind::Control => service::control(self.robot),
            Kind::Tempo => service::tempo(self.robot),
            Kind::Heartbeat => service::heartbeat(),
        })
    }
}

impl FromStr for Topic {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let (robot, name) = match text.strip_prefix("hop/r").and_then(|rest| rest.split_once('/')) {
            Some((robot, name)) => {
                let robot = robot.parse().map_err(|_| format!("a robot is a number, got {robot:?}"))?;
                (RobotId(robot), name)
            }
            None => (RobotId(0), text),
        };
        KINDS
            .into_iter()
            .map(|(kind, short)| (Topic { kind, robot }, short))
            .find(|(topic, short)| *short == name || topic.name() == text)
            .map(|(topic, _)| topic)
            .ok_or_else(|| {
                let names: Vec<_> = KINDS.iter().map(|(_, short)| *short).collect();
                format!("a topic is one of {}, got {text:?}", names.join(", "))
            })
    }
}

/// Runs the command.
///
/// # Errors
/// Exit code 4 if no hopper-sim is heard within `--wait`; otherwise if shared memory fails.
pub fn run(command: &Command) -> Result<Exit, Failure> {
    let end = match command {
        Command::List(target) => list(target),
        Command::Echo(args) => echo(args),
        Command::Hz(args) => hz(args),
    };
    match end {
        Ok(()) | Err(End::ReaderGone) => Ok(Exit::Done),
        Err(End::Stopped) => Ok(Exit::Interrupted),
        Err(End::Failed(failure)) => Err(failure),
    }
}

/// Why looking ended before its time.
enum End {
    /// A signal.
    Stopped,
    /// Standard output is closed: the reader has seen enough.
    ReaderGone,
    Failed(Failure),
}

impl<F: Into<Failure>> From<F> for End {
    fn from(failure: F) -> Self {
        End::Failed(failure.into())
    }
}

fn line(text: &str) -> Result<(), End> {
    let mut out = io::stdout().lock();
    match writeln!(out, "{text}").and_then(|()| out.flush()) {
        Err(error) if error.kind() == ErrorKind::BrokenPipe => Err(End::ReaderGone),
        result => Ok(result?),
    }
}

fn list(target: &Target) -> Result<(), End> {
    let (instance, _) = appear(target)?;
    let services = services(&instance)?;
    match target.format {
        Format::Json => services.iter().try_for_each(|service| line(&json!(service).to_string())),
        Format::Text => {
            let row = |service: &node::inspect::ServiceReport| {
                [service.name.clone(), service.nodes.to_string(), service.kind.clone()]
            };
            let rows: Vec<_> = services.iter().map(row).collect();
            line(table(["service", "processes", "type and qualities"], &rows).trim_end())
        }
    }
}

fn echo(args: &Echo) -> Result<(), End> {
    let mut left = args.count;
    if left == Some(0) {
        return Ok(());
    }
    watch(&args.topic, &args.target, args.full, |news| {
        let News::Message(message) = news else { return Ok(true) };
        match (args.target.format, &message) {
            (Format::Json, Ok(value)) => line(&value.to_string())?,
            (Format::Text, Ok(value)) => line(&flat(value))?,
            (Format::Json, Err(refusal)) => line(&json!({ "refused": refusal }).to_string())?,
            (Format::Text, Err(refusal)) => line(&format!("refused ({}): {refusal}", refusal.reason()))?,
        }
        left = left.map(|left| left - 1);
        Ok(left != Some(0))
    })
}

/// Messages within one second.
#[derive(Serialize)]
struct Rate {
    topic: String,
    hz: f64,
    messages: u64,
    gap_max_ms: f64,
}

fn hz(args: &Hz) -> Result<(), End> {
    const WINDOW_NS: u64 = 1_000_000_000;
    let topic = args.topic.name();
    let (mut left, mut since, mut messages) = (args.count, Node::now(), 0);
    let (mut last, mut gap_max_ns) = (None::<MonotonicNs>, 0);
    watch(&args.topic, &args.target, false, |news| {
        let now = Node::now();
        if let News::Message(_) = news {
            messages += 1;
            gap_max_ns = gap_max_ns.max(last.map_or(0, |last| now.since_ns(last)));
            last = Some(now);
        }
        let elapsed_ns = now.since_ns(since);
        if elapsed_ns < WINDOW_NS && !matches!(news, News::Over) {
            return Ok(left != Some(0));
        }
        let hz = messages as f64 * 1e9 / elapsed_ns.max(1) as f64;
        let rate = Rate { topic: topic.clone(), hz, messages, gap_max_ms: gap_max_ns as f64 / 1e6 };
        match args.target.format {
            Format::Json => line(&json!(rate).to_string())?,
            Format::Text => {
                line(&format!(
                    "{topic} {hz:.1} Hz, {messages} messages, longest gap {:.1} ms",
                    rate.gap_max_ms
                ))?;
            }
        }
        (since, messages, gap_max_ns) = (now, 0, 0);
        left = left.map(|left| left.saturating_sub(1));
        Ok(left != Some(0))
    })
}

/// What a look brings.
enum News {
    Message(Result<Value, Refusal>),
    /// Time passed.
    Tick,
    /// The mission is over.
    Over,
}

/// Looks at a topic until `tell` has enough, the mission is over, or nobody is heard.
fn watch(
    topic: &Topic,
    target: &Target,
    full: bool,
    mut tell: impl FnMut(News) -> Result<bool, End>,
) -> Result<(), End> {
    /// The last messages of a mission are on their way when it ends.
    const FAREWELL_NS: u64 = 200_000_000;
    let (instance, mut patience) = appear(target)?;
    let mut node = Node::visit(&instance)?;
    let mut tap = open(&mut node, topic, full)?;
    let mut states = node.state_reader(topic.robot)?;
    if let Some(service) = topic.service().filter(|service| service.event) {
        node.listen(&service)?;
    }
    let (mut roster, mut over) = (Roster::default(), None::<MonotonicNs>);
    loop {
        node.wait(TICK);
        if node.stop_requested().is_some() {
            return Err(End::Stopped);
        }
        let now = Node::now();
        while let Some(message) = tap() {
            if !tell(News::Message(message))? {
                return Ok(());
            }
        }
        for beat in node.heartbeats().into_iter().flatten() {
            roster.observe(beat, now);
        }
        if let Some(Ok(state)) = states.newest() {
            over = if state.status.is_over() { over.or(Some(now)) } else { None };
        }
        if over.is_some_and(|over| now.since_ns(over) >= FAREWELL_NS) {
            tell(News::Over)?;
            return Ok(());
        }
        if !tell(News::Tick)? {
            return Ok(());
        }
        let alone = over.is_none() && !roster.has(Role::HopperSim, now);
        patience.check(alone.then_some("hopper-sim"), now)?;
    }
}

/// Waits until the instance lives.
fn appear(target: &Target) -> Result<(Instance, Patience), End> {
    const PAUSE: Duration = Duration::from_millis(20);
    let instance = Instance::new(&target.instance)?;
    let mut patience = Patience::new(Some(target.wait), &instance);
    let vigil = Vigil::new()?;
    if !instance.is_alive()? {
        tracing::info!("instance {:?} does not live yet; {}", target.instance, living()?);
    }
    while !instance.is_alive()? {
        patience.check(Some("hopper-sim"), Node::now())?;
        if vigil.wait(PAUSE) && matches!(vigil.stop_requested(), Some(Stop::Signal)) {
            return Err(End::Stopped);
        }
    }
    Ok((instance, patience))
}

/// Which instances live, in words.
fn living() -> Result<String, End> {
    let mut names = Vec::new();
    for instance in Instance::all()? {
        if instance.is_alive()? {
            names.push(format!("{:?}", instance.name()));
        }
    }
    Ok(if names.is_empty() { "no other does".into() } else { format!("those that do: {}", names.join(", ")) })
}

/// Gives the next message.
type Tap = Box<dyn FnMut() -> Option<Result<Value, Refusal>>>;

fn open(node: &mut Node, topic: &Topic, full: bool) -> Result<Tap, NodeError> {
    let robot = topic.robot;
    Ok(match topic.kind {
        Kind::Brief => plain(node.brief_reader()?),
        Kind::State => plain(node.state_reader(robot)?),
        Kind::Command => plain(node.command_reader(robot)?),
        Kind::Control => plain(node.control_reader(robot)?),
        Kind::Tempo => plain(node.tempo_reader(robot)?),
        Kind::Heartbeat => plain(node.heartbeat_reader()?),
        Kind::Map => sheet(node.map_reader(robot)?, move |patch| summary(patch, full)),
        Kind::Policy => sheet(node.policy_reader(robot)?, move |policy| summary(policy, full)),
        Kind::Truth => gathered(node, full)?,
    })
}

fn plain<M: Plain + Serialize + 'static>(mut reader: Reader<M>) -> Tap {
    Box::new(move || Some(reader.receive()?.map(|message| json!(message))))
}

fn sheet<S: Sheet + 'static>(mut reader: SheetReader<S>, value: impl Fn(S) -> Value + 'static) -> Tap {
    Box::new(move || Some(reader.receive()?.map(&value)))
}

/// The truth, asked for page by page once the brief says of which run.
fn gathered(node: &mut Node, full: bool) -> Result<Tap, NodeError> {
    let (mut briefs, mut client) = (node.brief_reader()?, node.truth_client()?);
    let mut gathering = Gathering::default();
    Ok(Box::new(move || {
        match briefs.newest() {
            Some(Ok(brief)) => gathering.begin(brief.run),
            Some(Err(refusal)) => return Some(Err(refusal)),
            None => {}
        }
        while let Some(page) = client.receive() {
            match page.and_then(|page| gathering.page(&page)) {
                Ok(Some(truth)) => return Some(Ok(summary(truth, full))),
                Ok(None) => {}
                Err(refusal) => return Some(Err(refusal)),
            }
        }
        if let Some(request) = gathering.ask(Node::now())
            && let Err(error) = client.request(&request)
        {
            tracing::debug!("asking for the truth: {error}");
        }
        None
    }))
}

/// A message with cells.
pub trait Cells: Serialize {
    /// Leaves it without cells; how many it had.
    fn strip(&mut self) -> usize;
}

macro_rules! cells {
    ($($message:ty),*) => {
        $(impl Cells for $message {
            fn strip(&mut self) -> usize {
                std::mem::take(&mut self.cells).len()
            }
        })*
    };
}

cells!(MapPatch, MapPage, Policy, Truth);

/// The message with the count of its cells; the cells themselves only in full, as they take a hundred times their
/// memory as JSON.
pub fn summary(mut message: impl Cells, full: bool) -> Value {
    let whole = full.then(|| json!(message));
    let count = message.strip();
    let mut value = whole.unwrap_or_else(|| json!(message));
    if let Value::Object(fields) = &mut value {
        if !full {
            fields.remove("cells");
        }
        fields.insert("cell_count".into(), json!(count));
    }
    value
}

/// A message in one line of `field=value`, nested fields joined by points.
fn flat(value: &Value) -> String {
    fn walk(text: &mut String, path: &str, fields: &Map<String, Value>) {
        for (key, value) in fields {
            let path = if path.is_empty() { key.clone() } else { format!("{path}.{key}") };
            match value {
                Value::Object(fields) => walk(text, &path, fields),
                Value::String(word) => {
                    let _ = write!(text, " {path}={word}");
                }
                other => {
                    let _ = write!(text, " {path}={other}");
                }
            }
        }
    }
    let mut text = String::new();
    match value {
        Value::Object(fields) => walk(&mut text, "", fields),
        other => text = other.to_string(),
    }
    text.trim_start().to_owned()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_topic_has_a_short_name_and_its_service_s() {
        for (text, kind, robot) in [
            ("state", Kind::State, 0),
            ("hop/r3/map", Kind::Map, 3),
            ("hop/brief", Kind::Brief, 0),
            ("truth/terrain", Kind::Truth, 0),
            ("hop/heartbeat", Kind::Heartbeat, 0),
        ] {
            assert_eq!(text.parse(), Ok(Topic { kind, robot: RobotId(robot) }), "{text}");
        }
        assert!("hop/rx/state".parse::<Topic>().is_err());
        assert!("nothing".parse::<Topic>().unwrap_err().contains("heartbeat"));
    }

    #[test]
    fn a_nested_message_becomes_one_line() {
        let value = json!({ "a": 1, "b": { "c": "x", "d": [1, 2] } });
        assert_eq!(flat(&value), "a=1 b.c=x b.d=[1,2]");
    }
}
