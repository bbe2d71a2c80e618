//! Every command with arguments that no author thought of: an answer or one clear error, never a panic or a hang.

use std::ffi::{OsStr, OsString};
use std::os::unix::ffi::OsStringExt as _;
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};

use rustix::fs::{CWD, FileType, Mode, mknodat};

use crate::harness::{hopper, stderr};
use crate::tools::is_served;

/// A folder with a mission that was flown, a campaign, a recording, an elevation model, and places where nothing can be
/// written.
struct Place(tempfile::TempDir);

impl Place {
    fn new() -> Self {
        let place = Self(tempfile::tempdir().unwrap());
        let write = |name: &str, bytes: &[u8]| std::fs::write(place.path(name), bytes).unwrap();
        write("file", b"text");
        write(
            "c.toml",
            b"name = \"c\"\nseed = 1\nrepetitions = 2\nscenarios = [\"hard\"]\nplanners = [\"greedy\"]\n",
        );
        let row = ["1"; 40].join(" ");
        let header = "ncols 40\nnrows 40\nxllcorner 0\nyllcorner 0\ncellsize 1\n";
        write("dem.asc", format!("{header}{}\n", [row.as_str(); 40].join("\n")).as_bytes());
        let golden = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/golden/hard.mcap");
        std::fs::copy(golden, place.path("hard.mcap")).unwrap();
        std::fs::create_dir(place.path("folder")).unwrap();
        mknodat(CWD, place.path("pipe"), FileType::Fifo, Mode::RWXU, 0).unwrap();
        for words in [
            &["run", "--lockstep", "--out", "flown"][..],
            &["campaign", "run", "c.toml", "--out", "campaign"],
        ] {
            assert_eq!(place.run(words, &[]).status.code(), Some(0), "{words:?}");
        }
        place
    }

    fn path(&self, name: impl AsRef<Path>) -> PathBuf {
        self.0.path().join(name)
    }

    fn command(&self, words: &[&str], more: &[&OsStr]) -> Command {
        let mut command = hopper(words);
        command.args(more).current_dir(self.0.path());
        command
    }

    fn run(&self, words: &[&str], more: &[&OsStr]) -> Output {
        self.command(words, more).output().unwrap()
    }

    /// Runs it, and checks what holds for every command, whatever its arguments.
    fn checked(&self, words: &[&str], more: &[&OsStr]) -> (i32, String) {
        let output = self.run(words, more);
        (clear(&output, &format!("{words:?} {more:?}")), stderr(&output))
    }
}

/// The exit code, which is one of Hopper's; errors are few lines in words.
fn clear(output: &Output, what: &str) -> i32 {
    let text = stderr(output);
    let code = output.status.code().unwrap_or_else(|| panic!("{what}: {}: {text}", output.status));
    assert!([0, 1, 2, 3, 4, 130].contains(&code), "{what}: {code}: {text}");
    for bad in ["panicked", "os error"] {
        assert!(!text.contains(bad), "{what}: {text}");
    }
    assert!(text.lines().count() <= 14 && text.len() < 4000, "{what} is not one clear error: {text:.4000}");
    code
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Writes {
    /// A file of one of these formats; anything if there is none.
    File(&'static [&'static str]),
    Folder,
}

/// Commands that write where they are told to; the path comes last.
const WRITERS: &[(&[&str], Writes)] = &[
    (&["run", "--lockstep", "--out"], Writes::Folder),
    (&["campaign", "run", "c.toml", "--out"], Writes::Folder),
    (&["campaign", "merge", "campaign", "--out"], Writes::Folder),
    (&["campaign", "report", "campaign", "--out"], Writes::Folder),
    (&["campaign", "rerun", "campaign", "--trial", "0", "--out"], Writes::Folder),
    (&["known", "plan", "hard", "--out"], Writes::Folder),
    (&["man", "--out"], Writes::Folder),
    (&["scenario", "new", "--dem", "dem.asc", "--out"], Writes::File(&[])),
    (&["journal", "draw", "flown", "--at", "3", "--out"], Writes::File(&["svg", "pdf"])),
    (&["gif", "flown", "--width", "120", "--out"], Writes::File(&["gif"])),
    (&["bag", "recover", "hard.mcap"], Writes::File(&[])),
    (&["latency", "report", "hard.mcap", "--svg"], Writes::File(&["svg"])),
    (&["latency", "report", "hard.mcap", "--hgrm"], Writes::File(&[])),
];

