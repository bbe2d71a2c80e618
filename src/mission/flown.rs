//! A mission read back from its journal, ready to be drawn at any decision.

use std::path::Path;

use contract::{Brief, Decision, Detail, Record, Route};
use hopper_sim::JournalReader;
use node::Failure;
use report::PictureStyle;
use scenario::ResolvedScenario;

use super::{Sensed, Snapshot};

/// Most records that are read back: a longer mission fits no picture.
const RECORDS_MAX: usize = 1 << 20;

/// The records of a mission with the world they were flown in.
pub struct Flown {
    /// The world, resolved from the scenario in the journal.
    pub world: ResolvedScenario,
    /// The brief of the run.
    pub brief: Brief,
    /// Executed decisions in order, from the first.
    pub records: Vec<Record>,
    routes: Vec<Route>,
    /// What the motion model told of decisions, in their order; empty under the law.
    pub details: Vec<(Decision, Detail)>,
    seed: u64,
}

impl Flown {
    /// The mission whose journal is in `dir`.
    ///
    /// # Errors
    /// If the journal cannot be read or is not sound, its scenario cannot be resolved, or it is longer than a picture shows.
    pub fn read(dir: &Path) -> Result<Self, Failure> {
        let journal = JournalReader::open(dir)?;
        journal.require_sound()?;
        let (world, header) = (journal.world()?, journal.header());
        let brief = Brief { run: header.run(), ..world.brief.clone() };
        let mut read = journal.records();
        let (mut records, mut details) = (Vec::new(), Vec::new());
        while let Some(record) = read.next().transpose()? {
            if records.len() == RECORDS_MAX {
                let dir = dir.display();
                return Err(Failure::usage(format!(
                    "{dir} needs at most {RECORDS_MAX} decisions to be drawn, got more"
                )));
            }
            details.extend(read.detail().map(|detail| (record.decision, detail.clone())));
            records.push(record);
        }
        Ok(Self { world, brief, records, routes: read.into_routes(), details, seed: header.seed })
    }

    /// The pictures after each number of decisions in `at`, which rise.
    ///
    /// # Errors
    /// If one cannot be drawn.
    pub fn pictures(&self, at: &[usize], style: PictureStyle) -> Result<Vec<String>, Failure> {
        let mut sensed = Sensed::new(&self.world, &self.brief, self.seed);
        let (mut folded, mut pictures) = (0, Vec::new());
        for &count in at {
            for record in &self.records[folded..count] {
                sensed.record(record, &self.routes);
            }
            folded = count;
            pictures.push(self.picture(&self.records[..count], &sensed, style)?);
        }
        Ok(pictures)
    }

    fn picture(&self, route: &[Record], sensed: &Sensed, style: PictureStyle) -> Result<String, Failure> {
        let shown = &route[route.len().saturating_sub(super::output_dir::ROUTE_SHOWN)..];
        let planner =
            route.last().or(self.records.first()).map_or("hold", |record| record.leader.planner.as_str());
        let snapshot = Snapshot::with(&self.world, &self.brief, sensed, &self.routes, planner);
        snapshot.picture(&self.world, &self.brief, shown, &self.details).svg_in(style).map_err(Failure::run)
    }
}
