//! Bad input gets one clear error and an exit code, never a panic or a hang.

use crate::harness::{hopper, stderr};

/// Runs `hopper WORDS`, which must fail with `code` and say all of `says`, in few lines.
fn refuses(words: &[&str], code: i32, says: &[&str]) {
    let output = hopper(words).output().unwrap();
    let text = stderr(&output);
    assert_eq!(output.status.code(), Some(code), "{words:?}: {text}");
    assert!(output.stdout.is_empty(), "{words:?} wrote data: {}", String::from_utf8_lossy(&output.stdout));
    for part in says {
        assert!(text.contains(part), "{words:?} does not say {part:?}: {text}");
    }
    assert!(!text.contains("panicked"), "{words:?}: {text}");
    assert!(
        text.lines().count() <= 12 && text.len() < 3000,
        "{words:?} is not one clear error: {text:.3000}"
    );
}

/// P-FLAGS: Bad flags are usage errors, and problems that only the monitor would find are reported
/// before anything flies.
#[test]
fn bad_flags_are_usage_errors() {
    refuses(&["run", "--planner", "teleport"], 2, &["teleport", "mdp"]);
    refuses(&["planner", "--algorithm", "teleport"], 2, &["teleport", "mdp"]);
    refuses(&["run", "--profile", "teleport"], 2, &["paper-2023", "hopper"]);
    refuses(&["run", "--pace=-3"], 2, &["pace"]);
    refuses(&["run", "--pace", "NaN"], 2, &["pace"]);
    refuses(&["run", "--budget", "soon"], 2, &["budget"]);
    refuses(&["run", "--lockstep", "--budget", "5124096h"], 2, &["decision_budget_ms", "1e-6 to 1e12 ms"]);
    refuses(&["run", "--seed", "x"], 2, &["seed"]);
    refuses(&["run", "--lockstep", "--pace", "real"], 2, &["--lockstep"]);
    refuses(&["run", "--nonsense"], 2, &["--nonsense"]);
    refuses(&["run", "--instance", ""], 2, &["instance"]);
    refuses(&["journal", "verify", "no/such/journal"], 2, &["no/such/journal"]);
    refuses(&["run", "--lockstep", "--planners-from", "no/such/journal"], 2, &["no/such/journal"]);
    let file = tempfile::NamedTempFile::new().unwrap();
    refuses(
        &["journal", "verify", file.path().to_str().unwrap()],
        2,
        &["need the folder of a journal, got the file"],
    );
}

/// P-FLAGS. Problems that only the monitor would find are reported before anything flies.
#[test]
fn a_recording_or_a_page_that_cannot_be_made_is_a_usage_error() {
    refuses(&["run", "--record", "no/such/folder/x.mcap"], 2, &["no/such/folder", "create it first"]);
    let taken = std::net::TcpListener::bind("127.0.0.1:0").unwrap();
    let address = taken.local_addr().unwrap().to_string();
    refuses(&["run", "--web", &address], 2, &[&address, "choose another port, or 0"]);
}

/// P-SCENARIO: Bad scenarios are refused, and the error names the field.
#[test]
fn bad_scenarios_are_refused_by_name() {
    let dir = tempfile::tempdir().unwrap();
    let file = dir.path().join("bad.toml");
    let path = file.to_str().unwrap();
    refuses(&["run", "--lockstep", "--scenario", "no-such-scenario"], 2, &["no-such-scenario", "hard"]);
    refuses(&["scenario", "check", "no-such.toml"], 2, &["no-such.toml"]);
    let good = include_str!("../scenarios/hard.toml");
    let cut = &good[..good.len() * 2 / 3];
    for text in [cut, "", "goal = 3", "[truth]\nkind = 7", "\u{0}\u{1}"] {
        std::fs::write(&file, text).unwrap();
        refuses(&["scenario", "check", path], 2, &["bad.toml"]);
        refuses(&["sim", "--scenario", path], 2, &["bad.toml"]);
    }
    std::fs::write(&file, [0xff, 0xfe, 0x00]).unwrap();
    refuses(&["scenario", "check", path], 2, &["bad.toml"]);
}

