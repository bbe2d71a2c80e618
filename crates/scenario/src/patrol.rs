//! Section `[mission]`: whether the hopper goes to one goal or visits several in turn, rovers cover the ground, or each robot
//! has a task of its own.

use contract::limits::{DECISIONS_MAX, SAMPLES_MAX};
use contract::{Cell, Cover, CoverMode, Sampling, Visit};
#[cfg(test)]
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::{ScenarioError, exact};

/// What the mission is about.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(test, derive(JsonSchema))]
#[serde(rename_all = "snake_case")]
pub enum MissionKind {
    /// From the start to `brief.goal`.
    #[default]
    Reach,
    /// From goal to goal in turn, from the last to the first again, until `hops_max` hops are flown. The first goal
    /// is `brief.goal`, and `limits.steps_max` does not apply.
    Patrol,
    /// The rovers of `[[robots]]` visit the ground that they can reach.
    Cover,
    /// The rover of `[[robots]]` drives to a goal over uncertain ground, and helicopters look ahead for it.
    Scout,
    /// Each of `[[robots]]`, of any kind, has a start and a task of its own.
    Mixed,
}

/// Section `[mission]` of a scenario: its objective, and what that needs.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(test, derive(JsonSchema))]
#[serde(deny_unknown_fields, default)]
pub struct MissionRules {
    /// `reach`, `patrol`, `cover`, `scout` or `mixed`.
    pub kind: MissionKind,
    /// Goals of a patrol after `brief.goal`, 1 to 15 cells (x, y), each different from the one before it.
    #[serde(skip_serializing_if = "Vec::is_empty", deserialize_with = "exact::list")]
    pub goals: Vec<[i32; 2]>,
    /// Hops after which a patrol ends; by default as many as a mission can count.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub hops_max: Option<u64>,
    /// Share of the reachable cells to cover, 1 to 100 %; all by default.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub percent: Option<u32>,
    /// How rovers share the ground: `overlap`, all cover all of it, or `voronoi`, each the cells nearest to its start. By
    /// default `overlap`.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[cfg_attr(test, schemars(with = "Option<String>", extend("enum" = ["overlap", "voronoi", null])))]
    pub mode: Option<CoverMode>,
    /// Samples that the RRT* planners of the rover draw, 1 to 1000000; by default 1200, for 200 x 200 cells.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub rover_samples: Option<u32>,
    /// Samples that the RRT* planner of a helicopter draws, 1 to 1000000; by default 600.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub helicopter_samples: Option<u32>,
    /// Flights of the helicopters before the goal, each with a drive after it that takes a Sol at most unless it is the last, 1 to
    /// 64; by default 1.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub stages: Option<u32>,
}

impl MissionRules {
    /// Whether the mission is that of one hopper, alone or with helicopters.
    pub(crate) fn is_of_hopper(&self) -> bool {
        matches!(self.kind, MissionKind::Reach | MissionKind::Patrol)
    }

    pub(crate) fn is_cover(&self) -> bool {
        self.kind == MissionKind::Cover
    }

    pub(crate) fn is_scout(&self) -> bool {
        self.kind == MissionKind::Scout
    }

    pub(crate) fn is_mixed(&self) -> bool {
        self.kind == MissionKind::Mixed
    }

    /// What planners of routes are given, with the defaults filled in; `None` where no rover drives to a goal. `seed` is
    /// theirs.
    pub(crate) fn resolve_sampling(
        &mut self,
        drives: bool,
        flies: bool,
        seed: u64,
    ) -> Result<Option<Sampling>, ScenarioError> {
        let refuse = |field, need, got: u32| Err(ScenarioError::Value { field, need, got: got.to_string() });
        let stages = self.stages.unwrap_or(1);
        if !self.is_scout() && self.stages.is_some() {
            return refuse("mission.stages", "mission.kind = \"scout\"", stages);
        }
        if !drives {
            return match self.rover_samples.or(self.helicopter_samples) {
                None => Ok(None),
                Some(got) => {
                    let need =
                        "a rover that drives to a goal: mission.kind = \"scout\", or \"mixed\" with one";
                    refuse("mission.rover_samples, helicopter_samples", need, got)
                }
            };
        }
        if !(1..=Sampling::STAGES_MAX).contains(&stages) {
            return refuse("mission.stages", "1 to 64", stages);
        }
        if stages > 1 && !flies {
            return refuse(
                "mission.stages",
                "1 without a helicopter, whose flights begin the stages",
                stages,
            );
        }
        // A scenario that states the default is that which leaves it out.
        if stages <= 1 {
            self.stages = None;
        }
        let rover_samples = *self.rover_samples.get_or_insert(1200);
        let helicopter_samples = *self.helicopter_samples.get_or_insert(600);
        for (field, samples) in
            [("mission.rover_samples", rover_samples), ("mission.helicopter_samples", helicopter_samples)]
        {
            if !(1..=SAMPLES_MAX).contains(&samples) {
                return refuse(field, "1 to 1000000", samples);
            }
        }
        Ok(Some(Sampling { seed, rover_samples, helicopter_samples, stages }))
    }

    /// Whether the section is absent or empty, so that it is left out of the canonical text.
    pub(crate) fn is_empty(&self) -> bool {
        *self == Self::default()
    }

    /// What is to be covered, with the defaults filled in; where no rover covers ground, the default.
    pub(crate) fn resolve_cover(&mut self, covers: bool) -> Result<Cover, ScenarioError> {
        if !covers {
            return match self.percent.is_some() || self.mode.is_some() {
                false => Ok(Cover::default()),
                true => {
                    let need = "rovers that cover ground, for percent or mode: mission.kind = \"cover\", or \"mixed\" with a rover without goal";
                    Err(ScenarioError::Value { field: "mission.kind", need, got: "another".into() })
                }
            };
        }
        let percent = *self.percent.get_or_insert(100);
        if !(1..=100).contains(&percent) {
            let (field, need) = ("mission.percent", "1 to 100 %");
            return Err(ScenarioError::Value { field, need, got: percent.to_string() });
        }
        Ok(Cover { percent, mode: *self.mode.get_or_insert_default() })
    }

    /// The visits of a patrol whose first goal is `first`, with the default of `hops_max` filled in; `None` if the mission is no
    /// patrol.
    pub(crate) fn resolve_visits(&mut self, first: Cell) -> Result<Option<Visit>, ScenarioError> {
        let refuse = |field, need, got| Err(ScenarioError::Value { field, need, got });
        if self.kind != MissionKind::Patrol {
            if self.goals.is_empty() && self.hops_max.is_none() {
                return Ok(None);
            }
            return refuse("mission.kind", "patrol, for goals or hops_max", "another".into());
        }
        let hops_max = *self.hops_max.get_or_insert(DECISIONS_MAX);
        if !(1..=DECISIONS_MAX).contains(&hops_max) {
            return refuse("mission.hops_max", "1 to 4294967296 hops", hops_max.to_string());
        }
        let mut goals = vec![first];
        goals.extend(self.goals.iter().map(|&[x, y]| Cell::new(x, y)));
        match Visit::new(&goals, hops_max) {
            Some(visits) => Ok(Some(visits)),
            None => {
                let need = "1 to 15 cells, each different from the one before it, the first and the last different from brief.goal";
                refuse("mission.goals", need, format!("{:?}", self.goals))
            }
        }
    }
}
