//! Scenarios from text to world: what is resolved, what is refused, and how.

#![allow(clippy::unwrap_used)]

mod brief;
mod built_in;
mod ground;
mod mixed;
mod mobility;
mod refusals;
mod robots;
mod schema;

use std::path::PathBuf;

use scenario::{ResolvedScenario, Scenario, ScenarioError, load};

/// A folder with an elevation model: 12 x 9 cells of 2 m that rise 0.5 m a cell northwards, with one
/// cell that has no height (0, 0) and a wall of cliffs around (6, 4).
struct Folder(tempfile::TempDir);

impl Folder {
    fn new() -> Self {
        let folder = Self(tempfile::tempdir().unwrap());
        folder.write(
            "dem.asc",
            &grid(|x, y| if (x, y) == (6, 4) { -3980.0 } else { f64::from(y) * 0.5 - 4000.0 }),
        );
        folder
    }

    fn write(&self, name: &str, text: &str) -> PathBuf {
        let path = self.0.path().join(name);
        std::fs::write(&path, text).unwrap();
        path
    }

    /// The world of `text` as a file in this folder.
    fn world(&self, text: &str) -> Result<ResolvedScenario, ScenarioError> {
        let path = self.write("mission.toml", text);
        load(path.to_str().unwrap())?.resolve()
    }

    fn error(&self, text: &str) -> String {
        self.world(text).expect_err("the scenario is refused").to_string()
    }
}

/// An ASCII grid of 12 x 9 cells of 2 m; (0, 0) has no height.
fn grid(height: impl Fn(u32, u32) -> f64) -> String {
    let mut text =
        String::from("ncols 12\nnrows 9\nxllcorner 100\nyllcorner 300\ncellsize 2\nNODATA_value -9999\n");
    for y in (0..9).rev() {
        let row: Vec<String> = (0..12)
            .map(|x| if (x, y) == (0, 0) { "-9999".into() } else { height(x, y).to_string() })
            .collect();
        text += &(row.join(" ") + "\n");
    }
    text
}

const REAL: &str = r#"
[truth.terrain.elevation_file]
file = "dem.asc"
[brief]
start = [1, 1]
goal = [10, 7]
datum_m = -4000
[robot]
hop_distance_m = 2.0
"#;

const HILLY: &str = r#"
[truth.terrain.gaussians]
width_cells = 10
height_cells = 8
cell_size_m = 0.5
sigma_m = 1.0
amplitude_m = 0.2
raised_m = [[1, 1]]
[brief]
start = [0, 0]
goal = [8, 6]
"#;

fn hilly(from: &str, to: &str) -> Result<ResolvedScenario, ScenarioError> {
    assert!(HILLY.contains(from), "{from:?}");
    Scenario::parse(&HILLY.replace(from, to), "hilly")?.resolve()
}

fn says(text: &str, words: &[&str]) {
    for word in words {
        assert!(text.contains(word), "{word:?} is missing in: {text}");
    }
}

fn built_in(name: &str) -> ResolvedScenario {
    load(name).unwrap().resolve().unwrap()
}
