//! Test programs that are built only when their suite is due.

/// Tables, figures and claims of the papers.
#[test]
fn the_tests_of_research_pass() {
    suites::run_programs("research");
}

/// Pictures of missions as pixels, animations and PDF, and the manual of all commands.
#[test]
fn the_tests_of_pictures_and_manual_pass() {
    suites::run_programs("pictures and manual");
}

/// What compiles schemas, and what reads them.
#[test]
fn the_tests_of_schemas_pass() {
    suites::run_programs("schemas");
}

/// A test program that `cargo test` passes over is run by a suite.
#[test]
fn every_test_program_that_is_passed_over_belongs_to_a_suite() {
    let mut known: Vec<&str> = suites::SUITES.iter().flat_map(|suite| suite.programs).copied().collect();
    let mut passed_over = Vec::new();
    for manifest in crate::structure::manifests() {
        let manifest: Vec<&str> = manifest.split("[[test]]\n").skip(1).collect();
        for entry in
            manifest.iter().filter(|entry| entry.split("\n\n").next().unwrap().contains("\ntest = false"))
        {
            passed_over.push(entry.split('"').nth(1).unwrap().to_owned());
        }
    }
    passed_over.sort();
    known.sort_unstable();
    assert_eq!(passed_over, known);
}
