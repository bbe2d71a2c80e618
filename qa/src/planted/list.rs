//! The list of bugs, and a copy of the sources in which each of them is a choice at run time.

use std::collections::BTreeMap;
use std::fs;
use std::ops::Range;
use std::path::Path;

use node::Failure;
use serde::Deserialize;

/// Where the list is, from the root of the repository: a file for the bugs of each kind of mission.
const LIST: &str = "qa/planted";

/// Whose missions the example `seeds` simulates, and the names of the files in `qa/planted`.
pub(super) const MISSIONS: [&str; 5] = ["hopper", "rovers", "scouts", "accompanied", "mixed"];

/// The environment variable that names the bug to switch on.
pub(super) const SWITCH: &str = "HOPPER_PLANTED";

/// A bug to plant.
#[derive(Clone, Debug)]
pub struct Bug {
    /// What switches it on.
    pub name: String,
    /// What is wrong, in a sentence.
    pub description: String,
    /// In whose missions it is to be found.
    pub missions: &'static str,
    edits: Vec<Edit>,
}

/// How a bug is written down.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Entry {
    breaks: String,
    file: String,
    old: String,
    new: String,
    #[serde(default)]
    more: Vec<Edit>,
}

/// A change within the body of one function.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct Edit {
    file: String,
    old: String,
    new: String,
}

/// Every bug of the repository at `root`, by name.
///
/// # Errors
/// If a file of the list is missing or is not valid, or two bugs have one name.
pub fn bugs(root: &Path) -> Result<Vec<Bug>, Failure> {
    let mut bugs = BTreeMap::new();
    for missions in MISSIONS {
        let path = root.join(LIST).join(format!("{missions}.toml"));
        let invalid = |error: &str| Failure::usage(format!("{}: {error}", path.display()));
        let text = fs::read_to_string(&path).map_err(|error| invalid(&error.to_string()))?;
        let entries: BTreeMap<String, Entry> =
            toml::from_str(&text).map_err(|error| invalid(&error.to_string()))?;
        for (name, Entry { breaks: description, file, old, new, more }) in entries {
            let edits = [vec![Edit { file, old, new }], more].concat();
            let bug = Bug { name: name.clone(), description, missions, edits };
            if bugs.insert(name, bug).is_some_and(|other| other.missions != missions) {
                return Err(invalid("a bug has the name of one in another file"));
            }
        }
    }
    Ok(bugs.into_values().collect())
}

/// The changed files with all `bugs` in them, by path from `root`. Each function that a bug changes has its body once as it
/// is and once for each bug, and an environment variable says at run time which body is executed.
///
/// # Errors
/// If an edit does not fit the sources; all that do not are named.
pub fn plant(root: &Path, bugs: &[Bug]) -> Result<BTreeMap<String, String>, Failure> {
    let mut files: BTreeMap<&str, Vec<(&str, &Edit)>> = BTreeMap::new();
    for bug in bugs {
        for edit in &bug.edits {
            files.entry(&edit.file).or_default().push((&bug.name, edit));
        }
    }
    let (mut planted, mut stale) = (BTreeMap::new(), Vec::new());
    for (file, edits) in files {
        let text = fs::read_to_string(root.join(file)).unwrap_or_default();
        let mut bodies: BTreeMap<(usize, usize), BTreeMap<&str, String>> = BTreeMap::new();
        for (name, Edit { old, new, .. }) in edits {
            match body_around(&text, old) {
                Ok(body) => {
                    let bodies = bodies.entry((body.start, body.end)).or_default();
                    let changed = bodies.entry(name).or_insert_with(|| text[body].to_owned());
                    *changed = changed.replacen(old, new, 1);
                }
                Err(reason) => stale.push(format!("{name}: {reason} {file}: {old}")),
            }
        }
        let mut with_choices = text.clone();
        for ((start, end), changed) in bodies.into_iter().rev() {
            let mut choice = String::new();
            for (name, body) in changed {
                choice += &format!("if is_planted({name:?}) {{\n{body}}} else ");
            }
            choice += &format!("{{\n{}}}\n", &text[start..end]);
            with_choices.replace_range(start..end, &choice);
        }
        planted.insert(file.to_owned(), with_choices + &switch());
    }
    if stale.is_empty() {
        return Ok(planted);
    }
    Err(Failure::run(format!(
        "{} edits in {LIST} do not fit the sources, write them anew:\n{}",
        stale.len(),
        stale.join("\n")
    )))
}

/// The function that tells whether a bug is switched on, for the end of a file.
fn switch() -> String {
    format!(
        "
fn is_planted(bug: &str) -> bool {{
    static PLANTED: std::sync::LazyLock<Option<String>> = std::sync::LazyLock::new(|| std::env::var({SWITCH:?}).ok());
    PLANTED.as_deref() == Some(bug)
}}
"
    )
}

/// The lines of the body of the outermost function around `old`, which are found by their indentation: sources are as
/// rustfmt writes them.
fn body_around(text: &str, old: &str) -> Result<Range<usize>, &'static str> {
    let mut places = text.match_indices(old).map(|(at, _)| at..at + old.len());
    let place = places.next().ok_or("not found in")?;
    if places.next().is_some() {
        return Err("more than once in");
    }
    let mut begin = 0;
    let mut open: Option<(&str, Option<usize>)> = None;
    for line in text.split_inclusive('\n') {
        let indentation = &line[..line.len() - line.trim_start().len()];
        let end = begin + line.len();
        match open {
            None if begins_function(line) => open = Some((indentation, line.ends_with("{\n").then_some(end))),
            Some((outer, None)) if indentation == outer && line.ends_with("{\n") => {
                open = Some((outer, Some(end)));
            }
            Some((outer, Some(body))) if indentation == outer && line.trim() == "}" => {
                if body <= place.start && place.end <= begin {
                    return Ok(body..begin);
                }
                open = None;
            }
            _ => {}
        }
        begin = end;
    }
    Err("in no function's body in")
}

fn begins_function(line: &str) -> bool {
    line.split_once("fn ").is_some_and(|(before, _)| {
        let mut words = before.split_whitespace();
        words.all(|word| matches!(word, "const" | "async" | "unsafe") || word.starts_with("pub"))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    const SOURCE: &str = "
impl Counter {
    pub fn add(
        &mut self,
        by: u32,
    ) {
        fn least(by: u32) -> u32 {
            by.max(1)
        }
        self.count += least(by);
    }
}

const LIMIT: u32 = 3;
";

    #[test]
    fn a_body_is_that_of_the_outermost_function() {
        for old in ["by.max(1)", "self.count += least(by);"] {
            let body = &SOURCE[body_around(SOURCE, old).unwrap()];
            assert!(body.starts_with("        fn least") && body.ends_with("least(by);\n"), "{body}");
        }
        assert_eq!(body_around(SOURCE, "LIMIT: u32 = 3"), Err("in no function's body in"));
        assert_eq!(body_around(SOURCE, "by"), Err("more than once in"));
        assert_eq!(body_around(SOURCE, "by.min(1)"), Err("not found in"));
    }
}
