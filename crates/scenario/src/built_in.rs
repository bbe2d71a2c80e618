//! Loads a scenario by built-in name or from a file.

use std::path::Path;

use crate::text::{self, TEXT_BYTES_MAX};
use crate::{Scenario, ScenarioError};

/// Built-in scenarios: name and TOML text. The texts are the files of `scenarios/`.
pub const BUILT_IN: [(&str, &str); 19] = [
    ("hard", include_str!("../scenarios/hard.toml")),
    ("heterogeneous", include_str!("../scenarios/heterogeneous.toml")),
    ("sandy", include_str!("../scenarios/sandy.toml")),
    ("large", include_str!("../scenarios/large.toml")),
    ("treasures", include_str!("../scenarios/treasures.toml")),
    ("wide", include_str!("../scenarios/wide.toml")),
    ("vast", include_str!("../scenarios/vast.toml")),
    ("hills", include_str!("../scenarios/hills.toml")),
    ("patrol", include_str!("../scenarios/patrol.toml")),
    ("mars", include_str!("../scenarios/mars.toml")),
    ("coverage", include_str!("../scenarios/coverage.toml")),
    ("coverage-8", include_str!("../scenarios/coverage-8.toml")),
    ("hopper-scout", include_str!("../scenarios/hopper-scout.toml")),
    ("rover-helicopter", include_str!("../scenarios/rover-helicopter.toml")),
    ("expedition", include_str!("../scenarios/expedition.toml")),
    ("known-hard", include_str!("../scenarios/known-hard.toml")),
    ("known-heterogeneous", include_str!("../scenarios/known-heterogeneous.toml")),
    ("known-sandy", include_str!("../scenarios/known-sandy.toml")),
    ("rocks", include_str!("../scenarios/rocks.toml")),
];

/// The scenario that `selector` names: a built-in name, or else the path of a file.
///
/// # Errors
/// If it is neither, cannot be read, or is not a scenario.
pub fn load(selector: impl AsRef<Path>) -> Result<Scenario, ScenarioError> {
    let path = selector.as_ref();
    if let Some((name, text)) = BUILT_IN.into_iter().find(|(name, _)| path.as_os_str() == *name) {
        return Scenario::parse(text, &format!("built-in scenario {name}"));
    }
    let exists = path.try_exists().map_err(|source| ScenarioError::Read { path: path.into(), source })?;
    if !exists {
        let built_in = BUILT_IN.map(|(name, _)| name);
        let meant = text::meant(path, &built_in);
        let got = path.display().to_string();
        return Err(match text::is_file_name(path) {
            true => ScenarioError::NoFile { got, meant },
            false if meant.is_empty() => ScenarioError::Unknown { built_in: built_in.join(", "), got },
            false => ScenarioError::Mistyped { got, meant },
        });
    }
    let text = text::read(path, TEXT_BYTES_MAX)?;
    let mut scenario = Scenario::parse(&text, &path.display().to_string())?;
    scenario.file = Some(path.into());
    scenario.folder = path.parent().map(Path::to_path_buf).unwrap_or_default();
    if scenario.brief.name.is_none() {
        scenario.brief.name = path.file_stem().map(|stem| stem.to_string_lossy().into_owned());
    }
    Ok(scenario)
}

/// What a built-in scenario or campaign is: the first sentence of the comment that its TOML `text` begins with.
#[must_use]
pub fn description(text: &str) -> String {
    let comment: Vec<&str> = text
        .lines()
        .map_while(|line| line.strip_prefix('#'))
        .map(str::trim)
        .take_while(|line| !line.is_empty())
        .collect();
    let comment = comment.join(" ");
    let is_end = |at: &usize| !comment[..*at].ends_with("et al");
    let end = comment.match_indices(". ").map(|(at, _)| at).find(is_end);
    comment[..end.unwrap_or(comment.len())].trim_end_matches('.').to_owned()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_built_in_scenario_is_described_in_a_line() {
        for (name, text) in BUILT_IN {
            let description = description(text);
            assert!(
                (10..200).contains(&description.len()) && !description.contains('\n'),
                "{name}: {description}"
            );
        }
        assert_eq!(description("# One thing\n# of 2.5 m. Another.\n\n# No more."), "One thing of 2.5 m");
        assert_eq!(description("name = 1 # nothing"), "");
    }
}
