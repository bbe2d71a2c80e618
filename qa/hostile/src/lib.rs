//! Malformed input for every reader of bytes that another program may have written.
//!
//! Each [`Target`] is the body of a fuzz target: it takes any bytes and returns, or panics because a claim
//! does not hold. `fuzz/` runs the bodies under libFuzzer; `tests/corpus.rs` here runs the same ones over
//! the committed corpus and over mutations of valid input, on any toolchain.

pub mod campaign;
pub mod disk;
pub mod extremes;
pub mod fixtures;
pub mod journal;
pub mod mission;
pub mod mutation;
pub mod raster;
pub mod recording;
pub mod scenario;
pub mod wire;

/// A reader to be fuzzed.
#[derive(Clone, Copy, Debug)]
pub struct Target {
    /// Its name, which is that of its fuzz target and of its corpus.
    pub name: &'static str,
    /// Reads any bytes; panics if a claim about the reader does not hold.
    pub read: fn(&[u8]),
    /// Valid input to start mutations from.
    pub seeds: fn() -> Vec<Vec<u8>>,
}

/// All readers; `fuzz/fuzz_targets` has a target for each.
pub const TARGETS: [Target; 26] = [
    Target { name: "scenario", read: scenario::read, seeds: scenario::seeds },
    Target { name: "campaign", read: campaign::read, seeds: campaign::seeds },
    Target { name: "checkpoint", read: campaign::read_checkpoint, seeds: campaign::checkpoints },
    Target { name: "rows", read: campaign::read_rows, seeds: campaign::rows },
    Target { name: "geotiff", read: raster::read, seeds: Vec::new },
    Target { name: "ascii_grid", read: raster::read, seeds: raster::ascii_grids },
    Target { name: "journal", read: journal::read, seeds: journal::seeds },
    Target { name: "recording", read: recording::read, seeds: recording::seeds },
    Target { name: "brief", read: wire::brief, seeds: wire::briefs },
    Target { name: "command", read: wire::command, seeds: wire::commands },
    Target { name: "control", read: wire::control, seeds: wire::controls },
    Target { name: "heartbeat", read: wire::heartbeat, seeds: wire::heartbeats },
    Target { name: "state", read: wire::state, seeds: wire::states },
    Target { name: "map_patch", read: wire::map_patch, seeds: wire::map_patches },
    Target { name: "map_page", read: wire::map_page, seeds: wire::map_pages },
    Target { name: "past_page", read: wire::past_page, seeds: wire::past_pages },
    Target { name: "team", read: wire::team, seeds: wire::teams },
    Target { name: "route", read: wire::route, seeds: wire::routes },
    Target { name: "detail_page", read: wire::detail_page, seeds: wire::detail_pages },
    Target { name: "prior_page", read: wire::prior_page, seeds: wire::prior_pages },
    Target { name: "table_page", read: wire::table_page, seeds: wire::table_pages },
    Target { name: "policy", read: wire::policy, seeds: wire::policies },
    Target { name: "truth_page", read: wire::truth_page, seeds: wire::truth_pages },
    Target { name: "cell", read: wire::cell, seeds: wire::cells },
    Target { name: "request", read: wire::request, seeds: wire::requests },
    Target { name: "mission", read: mission::read, seeds: mission::seeds },
];

/// Panics unless the error has a text of bounded length.
pub(crate) fn told(error: &dyn std::fmt::Display) {
    let text = error.to_string();
    assert!(!text.trim().is_empty(), "an error says what is wrong");
    assert!(text.len() < 20_000, "an error of {} bytes says too much", text.len());
}
