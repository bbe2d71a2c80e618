//! The journal's header: which mission this is, complete enough to fly it again.

use std::io;
use std::path::Path;

use contract::limits::{GOALS_MAX, TREASURES_MAX};
use contract::wire::BriefV9;
use contract::{
    Brief, Cell, Cover, Grid, Guard, Limits, Mixed, MotionParameters, Name, Patrol, Payoff, Priors, Profile,
    Range, Reading, RunId, Scout, SensorParameters, Weights,
};
use scenario::{Difference, Fleet, ResolvedScenario, Scenario, ScenarioError};
use serde::de::Error as _;
use serde::{Deserialize, Deserializer, Serialize};

use super::disagreement::{Disagreement, agree};
use super::{JournalError, Storage, codec, frame};

/// First bytes of every journal.
const MAGIC: [u8; 8] = *b"HOPPERJ\n";

/// Version of the layout of header and records; a changed layout takes a new one. That of a single hopper's mission.
pub const FORMAT: u32 = 5;

/// As [`FORMAT`], of a mission of rovers that cover ground: its header holds them, and its brief the task.
const FORMAT_OF_ROVERS: u32 = 6;

/// As [`FORMAT_OF_ROVERS`], of a mission whose robots announce routes, which stand behind the records that announce them.
const FORMAT_OF_ROUTES: u32 = 7;

/// As [`FORMAT_OF_ROUTES`], of a hopper with helicopters: its brief is that of a hopper.
const FORMAT_OF_ACCOMPANIED: u32 = 8;

/// As [`FORMAT_OF_ROUTES`], of a mission of several stages: its task has their number.
const FORMAT_OF_STAGES: u32 = 9;

/// As [`FORMAT_OF_ROUTES`], of a mission whose robots have tasks of their own: its header holds all of these.
const FORMAT_OF_MIXED: u32 = 10;

/// The format of the release before, whose brief has neither a [`Reading`] nor the number of treasures; its journals are
/// read and resumed all the same. Format 4 was never released.
const FORMAT_BEFORE: u32 = 3;

/// All formats that are read.
const FORMATS: [u32; 7] = [
    FORMAT_BEFORE,
    FORMAT,
    FORMAT_OF_ROVERS,
    FORMAT_OF_ROUTES,
    FORMAT_OF_ACCOMPANIED,
    FORMAT_OF_STAGES,
    FORMAT_OF_MIXED,
];

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
    /// The robots, if the mission is not a single hopper's.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub fleet: Option<Fleet>,
}

impl JournalHeader {
    /// The header of `world` flown with `seed`; its run is the world's, until
    /// [`JournalHeader::with_run`] gives it one.
    #[must_use]
    pub fn new(world: &ResolvedScenario, seed: u64) -> Self {
        Self { brief: world.brief, seed, resolved: world.resolved.clone(), fleet: world.fleet.clone() }
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
        agree("brief", need_brief, &Brief { run: need_brief.run, limits, ..*got_brief })?;
        agree("fleet", &self.fleet, &got.fleet)?;
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
        let mut bytes = MAGIC.to_vec();
        if let Some(header) = HeaderOfMixed::of(self) {
            bytes.extend(FORMAT_OF_MIXED.to_le_bytes());
            bytes.extend(frame::seal(&codec::encode(&header)?, codec::BYTES_MAX)?);
            return Ok(bytes);
        }
        let format = match (&self.brief.scout, &self.fleet) {
            (Some(Scout { stages: 1, .. }), _) => FORMAT_OF_ROUTES,
            (Some(_), _) => FORMAT_OF_STAGES,
            (None, Some(_)) if self.brief.is_of_hopper() => FORMAT_OF_ACCOMPANIED,
            (None, Some(_)) => FORMAT_OF_ROVERS,
            (None, None) => FORMAT,
        };
        bytes.extend(format.to_le_bytes());
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
        if !FORMATS.contains(&format) {
            let need = FORMATS.map(|format| format.to_string()).join(", ");
            let got = format.to_string();
            return Err(JournalError::Mismatch { field: "format".into(), need, got });
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
            FORMAT_OF_MIXED => codec::decode::<HeaderOfMixed>(payload).map_err(bad)?.into(),
            FORMAT_OF_ACCOMPANIED => codec::decode::<HeaderOfAccompanied>(payload).map_err(bad)?.into(),
            FORMAT_OF_STAGES => codec::decode::<HeaderOfRobots<Scout>>(payload).map_err(bad)?.into(),
            FORMAT_OF_ROUTES => {
                codec::decode::<HeaderOfRobots<ScoutOfOneStage>>(payload).map_err(bad)?.into()
            }
            FORMAT_OF_ROVERS => codec::decode::<HeaderOfRobots<Cover>>(payload).map_err(bad)?.into(),
            FORMAT => codec::decode::<HeaderOfHopper>(payload).map_err(bad)?.into(),
            _ => codec::decode::<HeaderBefore>(payload).map_err(bad)?.into(),
        };
        if header.fleet.is_some() != header.brief.has_team() {
            return Err(bad("brief and robots are of different missions".into()));
        }
        // The bounds of the wire are those of the journal too; they are stated there.
        Brief::try_from(&BriefV9::from(&header.brief)).map_err(|refusal| bad(refusal.to_string()))?;
        Ok((header, (PREAMBLE_BYTES + frame.len()) as u64))
    }
}

