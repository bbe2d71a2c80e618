//! Where two resolved scenarios differ.

use toml::Value;

use crate::resolved::{canonical, hashed};
use crate::{Scenario, ScenarioError};

/// A field that two scenarios give different values.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Difference {
    /// Path of the field, such as `truth.sand.share`.
    pub field: String,
    /// Its value in the first scenario; "nothing" if it is not there.
    pub first: String,
    /// Its value in the second one.
    pub second: String,
}

/// Fields that change no outcome, so that missions may differ in them.
const WITHOUT_EFFECT: [&str; 2] = ["limits.decision_budget_ms", "planner"];

/// Longest value that is shown, characters.
const VALUE_CHARACTERS_MAX: usize = 80;

/// The first field in which two canonical texts differ, in the order of their names; `None` if they differ in none that
/// changes an outcome, or are no scenarios. Of a path of a file only the name counts, as in the hash of a scenario.
#[must_use]
pub fn difference(first: &str, second: &str) -> Option<Difference> {
    let [first, second]: [Value; 2] = [toml::from_str(first).ok()?, toml::from_str(second).ok()?];
    differing("", Some(&first), Some(&second))
}

/// The first field of what the hash of a scenario covers in which two canonical texts differ; `None` if they have the same hash on
/// the same ground.
///
/// # Errors
/// [`ScenarioError::Toml`] if one of them is no scenario.
pub fn hashed_difference(first: &str, second: &str) -> Result<Option<Difference>, ScenarioError> {
    let text =
        |text: &str, origin| Scenario::parse(text, origin).map(|scenario| canonical(&hashed(&scenario)));
    let (first, second) = (text(first, "the first scenario")?, text(second, "the second scenario")?);
    Ok(if first == second { None } else { difference(&first, &second) })
}

fn differing(field: &str, first: Option<&Value>, second: Option<&Value>) -> Option<Difference> {
    let is_without_effect = |name: &str| field == name || field.ends_with(&format!(".{name}"));
    if first == second || WITHOUT_EFFECT.into_iter().any(is_without_effect) {
        return None;
    }
    if let (Some(Value::Table(first)), Some(Value::Table(second))) = (first, second) {
        let mut names: Vec<&String> = first.keys().chain(second.keys()).collect();
        names.sort();
        names.dedup();
        return names.into_iter().find_map(|name| {
            let path = if field.is_empty() { name.clone() } else { format!("{field}.{name}") };
            differing(&path, first.get(name), second.get(name))
        });
    }
    if let (Some(Value::Array(first)), Some(Value::Array(second))) = (first, second)
        && first.iter().chain(second).any(Value::is_table)
    {
        let of =
            |number: usize| differing(&format!("{field}.{number}"), first.get(number), second.get(number));
        return (0..first.len().max(second.len())).find_map(of);
    }
    let is_path = field.ends_with("file");
    let [first, second] = [first, second].map(|value| in_words(value, is_path));
    (first != second).then(|| Difference { field: field.to_owned(), first, second })
}

fn in_words(value: Option<&Value>, is_path: bool) -> String {
    let text = match value {
        None => "nothing".to_owned(),
        Some(Value::String(path)) if is_path => path.rsplit('/').next().unwrap_or(path).to_owned(),
        Some(value) => value.to_string(),
    };
    match text.char_indices().nth(VALUE_CHARACTERS_MAX) {
        Some((end, _)) => format!("{} ...", &text[..end]),
        None => text,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_first_field_that_changes_an_outcome_is_named_with_both_values() {
        let base = "[brief]\ngoal = [3, 4]\n[limits]\ndecision_budget_ms = 600.0\n[truth.terrain]\nfile = \"/a/b.tif\"\n";
        for (from, to, told) in [
            ("[3, 4]", "[3, 5]", Some(("brief.goal", "[3, 4]", "[3, 5]"))),
            ("goal", "aim", Some(("brief.aim", "nothing", "[3, 4]"))),
            ("/a/b.tif", "/c/d.tif", Some(("truth.terrain.file", "b.tif", "d.tif"))),
            ("/a/b.tif", "/c/b.tif", None),
            ("600.0", "1.0", None),
            (
                "[brief]",
                "[[robots]]\nplanner = \"a\"\n[brief]",
                Some(("robots", "nothing", "[{ planner = \"a\" }]")),
            ),
        ] {
            let other = base.replace(from, to);
            let got = difference(base, &other);
            let got = got.as_ref().map(|got| (got.field.as_str(), got.first.as_str(), got.second.as_str()));
            assert_eq!(got, told, "{to}");
        }
        assert_eq!(difference("", "=("), None);
        assert!(hashed_difference("", "=(").is_err());
        let robots = |name: &str, x: u32| format!("[[robots]]\nplanner = \"{name}\"\nx = {x}\n");
        assert_eq!(difference(&robots("a", 1), &robots("b", 1)), None);
        assert_eq!(difference(&robots("a", 1), &robots("a", 2)).unwrap().field, "robots.0.x");
    }

    #[test]
    fn what_the_hash_leaves_out_is_no_difference_of_what_it_covers() {
        let text = "[truth.terrain.elevation_file]\nfile = \"/a/b.tif\"\nnodata = [1.0]\n[brief]\nstart = [0, 0]\ngoal = [3, 4]\n\
                    [limits]\nsteps_max = 150\ndecision_budget_ms = 600.0\n";
        for (from, to, told) in [
            ("/a/b.tif", "/c/b.tif", None),
            ("[1.0]", "[2.0]", None),
            ("600.0", "1.0", None),
            ("/a/b.tif", "/a/c.tif", Some("truth.terrain.elevation_file.file")),
            ("[3, 4]", "[3, 5]", Some("brief.goal")),
            ("150", "151", Some("limits.steps_max")),
        ] {
            let got = hashed_difference(text, &text.replace(from, to)).unwrap();
            assert_eq!(got.as_ref().map(|got| got.field.as_str()), told, "{to}");
        }
    }
}
