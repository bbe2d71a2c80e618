//! The page's side of its requests.

// Helpers of tests are not recognised as tests.
#![allow(clippy::unwrap_used)]

use std::path::Path;
use std::process::Command;

/// P-WEB-KEY: A page drops a key that its tab has kept from an earlier mission at the same address
/// once the server does not know it, and then offers no orders.
/// P-WEB-DEAF. A page sends back the number of each of its streams.
#[test]
fn a_page_drops_a_key_that_the_server_does_not_know_and_shows_that_it_reads() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let mut node = Command::new("node");
    node.arg(root.join("tests/transport.mjs")).arg(root.join("src/web/page/transport.js"));
    let output =
        node.output().unwrap_or_else(|error| panic!("the page's test needs node on PATH, got: {error}"));
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
}
