//! What the page without a server is told of uncertain ground.

// Helpers of tests are not recognised as tests.
#![allow(clippy::unwrap_used)]

use std::sync::Arc;

use browser::{Request, Session};
use contract::MonotonicNs;

/// P-BROWSER-SPEEDS: The page without a server shows the expected speed of every cell too.
#[test]
fn the_page_without_a_server_is_told_all_expected_speeds() {
    let request = Request { scenario: Some("rover-helicopter".into()), ..Request::default() };
    let mut now_ns = 0;
    let clock = move || {
        now_ns += 1_000_000;
        MonotonicNs(now_ns)
    };
    let mut session = Session::begin(&request, &Arc::from([]), Box::new(clock)).unwrap();
    while !session.turn().unwrap() {}
    let (mut cells, mut routes) = (0, 0);
    while let Some(frame) = session.frame(MonotonicNs(1)) {
        let data: serde_json::Value = serde_json::from_str(&frame.data).unwrap();
        match frame.event {
            "speeds" => {
                let runs = data["runs"].as_array().unwrap();
                cells += runs.chunks(2).map(|run| run[1].as_u64().unwrap()).sum::<u64>();
            }
            "routes" => routes += 1,
            _ => {}
        }
    }
    assert_eq!(cells, 40_000);
    assert!(routes >= 2, "the rover's and the helicopter's");
}
