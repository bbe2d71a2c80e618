//! `hopper topic`: the messages of a running instance, typed.

use std::fmt::Write as _;
use std::io::{self, ErrorKind, IsTerminal as _, Write as _};
use std::str::FromStr;
use std::time::Duration;

use contract::message::Visitor;
use contract::spelling::did_you_mean;
use contract::{
    Brief, DetailPage, DetailRequest, Heartbeat, Message, MonotonicNs, Payload, PeerTable, Refusal, Request,
    RobotId, Robots, Role, State, Truth, TruthRequest,
};
use follow::{DetailFollower, TruthFollower};
use node::inspect::services;
use node::{Exit, Failure, Instance, Node, NodeError, ShutdownSignal, StopReason};
use process::{Client as _, Patience, Ports, Reader as _, TICK_NS};
use report::{Format, table};
use serde::Serialize;
use serde_json::{Map, Value, json};

use crate::stdout::unwritten;

/// Looks at the messages of a running instance.
#[derive(clap::Subcommand, Clone, Debug)]
pub enum Command {
    /// List the services with their types and qualities.
    #[command(
        after_help = "Examples:\n  hopper topic list\n  hopper topic list --instance mine --format json"
    )]
    List(Target),
    /// Print messages as they come: one line a message, or on a terminal one line a field.
    #[command(
        after_help = "Examples:\n  hopper topic echo state\n  hopper topic echo hop/r1/command --field decision --field action --count 10"
    )]
    Echo(Echo),
    /// Measure how often messages come, one line a second.
    #[command(after_help = "Examples:\n  hopper topic hz heartbeat\n  hopper topic hz map --count 5")]
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
    #[arg(help = topics_in_words())]
    topic: Topic,
    #[command(flatten)]
    target: Target,
    /// End after so many messages [default: when the mission is over].
    #[arg(long, value_name = "N")]
    count: Option<u64>,
    /// Print the cells of maps, policies and the truth too.
    #[arg(long)]
    full: bool,
    /// Print this field alone, one line a message, e.g. decision or pose.cell; may be repeated.
    #[arg(long = "field", value_name = "NAME")]
    fields: Vec<String>,
}

/// Arguments of `hopper topic hz`.
#[derive(clap::Args, Clone, Debug)]
pub struct Hz {
    #[arg(help = topics_in_words())]
    topic: Topic,
    #[command(flatten)]
    target: Target,
    /// End after so many seconds [default: when the mission is over].
    #[arg(long, value_name = "N")]
    count: Option<u64>,
}

/// A service whose messages can be looked at.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Topic {
    /// Full name of the service.
    service: String,
    /// Whose messages, if each robot has a service of its own.
    robot: RobotId,
}

