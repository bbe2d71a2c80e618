//! Takes messages, gives the bytes of an MCAP file.
//!
//! A chunk is closed every half second, so whoever appends the bytes at once loses no more than that when killed.
//! The recorder asks for what did not reach it, or was before its time: executed decisions from `hop/past`, until
//! it has them all, and the map from `hop/rN/snapshot`; the answers are recorded like all else.

use std::collections::{BTreeMap, BTreeSet};

use contract::limits::{ASK_AGAIN_NS, PAST_PAGE_RECORDS};
use contract::{
    Brief, Decision, Incarnation, Leader, MapRequest, MonotonicNs, PastPage, PastRequest, Replica, RobotId,
    RunId, State, Status, Vetoed,
};
use mcap::records::{MessageHeader, Metadata};
use mcap::write::NoSeek;
use mcap::{WriteOptions, Writer};
use prost::Message as _;

use crate::proto::foxglove::log::Level;
use crate::shared::Shared;
use crate::topic::ROBOT;
use crate::{Gap, Gaps, Message, RecordingError, Topic, view};

/// Time after which a chunk is closed, nanoseconds.
pub const CHUNK_NS: u64 = 500_000_000;

/// Bytes at which a chunk is closed before its time.
const CHUNK_BYTES: u64 = 4 << 20;

/// Pause between two questions for the past while little of it is missing, nanoseconds.
const PAST_PERIOD_NS: u64 = 250_000_000;

/// Pause between two drawings of the map, nanoseconds, and that for each cell: a large one takes megabytes.
const GRID_PERIOD_NS: u64 = 1_000_000_000;
const GRID_CELL_NS: u64 = 20_000;

/// Lives of processes that are told of in the log at most.
const LIVES_TOLD: usize = 4096;

/// What is known before the first message, for the metadata: name of the record to its entries.
pub type Context = BTreeMap<String, BTreeMap<String, String>>;

/// What the recorder wants to be asked for.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Wanted {
    /// Of `hop/past`.
    pub past: Option<PastRequest>,
    /// Of `hop/rN/snapshot`.
    pub map: Option<MapRequest>,
}

impl Wanted {
    /// What is wanted later, or else what was wanted before.
    #[must_use]
    pub fn or(self, later: Wanted) -> Self {
        Self { past: later.past.or(self.past), map: later.map.or(self.map) }
    }
}

/// Records one mission after another.
pub struct Recorder {
    writer: Writer<NoSeek<Shared>>,
    out: Shared,
    /// Channel and messages so far of each topic, in the order of [`Topic::ALL`].
    channels: Vec<(u16, u32)>,
    closed: MonotonicNs,
    gaps: Gaps,
    missing: BTreeMap<String, u64>,
    brief: Option<Brief>,
    state: Option<State>,
    /// The decision whose record is wanted next.
    due: Decision,
    asked: MonotonicNs,
    map: Replica,
    /// Fingerprint of the map that was drawn last, and when.
    drawn: Option<(u64, MonotonicNs)>,
    lives: BTreeSet<Incarnation>,
    finished: bool,
}

/// How every recording is written.
pub(crate) fn options() -> WriteOptions {
    WriteOptions::new()
        .compression(None)
        .chunk_size(Some(CHUNK_BYTES))
        .disable_seeking(true)
        .library(concat!("hopper ", env!("CARGO_PKG_VERSION"), ", ", "mcap-rust"))
}

impl Recorder {
    /// A recorder that has written the head of its file: metadata, schemas, channels.
    ///
    /// # Errors
    /// If the writer refuses; so for all that writes.
    pub fn new(context: &Context, now: MonotonicNs) -> Result<Self, RecordingError> {
        let out = Shared::default();
        let mut writer = options().profile("hopper").create(NoSeek::new(out.clone()))?;
        for (name, metadata) in context {
            writer.write_metadata(&Metadata { name: name.clone(), metadata: metadata.clone() })?;
        }
        let mut channels = Vec::new();
        for topic in Topic::ALL {
            let schema = writer.add_schema(topic.schema(), "protobuf", topic.descriptors())?;
            channels.push((writer.add_channel(schema, &topic.name(), "protobuf", &BTreeMap::new())?, 0));
        }
        writer.flush()?;
        Ok(Self {
            writer,
            out,
            channels,
            closed: now,
            gaps: Gaps::default(),
            missing: BTreeMap::new(),
            brief: None,
            state: None,
            due: Decision(0),
            asked: MonotonicNs(0),
            map: Replica::new(ROBOT),
            drawn: None,
            lives: BTreeSet::new(),
            finished: false,
        })
    }

    /// The bytes that are to be appended to the file.
    #[must_use]
    pub fn bytes(&self) -> Vec<u8> {
        self.out.take()
    }

