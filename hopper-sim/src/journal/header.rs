//! The journal's header: which mission this is, complete enough to fly it again.
//!
//! ```text
//! magic | format u32, little-endian | frame of the build's version | frame of a JSON text
//! ```
//!
//! The text names its fields, those of [`JournalHeader`]. A field that a build does not know is refused by name, and one that an
//! older build did not write takes its default.

use std::io;
use std::path::Path;

use contract::wire::{BriefV10, RobotV1, brief_from_wire};
use contract::{Brief, Limits, Name, RunId};
use scenario::{Difference, Dynamics, Fault, ResolvedScenario, Scenario, ScenarioError};
use serde::{Deserialize, Serialize};
use serde_json::Value;

use super::disagreement::{Disagreement, agree};
use super::{JournalError, Storage, frame};
use crate::Mission;

/// First bytes of every journal.
const MAGIC: [u8; 8] = *b"HOPJRNL\n";

/// First bytes of a journal of before the first release, in one of its formats.
const MAGIC_BEFORE: [u8; 8] = *b"HOPPERJ\n";

/// Version of the layout of header and records. A new field of the header needs no new one, another layout of records does.
pub const FORMAT: u32 = 1;

/// Version of this build, which a journal that it begins names.
const VERSION: &str = env!("CARGO_PKG_VERSION");

/// Most bytes of a header's text.
const TEXT_BYTES_MAX: usize = 1 << 24;

/// Most characters that an error quotes of a header.
const EXCERPT_CHARS_MAX: usize = 200;

/// Which mission the journal is of. The brief holds run nonce, scenario name and hash, and profile.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct JournalHeader {
    /// The brief, run nonce included.
    pub brief: Brief,
    /// Seed of the keyed draws.
    pub seed: u64,
    /// The resolved scenario in its canonical text.
    pub resolved: String,
    /// Where a hop ends.
    #[serde(default, skip_serializing_if = "Dynamics::is_law")]
    pub dynamics: Dynamics,
    /// How robots will fail.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub faults: Vec<Fault>,
}

impl JournalHeader {
    /// The header of `world` flown with `seed`; its run is the world's, until
    /// [`JournalHeader::with_run`] gives it one.
    #[must_use]
    pub fn new(world: &ResolvedScenario, seed: u64) -> Self {
        Self {
            brief: world.brief.clone(),
            seed,
            resolved: world.resolved.clone(),
            dynamics: world.dynamics.clone(),
            faults: world.faults.clone(),
        }
    }

    /// The header of a mission whose scenario is not at hand.
    #[must_use]
    pub fn untold(mission: &Mission) -> Self {
        let Mission { brief, seed, dynamics, faults, .. } = mission;
        Self {
            brief: brief.clone(),
            seed: *seed,
            resolved: String::new(),
            dynamics: dynamics.clone(),
            faults: faults.clone(),
        }
    }

    /// The header of the same mission as another run.
    #[must_use]
    pub fn with_run(mut self, run: RunId) -> Self {
        self.brief.run = run;
        self
    }

    /// The run nonce, drawn when the journal was created.
    #[must_use]
    pub fn run(&self) -> RunId {
        self.brief.run
    }

    /// Checks that a journal with the header `got` is of this mission. Its run may be another, and its decision budget, on which no
    /// outcome depends.
    ///
    /// # Errors
    /// [`JournalError::Mismatch`] names the first field that differs.
    pub fn check(&self, got: &JournalHeader) -> Result<(), JournalError> {
        let (need_brief, got_brief) = (&self.brief, &got.brief);
        differing("scenario", need_brief.scenario.to_string(), got_brief.scenario.to_string())?;
        differing("seed", self.seed.to_string(), got.seed.to_string())?;
        differing("profile", need_brief.profile.to_string(), got_brief.profile.to_string())?;
        self.check_text(got)?;
        // The same scenario, read differently by another version of the program.
        let limits = Limits { decision_budget_ns: need_brief.limits.decision_budget_ns, ..got_brief.limits };
        agree("brief", need_brief, &Brief { run: need_brief.run, limits, ..got_brief.clone() })?;
        agree("dynamics", &self.dynamics, &got.dynamics)?;
        agree("faults", &self.faults, &got.faults)?;
        Ok(())
    }

    /// Checks the text of the scenario, with its hash and the budget that it has.
    fn check_text(&self, got: &JournalHeader) -> Result<(), Disagreement> {
        let is_same = self.resolved == got.resolved;
        let budgets_ns = [self, got].map(|header| header.brief.limits.decision_budget_ns);
        if !is_same || budgets_ns[0] != budgets_ns[1] {
            let need = got.scenario()?.limits.decision_budget_ns();
            differing("brief.limits.decision_budget_ns", need.to_string(), budgets_ns[1].to_string())?;
        }
        let difference = if self.brief.scenario_hash != got.brief.scenario_hash {
            // The texts agree: a file that they name has other contents than when the journal was begun.
            let need_hash = format!("the cells of hash {}", hex(&self.brief.scenario_hash));
            let got_hash = format!("the cells of hash {}", hex(&got.brief.scenario_hash));
            let ground = || Difference { field: "ground".into(), first: need_hash, second: got_hash };
            Some(scenario::difference(&self.resolved, &got.resolved).unwrap_or_else(ground))
        } else if is_same {
            None
        } else {
            scenario::hashed_difference(&self.resolved, &got.resolved).map_err(no_scenario)?
        };
        match difference {
            Some(Difference { field, first: need, second: got }) => Err(Disagreement { field, need, got }),
            None => Ok(()),
        }
    }

