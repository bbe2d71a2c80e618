//! Turns messages into the bytes of an MCAP file.
//!
//! A chunk is closed every half second, so a process that appends the bytes at once loses no more than that when
//! killed. The recorder requests what it missed, or what was published before it started: executed decisions from
//! `hop/past` until it has all of them, and the map from `hop/rN/snapshot`. The answers are recorded too.

use std::collections::{BTreeMap, BTreeSet};

use contract::limits::{ASK_AGAIN_NS, PAST_PAGE_RECORDS};
use contract::{
    Brief, Decision, Incarnation, Leader, MapRequest, MonotonicNs, PageCursor, PastPage, PastRequest,
    Replica, RobotId, RunId, State, Status, Timeline, Vetoed,
};
use mcap::records::{MessageHeader, Metadata};
use mcap::write::NoSeek;
use mcap::{WriteOptions, Writer};
use prost::Message as _;

use crate::channel::ROBOT;
use crate::output_buffer::OutputBuffer;
use crate::proto::foxglove::log::Level;
use crate::{Channel, JsonMessage, RecordedMessage, RecordingError, SequenceGap, SequenceGaps, view};

/// Time after which a chunk is closed, nanoseconds.
pub const CHUNK_NS: u64 = 500_000_000;

/// Size at which a chunk is closed early, bytes.
const CHUNK_BYTES: u64 = 4 << 20;

/// Time between two requests for the past while less than a page is missing, nanoseconds.
const PAST_PERIOD_NS: u64 = 250_000_000;

/// Time between two grids of the map for viewers, nanoseconds.
const GRID_PERIOD_NS: u64 = 1_000_000_000;

/// Time added to it for each cell, nanoseconds: grids of large maps take megabytes.
const GRID_CELL_NS: u64 = 20_000;

/// Most processes whose start is logged.
const LOGGED_PROCESSES_MAX: usize = 4096;

/// Metadata known before the first message: name of the record to its entries.
pub type Context = BTreeMap<String, BTreeMap<String, String>>;

/// Requests that the caller has to send for the recorder.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Requests {
    /// Request to `hop/past`.
    pub past: Option<PastRequest>,
    /// Request to `hop/rN/snapshot`.
    pub map: Option<MapRequest>,
}

impl Requests {
    /// `later` where it has a request, else this.
    #[must_use]
    pub fn or(self, later: Requests) -> Self {
        Self { past: later.past.or(self.past), map: later.map.or(self.map) }
    }
}

/// Records missions, one after another, into one file.
pub struct Recorder {
    writer: Writer<NoSeek<OutputBuffer>>,
    out: OutputBuffer,
    /// MCAP id and number of messages of each channel, in the order of [`Channel::ALL`].
    channels: Vec<(u16, u32)>,
    /// The same of the channels of JSON messages, by topic; each is added with its first message.
    json_channels: BTreeMap<String, (u16, u32)>,
    closed: MonotonicNs,
    gaps: SequenceGaps,
    missing: BTreeMap<String, u64>,
    brief: Option<Brief>,
    state: Option<State>,
    /// The records that are missing, by decision.
    past: PageCursor,
    /// Where the last of the records that came stands in the digest chain.
    timeline: Timeline,
    /// The decisions before this have their records among the bytes given out.
    flushed: Decision,
    map: Replica,
    /// Fingerprint of the last grid made for viewers, and when it was made.
    drawn: Option<(u64, MonotonicNs)>,
    processes: BTreeSet<Incarnation>,
    finished: bool,
}

/// Writer options of every recording.
pub(crate) fn options() -> WriteOptions {
    WriteOptions::new()
        .compression(None)
        .chunk_size(Some(CHUNK_BYTES))
        .disable_seeking(true)
        .library(concat!("hopper ", env!("CARGO_PKG_VERSION"), ", ", "mcap-rust"))
}

impl Recorder {
    /// A recorder that has written the beginning of its file: metadata, schemas, channels.
    ///
    /// # Errors
    /// If the MCAP writer fails; the same applies to all methods that write.
    pub fn new(context: &Context, now: MonotonicNs) -> Result<Self, RecordingError> {
        let out = OutputBuffer::default();
        let mut writer = options().profile("hopper").create(NoSeek::new(out.clone()))?;
        for (name, metadata) in context {
            writer.write_metadata(&Metadata { name: name.clone(), metadata: metadata.clone() })?;
        }
        let mut channels = Vec::new();
        for topic in Channel::ALL {
            let schema = writer.add_schema(topic.schema(), "protobuf", topic.descriptors())?;
            channels.push((writer.add_channel(schema, &topic.name(), "protobuf", &BTreeMap::new())?, 0));
        }
        writer.flush()?;
        Ok(Self {
            writer,
            out,
            channels,
            json_channels: BTreeMap::new(),
            closed: now,
            gaps: SequenceGaps::default(),
            missing: BTreeMap::new(),
            brief: None,
            state: None,
            past: PageCursor::default(),
            timeline: Timeline::default(),
            flushed: Decision(0),
            map: Replica::new(ROBOT),
            drawn: None,
            processes: BTreeSet::new(),
            finished: false,
        })
    }

