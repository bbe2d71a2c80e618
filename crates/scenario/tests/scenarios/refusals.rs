//! What is refused, and in which words.

use std::path::Path;

use contract::Cell;
use proptest::prelude::*;
use scenario::{BUILT_IN, Scenario};
use serde::Deserialize;

use crate::{Folder, HILLY, built_in};

/// A scenario, and what it is refused for with a few lines changed.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Base {
    of: String,
    toml: Option<String>,
    built_in: Option<String>,
    refused: Vec<Refused>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Refused {
    old: Option<String>,
    new: Option<String>,
    add: Option<String>,
    error: String,
}

#[derive(Deserialize)]
struct Refusals {
    base: Vec<Base>,
}

fn bases() -> Vec<Base> {
    toml::from_str::<Refusals>(include_str!("refusals.toml")).unwrap().base
}

impl Base {
    fn text(&self) -> &str {
        match (&self.toml, &self.built_in) {
            (Some(toml), None) => toml,
            (None, Some(name)) => BUILT_IN.iter().find(|(known, _)| known == name).unwrap().1,
            _ => panic!("{}: need toml or built_in", self.of),
        }
    }
}

impl Refused {
    fn change(&self, text: &str) -> String {
        match (&self.old, &self.new, &self.add) {
            (Some(old), Some(new), None) => {
                assert!(text.contains(old), "{old:?} is not in the base");
                text.replacen(old, new, 1)
            }
            (None, None, Some(add)) => format!("{text}{add}\n"),
            _ => panic!("need old and new, or add, for {}", self.error),
        }
    }
}

/// The message of an error in a line: of a TOML error, the place and what is wrong.
fn in_a_line(message: &str) -> String {
    let lines: Vec<&str> = message.lines().collect();
    match lines[..] {
        [place, _, _, _, ref rest @ ..] => {
            let place = place.split_once("TOML parse error at ").unwrap().1;
            format!("{place}: {}", rest.join(" "))
        }
        _ => message.to_owned(),
    }
}