    /// Records a message at `now`. Of those that came together give states, patches and commands in the order of
    /// their publication, and pages last.
    pub fn on(&mut self, message: Message, now: MonotonicNs) -> Result<Wanted, RecordingError> {
        self.write(&message, now)?;
        let mut wanted = Wanted::default();
        match message {
            Message::Brief(brief) => self.brief(brief, now)?,
            Message::State(state) => self.state(&state, now)?,
            Message::Patch(patch) => {
                if self.is_of_run(patch.run, patch.robot) {
                    let gap = self.gaps.patch(&patch);
                    self.tell_gap(gap, now)?;
                }
                wanted.map = self.map.patch(patch, now);
            }
            Message::Page(page) => wanted.map = self.map.page(&page, now),
            Message::Heartbeat(beat) => {
                let gap = self.gaps.beat(&beat);
                self.tell_gap(gap, now)?;
                if self.lives.len() < LIVES_TOLD && self.lives.insert(beat.incarnation) {
                    let words = format!("{} lives, process {} {}", beat.role, beat.pid, beat.planner);
                    self.tell(Level::Info, beat.role.as_str(), words.trim_end().into(), now)?;
                }
            }
            Message::Past(page) => wanted.past = self.past(&page, now),
            Message::Command(_)
            | Message::Policy(_)
            | Message::Control(_)
            | Message::Tempo(_)
            | Message::Host(_)
            | Message::Gap(_) => {}
        }
        Ok(wanted)
    }

    /// Time has passed: closes a chunk that is due, and says what is still wanted.
    pub fn tick(&mut self, now: MonotonicNs) -> Result<Wanted, RecordingError> {
        self.draw(now, false)?;
        if now.since_ns(self.closed) >= CHUNK_NS {
            self.closed = now;
            self.writer.flush()?;
        }
        Ok(Wanted { past: self.past_wanted(now), map: self.map.ask(now) })
    }

    /// Whether the record of every decision of `run` before `decision` is there.
    #[must_use]
    pub fn is_whole_until(&self, run: RunId, decision: Decision) -> bool {
        self.brief.is_some_and(|brief| brief.run == run) && self.due >= decision
    }

    /// Messages missing so far, by topic.
    #[must_use]
    pub fn missing(&self) -> &BTreeMap<String, u64> {
        &self.missing
    }

    /// Ends the file: the last chunk, the journal's digest, the index. What comes later is not recorded.
    pub fn finish(&mut self, now: MonotonicNs) -> Result<(), RecordingError> {
        if self.finished {
            return Ok(());
        }
        self.draw(now, true)?;
        self.finished = true;
        let mut entries = BTreeMap::from([("ended_ns".to_owned(), now.0.to_string())]);
        if let Some(state) = &self.state {
            entries.insert("digest".into(), state.digest.to_string());
            entries.insert("decision".into(), state.decision.to_string());
            entries.insert("status".into(), state.status.to_string());
            entries.insert("records_through".into(), self.due.to_string());
        }
        for (topic, missing) in &self.missing {
            entries.insert(format!("missing {topic}"), missing.to_string());
        }
        self.writer.write_metadata(&Metadata { name: "end".into(), metadata: entries })?;
        self.writer.finish()?;
        Ok(())
    }

    fn brief(&mut self, brief: Brief, now: MonotonicNs) -> Result<(), RecordingError> {
        if self.brief.is_some_and(|known| known.run == brief.run) {
            return Ok(());
        }
        self.gaps.begin();
        (self.brief, self.state, self.due, self.drawn) = (Some(brief), None, Decision(0), None);
        self.map = Replica::new(ROBOT);
        self.map.begin(brief.run, brief.grid);
        let words = format!("run {} of {} in profile {}", brief.run, brief.scenario, brief.profile);
        self.tell(Level::Info, "hopper-sim", words, now)
    }

    /// Whether a message is of the run that is recorded: only there do its numbers go on from one another.
    fn is_of_run(&self, run: RunId, robot: RobotId) -> bool {
        robot == ROBOT && self.brief.is_some_and(|brief| brief.run == run)
    }

    fn state(&mut self, state: &State, now: MonotonicNs) -> Result<(), RecordingError> {
        let Some(brief) = self.brief.filter(|_| self.is_of_run(state.run, state.robot)) else {
            return Ok(());
        };
        let gap = self.gaps.state(state);
        self.tell_gap(gap, now)?;
        let before = self.state.replace(*state);
        // A journal that has lost its tail hops those decisions again.
        self.due = self.due.min(state.decision);
        if before.is_none_or(|before| before.decision != state.decision) {
            let (pose, scene) = (view::pose_of(&brief, state), view::scene(&brief, state));
            self.put(Topic::ViewPose, &pose.encode_to_vec(), state.published, now)?;
            self.put(Topic::ViewScene, &scene.encode_to_vec(), state.published, now)?;
        }
        self.tell_of_state(before.as_ref(), state, now)
    }

