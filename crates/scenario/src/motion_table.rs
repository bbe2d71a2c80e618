//! Section `[brief.motion]`: what planners believe of where hops end, in place of the four branches.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use contract::{MotionRow, MotionTable, Soil, TableLanding};
#[cfg(test)]
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::error::refuse;
use crate::{Scenario, ScenarioError, text};

/// Longest file of a motion table, bytes: twice what all classes with all landings take.
const TABLE_BYTES_MAX: u64 = 1 << 22;

/// How far the probabilities of a class may be from 1 in all, as decimals are rounded.
const SUM_TOLERANCE: f64 = 1e-6;

/// Most landings of a class beside `far`.
const LANDINGS_MAX: usize = MotionRow::LANDINGS_MAX - 1;

/// Section `[brief.motion]`.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(test, derive(JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct BelievedMotion {
    /// TOML file of a motion table, as `hopper motion derive` writes it: where hops end by soil and slope, as planner `mdp` shall believe it
    /// in place of the scatter of `[robot]`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub table: Option<PathBuf>,
}

impl BelievedMotion {
    pub(crate) fn is_law(&self) -> bool {
        self.table.is_none()
    }
}

/// A motion table as it is written.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct TableFile {
    #[serde(rename = "preset")]
    _preset: Option<String>,
    #[serde(rename = "gravity_mps2")]
    _gravity_mps2: Option<f64>,
    hop_m: f64,
    classes: Vec<Class>,
}

/// Where hops of one soil and slope end.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Class {
    soil: Soil,
    along_deg: f64,
    across_deg: f64,
    #[serde(rename = "samples")]
    _samples: Option<u64>,
    #[serde(default)]
    landings: Vec<Landing>,
    #[serde(default)]
    far: Far,
    #[serde(default)]
    rolls_away: bool,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Landing {
    offset: [i32; 2],
    probability: f64,
    #[serde(rename = "low")]
    _low: Option<f64>,
    #[serde(rename = "high")]
    _high: Option<f64>,
}

#[derive(Default, Deserialize)]
#[serde(deny_unknown_fields)]
struct Far {
    probability: f64,
    mean: [f64; 2],
}

/// What is wrong with a table.
struct Wrong {
    need: &'static str,
    got: String,
}

fn wrong<T>(need: &'static str, got: impl ToString) -> Result<T, Wrong> {
    Err(Wrong { need, got: got.to_string() })
}

impl Scenario {
    /// The motion table that planners are to believe, if the scenario names one.
    pub(crate) fn motion_table(&self) -> Result<Option<Arc<MotionTable>>, ScenarioError> {
        let Some(path) = &self.brief.motion.table else { return Ok(None) };
        let field = "brief.motion.table";
        if !self.has_hoppers() {
            return refuse(field, "a hopper, whose hops it describes", "none".into());
        }
        if self.robot.vertical {
            return refuse(field, "robot.vertical = false: a table has no vertical hops", "true".into());
        }
        if self.brief.profile == contract::Profile::Paper2022 {
            let need = "profile \"hopper\" or \"paper-2023\", which plan by landings";
            return refuse(field, need, "\"paper-2022\"".into());
        }
        if self.brief.reading.unseen != contract::UnseenGround::Flat {
            let need = "brief.reading.unseen = \"flat\": by a table hops lead over unseen ground";
            return refuse(field, need, "another".into());
        }
        if !self.truth.treasures.is_empty() {
            let need = "no truth.treasures, for which nobody plans by a table";
            return refuse(field, need, self.truth.treasures.len().to_string());
        }
        let told = text::read(path, TABLE_BYTES_MAX)?;
        let file: TableFile = toml::from_str(&told).map_err(|error| ScenarioError::Toml {
            origin: path.display().to_string(),
            message: text::toml_error(&error),
        })?;
        table(&file, self.robot.hop_distance_m)
            .map(|table| Some(Arc::new(table)))
            .map_err(|Wrong { need, got }| ScenarioError::MotionTable { path: path.clone(), need, got })
    }
}