/// P-SCENARIO-LIMITS: Scenarios that are too long, too deep, too large or endless are refused, and
/// the error names the limit.
#[test]
fn scenarios_beyond_a_limit_are_refused_by_the_limits_name() {
    let dir = tempfile::tempdir().unwrap();
    let file = dir.path().join("bad.toml");
    let path = file.to_str().unwrap();
    let good = include_str!("../scenarios/hard.toml");
    let hills = format!("raised_m = [{}]", "[1,6],".repeat(1001));
    let nested = format!("name = {}", "[".repeat(100_000));
    let rectangles = format!("[truth.sand]\nrectangles = [{}]\n[brief]", "{x=[0,1],y=[0,1]},".repeat(1001));
    let treasures = format!("[truth]\ntreasures = [{}]\n[truth.terrain", "[3,3],".repeat(17));
    for (from, to, says) in [
        (
            "raised_m = [[1, 6], [5, 0], [5, 20], [7, 14], [8, 8]]",
            hills.as_str(),
            "need at most 1000 hills, got 1004",
        ),
        ("width_cells = 20", "width_cells = 1025", "sides of 1 to 1024 cells"),
        ("width_cells = 20", "width_cells = 4294967296", "width_cells"),
        ("cell_size_m = 1.0", "cell_size_m = 1e-9", "need a hop of a whole number of cells"),
        ("name = \"hard\"", nested.as_str(), "max recursion depth"),
        ("[brief]", rectangles.as_str(), "truth.sand.rectangles: need at most 1000, got 1001"),
        ("[truth.terrain", treasures.as_str(), "truth.treasures: need at most 16 cells, got 17"),
        ("steps_max = 150", "steps_max = 4294967297", "brief.steps_max needs 1 to 4294967296"),
        (
            "decision_budget_ms = 600",
            "decision_budget_ms = 1e13",
            "limits.decision_budget_ms: need 1e-6 to 1e12 ms",
        ),
    ] {
        let text = good.replace(from, to);
        assert_ne!(text, good, "{from}");
        std::fs::write(&file, text).unwrap();
        refuses(&["scenario", "check", path], 2, &[says]);
    }
    std::fs::File::create(&file).unwrap().set_len(1 << 40).unwrap();
    for words in [
        &["scenario", "check", path][..],
        &["run", "--lockstep", "--scenario", path],
        &["sim", "--scenario", path],
    ] {
        refuses(words, 2, &["bad.toml: need at most 1048576 bytes, got more"]);
    }
    refuses(&["scenario", "check", "/dev/zero"], 2, &["/dev/zero: need at most 1048576 bytes, got more"]);
}

#[test]
fn a_log_filter_that_is_none_is_named_and_a_wait_names_who_lives() {
    let words = ["topic", "list", "--instance", "nobody-home", "--wait", "50ms"];
    let output = hopper(&words).env("HOPPER_LOG", "=)(").output().unwrap();
    let text = stderr(&output);
    assert_eq!(output.status.code(), Some(4), "{text}");
    assert!(text.contains("HOPPER_LOG") && text.contains("=)("), "{text}");
    assert!(text.contains("\"nobody-home\" is not running"), "{text}");
}

/// P-TERRAIN: Bad elevation models are refused, and the error names the problem.
#[test]
fn bad_elevation_models_are_refused_by_name() {
    let dir = tempfile::tempdir().unwrap();
    let write = |name: &str, bytes: &[u8]| {
        let path = dir.path().join(name);
        std::fs::write(&path, bytes).unwrap();
        path.to_str().unwrap().to_owned()
    };
    refuses(&["terrain", "check", "no/such.tif"], 2, &["no/such.tif"]);
    refuses(&["terrain", "check", &write("empty.tif", b"")], 2, &["empty.tif"]);
    refuses(&["terrain", "check", &write("text.tif", b"this is no elevation model")], 2, &["text.tif"]);
    refuses(&["terrain", "check", &write("cut.tif", b"II*\0\x08\0\0\0\x05\0")], 2, &["cut.tif"]);
    refuses(&["terrain", "check", &write("cut.asc", b"ncols 4\nnrows 4\n")], 2, &["cut.asc"]);
    let huge = b"ncols 99999999\nnrows 99999999\nxllcorner 0\nyllcorner 0\ncellsize 1\n1 2 3\n";
    refuses(&["terrain", "check", &write("huge.asc", huge)], 2, &["huge.asc"]);
    refuses(&["run", "--lockstep", "--scenario", "mars", "--dem", "no/such.tif"], 2, &["no/such.tif"]);
    // What is no file might never open, or never end.
    let pipe = dir.path().join("pipe.tif");
    rustix::fs::mknodat(rustix::fs::CWD, &pipe, rustix::fs::FileType::Fifo, rustix::fs::Mode::RWXU, 0)
        .unwrap();
    for path in [pipe.to_str().unwrap(), dir.path().to_str().unwrap(), "/dev/zero"] {
        refuses(&["terrain", "check", path], 2, &[path, "file: need a regular one"]);
    }
}

/// P-OUT: An output directory that cannot be created, or that belongs to another mission, is
/// refused and left as it was.
#[test]
fn an_output_folder_that_cannot_be_made_is_refused() {
    let dir = tempfile::tempdir().unwrap();
    let file = dir.path().join("file");
    std::fs::write(&file, "").unwrap();
    let inside = file.join("out");
    refuses(&["run", "--lockstep", "--out", inside.to_str().unwrap()], 2, &["--out"]);
}

/// P-PIPE: A closed or full standard output, a terminal without abilities and an empty environment
/// cause no panic, no escape sequence and no bare error number.
#[test]
fn a_closed_standard_output_is_no_panic() {
    let (reader, writer) = std::io::pipe().unwrap();
    drop(reader);
    let output = hopper(&["scenario", "schema"]).stdout(writer).output().unwrap();
    assert!(!stderr(&output).contains("panicked"), "{}", stderr(&output));
}