/// Commands that write too, and take longer: they are given only what is refused.
const SLOW_WRITERS: &[&[&str]] = &[
    &["run", "--record"],
    &["run", "--out"],
    &["sim", "--journal"],
    &["monitor", "--record"],
    &["gallery", "--out"],
    &["coverage", "--out"],
    &["scouting", "--out"],
    &["scouting", "scale", "--out"],
    &["known", "findings", "--out"],
    &["endure", "--out"],
];

/// P-PATHS: A path to write is written whatever its bytes and named, or refused: standard output, a
/// pipe, or a name of another format. A path to read that is something else is refused.
#[test]
fn a_path_to_write_is_written_as_asked_or_refused() {
    let place = Place::new();
    let writers = WRITERS.iter().filter(|(words, _)| is_served(words));
    for (number, (words, writes)) in writers.enumerate() {
        let odd = OsString::from_vec([format!("odd-{number}-").as_bytes(), b"\xff\xfe"].concat());
        let (code, text) = place.checked(words, &[&odd]);
        assert!([0, 3].contains(&code) && place.path(&odd).exists(), "{words:?}: {text}");
        // Who writes a file names it; a run names its files in its summary, on standard output.
        let output = place.run(words, &[OsStr::new(&format!("named-{number}"))]);
        clear(&output, &format!("{words:?}"));
        let told = stderr(&output) + &String::from_utf8_lossy(&output.stdout);
        assert!(told.contains(&format!("named-{number}")), "{words:?} does not name what it wrote: {told}");

        for refused in ["", "-", "file/below", "/dev/null/below"] {
            let (code, text) = place.checked(words, &[OsStr::new(refused)]);
            assert_eq!(code, 2, "{words:?} {refused:?}: {text}");
        }
        match writes {
            Writes::Folder => {
                for refused in ["file", "/dev/null", "/dev/full", "pipe"] {
                    let (code, text) = place.checked(words, &[OsStr::new(refused)]);
                    assert_eq!(code, 2, "{words:?} {refused:?}: {text}");
                }
            }
            Writes::File(endings) => {
                for refused in ["folder", "pipe", "no/such/folder/x"] {
                    let (code, text) = place.checked(words, &[OsStr::new(refused)]);
                    assert_eq!(code, 2, "{words:?} {refused:?}: {text}");
                }
                place.checked(words, &[OsStr::new("/dev/full")]);
                for other in ["jpg", "PNG", "webp"] {
                    let other = format!("x-{number}.{other}");
                    let (code, text) = place.checked(words, &[OsStr::new(&other)]);
                    if !endings.is_empty() {
                        assert_eq!(code, 2, "{words:?} {other}: {text}");
                        assert!(text.contains(endings[0]) && !place.path(&other).exists(), "{text}");
                    }
                }
            }
        }
    }
    for words in SLOW_WRITERS {
        for refused in ["", "-"] {
            let (code, text) = place.checked(words, &[OsStr::new(refused)]);
            assert_eq!(code, 2, "{words:?} {refused:?}: {text}");
        }
    }
    assert!(!place.path("-").exists());
}

/// Commands that read what they are told to; the path comes last.
const READERS: &[&[&str]] = &[
    &["run", "--lockstep", "--scenario"],
    &["run", "--lockstep", "--dem"],
    &["run", "--lockstep", "--planners-from"],
    &["sim", "--scenario"],
    &["sim", "--dem"],
    &["view"],
    &["campaign", "run"],
    &["campaign", "merge"],
    &["campaign", "report"],
    &["campaign", "report", "campaign", "--beside"],
    &["campaign", "rerun", "--trial", "0"],
    &["scenario", "check"],
    &["scenario", "check", "--dem"],
    &["scenario", "new", "--dem"],
    &["terrain", "check"],
    &["journal", "verify"],
    &["journal", "show"],
    &["journal", "draw"],
    &["gif"],
    &["bag", "info"],
    &["bag", "replay"],
    &["bag", "export"],
    &["latency", "report"],
    &["known", "plan"],
    &["endure", "--scenario"],
];