    /// The bytes to append to the file, written since the last call.
    #[must_use]
    pub fn bytes(&self) -> Vec<u8> {
        self.out.take()
    }

    /// Records a message received at `now`. Of messages received together, pass states, patches and commands in the
    /// order of their publication, and pages last.
    pub fn on(&mut self, message: RecordedMessage, now: MonotonicNs) -> Result<Requests, RecordingError> {
        self.write(&message, now)?;
        let mut requests = Requests::default();
        match message {
            RecordedMessage::Brief(brief) => self.brief(brief, now)?,
            RecordedMessage::State(state) => self.state(&state, now)?,
            RecordedMessage::Patch(patch) => {
                if self.is_of_run(patch.run, patch.robot) {
                    let gap = self.gaps.patch(&patch);
                    self.record_gap(gap, now)?;
                }
                requests.map = self.map.patch(patch, now);
            }
            RecordedMessage::Page(page) => requests.map = self.map.page(&page, now),
            RecordedMessage::Heartbeat(beat) => {
                let gap = self.gaps.beat(&beat);
                self.record_gap(gap, now)?;
                if self.processes.len() < LOGGED_PROCESSES_MAX && self.processes.insert(beat.incarnation) {
                    let text = format!("{} processes, process {} {}", beat.role, beat.pid, beat.planner);
                    self.log(Level::Info, beat.role.as_str(), text.trim_end().into(), now)?;
                }
            }
            RecordedMessage::Past(page) => requests.past = self.past(&page, now),
            RecordedMessage::Command(_)
            | RecordedMessage::Policy(_)
            | RecordedMessage::Control(_)
            | RecordedMessage::Pacing(_)
            | RecordedMessage::Host(_)
            | RecordedMessage::Gap(_) => {}
        }
        Ok(requests)
    }

    /// Records a message that has no schema of ours, received at `now`.
    pub fn on_json(&mut self, message: &JsonMessage, now: MonotonicNs) -> Result<(), RecordingError> {
        if self.finished {
            return Ok(());
        }
        if !self.json_channels.contains_key(&message.topic) {
            // Schema 0: JSON describes itself.
            let id = self.writer.add_channel(0, &message.topic, "json", &BTreeMap::new())?;
            self.json_channels.insert(message.topic.clone(), (id, 0));
        }
        if let Some((channel_id, count)) = self.json_channels.get_mut(&message.topic) {
            let header = MessageHeader {
                channel_id: *channel_id,
                sequence: *count,
                log_time: now.0,
                publish_time: now.0,
            };
            *count = count.wrapping_add(1);
            self.writer.write_to_known_channel(&header, &message.json)?;
        }
        Ok(())
    }

    /// Lets time pass: closes the chunk if it is due, and returns the requests that are due.
    pub fn tick(&mut self, now: MonotonicNs) -> Result<Requests, RecordingError> {
        self.draw(now, false)?;
        // The end of a mission is acknowledged once its last record is in the file, so it does not wait for its chunk.
        let is_last = self.state.is_some_and(|state| state.status.is_over() && self.due() >= state.decision);
        if now.since_ns(self.closed) >= CHUNK_NS || is_last && self.flushed < self.due() {
            self.closed = now;
            self.writer.flush()?;
            self.flushed = self.due();
        }
        Ok(Requests { past: self.past_wanted(now), map: self.map.ask(now) })
    }

    /// Whether the record of every decision of `run` before `decision` is among the bytes given out, and not only in a
    /// chunk that is still open.
    #[must_use]
    pub fn is_whole_until(&self, run: RunId, decision: Decision) -> bool {
        self.brief.is_some_and(|brief| brief.run == run) && self.flushed >= decision
    }

    /// Number of missing messages so far, by topic.
    #[must_use]
    pub fn missing(&self) -> &BTreeMap<String, u64> {
        &self.missing
    }

