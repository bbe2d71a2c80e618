//! The journal's header: which mission this is, complete enough to fly it again.

use std::io;
use std::path::Path;

use contract::wire::BriefV4;
use contract::{
    Brief, Cell, Grid, Guard, Limits, MotionParameters, Name, Patrol, Payoff, Priors, Profile, Reading,
    RunId, SensorParameters, Weights,
};
use scenario::ResolvedScenario;
use serde::{Deserialize, Serialize};

use super::{JournalError, Storage, codec, frame};

/// First bytes of every journal.
const MAGIC: [u8; 8] = *b"HOPPERJ\n";

/// Version of the layout of header and records; a changed layout takes a new one.
pub const FORMAT: u32 = 4;

/// The format before it, whose brief has no [`Reading`]; its journals are read and resumed all the same.
const FORMAT_BEFORE: u32 = 3;

/// Bytes before the header's frame.
const PREAMBLE_BYTES: usize = MAGIC.len() + size_of::<u32>();

/// Which mission the journal is of. The brief holds run nonce, scenario name and hash, and profile.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct JournalHeader {
    /// The brief, run nonce included.
    pub brief: Brief,
    /// Seed of the keyed draws.
    pub seed: u64,
    /// The resolved scenario in its canonical text.
    pub resolved: String,
}

impl JournalHeader {
    /// The header of `world` flown with `seed`; its run is the world's, until
    /// [`JournalHeader::with_run`] gives it one.
    #[must_use]
    pub fn new(world: &ResolvedScenario, seed: u64) -> Self {
        Self { brief: world.brief, seed, resolved: world.resolved.clone() }
    }

    /// The same mission as another run.
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

    /// Checks that a journal with the header `got` is of this mission; the run nonces may differ.
    ///
    /// # Errors
    /// [`JournalError::Mismatch`] names the first field that differs.
    pub fn check(&self, got: &JournalHeader) -> Result<(), JournalError> {
        let differing = |field, need: String, got: String| {
            if need == got { Ok(()) } else { Err(JournalError::Mismatch { field, need, got }) }
        };
        let (need_brief, got_brief) = (&self.brief, &got.brief);
        let scenario = |brief: &Brief| format!("{} {}", brief.scenario, hex(&brief.scenario_hash));
        differing("scenario", scenario(need_brief), scenario(got_brief))?;
        differing("seed", self.seed.to_string(), got.seed.to_string())?;
        differing("profile", need_brief.profile.to_string(), got_brief.profile.to_string())?;
        // The same scenario, read differently by another version of the program.
        // Its budget may change from life to life: no outcome depends on it.
        let limits = Limits { decision_budget_ns: 0, ..need_brief.limits };
        let rest = |brief: &Brief| {
            let limits = Limits { steps_max: brief.limits.steps_max, ..limits };
            format!("{:?}", Brief { run: RunId(0), limits, ..*brief })
        };
        differing("brief", rest(need_brief), rest(got_brief))
    }

    /// Everything before the first record's frame.
    pub(super) fn seal(&self) -> Result<Vec<u8>, JournalError> {
        let mut bytes = MAGIC.to_vec();
        bytes.extend(FORMAT.to_le_bytes());
        bytes.extend(frame::seal(&codec::encode(self)?, codec::BYTES_MAX)?);
        Ok(bytes)
    }

    /// The header of `file`, which is at `path`, with the byte where it ends.
    pub(super) fn read(file: &impl Storage, path: &Path) -> Result<(Self, u64), JournalError> {
        let bad = |reason: String| JournalError::BadHeader { path: path.into(), reason };
        let short = |error: io::Error| match error.kind() {
            io::ErrorKind::UnexpectedEof => bad("it ends within its header".into()),
            _ => super::io("read", path)(error),
        };
        let mut preamble = [0; PREAMBLE_BYTES + 4];
        file.read_exact_at(&mut preamble, 0).map_err(short)?;
        let (magic, rest) = preamble.split_at(MAGIC.len());
        let (format, length) = rest.split_at(size_of::<u32>());
        if magic != MAGIC {
            return Err(bad("its first bytes are none of a journal's".into()));
        }
        let number = |bytes: &[u8]| u32::from_le_bytes(bytes.try_into().expect("four bytes"));
        let format = number(format);
        if format != FORMAT && format != FORMAT_BEFORE {
            let (need, got) = (format!("{FORMAT_BEFORE} or {FORMAT}"), format.to_string());
            return Err(JournalError::Mismatch { field: "format", need, got });
        }
        let length = number(length) as usize;
        if length > codec::BYTES_MAX {
            return Err(bad(format!("a header needs at most {} bytes, got {length}", codec::BYTES_MAX)));
        }
        let mut frame = vec![0; frame::PREFIX_BYTES + length];
        file.read_exact_at(&mut frame, PREAMBLE_BYTES as u64).map_err(short)?;
        let payload = frame::payload(&frame, codec::BYTES_MAX)
            .ok_or_else(|| bad("its checksum does not hold".into()))?;
        let header: Self = match format {
            FORMAT => codec::decode(payload).map_err(bad)?,
            _ => codec::decode::<HeaderBefore>(payload).map_err(bad)?.into(),
        };
        // The bounds of the wire are those of the journal too; they are stated there.
        Brief::try_from(&BriefV4::from(&header.brief)).map_err(|refusal| bad(refusal.to_string()))?;
        Ok((header, (PREAMBLE_BYTES + frame.len()) as u64))
    }
}

/// [`JournalHeader`] in [`FORMAT_BEFORE`].
#[derive(Deserialize)]
struct HeaderBefore {
    brief: BriefBefore,
    seed: u64,
    resolved: String,
}

/// [`Brief`] in [`FORMAT_BEFORE`]; the fields mean the same.
#[derive(Deserialize)]
struct BriefBefore {
    run: RunId,
    scenario: Name,
    scenario_hash: [u8; 32],
    profile: Profile,
    robots: u16,
    grid: Grid,
    datum_m: f64,
    start: Cell,
    goal: Cell,
    patrol: Option<Patrol>,
    weights: Weights,
    payoff: Payoff,
    priors: Priors,
    motion: MotionParameters,
    sensor: SensorParameters,
    limits: Limits,
    guard: Guard,
}

impl From<HeaderBefore> for JournalHeader {
    fn from(header: HeaderBefore) -> Self {
        let HeaderBefore { brief, seed, resolved } = header;
        let BriefBefore { run, scenario, scenario_hash, profile, robots, grid, datum_m, start, goal, .. } =
            brief;
        let BriefBefore { patrol, weights, payoff, priors, motion, sensor, limits, guard, .. } = brief;
        let reading = Reading::default();
        let brief = Brief {
            run,
            scenario,
            scenario_hash,
            profile,
            robots,
            grid,
            datum_m,
            start,
            goal,
            patrol,
            weights,
            payoff,
            priors,
            motion,
            sensor,
            limits,
            guard,
            reading,
        };
        Self { brief, seed, resolved }
    }
}

fn hex(bytes: &[u8; 32]) -> String {
    contract::Digest(*bytes).to_string()
}