/// P-PATHS. A path to read that does not exist, or is something else, is refused.
#[test]
fn a_path_to_read_that_is_something_else_is_refused() {
    let place = Place::new();
    let odd = OsString::from_vec(b"odd-\xff".to_vec());
    for words in READERS.iter().filter(|words| is_served(words)) {
        let names = ["", "no/such", "no-such.toml", "folder", "file/below", "/dev/null", "file"];
        for name in names.map(OsStr::new).into_iter().chain([odd.as_os_str()]) {
            let (code, text) = place.checked(words, &[name]);
            assert!([1, 2].contains(&code), "{words:?} {name:?}: {code}: {text}");
        }
    }
    // What has no end is not read to its end.
    for words in [&["bag", "info"][..], &["terrain", "check"], &["scenario", "check"], &["latency", "report"]]
    {
        let (code, text) = place.checked(words, &[OsStr::new("/dev/zero")]);
        assert_eq!(code, 2, "{words:?}: {text}");
    }
    for words in [&["bag", "info"][..], &["terrain", "check"], &["latency", "report"], &["run", "--dem"]] {
        let (code, text) = place.checked(words, &[OsStr::new("pipe")]);
        assert_eq!(code, 2, "{words:?}: {text}");
    }
}

/// Commands with a flag that takes a number, a duration, a name or a list.
const VALUES: &[&[&str]] = &[
    &["run", "--lockstep", "--seed"],
    &["run", "--lockstep", "--budget"],
    &["run", "--lockstep", "--profile"],
    &["run", "--lockstep", "--planner"],
    &["run", "--lockstep", "--picture"],
    &["run", "--lockstep", "--format"],
    &["run", "--pace"],
    &["run", "--patience"],
    &["run", "--web"],
    &["sim", "--linger"],
    &["sim", "--wait"],
    &["perception", "--wait"],
    &["planner", "--robot"],
    &["planner", "--algorithm"],
    &["monitor", "--web"],
    &["view", "flown", "--web"],
    &["campaign", "run", "c.toml", "--jobs"],
    &["campaign", "run", "c.toml", "--shard"],
    &["campaign", "rerun", "campaign", "--trial"],
    &["campaign", "report", "campaign", "--against"],
    &["campaign", "report", "campaign", "--format"],
    &["scenario", "check", "hard", "--profile"],
    &["terrain", "check", "dem.asc", "--crop"],
    &["terrain", "check", "dem.asc", "--slope-limit"],
    &["journal", "draw", "flown", "--at"],
    &["gif", "flown", "--width"],
    &["bag", "replay", "hard.mcap", "--rate"],
    &["bag", "replay", "hard.mcap", "--planner"],
    &["bag", "export", "hard.mcap", "--topic"],
    &["latency", "report", "hard.mcap", "--budget"],
    &["topic", "echo"],
    &["topic", "hz", "state", "--count"],
    &["topic", "list", "--wait"],
    &["known", "plan", "hard", "--w1"],
    &["known", "plan", "hard", "--goal"],
    &["known", "search", "--samples"],
    &["scouting", "--accuracy"],
    &["scouting", "--stages"],
    &["scouting", "large", "--good"],
    &["coverage", "--runs"],
    &["simulate", "--seeds"],
    &["simulate", "--missions"],
    &["chaos", "--role"],
    &["chaos", "--faults"],
    &["endure", "--samples"],
    &["completions"],
];

/// P-FLAGS. Invalid numbers, durations and names.
#[test]
fn a_value_that_is_none_is_refused() {
    let place = Place::new();
    for words in VALUES.iter().filter(|words| is_served(words)) {
        for value in ["", "-1", "NaN", "1e999", "0x10", "99999999999999999999999999", "\u{fffd} x"] {
            // As one word with its flag: a value with a minus is no flag then.
            let (last, flag) = (words.last().unwrap(), format!("{}={value}", words.last().unwrap()));
            let (code, text) = match last.strip_prefix("--") {
                Some(_) => place.checked(&[&words[..words.len() - 1], &[flag.as_str()]].concat(), &[]),
                None => place.checked(words, &[OsStr::new(value)]),
            };
            assert_ne!(code, 0, "{words:?} {value:?}: {text}");
        }
    }
}