/// Every scenario of `refusals.toml` is refused with one error, in these words.
///
/// P-SCOUT-SCENARIO: Every scenario of driver and helicopter that is impossible is refused with one error that names the reason.
///
/// P-MIXED-SCENARIO: Every impossible mission of robots of all kinds is refused with one error.
///
/// P-MOBILITY-REFUSED: Rasters of other cells, values out of range and probabilities that do not add up are refused by name.
///
/// P-STAGES-SCENARIO.
///
/// P-PATROL-SCENARIO.
///
/// P-GUARD-SCENARIO.
///
/// P-READINGS.
///
/// P-TREASURE-CELLS.
#[test]
fn what_cannot_be_is_refused_by_name() {
    let folder = Folder::new();
    write_layers(&folder);
    write_tables(&folder);
    let mut wrong = Vec::new();
    for base in bases() {
        let resolved = |text: &str| {
            let mut scenario = Scenario::parse(text, "test")?;
            scenario.folder = folder.0.path().into();
            scenario.resolve()
        };
        if let Err(error) = resolved(base.text()) {
            panic!("the base of {}: {error}", base.of);
        }
        for refused in &base.refused {
            let got = match resolved(&refused.change(base.text())) {
                Ok(_) => "nothing: it is accepted".into(),
                Err(error) => in_a_line(&error.to_string()),
            };
            let got = got.replace(folder.0.path().canonicalize().unwrap().to_str().unwrap(), "FOLDER");
            let is_right = match refused.error.strip_suffix(" ...") {
                Some(beginning) => got.starts_with(beginning),
                None => got == refused.error,
            };
            if !is_right {
                let Refused { old, new, add, error } = refused;
                let change = format!("{:?}", (old, new.as_ref().or(add.as_ref())));
                wrong.push(format!("{}: {change}\n  need {error}\n   got {got}", base.of));
            }
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

/// Rasters that rows of `refusals.toml` name.
fn write_layers(folder: &Folder) {
    let grid = |name: &str, west_m: u32, value: &dyn Fn(u32, u32) -> &'static str| {
        let row = |y: u32| (0..6).map(|x| value(x, y)).collect::<Vec<_>>().join(" ");
        let rows: Vec<String> = (0..4).rev().map(row).collect();
        let head =
            format!("ncols 6\nnrows 4\nxllcorner {west_m}\nyllcorner 2000\ncellsize 1\nNODATA_value -9999\n");
        folder.write(name, &(head + &rows.join("\n") + "\n"));
    };
    let ramp = ["0", "0", "0", "0.5", "1", "1.5"];
    grid("ramp.asc", 1000, &|x, y| if (x, y) == (2, 3) { "-9999" } else { ramp[x as usize] });
    grid("half.asc", 1000, &|_, _| "0.5");
    grid("elsewhere.asc", 1003, &|_, _| "0.5");
    grid("holes.asc", 1000, &|x, _| if x == 1 { "-9999" } else { "0.5" });
    folder.write("small.asc", "ncols 2\nnrows 1\nxllcorner 0\nyllcorner 0\ncellsize 1\n0.5 0.5\n");
    folder.write("short.asc", "ncols 12\nnrows 9\n");
}

/// Motion tables that rows of `refusals.toml` name: each is one class, with what is wrong about it.
fn write_tables(folder: &Folder) {
    let head = "hop_m = 1.0\n[[classes]]\nsoil = \"hard\"\nalong_deg = 2.5\nacross_deg = -5.0\n";
    let tables = [
        ("one.toml", "landings = [{ offset = [1, 0], probability = 1.0 }]"),
        (
            "sum.toml",
            "landings = [{ offset = [1, 0], probability = 0.9 }]\nfar = { probability = 0.2, mean = [4, 0] }",
        ),
        (
            "share.toml",
            "landings = [{ offset = [1, 0], probability = 1.5 }, { offset = [0, 0], probability = -0.5 }]",
        ),
        ("offset.toml", "landings = [{ offset = [3, 0], probability = 1.0 }]"),
        (
            "again.toml",
            "landings = [{ offset = [1, 0], probability = 0.5 }, { offset = [1, 0], probability = 0.5 }]",
        ),
        ("far.toml", "far = { probability = 1.0, mean = [inf, 0] }"),
        ("key.toml", "landing = []"),
    ];
    for (name, class) in tables {
        folder.write(name, &format!("{head}{class}\n"));
    }
    let sure = "landings = [{ offset = [1, 0], probability = 1.0 }]\n";
    folder.write("twice.toml", &format!("{head}{sure}{}{sure}", head.replace("hop_m = 1.0", "")));
    folder.write("bin.toml", &format!("{}{sure}", head.replace("2.5", "3.0")));
    folder.write("steep.toml", &format!("{}{sure}", head.replace("-5.0", "-32.5")));
    folder.write("soil.toml", &format!("{}{sure}", head.replace("hard", "ice")));
    folder.write("hop.toml", &format!("{}{sure}", head.replace("1.0", "5.0")));
    folder.write("away.toml", &format!("{head}rolls_away = true\n"));
    let offsets = (-1..=2).flat_map(|forward| (-2..=2).map(move |left| (forward, left)));
    let all =
        offsets.map(|(forward, left)| format!("{{ offset = [{forward}, {left}], probability = 0.05 }}"));
    folder.write("many.toml", &format!("{head}landings = [{}]\n", all.collect::<Vec<_>>().join(", ")));
}

/// Texts that no row can bring about.
const WITHOUT_A_ROW: [&str; 2] = ["a path that is UTF-8", "terrain that a rover's map can hold"];

/// Each text in the sources of what is needed is in the message of some row.
#[test]
fn every_need_of_the_sources_is_told_by_a_row() {
    let errors: Vec<String> =
        bases().into_iter().flat_map(|base| base.refused).map(|refused| refused.error).collect();
    let mut missing = Vec::new();
    let src = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
    for folder in [src.clone(), src.join("robots")] {
        for file in std::fs::read_dir(folder).unwrap().map(|file| file.unwrap().path()) {
            if file.extension().is_none_or(|extension| extension != "rs") {
                continue;
            }
            let text = std::fs::read_to_string(&file).unwrap();
            let text = text.split("#[cfg(test)]\nmod tests").next().unwrap();
            for need in needs(text) {
                let is_told = errors.iter().any(|error| error.contains(&need));
                if !is_told && !WITHOUT_A_ROW.contains(&need.as_str()) {
                    missing.push(format!("{}: {need}", file.file_name().unwrap().display()));
                }
            }
        }
    }
    assert!(missing.is_empty(), "no row of refusals.toml tells\n{}", missing.join("\n"));
}

/// What is needed, in words, by the calls that refuse values: string literals of several words in their arguments, or named `need`.
fn needs(text: &str) -> Vec<String> {
    let mut needs = Vec::new();
    for call in ["refuse(", "in_range(", "need: ", "let need = ", "need) = ("] {
        for (at, _) in text.match_indices(call) {
            let end = text[at..].find(';').map_or(text.len(), |end| at + end);
            let escaped = text[at..end].replace("\\\"", "\u{1}");
            let literals = escaped.split('"').skip(1).step_by(2);
            let needed = literals.filter(|words| words.contains(' ') && !words.contains(['{', '\\']));
            needs.extend(needed.map(|words| words.replace('\u{1}', "\"")));
        }
    }
    needs.sort();
    needs.dedup();
    needs
}

/// P-TREASURE-CELLS: Treasures lie where they can be collected, or the scenario is refused.
#[test]
fn treasures_lie_where_they_can_be_collected() {
    let treasures = built_in("treasures").terrain.treasures.clone();
    assert_eq!(
        treasures,
        [(12, 4), (4, 10), (10, 10), (15, 15)].map(|(x, y)| Cell::new(x, y)),
        "in index order"
    );
    let at = |cells: &str| {
        let text = BUILT_IN.iter().find(|(name, _)| *name == "treasures").unwrap().1;
        let all = "[[12, 4], [10, 10], [4, 10], [15, 15]]";
        assert!(text.contains(all));
        Scenario::parse(&text.replace(all, cells), "test").unwrap().resolve()
    };
    assert_ne!(at("[[12, 4]]").unwrap().hash, at("[[12, 5]]").unwrap().hash);
    assert_eq!(at("[[5, 4], [3, 4]]").unwrap().hash, at("[[3, 4], [5, 4]]").unwrap().hash);
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 400, ..ProptestConfig::default() })]

    #[test]
    fn a_scenario_with_foreign_bytes_resolves_or_is_refused(
        changes in prop::collection::vec((any::<prop::sample::Index>(), any::<char>()), 1..4),
    ) {
        let mut text: Vec<char> = HILLY.chars().collect();
        for (at, character) in changes {
            let at = at.index(text.len());
            text[at] = character;
        }
        let text: String = text.into_iter().collect();
        let _ = Scenario::parse(&text, "damaged").and_then(|scenario| scenario.resolve());
    }
}