/// [`JournalHeader`] in [`FORMAT`].
#[derive(Deserialize)]
struct HeaderOfHopper {
    brief: BriefOf<Priors>,
    reading: Reading,
    seed: u64,
    resolved: String,
}

/// [`JournalHeader`] in [`FORMAT_OF_ROVERS`], [`FORMAT_OF_ROUTES`] and [`FORMAT_OF_STAGES`], which differ in their task.
#[derive(Deserialize)]
struct HeaderOfRobots<T> {
    brief: BriefOf<Priors>,
    reading: Reading,
    task: Option<T>,
    seed: u64,
    resolved: String,
    fleet: Option<Fleet>,
}

/// [`Scout`] in [`FORMAT_OF_ROUTES`] and [`FORMAT_OF_MIXED`], whose missions have one stage.
#[derive(Serialize, Deserialize)]
struct ScoutOfOneStage {
    seed: u64,
    rover_samples: u32,
    helicopter_samples: u32,
}

/// [`JournalHeader`] in [`FORMAT_OF_ACCOMPANIED`].
#[derive(Deserialize)]
struct HeaderOfAccompanied {
    brief: BriefOf<Priors>,
    reading: Reading,
    seed: u64,
    resolved: String,
    fleet: Option<Fleet>,
}

/// [`JournalHeader`] in [`FORMAT_OF_MIXED`].
#[derive(Serialize, Deserialize)]
struct HeaderOfMixed {
    brief: BriefOf<Priors>,
    reading: Reading,
    cover: Option<Cover>,
    scout: Option<ScoutOfOneStage>,
    mixed: Mixed,
    seed: u64,
    resolved: String,
    fleet: Option<Fleet>,
}

impl HeaderOfMixed {
    /// `None` of a header of another mission.
    fn of(header: &JournalHeader) -> Option<Self> {
        let JournalHeader { brief, seed, resolved, fleet } = header;
        let Brief {
            run, scenario, scenario_hash, profile, robots, grid, datum_m, start, goal, patrol, ..
        } = *brief;
        let Brief {
            weights,
            payoff,
            priors,
            motion,
            sensor,
            limits,
            guard,
            reading,
            cover,
            scout,
            mixed,
            ..
        } = *brief;
        Some(Self {
            brief: BriefOf {
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
            },
            reading,
            cover,
            scout: scout.map(ScoutOfOneStage::from),
            mixed: mixed?,
            seed: *seed,
            resolved: resolved.clone(),
            fleet: fleet.clone(),
        })
    }
}

/// [`JournalHeader`] in [`FORMAT_BEFORE`].
#[derive(Deserialize)]
struct HeaderBefore {
    brief: BriefOf<PriorsBefore>,
    seed: u64,
    resolved: String,
}

/// The fields that [`Brief`] begins with in every format; they mean the same.
#[derive(Serialize, Deserialize)]
struct BriefOf<P> {
    run: RunId,
    scenario: Name,
    scenario_hash: [u8; 32],
    profile: Profile,
    robots: u16,
    grid: Grid,
    datum_m: f64,
    start: Cell,
    goal: Cell,
    #[serde(deserialize_with = "patrol")]
    patrol: Option<Patrol>,
    weights: Weights,
    payoff: Payoff,
    priors: P,
    motion: MotionParameters,
    sensor: SensorParameters,
    limits: Limits,
    guard: Guard,
}

/// [`Patrol`] as it lies in a header, its goals not yet counted.
#[derive(Deserialize)]
struct PatrolAsWritten {
    cells: [Cell; GOALS_MAX],
    count: u32,
    hops_max: u64,
}

/// Reads a patrol whose goals can be counted.
fn patrol<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Option<Patrol>, D::Error> {
    let Some(written) = Option::<PatrolAsWritten>::deserialize(deserializer)? else { return Ok(None) };
    let PatrolAsWritten { cells, count, hops_max } = written;
    let goals = usize::try_from(count).ok().and_then(|count| cells.get(..count));
    let patrol = goals.and_then(|goals| Patrol::new(goals, hops_max));
    let refusal = || {
        D::Error::custom(format!(
            "a patrol needs 2 to {GOALS_MAX} goals and a hop, got {count} and {hops_max}"
        ))
    };
    patrol.ok_or_else(refusal).map(Some)
}