/// Commands that print, with what they need.
const PRINTERS: &[&[&str]] = &[
    &["--help"],
    &["--version"],
    &["run", "--help"],
    &["run", "--lockstep", "--seed", "2"],
    &["run", "--lockstep", "--format", "json"],
    &["campaign", "list"],
    &["campaign", "report", "campaign"],
    &["scenario", "list"],
    &["scenario", "schema"],
    &["scenario", "check", "hard"],
    &["scenario", "new", "--dem", "dem.asc"],
    &["terrain", "check", "dem.asc"],
    &["journal", "verify", "flown"],
    &["journal", "show", "flown"],
    &["journal", "show", "flown", "--format", "json"],
    &["bag", "info", "hard.mcap"],
    &["bag", "replay", "hard.mcap"],
    &["bag", "export", "hard.mcap"],
    &["bag", "export", "hard.mcap", "--topic", "hop/state", "--format", "json"],
    &["latency", "report", "hard.mcap"],
    &["known", "plan", "hard"],
    &["doctor", "--instance", "nobody-prints"],
    &["topic", "list", "--instance", "nobody-prints", "--wait", "1ms"],
    &["completions", "bash"],
    &["man"],
];

/// P-PIPE. A reader that has exited, a full disk, a terminal without abilities, an empty
/// environment.
#[test]
fn every_command_prints_to_whatever_is_there() {
    let place = Place::new();
    for words in PRINTERS.iter().filter(|words| is_served(words)) {
        let plain = clear(&place.run(words, &[]), &format!("{words:?}"));
        let (reader, writer) = std::io::pipe().unwrap();
        drop(reader);
        let output = place.command(words, &[]).stdout(writer).output().unwrap();
        assert_eq!(clear(&output, &format!("{words:?}, no reader")), plain, "{}", stderr(&output));

        let full = std::fs::File::options().write(true).open("/dev/full").unwrap();
        let output = place.command(words, &[]).stdout(full).output().unwrap();
        clear(&output, &format!("{words:?}, a full disk"));

        let mut bare = place.command(words, &[]);
        bare.env_clear().env("TERM", "dumb").env("NO_COLOR", "1").env("HOPPER_INSTANCE", "nobody-prints");
        let output = bare.stdin(Stdio::null()).output().unwrap();
        assert_eq!(clear(&output, &format!("{words:?}, bare")), plain, "{}", stderr(&output));
        let printed = [&output.stdout[..], &output.stderr].concat();
        assert!(!printed.contains(&0x1b), "{words:?} is coloured: {}", String::from_utf8_lossy(&printed));
    }
}

/// P-MEANT: A mistyped scenario, scenario file, planner, campaign, profile, role, topic or
/// experiment is answered with the one it resembles, whatever its capitals; a name given without
/// its flag is answered with the flag.
#[test]
fn a_name_that_is_nearly_right_is_answered_with_the_right_one() {
    let place = Place::new();
    std::fs::copy(place.path("flown/scenario.toml"), place.path("mine.toml")).unwrap();
    for (words, meant) in [
        (&["run", "hard"][..], "--scenario hard"),
        (&["run", "hrad"], "--scenario hard"),
        (&["hard"], "--scenario hard"),
        (&["sim", "sandy"], "--scenario sandy"),
        (&["run", "mine.toml"], "--scenario mine.toml"),
        (&["run", "dem.TIF"], "--dem dem.TIF"),
        (&["run", "mdp"], "--planner mdp"),
        (&["planner", "greedy"], "--algorithm greedy"),
        (&["run", "--lockstep", "--scenario", "hrad"], "did you mean hard?"),
        (&["run", "--scenario", "HARD"], "did you mean hard?"),
        (&["scenario", "check", "rover_helicopter"], "did you mean rover-helicopter?"),
        (&["scenario", "check", "mien.toml"], "did you mean mine.toml?"),
        (&["scenario", "check", "mine"], "did you mean mine.toml?"),
        (&["run", "--scenario", "folder"], "need a file, got a folder"),
        (&["run", "--scenario", "."], "need a file, got a folder"),
        (&["run", "--scenario", "flown"], "flown/scenario.toml"),
        (&["scenario", "check", "no/such/file.toml"], "no/such/file.toml: need a scenario file, found none"),
        (&["run", "--planner", "MDP"], "did you mean mdp?"),
        (&["run", "--lockstep", "--planner", "Clairvoyent"], "did you mean clairvoyant?"),
        (&["planner", "--algorithm", "dstar-lite"], "did you mean dstar_lite?"),
        (&["bag", "replay", "hard.mcap", "--planner", "gredy"], "did you mean greedy?"),
        (&["campaign", "run", "p23_tables"], "did you mean p23-tables?"),
        (&["campaign", "run", "d.toml"], "did you mean c.toml?"),
        (&["run", "--profile", "paper2023"], "did you mean paper-2023?"),
        (&["topic", "echo", "heartbeats"], "did you mean heartbeat?"),
        (&["topic", "hz", "hop/stat"], "did you mean hop/state?"),
        (&["bag", "export", "hard.mcap", "--topic", "decision"], "did you mean decisions?"),
        (&["known", "plan", "sand"], "did you mean sandy?"),
        (&["chaos", "--role", "hopper_sim"], "did you mean hopper-sim?"),
    ] {
        let (code, text) = place.checked(words, &[]);
        assert_eq!(code, 2, "{words:?}: {text}");
        assert!(text.contains(meant), "{words:?} does not say {meant:?}: {text}");
        let long = text.lines().filter(|line| line.len() > 300).count();
        assert_eq!(long, 0, "{words:?} is no short sentence: {text}");
    }
}

