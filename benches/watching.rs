//! What it costs the stack to be watched: monitor, recording, page and a client that reads everything, or none of it.
//!
//! `cargo bench --bench watching`. Each round flies the same missions both ways, in turn; ratios are taken within
//! a round, so that the noise of a shared machine falls on both sides alike.

#![allow(clippy::print_stdout, reason = "a benchmark's output is its data")]

mod flown;

use std::io::{BufRead, BufReader, Read, Write};
use std::net::TcpStream;
use std::process::{Child, Command, Stdio};
use std::thread::JoinHandle;

use contract::Timing;
use flown::{median, overhead_us, timings};

/// Interleaved rounds of each kind.
const ROUNDS: u64 = 51;

/// Pace of the missions, landings a second.
const PACE_HZ: &str = "50";

fn main() {
    let mut ratios = Vec::new();
    let (mut alone, mut watched) = (Vec::new(), Vec::new());
    for round in 0..ROUNDS {
        // Who goes first takes turns too.
        let order = if round % 2 == 0 { [false, true] } else { [true, false] };
        let mut both_us = [0.0; 2];
        for with_page in order {
            both_us[usize::from(with_page)] = median(fly(round, with_page).iter().map(overhead_us));
        }
        ratios.push(both_us[1] / both_us[0]);
        alone.push(both_us[0]);
        watched.push(both_us[1]);
    }
    println!("processor: {}", node::host::processor());
    println!("rounds: {ROUNDS}, each a mission on hard ground at {PACE_HZ} landings a second, both ways\n");
    print("landing to accepted, less planning, p50 of a round [us]: alone", &alone);
    print("the same with monitor, recording, page, and a client of both streams", &watched);
    print("ratio within a round", &ratios);
    let cost = |ratio: f64| 100.0 * (ratio - 1.0);
    let (low, high) = interval(&ratios);
    println!(
        "\nwatching costs {:+.1} % at p50, {:+.1} to {:+.1} with 95 % confidence; below 10 % is what is asked for",
        cost(median(ratios.iter().copied())),
        cost(low),
        cost(high)
    );
}

/// Timings of a mission flown by three processes, or by four with a recording, a page and its client.
fn fly(round: u64, with_page: bool) -> Vec<Timing> {
    let instance = format!("bench-watching-{}-{round}-{with_page}", std::process::id());
    let dir = tempfile::tempdir().expect("a folder");
    let journal = dir.path().join("journal");
    let start = |words: &[&str], error: Stdio| -> Child {
        let mut command = Command::new(env!("CARGO_BIN_EXE_hopper"));
        command.args(words).args(["--instance", &instance]);
        command.stdin(Stdio::null()).stdout(Stdio::null()).stderr(error).spawn().expect("hopper runs")
    };
    let mut peers = vec![start(&["perception"], Stdio::null()), start(&["planner"], Stdio::null())];
    let mut clients = Vec::new();
    if with_page {
        let recording = dir.path().join("watched.mcap");
        let words = ["monitor", "--web", "0", "--web-exit", "--record", &recording.to_string_lossy()];
        let mut monitor = start(&words, Stdio::piped());
        clients = read_everything(&address(&mut monitor));
        peers.push(monitor);
    }
    let (seed, journal_text) = ((round + 1).to_string(), journal.to_string_lossy());
    let words = ["sim", "--pace", PACE_HZ, "--seed", &seed, "--journal", &journal_text];
    let status = start(&words, Stdio::null()).wait().expect("hopper-sim ends");
    assert!(matches!(status.code(), Some(0 | 1)), "the mission ended with {status}");
    for mut peer in peers {
        peer.wait().expect("a peer ends");
    }
    for client in clients {
        assert!(client.join().expect("a client ends") > 0, "the page told something");
    }
    timings(&journal)
}

/// Where a monitor says its page is; its further lines are read and dropped.
fn address(monitor: &mut Child) -> String {
    let mut log = BufReader::new(monitor.stderr.take().expect("its standard error"));
    let mut line = String::new();
    while !line.contains("page at http://") {
        line.clear();
        assert!(log.read_line(&mut line).expect("a log") > 0, "the monitor tells its page");
    }
    std::thread::spawn(move || std::io::copy(&mut log, &mut std::io::sink()));
    let rest = line.split("http://").nth(1).expect("an address");
    rest.trim().trim_end_matches('/').to_owned()
}

/// Clients of account and policies, as a browser with both in sight would be; each tells the bytes it got.
fn read_everything(address: &str) -> Vec<JoinHandle<usize>> {
    let client = |path: &str| {
        let mut stream = TcpStream::connect(address).expect("a page");
        write!(stream, "GET {path} HTTP/1.1\r\nHost: {address}\r\n\r\n").expect("a request");
        std::thread::spawn(move || {
            let (mut bytes, mut piece) = (0, vec![0; 1 << 16]);
            while let Ok(count @ 1..) = stream.read(&mut piece) {
                bytes += count;
            }
            bytes
        })
    };
    vec![client("/events"), client("/policy")]
}

/// The 95 % interval of a median by ranks, whatever the values are distributed like: on a busy machine single
/// rounds are far off.
fn interval(values: &[f64]) -> (f64, f64) {
    let mut values = values.to_vec();
    values.sort_by(f64::total_cmp);
    let count = values.len() as f64;
    let rank = ((count - 1.96 * count.sqrt()) / 2.0).floor().max(1.0) as usize;
    (values[rank - 1], values[values.len() - rank])
}

fn print(name: &str, rounds: &[f64]) {
    let low = rounds.iter().copied().fold(f64::MAX, f64::min);
    let high = rounds.iter().copied().fold(f64::MIN, f64::max);
    println!("{name:<64} {:>8.2}   (rounds {low:.2} to {high:.2})", median(rounds.iter().copied()));
}