/// Everything that can be looked at, by short and full name: all messages that are published, and the truth and the details of hops,
/// which are asked for instead.
fn topics(robot: RobotId) -> Vec<(&'static str, Topic)> {
    struct Topics(RobotId, Vec<(&'static str, Topic)>);
    impl Visitor for Topics {
        fn message<M: Message>(&mut self) {
            let topic = Topic { service: M::SERVICE.name_of(self.0), robot: self.0 };
            self.1.push((M::SERVICE.short_name(), topic));
        }

        fn request<Q: Request>(&mut self) {}
    }
    let mut topics = Topics(robot, Vec::new());
    contract::wire::visit(&mut topics);
    let details = DetailRequest::SERVICE;
    topics.1.push((details.short_name(), Topic { service: details.name_of(robot), robot }));
    topics.1.push(("truth", Topic { service: TruthRequest::SERVICE.name_of(robot), robot }));
    topics.1
}

/// Short names of everything that can be looked at.
#[must_use]
pub fn names() -> Vec<&'static str> {
    topics(RobotId(0)).iter().map(|(short, _)| *short).collect()
}

/// What `--help` says of a topic.
fn topics_in_words() -> String {
    let names = names().join(", ");
    format!("One of {names}; or a service name such as hop/state")
}

impl FromStr for Topic {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let robot = match text.strip_prefix("hop/r").and_then(|rest| rest.split_once('/')) {
            Some((robot, _)) => robot.parse().map_err(|_| format!("a robot is a number, got {robot:?}"))?,
            None => 0,
        };
        let topics = topics(RobotId(robot));
        let names = topics.iter().map(|(short, _)| *short).collect::<Vec<_>>().join(", ");
        let known = topics.clone();
        topics
            .into_iter()
            .find(|(short, topic)| *short == text || topic.service == text)
            .map(|(_, topic)| topic)
            .ok_or_else(|| {
                let known = known.iter().flat_map(|(short, topic)| [*short, topic.service.as_str()]);
                let meant = did_you_mean(text, known);
                format!("a topic is one of {names}, got {text:?}{meant}")
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
    /// SIGINT, SIGTERM or SIGHUP came.
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
        result => result.map_err(|error| End::Failed(unwritten(&error))),
    }
}

fn list(target: &Target) -> Result<(), End> {
    let (instance, ..) = appear(target)?;
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
    watch(&args.topic, &args.target, args.full, |update| {
        let Update::Message(message) = update else { return Ok(true) };
        match (args.target.format, &message) {
            (format, Ok(value)) if !args.fields.is_empty() => {
                let mut picked = picked(value, &args.fields).map_err(Failure::usage)?;
                if let Some(mark) = value.get(REPEATED) {
                    picked.push((REPEATED.into(), mark.clone()));
                }
                line(&match (format, picked.as_slice()) {
                    (Format::Json, _) => Value::Object(picked.into_iter().collect()).to_string(),
                    (Format::Text, [(_, value)]) => flat(value),
                    (Format::Text, [(_, value), (mark, repeated)]) if mark == REPEATED => {
                        format!("{} {mark}={repeated}", flat(value))
                    }
                    (Format::Text, _) => flat(&Value::Object(picked.into_iter().collect())),
                })?;
            }
            (Format::Json, Ok(value)) => line(&value.to_string())?,
            (Format::Text, Ok(value)) if io::stdout().is_terminal() => line(&block(value))?,
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
struct Rate<'a> {
    topic: &'a str,
    hz: f64,
    messages: u64,
    /// Messages that repeat the one before them.
    repeated: u64,
    gap_max_ms: f64,
}

fn hz(args: &Hz) -> Result<(), End> {
    const WINDOW_NS: u64 = 1_000_000_000;
    let topic = &args.topic.service;
    let (mut left, mut since, mut messages, mut repeated) = (args.count, Node::now(), 0, 0);
    let (mut last, mut gap_max_ns) = (None::<MonotonicNs>, 0);
    watch(&args.topic, &args.target, false, |update| {
        let now = Node::now();
        if let Update::Message(message) = &update {
            messages += 1;
            repeated += u64::from(message.as_ref().is_ok_and(|value| value.get(REPEATED).is_some()));
            gap_max_ns = gap_max_ns.max(last.map_or(0, |last| now.since_ns(last)));
            last = Some(now);
        }
        let elapsed_ns = now.since_ns(since);
        if elapsed_ns < WINDOW_NS && !matches!(update, Update::Over) {
            return Ok(left != Some(0));
        }
        let hz = messages as f64 * 1e9 / elapsed_ns.max(1) as f64;
        let rate = Rate { topic, hz, messages, repeated, gap_max_ms: gap_max_ns as f64 / 1e6 };
        match args.target.format {
            Format::Json => line(&json!(rate).to_string())?,
            Format::Text => {
                line(&format!(
                    "{topic} {hz:.1} Hz, {messages} messages, {repeated} of them repeated, longest gap {:.1} ms",
                    rate.gap_max_ms
                ))?;
            }
        }
        (since, messages, repeated, gap_max_ns) = (now, 0, 0, 0);
        left = left.map(|left| left.saturating_sub(1));
        Ok(left != Some(0))
    })
}

/// Field that marks a message which is the one before it, sent again for whoever missed it.
const REPEATED: &str = "repeated";

/// Marks messages that are the message before them.
#[derive(Default)]
struct Repeats(Option<Value>);

impl Repeats {
    /// The message, marked if it is a repetition.
    fn mark(&mut self, mut message: Value) -> Value {
        if self.0.as_ref() != Some(&message) {
            self.0 = Some(message.clone());
        } else if let Value::Object(fields) = &mut message {
            fields.insert(REPEATED.into(), true.into());
        }
        message
    }
}

/// What one look at a topic yields.
enum Update {
    Message(Result<Value, Refusal>),
    /// One look is over; more may follow.
    Tick,
    /// The mission is over.
    Over,
}

/// Looks at a topic until `tell` has enough, the mission is over, or nobody is heard.
fn watch(
    topic: &Topic,
    target: &Target,
    full: bool,
    mut tell: impl FnMut(Update) -> Result<bool, End>,
) -> Result<(), End> {
    /// The last messages of a mission are on their way when it ends.
    const FAREWELL_NS: u64 = 200_000_000;
    /// What was asked for and is still to come is waited for no longer, since hopper-sim leaves too.
    const LONG_FAREWELL_NS: u64 = 5_000_000_000;
    let (instance, mut patience, shutdown) = appear(target)?;
    let mut node = Node::visit(&instance)?;
    // The node watches from here on; what came before is not lost.
    if matches!(shutdown.stop_reason(), Some(StopReason::Signal)) {
        return Err(End::Stopped);
    }
    drop(shutdown);
    let mut source = open(&mut node, topic, full)?;
    let mut states = node.reader::<State>(topic.robot, false)?;
    let mut heartbeats = node.reader::<Heartbeat>(topic.robot, false)?;
    let (mut peer_table, mut over) = (PeerTable::default(), None::<MonotonicNs>);
    let mut repeats = Repeats::default();
    loop {
        node.sleep(Duration::from_nanos(TICK_NS));
        if node.stop_requested() {
            return Err(End::Stopped);
        }
        let now = Node::now();
        while let Some(message) = source.next() {
            let message = message.map(|message| repeats.mark(message));
            if !tell(Update::Message(message))? {
                return Ok(());
            }
        }
        for beat in heartbeats.drain().into_iter().flatten() {
            peer_table.observe(beat, now);
        }
        if let Some(Ok(state)) = states.newest() {
            over = if state.status.is_over() { over.or(Some(now)) } else { None };
        }
        let farewell_ns = if source.is_whole() { FAREWELL_NS } else { LONG_FAREWELL_NS };
        if over.is_some_and(|over| now.since_ns(over) >= farewell_ns) {
            tell(Update::Over)?;
            return Ok(());
        }
        if !tell(Update::Tick)? {
            return Ok(());
        }
        let alone = over.is_none() && !peer_table.has(Role::HopperSim, now);
        patience.check(alone.then_some("hopper-sim"), &mut node)?;
    }
}

/// Waits until a process of the instance lives; with it comes what has watched signals meanwhile.
fn appear(target: &Target) -> Result<(Instance, Patience, ShutdownSignal), End> {
    const PAUSE: Duration = Duration::from_millis(20);
    let instance = Instance::new(&target.instance)?;
    let mut patience = Patience::new(Some(target.wait));
    let shutdown = ShutdownSignal::new()?;
    if !instance.is_alive()? {
        tracing::info!("instance {:?} is not running yet; {}", target.instance, running()?);
    }
    while !instance.is_alive()? {
        patience.check_at(Some("hopper-sim"), Node::now(), || instance.namesake_hint())?;
        if shutdown.wait(PAUSE) && matches!(shutdown.stop_reason(), Some(StopReason::Signal)) {
            return Err(End::Stopped);
        }
    }
    Ok((instance, patience, shutdown))
}

/// Which instances run, in words.
fn running() -> Result<String, End> {
    let mut names = Vec::new();
    for instance in Instance::all()? {
        if instance.is_alive()? {
            names.push(format!("{:?}", instance.name()));
        }
    }
    Ok(if names.is_empty() { "no other is".into() } else { format!("those that are: {}", names.join(", ")) })
}

/// What is told of a topic.
trait Source {
    /// The next message, if there is one yet.
    fn next(&mut self) -> Option<Result<Value, Refusal>>;

    /// Whether nothing that was asked for is still to come.
    fn is_whole(&self) -> bool {
        true
    }
}

impl<F: FnMut() -> Option<Result<Value, Refusal>>> Source for F {
    fn next(&mut self) -> Option<Result<Value, Refusal>> {
        self()
    }
}

/// Opens the topic for reading.
fn open(node: &mut Node, topic: &Topic, full: bool) -> Result<Box<dyn Source>, NodeError> {
    struct Opener<'a> {
        node: &'a mut Node,
        topic: &'a Topic,
        full: bool,
        opened: Option<Result<Box<dyn Source>, NodeError>>,
    }
    impl Visitor for Opener<'_> {
        fn message<M: Message>(&mut self) {
            let (robot, full) = (self.topic.robot, self.full);
            if M::SERVICE.name_of(robot) == self.topic.service {
                let reader = self.node.reader::<M>(robot, M::SERVICE.event);
                self.opened = Some(reader.map(|mut reader| -> Box<dyn Source> {
                    Box::new(move || Some(reader.receive()?.map(|message| summary(message, full))))
                }));
            }
        }

        fn request<Q: Request>(&mut self) {}
    }
    let mut opener = Opener { node, topic, full, opened: None };
    contract::wire::visit(&mut opener);
    let Opener { node, opened, .. } = opener;
    opened.unwrap_or_else(|| {
        if topic.service == DetailRequest::SERVICE.name_of(topic.robot) {
            details(node)
        } else {
            gathered(node, full)
        }
    })
}

/// The detail of each decision from now on, asked for as its state comes.
struct Details<B, S, C> {
    briefs: B,
    states: S,
    client: C,
    follower: DetailFollower,
    robots: Option<Robots>,
}

/// Details that are waited for at once, at most: a mission that is faster than its details are served loses the oldest.
const DETAILS_MAX: usize = 1 << 14;

fn details(node: &mut Node) -> Result<Box<dyn Source>, NodeError> {
    let robot = RobotId(0);
    Ok(Box::new(Details {
        briefs: node.reader::<Brief>(robot, false)?,
        states: node.reader::<State>(robot, false)?,
        client: node.client::<DetailRequest>(robot)?,
        follower: DetailFollower::default(),
        robots: None,
    }))
}

impl<B, S, C> Source for Details<B, S, C>
where
    B: process::Reader<Brief>,
    S: process::Reader<State>,
    C: process::Client<DetailRequest>,
    C::Error: std::fmt::Display,
{
    fn next(&mut self) -> Option<Result<Value, Refusal>> {
        match self.briefs.newest() {
            Some(Ok(brief)) => {
                self.follower.begin(brief.run);
                self.robots = Some(brief.robots);
            }
            Some(Err(refusal)) => return Some(Err(refusal)),
            None => {}
        }
        if let Some(robots) = &self.robots {
            for state in self.states.drain().iter().flatten() {
                self.follower.state(robots, state);
                self.follower.keep_last(DETAILS_MAX);
            }
        }
        let mut next = None;
        while next.is_none()
            && let Some(page) = self.client.receive()
        {
            next = match page {
                Ok(page) => {
                    let run = page.run;
                    let found = self.follower.page(page);
                    found.map(|(decision, detail)| Ok(json!(DetailPage { run, decision, detail })))
                }
                Err(refusal) => Some(Err(refusal)),
            };
        }
        if let Some(request) = self.follower.ask(Node::now())
            && let Err(error) = self.client.request(request)
        {
            tracing::debug!("asking for details: {error}");
        }
        next
    }

    fn is_whole(&self) -> bool {
        self.follower.is_whole()
    }
}

/// The truth, asked for page by page once the brief says of which run.
fn gathered(node: &mut Node, full: bool) -> Result<Box<dyn Source>, NodeError> {
    let robot = RobotId(0);
    let (mut briefs, mut client) = (node.reader::<Brief>(robot, false)?, node.client::<TruthRequest>(robot)?);
    let mut follower = TruthFollower::default();
    Ok(Box::new(move || {
        match briefs.newest() {
            Some(Ok(brief)) => follower.begin(brief.run),
            Some(Err(refusal)) => return Some(Err(refusal)),
            None => {}
        }
        while let Some(page) = client.receive() {
            match page.and_then(|page| follower.page(page)) {
                Ok(Some(truth)) => return Some(Ok(truth_summary(truth, full))),
                Ok(None) => {}
                Err(refusal) => return Some(Err(refusal)),
            }
        }
        if let Some(request) = follower.ask(Node::now())
            && let Err(error) = client.request(request)
        {
            tracing::debug!("asking for the truth: {error}");
        }
        None
    }))
}

/// The message, with the number of its cells if it has any; the cells themselves only in full, as they take a hundred
/// times their memory as JSON.
#[must_use]
pub fn summary(message: impl Payload, full: bool) -> Value {
    summary_of(message, full, Payload::clear_cells)
}

fn truth_summary(truth: Truth, full: bool) -> Value {
    summary_of(truth, full, |truth| Some(std::mem::take(&mut truth.cells).len()))
}

fn summary_of<T: Serialize>(
    mut message: T,
    full: bool,
    clear_cells: impl FnOnce(&mut T) -> Option<usize>,
) -> Value {
    let whole = full.then(|| json!(message));
    let count = clear_cells(&mut message);
    let mut value = whole.unwrap_or_else(|| json!(message));
    if let (Value::Object(fields), Some(count)) = (&mut value, count) {
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
        Value::String(word) => text.clone_from(word),
        other => text = other.to_string(),
    }
    text.trim_start().to_owned()
}

/// The fields of a message by their names, nested ones joined by points. A field within one that is null is null.
fn picked(message: &Value, names: &[String]) -> Result<Vec<(String, Value)>, String> {
    names
        .iter()
        .map(|name| {
            let within = |value: &Value, key: &str| match value {
                Value::Null => Some(Value::Null),
                other => other.get(key).cloned(),
            };
            let value = name.split('.').try_fold(message.clone(), |value, key| within(&value, key));
            value.map(|value| (name.clone(), value)).ok_or_else(|| {
                let fields = message.as_object().map(|fields| fields.keys().cloned().collect::<Vec<_>>());
                format!(
                    "--field needs one of {}, or one within it, got {name:?}",
                    fields.unwrap_or_default().join(", ")
                )
            })
        })
        .collect()
}

/// A message for a terminal: one line a field, its unit behind it; nested fields on one line where they fit.
fn block(message: &Value) -> String {
    const COLUMNS: usize = 100;
    fn walk(text: &mut String, depth: usize, fields: &Map<String, Value>) {
        let width = fields.keys().map(String::len).max().unwrap_or(0);
        for (key, value) in fields {
            let shown = flat(value);
            match value {
                Value::Object(nested) if 2 * depth + width + 2 + shown.len() > COLUMNS => {
                    let _ = writeln!(text, "{:1$}{key}", "", 2 * depth);
                    walk(text, depth + 1, nested);
                }
                Value::Object(_) => {
                    let _ = writeln!(text, "{:1$}{key:width$}  {shown}", "", 2 * depth);
                }
                _ => {
                    let unit = unit(key).map_or(String::new(), |unit| format!(" {unit}"));
                    let _ = writeln!(text, "{:1$}{key:width$}  {shown}{unit}", "", 2 * depth);
                }
            }
        }
    }
    let mut text = String::new();
    match message {
        Value::Object(fields) => walk(&mut text, 0, fields),
        other => text = flat(other),
    }
    text
}

/// The unit of a field whose name does not end with it: the moments of messages, and the sides of a grid.
#[must_use]
pub fn unit(field: &str) -> Option<&'static str> {
    match field {
        "landed" | "state_published" | "sensed" | "map_published" | "planning_started" | "planning_ended"
        | "accepted" | "committed" | "published" | "logged" | "since" | "until" => Some("ns"),
        "width" | "height" => Some("cells"),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use clap::Args as _;

    use super::*;

    #[test]
    fn a_topic_has_a_short_name_and_its_service_s() {
        for (text, service, robot) in [
            ("state", "hop/state", 0),
            ("hop/r3/policy", "hop/r3/policy", 3),
            ("hop/brief", "hop/brief", 0),
            ("truth", "truth/terrain", 0),
            ("truth/terrain", "truth/terrain", 0),
            ("hop/heartbeat", "hop/heartbeat", 0),
        ] {
            let topic = Topic { service: service.into(), robot: RobotId(robot) };
            assert_eq!(text.parse(), Ok(topic), "{text}");
        }
        assert!("hop/rx/state".parse::<Topic>().is_err());
        assert!("nothing".parse::<Topic>().unwrap_err().contains("heartbeat"));
    }

    #[test]
    fn help_names_every_topic() {
        let (echo, hz) = (clap::Command::new("echo"), clap::Command::new("hz"));
        for command in [Echo::augment_args(echo), Hz::augment_args(hz)] {
            let argument = command.get_arguments().find(|argument| argument.get_id() == "topic").unwrap();
            let help = argument.get_help().unwrap().to_string();
            for (topic, _) in topics(RobotId(0)) {
                assert!(help.contains(topic), "{topic} is not in {help:?}");
            }
        }
    }

    /// P-TOPIC-READ: On a terminal `topic echo` prints a field per line with its unit, no line
    /// wider than the terminal.
    #[test]
    fn on_a_terminal_a_message_is_one_line_a_field() {
        let state = hostile::fixtures::flown().1[1];
        let shown = block(&json!(state));
        assert!(shown.lines().all(|line| line.len() <= 100), "{shown}");
        assert!(shown.lines().count() > 10, "{shown}");
        let fields =
            [format!("decision     {}", state.decision.0), format!("published    {} ns", state.published.0)];
        for field in fields {
            assert!(shown.lines().any(|line| line == field), "{field:?} is not in {shown}");
        }
    }

    /// P-TOPIC-REPEATED: `topic echo` marks a message that is sent again, and `topic hz` counts
    /// such messages.
    #[test]
    fn a_message_that_is_sent_again_is_marked() {
        let mut repeats = Repeats::default();
        let (one, other) = (json!({"decision": 1}), json!({"decision": 2}));
        let shown = [&one, &one, &one, &other, &one].map(|message| repeats.mark(message.clone()));
        let marked = json!({"decision": 1, "repeated": true});
        assert_eq!(shown, [one.clone(), marked.clone(), marked, other, one]);
        assert_eq!(flat(&shown[1]), "decision=1 repeated=true");
    }

    /// P-TOPIC-FIELD: `topic echo --field` prints only the named fields; an unknown field is a
    /// usage error that lists the known ones.
    #[test]
    fn fields_are_picked_by_their_names() {
        let message = json!({ "a": 1, "b": { "c": "x", "d": [1, 2] }, "n": null });
        let pick =
            |names: &[&str]| picked(&message, &names.iter().map(ToString::to_string).collect::<Vec<_>>());
        let pair = |name: &str, value: Value| (name.to_owned(), value);
        assert_eq!(pick(&["b.c", "a"]).unwrap(), [pair("b.c", json!("x")), pair("a", json!(1))]);
        assert_eq!(pick(&["n.more"]).unwrap(), [pair("n.more", Value::Null)]);
        assert_eq!(flat(&json!("x")), "x");
        for name in ["z", "a.b", "b.z", ""] {
            let refused = pick(&[name]).unwrap_err();
            assert!(refused.contains("one of a, b, n") && refused.contains(name), "{refused}");
        }
    }

    #[test]
    fn a_nested_message_becomes_one_line() {
        let value = json!({ "a": 1, "b": { "c": "x", "d": [1, 2] } });
        assert_eq!(flat(&value), "a=1 b.c=x b.d=[1,2]");
    }
}