/// Content and time of every file below `folder`.
fn files(folder: &Path) -> Vec<(PathBuf, Vec<u8>, std::time::SystemTime)> {
    let mut found = Vec::new();
    for entry in std::fs::read_dir(folder).unwrap().map(Result::unwrap) {
        let path = entry.path();
        if path.is_dir() {
            found.extend(files(&path));
        } else {
            let modified = entry.metadata().unwrap().modified().unwrap();
            found.push((path.clone(), std::fs::read(&path).unwrap(), modified));
        }
    }
    found.sort();
    found
}

/// P-ENDED: A run or campaign into a directory that holds it complete flies nothing, prints the
/// summary again, and changes no file.
#[test]
fn a_finished_folder_is_left_as_it_is() {
    let place = Place::new();
    for (folder, words) in [
        ("flown", &["run", "--out", "flown"][..]),
        ("flown", &["run", "--lockstep", "--out", "flown"]),
        ("campaign", &["campaign", "run", "c.toml", "--out", "campaign"]),
        ("campaign", &["campaign", "run", "c.toml", "--out", "campaign", "--resume"]),
    ] {
        let before = files(&place.path(folder));
        let output = place.run(words, &[]);
        assert_eq!(clear(&output, &format!("{words:?}")), 0, "{}", stderr(&output));
        assert!(stderr(&output).contains("already ended, nothing flown"), "{words:?}: {}", stderr(&output));
        assert!(!output.stdout.is_empty(), "{words:?}: the summary is told again");
        assert!(files(&place.path(folder)) == before, "{words:?} has touched a file");
    }
    let rerun = ["campaign", "rerun", "campaign", "--trial", "1", "--out", "again"];
    place.checked(&rerun, &[]);
    let before = files(&place.path("again"));
    let (code, text) = place.checked(&rerun, &[]);
    assert!(code == 0 && text.contains("already ended, nothing flown"), "{text}");
    assert!(files(&place.path("again")) == before);

    let (code, text) = place.checked(&["run", "--out", "flown", "--record", "x.mcap"], &[]);
    assert!(code == 2 && text.contains("--record") && text.contains("already ended"), "{text}");
    let (code, text) = place.checked(&["run", "--lockstep", "--out", "flown", "--seed", "2"], &[]);
    assert!(code == 2 && text.contains("seed needs 2, got 1"), "{text}");
}

/// P-JOURNAL-FIELD: A journal of another mission is refused with the field that differs and both
/// values.
#[test]
fn a_journal_of_another_mission_is_refused_by_the_field_that_differs() {
    let place = Place::new();
    let text = std::fs::read_to_string(place.path("flown/scenario.toml")).unwrap();
    assert!(text.contains("steps_max = 150"));
    std::fs::write(place.path("longer.toml"), text.replace("steps_max = 150", "steps_max = 151")).unwrap();
    for (words, says) in [
        (&["--seed", "2"][..], "seed needs 2, got 1"),
        (&["--profile", "hopper"], "profile needs hopper, got paper-2023"),
        (&["--scenario", "sandy"], "scenario needs sandy, got hard"),
        (&["--scenario", "longer.toml"], "limits.steps_max needs 151, got 150"),
    ] {
        let instance = format!("arguments-{}", std::process::id());
        for command in [
            &["sim", "--instance", &instance, "--journal", "flown/journal"][..],
            &["run", "--lockstep", "--out", "flown"],
        ] {
            let (code, text) = place.checked(&[command, words].concat(), &[]);
            assert_eq!(code, 2, "{text}");
            assert!(text.contains(says), "{command:?} {words:?} does not say {says:?}: {text}");
            assert!(!text.contains("hash"), "{text}");
        }
    }
}