    /// Ends the file with the last chunk, the digest of the last state, and the index. Later messages are ignored.
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
            entries.insert("records_through".into(), self.due().to_string());
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
        (self.brief, self.state, self.drawn) = (Some(brief), None, None);
        self.forget_past();
        self.map = Replica::new(ROBOT);
        self.map.begin(&brief);
        let text = format!("run {} of {} in profile {}", brief.run, brief.scenario, brief.profile);
        self.log(Level::Info, "hopper-sim", text, now)
    }

    /// Whether a message belongs to the current run; only within a run are sequence numbers consecutive.
    fn is_of_run(&self, run: RunId, robot: RobotId) -> bool {
        self.brief.is_some_and(|brief| brief.run == run && robot.0 < brief.robots)
    }

    fn state(&mut self, state: &State, now: MonotonicNs) -> Result<(), RecordingError> {
        let Some(brief) = self.brief.filter(|_| self.is_of_run(state.run, state.robot)) else {
            return Ok(());
        };
        if self.state.is_some_and(|known| state.is_older_than(&known)) {
            return Ok(());
        }
        let gap = self.gaps.state(state);
        self.record_gap(gap, now)?;
        let before = self.state.replace(*state);
        if self.timeline.is_contradicted_by(state) {
            // A journal that has lost its tail, or was flown on elsewhere: those decisions are executed again.
            self.forget_past();
        }
        if before.is_none_or(|before| before.decision != state.decision) {
            let (pose, scene) = (view::pose_of(&brief, state), view::scene(&brief, state));
            self.put(Channel::ViewPose, &pose.encode_to_vec(), state.published, now)?;
            self.put(Channel::ViewScene, &scene.encode_to_vec(), state.published, now)?;
        }
        self.log_state(before.as_ref(), state, now)
    }

    /// Logs what a state means to a person: leader, vetoes, fallback, end.
    fn log_state(
        &mut self,
        before: Option<&State>,
        state: &State,
        now: MonotonicNs,
    ) -> Result<(), RecordingError> {
        let led = before.map_or(Leader::default(), |before| before.leader);
        if (state.leader.incarnation, state.leader.term) != (led.incarnation, led.term) {
            let Leader { planner, pid, term, .. } = state.leader;
            let text = format!("{planner}, process {pid}, commands under term {term}");
            self.log(Level::Info, "planner", text, now)?;
        }
        if state.vetoed != before.map_or(Vetoed::NONE, |before| before.vetoed) && !state.vetoed.is_empty() {
            let text =
                format!("the guard vetoed {} actions at decision {}", state.vetoed.count(), state.decision);
            self.log(Level::Warning, "guard", text, now)?;
        }
        if state.last_origin.is_fallback() && before.is_some_and(|before| before.decision != state.decision) {
            let text =
                format!("the fallback acted ({}) before decision {}", state.last_origin, state.decision);
            self.log(Level::Warning, "guard", text, now)?;
        }
        if state.status.is_over() && before.is_none_or(|before| !before.status.is_over()) {
            let level = if state.status == Status::Goal { Level::Info } else { Level::Error };
            let text = format!("the mission is over: {} after {} decisions", state.status, state.decision);
            self.log(level, "hopper-sim", text, now)?;
        }
        Ok(())
    }

    /// Counts executed decisions; returns the next request if they were a full page and more are missing.
    fn past(&mut self, page: &PastPage, now: MonotonicNs) -> Option<PastRequest> {
        if !self.is_of_run(page.run, page.robot) {
            return None;
        }
        for record in &page.records {
            if record.decision != self.due() {
                continue;
            }
            if self.timeline.is_broken_by(record) {
                self.forget_past();
                self.past.restart(now);
                return None;
            }
            // Fewer records than a page are asked for now and then: the pause stays in force.
            self.timeline.fold(record);
            self.past.move_to(self.timeline.due().0);
        }
        let is_whole = self.state.is_none_or(|state| self.due() >= state.decision);
        if page.records.len() < PAST_PAGE_RECORDS || is_whole {
            return None;
        }
        let from = Decision(self.past.ask_at_once(now));
        Some(PastRequest { run: page.run, robot: ROBOT, from })
    }

    /// Asks for all records again.
    fn forget_past(&mut self) {
        self.past.move_to(0);
        self.timeline = Timeline::default();
        self.flushed = Decision(0);
    }

    /// First decision whose record is still missing.
    fn due(&self) -> Decision {
        Decision(self.past.next())
    }

    fn past_wanted(&mut self, now: MonotonicNs) -> Option<PastRequest> {
        let (brief, state) = (self.brief?, self.state?);
        let behind = state.decision.0.saturating_sub(self.past.next());
        let urgent = behind >= PAST_PAGE_RECORDS as u64 || state.status.is_over();
        let pause_ns = if urgent { ASK_AGAIN_NS } else { PAST_PERIOD_NS };
        if behind == 0 {
            return None;
        }
        let from = Decision(self.past.ask_after(now, pause_ns)?);
        Some(PastRequest { run: brief.run, robot: ROBOT, from })
    }

    /// Writes the map as a grid for viewers if it changed and is due, or if the file ends.
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
        self.put(Channel::ViewMap, &bytes, published, now)
    }

    fn record_gap(&mut self, gap: Option<SequenceGap>, now: MonotonicNs) -> Result<(), RecordingError> {
        let Some(gap) = gap else { return Ok(()) };
        let missing = self.missing.entry(gap.topic.clone()).or_default();
        *missing = missing.saturating_add(gap.missing());
        let text = format!("{} {} of {} did not reach the recorder", gap.missing(), gap.counted, gap.topic);
        self.write(&RecordedMessage::Gap(gap), now)?;
        self.log(Level::Warning, "recorder", text, now)
    }

    fn log(
        &mut self,
        level: Level,
        name: &str,
        text: String,
        now: MonotonicNs,
    ) -> Result<(), RecordingError> {
        self.put(Channel::ViewLog, &view::line(level, name, text, now).encode_to_vec(), now, now)
    }

    fn write(&mut self, message: &RecordedMessage, now: MonotonicNs) -> Result<(), RecordingError> {
        self.put(message.topic(), &message.encode(), message.published().unwrap_or(now), now)
    }

    fn put(
        &mut self,
        topic: Channel,
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