/// [`Priors`] in [`FORMAT_BEFORE`].
#[derive(Deserialize)]
struct PriorsBefore {
    safety: Range,
    height_m: Range,
}

impl From<HeaderBefore> for JournalHeader {
    fn from(HeaderBefore { brief, seed, resolved }: HeaderBefore) -> Self {
        let PriorsBefore { safety, height_m } = brief.priors;
        let priors = Priors { safety, height_m, treasures: treasures_of(&resolved) };
        Self { brief: brief.with(priors, Reading::default()), seed, resolved, fleet: None }
    }
}

impl From<HeaderOfHopper> for JournalHeader {
    fn from(HeaderOfHopper { brief, reading, seed, resolved }: HeaderOfHopper) -> Self {
        let priors = brief.priors;
        Self { brief: brief.with(priors, reading), seed, resolved, fleet: None }
    }
}

impl From<HeaderOfAccompanied> for JournalHeader {
    fn from(HeaderOfAccompanied { brief, reading, seed, resolved, fleet }: HeaderOfAccompanied) -> Self {
        let priors = brief.priors;
        Self { brief: brief.with(priors, reading), seed, resolved, fleet }
    }
}

impl From<HeaderOfMixed> for JournalHeader {
    fn from(header: HeaderOfMixed) -> Self {
        let HeaderOfMixed { brief, reading, cover, scout, mixed, seed, resolved, fleet } = header;
        let priors = brief.priors;
        let scout = scout.map(Scout::from);
        let brief = Brief { cover, scout, mixed: Some(mixed), ..brief.with(priors, reading) };
        Self { brief, seed, resolved, fleet }
    }
}

impl From<HeaderOfRobots<Cover>> for JournalHeader {
    fn from(HeaderOfRobots { brief, reading, task, seed, resolved, fleet }: HeaderOfRobots<Cover>) -> Self {
        let priors = brief.priors;
        Self { brief: Brief { cover: task, ..brief.with(priors, reading) }, seed, resolved, fleet }
    }
}

impl From<HeaderOfRobots<Scout>> for JournalHeader {
    fn from(HeaderOfRobots { brief, reading, task, seed, resolved, fleet }: HeaderOfRobots<Scout>) -> Self {
        let priors = brief.priors;
        Self { brief: Brief { scout: task, ..brief.with(priors, reading) }, seed, resolved, fleet }
    }
}

impl From<HeaderOfRobots<ScoutOfOneStage>> for JournalHeader {
    fn from(header: HeaderOfRobots<ScoutOfOneStage>) -> Self {
        let HeaderOfRobots { brief, reading, task, seed, resolved, fleet } = header;
        HeaderOfRobots { brief, reading, task: task.map(Scout::from), seed, resolved, fleet }.into()
    }
}

impl From<ScoutOfOneStage> for Scout {
    fn from(ScoutOfOneStage { seed, rover_samples, helicopter_samples }: ScoutOfOneStage) -> Self {
        Self { seed, rover_samples, helicopter_samples, stages: 1 }
    }
}

impl From<Scout> for ScoutOfOneStage {
    fn from(Scout { seed, rover_samples, helicopter_samples, stages: _ }: Scout) -> Self {
        Self { seed, rover_samples, helicopter_samples }
    }
}

impl<P> BriefOf<P> {
    /// The brief of a hopper's mission with these fields.
    fn with(self, priors: Priors, reading: Reading) -> Brief {
        let Self { run, scenario, scenario_hash, profile, robots, grid, datum_m, start, goal, .. } = self;
        let Self { patrol, weights, payoff, motion, sensor, limits, guard, .. } = self;
        Brief {
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
            cover: None,
            scout: None,
            mixed: None,
        }
    }
}

/// How many treasures the canonical text of a scenario has; it was checked when the journal was made.
fn treasures_of(resolved: &str) -> u32 {
    let scenario = Scenario::parse(resolved, "the journal's scenario");
    scenario.map_or(0, |scenario| scenario.truth.treasures.len().min(TREASURES_MAX) as u32)
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_journal_of_the_format_before_has_the_treasures_of_its_scenario() {
        for (name, treasures) in [("treasures", 4), ("hard", 0)] {
            let world = scenario::load(name).and_then(|scenario| scenario.resolve());
            let resolved = world.expect("a built-in scenario").resolved;
            assert_eq!(treasures_of(&resolved), treasures, "{name}");
        }
        assert_eq!(treasures_of("not a scenario"), 0);
    }
}
