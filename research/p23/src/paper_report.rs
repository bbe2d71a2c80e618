//! The results of a campaign beside those of the paper.

use campaign::report::CampaignResults;
use serde::ser::{Serialize, SerializeStruct as _, Serializer};

use crate::agreement::{Agreement, agreements};
use crate::cell_beside_paper::CellBesidePaper;
use crate::claim::Claim;
use crate::claims::claims;
use crate::paper_tests::{PaperTest, paper_tests};

/// The results of a campaign beside the paper's. Serialised, it is the JSON report.
#[derive(Clone, Debug)]
pub struct PaperReport<'a> {
    /// Our results.
    pub results: &'a CampaignResults<'a>,
    /// Each cell of ours with the paper's, in the order of the plan.
    pub cells: Vec<CellBesidePaper<'a>>,
    /// Agreement with the paper, by profile; empty unless asked for.
    pub against: Vec<Agreement>,
    /// The paper's t-tests and ours; empty unless asked for.
    pub tests: Vec<PaperTest>,
    /// The paper's claims, each with a verdict; empty unless asked for.
    pub claims: Vec<Claim>,
}

impl<'a> PaperReport<'a> {
    /// The results compared with the paper.
    #[must_use]
    pub fn against_paper(results: &'a CampaignResults<'a>) -> Self {
        let cells: Vec<_> = results.cells.iter().map(CellBesidePaper::compared).collect();
        let (against, tests) = (agreements(&cells), paper_tests(&cells));
        Self { results, against, tests, claims: claims(&cells), cells }
    }

    /// The results alone, in the same form.
    #[must_use]
    pub fn alone(results: &'a CampaignResults<'a>) -> Self {
        let cells = results.cells.iter().map(|results| CellBesidePaper { results, paper: None }).collect();
        Self { results, cells, against: Vec::new(), tests: Vec::new(), claims: Vec::new() }
    }
}

impl Serialize for PaperReport<'_> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        // Not by #[serde(flatten)]: the cells take the place of those of the results.
        let CampaignResults { campaign, seed, version, hash, trials, flown, cells: _, planners } =
            self.results;
        let mut fields = serializer.serialize_struct("PaperReport", 11)?;
        fields.serialize_field("campaign", campaign)?;
        fields.serialize_field("seed", seed)?;
        fields.serialize_field("version", version)?;
        fields.serialize_field("hash", hash)?;
        fields.serialize_field("trials", trials)?;
        fields.serialize_field("flown", flown)?;
        fields.serialize_field("cells", &self.cells)?;
        fields.serialize_field("planners", planners)?;
        fields.serialize_field("against", &self.against)?;
        fields.serialize_field("tests", &self.tests)?;
        fields.serialize_field("claims", &self.claims)?;
        fields.end()
    }
}
