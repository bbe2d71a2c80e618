//! Packages that are built for their own tests alone.

/// Tables, figures and claims of the papers.
#[test]
fn the_tests_of_research_pass() {
    suites::run_packages("research");
}

/// Pictures of missions as pixels, animations and PDF, and the manual of all commands.
#[test]
fn the_tests_of_pictures_and_manual_pass() {
    suites::run_packages("pictures and manual");
}

/// What compiles schemas, and what reads them.
#[test]
fn the_tests_of_schemas_pass() {
    suites::run_packages("schemas");
}

/// Nothing is left out by being no default member.
#[test]
fn every_package_is_a_default_member_or_tested_by_a_suite() {
    let manifest = include_str!("../Cargo.toml");
    let list = |name: &str| {
        let list = manifest.split(&format!("\n{name} = [\n")).nth(1).unwrap().split("\n]").next().unwrap();
        list.lines().map(|line| line.trim().trim_matches([',', '"'])).collect::<Vec<_>>()
    };
    let (members, defaults) = (list("members"), list("default-members"));
    let tested = suites::SUITES.iter().flat_map(|suite| suite.files);
    let tested: Vec<&str> = tested.copied().chain(["bench"]).collect();
    let left: Vec<&&str> = members.iter().filter(|member| !defaults.contains(member)).collect();
    assert!(!left.is_empty());
    let is_tested =
        |member: &str| tested.iter().any(|file| member == *file || member.starts_with(&format!("{file}/")));
    let untested: Vec<&&&str> = left.iter().filter(|member| !is_tested(member)).collect();
    assert!(untested.is_empty(), "{untested:?}");
}
