//! The gallery of docs/ is what `hopper gallery` draws.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

use std::collections::BTreeSet;
use std::path::Path;

fn docs() -> std::path::PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../docs")
}

fn read(path: impl AsRef<Path>) -> String {
    let path = docs().join(path);
    std::fs::read_to_string(&path).unwrap_or_else(|error| panic!("{}: {error}", path.display()))
}

/// P-GALLERY: `hopper gallery` draws a figure to the same bytes each time, and docs/gallery matches
/// what it draws.
///
/// A few figures stand for all, since drawing all of them takes campaigns.
#[test]
fn a_figure_drawn_again_is_the_one_in_docs() {
    for name in ["states-hard", "p21-fig-14", "p21-fig-18", "p21-fig-19", "anytime"] {
        let draw = || hopper_research::gallery::figure(name).unwrap().unwrap();
        let first = draw();
        assert!(first == draw(), "two drawings of {name} differ");
        let kept = read(Path::new("gallery").join(name).with_extension("svg"));
        assert!(
            first.svg == kept,
            "docs/gallery is of another version: cargo run --release -p hopper-research -- gallery"
        );
        assert!(read("gallery.md").contains(&format!("## {}\n\n{}\n", first.title, first.text)), "{name}");
    }
}

/// A measurement of `research/p21/benches/anytime.csv` as a line of it.
fn line(side: u32, planner: &str, time: &str, above: &str) -> String {
    let (time, unit) = time.split_once(' ').unwrap();
    let time_ms: f64 = time.parse::<f64>().unwrap() * if unit == "s" { 1000.0 } else { 1.0 };
    format!("{side},{planner},{time_ms:.1},{:.1}", above.trim_end_matches(" %").parse::<f64>().unwrap())
}

/// P-GALLERY-CURVE: The anytime curve beside OMPL is drawn from the measurements in the book's
/// tables.
#[test]
fn the_anytime_curve_is_that_of_the_tables_in_the_book() {
    let page = read("scouting.md");
    let table = |headings: &str| -> Vec<Vec<String>> {
        let lines = page.lines().skip_while(|line| !line.starts_with(headings)).skip(2);
        let rows = lines.take_while(|line| line.starts_with('|'));
        rows.map(|line| line.trim_matches('|').split('|').map(|cell| cell.trim().to_owned()).collect())
            .collect()
    };
    let mut told = BTreeSet::new();
    for row in table("| after | 200 × 200: RRTstar") {
        for (cell, side, planner) in
            [(1, 200, "RRTstar"), (2, 200, "BITstar"), (3, 821, "RRTstar"), (4, 821, "BITstar")]
        {
            if row[cell] != "none" {
                told.insert(line(side, planner, &row[0], &row[cell]));
            }
        }
    }
    for row in table("| `rrt_star_ett`, N |") {
        told.insert(line(200, "rrt_star_ett", &row[1], &row[2]));
        told.insert(line(821, "rrt_star_ett", &row[3], &row[4]));
    }
    let exact = page.split("in per cent above `ett_exact`, which needs ").nth(1).unwrap();
    let (small, rest) = exact.split_once(" and ").unwrap();
    let large = rest.split(' ').next().unwrap();
    told.insert(line(200, "ett_exact", &format!("{small} ms"), "0"));
    told.insert(line(821, "ett_exact", &format!("{large} ms"), "0"));
    let drawn: BTreeSet<String> =
        hopper_research::gallery::anytime::MEASURED.lines().skip(1).map(Into::into).collect();
    assert_eq!(told, drawn);
}

#[test]
fn the_page_shows_every_figure_of_its_folder_and_no_other() {
    let page = read("gallery.md");
    let shown: BTreeSet<String> =
        page.split("](gallery/").skip(1).map(|rest| rest.split(')').next().unwrap().to_owned()).collect();
    let files: BTreeSet<String> = std::fs::read_dir(docs().join("gallery"))
        .unwrap()
        .map(|entry| entry.unwrap().file_name().into_string().unwrap())
        .collect();
    assert_eq!(shown, files);
    let bytes: usize = files.iter().map(|file| read(Path::new("gallery").join(file)).len()).sum();
    assert!(bytes < 2_000_000, "the gallery weighs {bytes} bytes");
}