    /// What a person would want to read of a state.
    fn tell_of_state(
        &mut self,
        before: Option<&State>,
        state: &State,
        now: MonotonicNs,
    ) -> Result<(), RecordingError> {
        let led = before.map_or(Leader::default(), |before| before.leader);
        if (state.leader.incarnation, state.leader.term) != (led.incarnation, led.term) {
            let Leader { planner, pid, term, .. } = state.leader;
            let words = format!("{planner}, process {pid}, commands under term {term}");
            self.tell(Level::Info, "planner", words, now)?;
        }
        if state.vetoed != before.map_or(Vetoed::NONE, |before| before.vetoed) && !state.vetoed.is_empty() {
            let words =
                format!("the guard vetoed {} actions at decision {}", state.vetoed.count(), state.decision);
            self.tell(Level::Warning, "guard", words, now)?;
        }
        if state.last_origin.is_fallback() && before.is_some_and(|before| before.decision != state.decision) {
            let words =
                format!("the fallback acted ({}) before decision {}", state.last_origin, state.decision);
            self.tell(Level::Warning, "guard", words, now)?;
        }
        if state.status.is_over() && before.is_none_or(|before| !before.status.is_over()) {
            let level = if state.status == Status::Goal { Level::Info } else { Level::Error };
            let words = format!("the mission is over: {} after {} decisions", state.status, state.decision);
            self.tell(level, "hopper-sim", words, now)?;
        }
        Ok(())
    }

    /// Takes note of executed decisions; what follows them, if they were a full page.
    fn past(&mut self, page: &PastPage, now: MonotonicNs) -> Option<PastRequest> {
        if !self.is_of_run(page.run, page.robot) {
            return None;
        }
        if page.from == self.due {
            self.due = Decision(page.from.0 + page.records.len() as u64);
        }
        let is_whole = self.state.is_none_or(|state| self.due >= state.decision);
        if page.records.len() < PAST_PAGE_RECORDS || is_whole {
            return None;
        }
        self.asked = now;
        self.past_request()
    }

    fn past_request(&self) -> Option<PastRequest> {
        Some(PastRequest { run: self.brief?.run, robot: ROBOT, from: self.due })
    }

    fn past_wanted(&mut self, now: MonotonicNs) -> Option<PastRequest> {
        let state = self.state?;
        let behind = state.decision.0.saturating_sub(self.due.0);
        let urgent = behind >= PAST_PAGE_RECORDS as u64 || state.status.is_over();
        let pause_ns = if urgent { ASK_AGAIN_NS } else { PAST_PERIOD_NS };
        if behind == 0 || now.since_ns(self.asked) < pause_ns {
            return None;
        }
        self.asked = now;
        self.past_request()
    }

    /// Draws the map if it has changed and it is time, or the file ends.
    fn draw(&mut self, now: MonotonicNs, ends: bool) -> Result<(), RecordingError> {
        let Some(map) = self.map.map() else { return Ok(()) };
        let period_ns = GRID_PERIOD_NS + GRID_CELL_NS * map.cells().len() as u64;
        let is_due = self.drawn.is_none_or(|(observation, drawn)| {
            observation != map.observation() && (ends || now.since_ns(drawn) >= period_ns)
        });
        if !is_due {
            return Ok(());
        }
        self.drawn = Some((map.observation(), now));
        let (bytes, published) = (view::grid(map).encode_to_vec(), map.published);
        self.put(Topic::ViewMap, &bytes, published, now)
    }

    fn tell_gap(&mut self, gap: Option<Gap>, now: MonotonicNs) -> Result<(), RecordingError> {
        let Some(gap) = gap else { return Ok(()) };
        let missing = self.missing.entry(gap.topic.clone()).or_default();
        *missing = missing.saturating_add(gap.missing());
        let words = format!("{} {} of {} did not reach the recorder", gap.missing(), gap.counted, gap.topic);
        self.write(&Message::Gap(gap), now)?;
        self.tell(Level::Warning, "recorder", words, now)
    }

    fn tell(
        &mut self,
        level: Level,
        name: &str,
        words: String,
        now: MonotonicNs,
    ) -> Result<(), RecordingError> {
        self.put(Topic::ViewLog, &view::line(level, name, words, now).encode_to_vec(), now, now)
    }

    fn write(&mut self, message: &Message, now: MonotonicNs) -> Result<(), RecordingError> {
        self.put(message.topic(), &message.encode(), message.published().unwrap_or(now), now)
    }

    fn put(
        &mut self,
        topic: Topic,
        data: &[u8],
        published: MonotonicNs,
        now: MonotonicNs,
    ) -> Result<(), RecordingError> {
        if self.finished {
            return Ok(());
        }
        let (channel_id, count) = &mut self.channels[topic as usize];
        let header = MessageHeader {
            channel_id: *channel_id,
            sequence: *count,
            log_time: now.0,
            publish_time: published.0,
        };
        *count = count.wrapping_add(1);
        self.writer.write_to_known_channel(&header, data)?;
        Ok(())
    }
}