    /// The scenario, read from its text.
    pub(super) fn scenario(&self) -> Result<Scenario, Disagreement> {
        let scenario = Scenario::parse(&self.resolved, "the journal's scenario").map_err(no_scenario)?;
        // The hash does not cover them, and so neither do comparisons with it.
        scenario.planners().map_err(no_scenario)?;
        Ok(scenario)
    }

    /// The scenario's hash in words.
    pub(super) fn hash(&self) -> String {
        hex(&self.brief.scenario_hash)
    }

    /// Everything before the first record's frame.
    pub(super) fn seal(&self) -> Result<Vec<u8>, JournalError> {
        let text = serde_json::to_vec(self).expect("a header is plain data");
        let mut bytes = MAGIC.to_vec();
        bytes.extend(FORMAT.to_le_bytes());
        bytes.extend(frame::seal(VERSION.as_bytes(), Name::BYTES)?);
        bytes.extend(frame::seal(&text, TEXT_BYTES_MAX)?);
        Ok(bytes)
    }

    /// The header of `file`, which is at `path`, with the byte where it ends.
    pub(super) fn read(file: &impl Storage, path: &Path) -> Result<(Self, u64), JournalError> {
        let mut parts = Parts { file, path, offset: 0 };
        let [magic, format] = [parts.bytes(MAGIC.len())?, parts.bytes(size_of::<u32>())?];
        let format = u32::from_le_bytes(format.try_into().expect("four bytes"));
        if magic == MAGIC_BEFORE {
            return Err(JournalError::OlderFormat { path: path.into(), format });
        }
        if magic != MAGIC || format < FORMAT {
            return Err(parts.bad("its first bytes are none of a journal's".into()));
        }
        // Every later format begins in the same way.
        let version = excerpt(&String::from_utf8_lossy(&parts.frame(Name::BYTES)?));
        if format > FORMAT {
            return Err(JournalError::NewerFormat { path: path.into(), format, version });
        }
        let text = parts.frame(TEXT_BYTES_MAX)?;
        let bad = |error: serde_json::Error| {
            parts.bad(format!("{} (written by version {version})", excerpt(&error.to_string())))
        };
        let header: Self = serde_json::from_slice(&text).map_err(bad)?;
        let written: Value = serde_json::from_slice(&text).map_err(bad)?;
        let known = serde_json::to_value(&header).map_err(bad)?;
        if let Some(field) = unknown_field(&written, &known) {
            return Err(JournalError::UnknownField { path: path.into(), field: excerpt(&field), version });
        }
        // The bounds of the wire are those of the journal too; they are stated there.
        let robots: Vec<RobotV1> = header.brief.robots.iter().map(RobotV1::from).collect();
        brief_from_wire(&BriefV10::from(&header.brief), &robots)
            .map_err(|refusal| parts.bad(refusal.to_string()))?;
        Ok((header, parts.offset))
    }
}

/// Reads a header part by part.
struct Parts<'a, S> {
    file: &'a S,
    path: &'a Path,
    /// Where the next part begins, bytes.
    offset: u64,
}

impl<S: Storage> Parts<'_, S> {
    fn bytes(&mut self, count: usize) -> Result<Vec<u8>, JournalError> {
        let mut bytes = vec![0; count];
        self.file.read_exact_at(&mut bytes, self.offset).map_err(|error| match error.kind() {
            io::ErrorKind::UnexpectedEof => self.bad("it ends within its header".into()),
            _ => super::io("read", self.path)(error),
        })?;
        self.offset += count as u64;
        Ok(bytes)
    }

    /// The payload of the next frame, of at most so many bytes.
    fn frame(&mut self, payload_max: usize) -> Result<Vec<u8>, JournalError> {
        let mut frame = self.bytes(frame::PREFIX_BYTES)?;
        let length = u32::from_le_bytes([frame[0], frame[1], frame[2], frame[3]]) as usize;
        if length > payload_max {
            return Err(self.bad(format!("a part of it needs at most {payload_max} bytes, got {length}")));
        }
        frame.extend(self.bytes(length)?);
        let payload = frame::payload(&frame, payload_max).map(<[u8]>::to_vec);
        payload.ok_or_else(|| self.bad("its checksum does not hold".into()))
    }

    fn bad(&self, reason: String) -> JournalError {
        JournalError::BadHeader { path: self.path.into(), reason }
    }
}

/// The path of the first field that is `written` and not `known`.
fn unknown_field(written: &Value, known: &Value) -> Option<String> {
    match (written, known) {
        (Value::Object(written), Value::Object(known)) => {
            written.iter().find_map(|(name, written)| match known.get(name) {
                Some(known) => unknown_field(written, known).map(|field| format!("{name}.{field}")),
                None => Some(name.clone()),
            })
        }
        (Value::Array(written), Value::Array(known)) => {
            let mut elements = written.iter().zip(known).enumerate();
            elements.find_map(|(number, (written, known))| {
                unknown_field(written, known).map(|field| format!("{number}.{field}"))
            })
        }
        _ => None,
    }
}

/// What an error shows of a text that anybody may have written.
fn excerpt(text: &str) -> String {
    text.chars().take(EXCERPT_CHARS_MAX).flat_map(char::escape_debug).collect()
}

fn differing(field: &str, need: String, got: String) -> Result<(), Disagreement> {
    if need == got { Ok(()) } else { Err(Disagreement { field: field.into(), need, got }) }
}

/// The text is no scenario.
fn no_scenario(error: ScenarioError) -> Disagreement {
    let need = "the text of a scenario".into();
    Disagreement { field: "resolved".into(), need, got: error.to_string() }
}

fn hex(bytes: &[u8; 32]) -> String {
    contract::Digest(*bytes).to_string()
}