fn table(file: &TableFile, hop_m: f64) -> Result<MotionTable, Wrong> {
    if (file.hop_m - hop_m).abs() > 1e-9 * hop_m {
        let got = format!("{} m with hops of {hop_m} m", file.hop_m);
        return wrong("hop_m as robot.hop_distance_m of the scenario", got);
    }
    let mut rows = vec![None; MotionTable::ROWS];
    for class in &file.classes {
        let named = |Wrong { need, got }| Wrong { need, got: format!("{got} for {}", class.name()) };
        let [along, across] = class.bins().map_err(named)?;
        let row = class.row().map_err(named)?;
        if rows[MotionTable::index(class.soil, along, across)].replace(row).is_some() {
            return wrong("each class once", format!("{} twice", class.name()));
        }
    }
    let bins = -MotionTable::BINS..=MotionTable::BINS;
    for soil in Soil::ALL {
        for along in bins.clone() {
            for across in bins.clone() {
                if rows[MotionTable::index(soil, along, across)].is_none() {
                    let [along, across] = [along, across].map(|bin| f64::from(bin) * MotionTable::BIN_DEG);
                    let got = format!("none for {}", name(soil, along, across));
                    return wrong(
                        "a class for each soil and each slope along and across, -30 to 30 degrees by 2.5",
                        got,
                    );
                }
            }
        }
    }
    let rows = rows.into_iter().flatten().collect();
    Ok(MotionTable::new(rows).expect("every class has a row"))
}

fn name(soil: Soil, along_deg: f64, across_deg: f64) -> String {
    format!("{} at {along_deg} degrees along, {across_deg} across", soil.name())
}

impl Class {
    fn name(&self) -> String {
        name(self.soil, self.along_deg, self.across_deg)
    }

    /// Its slopes in bins.
    fn bins(&self) -> Result<[i32; 2], Wrong> {
        let (mut bins, most) = ([0; 2], f64::from(MotionTable::BINS));
        for (bin, slope_deg) in bins.iter_mut().zip([self.along_deg, self.across_deg]) {
            let number = slope_deg / MotionTable::BIN_DEG;
            if number.fract() != 0.0 || number.abs() > most {
                return wrong("slopes of -30 to 30 degrees by 2.5, rising ahead and to the left", slope_deg);
            }
            *bin = number as i32;
        }
        Ok(bins)
    }

    /// Its landings, with `far` at the cell of its mean displacement, at most [`MotionRow::REACH`] away; none where the body rolls away.
    fn row(&self) -> Result<MotionRow, Wrong> {
        if self.landings.len() > LANDINGS_MAX {
            return wrong("at most 12 landings of a class", self.landings.len());
        }
        for (number, Landing { offset: [forward, left], .. }) in self.landings.iter().enumerate() {
            if !(-1..=2).contains(forward) || !(-2..=2).contains(left) {
                return wrong(
                    "offsets of -1 to 2 hops forward and -2 to 2 to the left",
                    format!("[{forward}, {left}]"),
                );
            }
            if self.landings[..number].iter().any(|other| other.offset == [*forward, *left]) {
                return wrong("each landing of a class once", format!("[{forward}, {left}] twice"));
            }
        }
        let shares = self.landings.iter().map(|landing| landing.probability).chain([self.far.probability]);
        if let Some(odd) = shares.clone().find(|share| !(0.0..=1.0).contains(share)) {
            return wrong("probabilities of 0 to 1", odd);
        }
        if self.far.mean.iter().any(|hops| !hops.is_finite()) {
            return wrong("a finite mean displacement", format!("{:?}", self.far.mean));
        }
        let sum: f64 = shares.sum();
        if self.rolls_away {
            return Ok(MotionRow::default());
        }
        if (sum - 1.0).abs() > SUM_TOLERANCE {
            return wrong(
                "probabilities of all landings and of far that add up to 1, or rolls_away = true",
                sum,
            );
        }
        let reach = f64::from(MotionRow::REACH);
        let [forward, left] = self.far.mean.map(|hops| libm::round(hops).clamp(-reach, reach) as i8);
        let far = TableLanding { forward, left, probability: self.far.probability / sum };
        let near = self.landings.iter().map(|landing| {
            let [forward, left] = landing.offset.map(|hops| hops as i8);
            TableLanding { forward, left, probability: landing.probability / sum }
        });
        let landings: Vec<TableLanding> =
            near.chain([far]).filter(|landing| landing.probability > 0.0).collect();
        Ok(MotionRow::new(&landings).expect("the landings were checked"))
    }
}

/// The path of a table on the command line or in a campaign, which starts from another folder than the scenario's.
pub(crate) fn from_here(path: &Path) -> PathBuf {
    std::path::absolute(path).unwrap_or_else(|_| path.into())
}
