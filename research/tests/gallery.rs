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

/// P-GALLERY: one figure stands for all; the whole takes a campaign.
#[test]
fn a_figure_drawn_again_is_the_one_in_docs() {
    let first = hopper_research::gallery::figure("states-hard").unwrap().unwrap();
    let again = hopper_research::gallery::figure("states-hard").unwrap().unwrap();
    assert!(first == again, "two drawings of one figure differ");
    let kept = read("gallery/states-hard.svg");
    assert!(
        first.svg == kept,
        "docs/gallery is of another version: cargo run --release -p hopper-research -- gallery"
    );
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
