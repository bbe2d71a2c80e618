//! Memory, disk and readers run out: refused at the start with the sizes, or held, never a death in mid-run.

use std::fs::{File, FileType};
use std::os::unix::fs::MetadataExt;
use std::process::{Command, Output};

use crate::harness::{self, Mission, Process, eventually, hopper, json, lockstep, skip, stderr};
use rustix::process::{Pid, Resource, Rlimit, Signal, getrlimit, prlimit};
use serde_json::Value;

/// Runs `script` in a mount namespace of its own, where shared memory has `size`; `None` if this user may not.
fn in_small_memory(mission: &Mission, size: &str, script: &str) -> Option<Output> {
    let own = |script: &str| {
        let mut command = Command::new("unshare");
        command.args(["--map-root-user", "--mount", "sh", "-c", script]).current_dir(mission.path(""));
        command.env("HOPPER", env!("CARGO_BIN_EXE_hopper")).env_remove("HOPPER_INSTANCE");
        command.output()
    };
    let mount = format!("mount -t tmpfs -o size={size} tmpfs /dev/shm");
    match own(&mount) {
        Ok(probe) if probe.status.success() => Some(own(&format!("{mount} && {script}")).unwrap()),
        other => {
            let why = other.map_or_else(|error| error.to_string(), |probe| stderr(&probe));
            skip("a small /dev/shm", &format!("no mount namespace: {}", why.trim()));
            None
        }
    }
}

/// P-ROOM-SMALL: If shared memory is too small, a process is refused at the start, with the sizes
/// needed and available.
#[test]
fn shared_memory_that_is_too_small_is_refused_at_the_start_with_the_sizes() {
    let mission = Mission::new("small");
    let fly = "$HOPPER run --seed 51 --format json --out . ; code=$?; ls -A /dev/shm >&2; exit $code";
    // Too small to join, for a service, for the whole mission.
    for size in ["64k", "3m", "7m", "16m"] {
        let Some(output) = in_small_memory(&mission, size, fly) else { return };
        let told = stderr(&output);
        assert_eq!(output.status.code(), Some(1), "{size}: {told}");
        assert!(told.contains("bytes of shared memory, got "), "{size}: {told}");
        assert!(!told.contains("signal") && !told.contains("hop_"), "{size}: {told}");
    }
    let output = in_small_memory(&mission, "40m", fly).unwrap();
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    assert_eq!(json(&output)["digest"], lockstep(&["--seed", "51"])["digest"]);
}

/// P-ROOM-FILLED: If shared memory fills up during a mission, no running process is killed or
/// disturbed; processes that want to join are refused with the sizes.
#[test]
fn shared_memory_that_is_filled_in_mid_run_disturbs_nobody() {
    let mission = Mission::new("backed");
    let slow = mission.start_slow_sim("52");
    let mut peers = mission.start_peers();
    mission.await_decisions(1);
    eventually("all pages to be there", || {
        let files = mission.instance().paths().unwrap();
        let data = files.iter().filter_map(|path| std::fs::metadata(path).ok());
        data.filter(|data| FileType::is_file(&data.file_type())).all(|data| data.blocks() * 512 >= data.len())
    });
    mission.hurry(slow, "52");
    peers.iter_mut().for_each(|peer| assert_eq!(peer.code(), 0, "{}", peer.log()));

    let filled = Mission::new("filled");
    let script = "
        $HOPPER run --instance full --seed 53 --pace 10 --out . --format json &
        run=$!
        while kill -0 $run && [ ! -s journal/hops.journal ]; do sleep 0.02; done
        begun=$(stat -c %s journal/hops.journal)
        while kill -0 $run && [ $(stat -c %s journal/hops.journal) -lt $((begun + 1500)) ]; do sleep 0.02; done
        dd if=/dev/zero of=/dev/shm/filler bs=64k 2>/dev/null
        timeout 20 $HOPPER planner --instance full --wait 5s; echo planner $? >&2
        $HOPPER doctor --instance full >&2
        wait $run; code=$?
        rm /dev/shm/filler; ls -A /dev/shm >&2; exit $code";
    let Some(output) = in_small_memory(&filled, "40m", script) else { return };
    let told = stderr(&output);
    assert_eq!(output.status.code(), Some(0), "{told}");
    let summary = json(&output);
    assert_eq!(summary["digest"], lockstep(&["--seed", "53"])["digest"]);
    for process in summary["processes"].as_array().unwrap() {
        assert_eq!(process["restarts"], 0, "{told}");
    }
    let refused = "planner: joining as planner needs 1048576 bytes of shared memory, got ";
    assert!(told.contains(refused) && told.contains("planner 1\n"), "{told}");
    assert!(told.contains("→ nobody can join: "), "{told}");
    assert!(!told.contains("hop_"), "{told}");
}

/// P-DISK-FULL: On a full disk hopper-sim holds before a hop that it cannot write down, and
/// continues when there is space.
#[test]
fn on_a_full_disk_the_hopper_holds_until_there_is_space_again() {
    let mission = Mission::new("disk");
    let mut sim = mission.start("sim", &["--seed", "54", "--pace", "20"]);
    let mut peers = mission.start_peers();
    mission.await_decisions(3);
    // The limit cuts a record in two.
    let bytes = std::fs::metadata(mission.journal().join("hops.journal")).unwrap().len() + 100;
    let (pid, maximum) = (Pid::from_raw(sim.pid() as i32), getrlimit(Resource::Fsize).maximum);
    let limit = |current| {
        prlimit(pid, Resource::Fsize, Rlimit { current, maximum }).unwrap();
    };
    limit(Some(bytes));
    sim.await_log("holding at decision");
    let held = mission.decisions();
    // Twice the state is told again, and it is that of the journal: nothing was published ahead of it.
    let echo = ["topic", "echo", "state", "--instance", &mission.name, "--count", "3", "--format", "json"];
    let output = hopper(&echo).output().unwrap();
    for line in String::from_utf8_lossy(&output.stdout).lines() {
        assert_eq!(serde_json::from_str::<Value>(line).unwrap()["decision"], held, "{line}");
    }
    assert_eq!(mission.decisions(), held);
    assert!(
        sim.has_ended().is_none() && sim.log().matches("holding at decision").count() == 1,
        "{}",
        sim.log()
    );
    limit(maximum);
    sim.await_log("going on");
    assert_eq!(sim.code(), 0, "{}", sim.log());
    assert_eq!(sim.json()["digest"], lockstep(&["--seed", "54"])["digest"]);
    let verified = mission.verified();
    assert_eq!((&verified["contiguous"], &verified["torn_bytes"]), (&true.into(), &0.into()), "{verified}");
    peers.iter_mut().for_each(|peer| assert_eq!(peer.code(), 0, "{}", peer.log()));
}

/// P-FULL-LOG: A process does not end because its log lines cannot be written.
#[test]
fn a_full_disk_under_the_log_ends_nobody() {
    let mission = Mission::new("mute");
    let words = ["run", "--instance", &mission.name, "--seed", "55", "--out", ".", "--format", "json"];
    let mut command = mission.hopper(&words);
    let full = std::fs::OpenOptions::new().write(true).open("/dev/full").unwrap();
    let output = command.env("HOPPER_LOG", "debug").stderr(full).output().unwrap();
    assert_eq!(output.status.code(), Some(0));
    let summary = json(&output);
    assert_eq!(summary["digest"], lockstep(&["--seed", "55"])["digest"]);
    assert!(
        summary["processes"].as_array().unwrap().iter().all(|process| process["restarts"] == 0),
        "{summary}"
    );
}

/// P-FULL-END: Files that cannot be written at the end of a mission, as on a full disk, hide
/// neither its summary nor the reason why it stopped.
#[test]
fn files_that_cannot_be_written_at_the_end_hide_neither_summary_nor_reason() {
    let mission = Mission::new("full-end");
    let start = |pace: &str, seed: &str| {
        let out = format!("out-{seed}");
        let words = ["run", "--instance", &mission.name, "--seed", seed, "--out", &out, "--format", "json"];
        let mut command = mission.hopper(&words);
        command.args(["--pace", pace]);
        let run = Process::spawn("run", command, &mission.path(""));
        eventually("the mission to be under way", || {
            let journal = format!("{out}/journal");
            let output =
                mission.hopper(&["journal", "verify", &journal, "--format", "json"]).output().unwrap();
            let told: Value = serde_json::from_slice(&output.stdout).unwrap_or_default();
            told["decisions"].as_u64().is_some_and(|count| count > 1)
        });
        // Found at the end only; the files before it and behind it are written.
        std::fs::create_dir(mission.path(&out).join("mission.svg")).unwrap();
        run
    };
    let mut whole = start("20", "61");
    // A folder in its place is bad input; a full disk would be a run error.
    assert_eq!(whole.code(), 2, "{}", whole.log());
    assert_eq!(whole.json()["digest"], lockstep(&["--seed", "61"])["digest"], "{}", whole.log());
    assert!(whole.log().contains("mission.svg"), "{}", whole.log());
    let kept: Value =
        serde_json::from_slice(&std::fs::read(mission.path("out-61/summary.json")).unwrap()).unwrap();
    assert_eq!(kept["digest"], whole.json()["digest"]);

    let mut stopped = start("2", "62");
    stopped.signal(Signal::TERM);
    assert_eq!(stopped.code(), 130, "{}", stopped.log());
    assert_eq!(stopped.json()["outcome"], "stopped");
    let log = stopped.log();
    assert!(log.contains("resumes the mission") && log.contains("mission.svg"), "{log}");
}

/// P-BAG-FULL: On a full disk a recovery leaves nothing behind, and is a run error.
#[test]
fn on_a_full_disk_nothing_is_left_of_a_recording_that_cannot_be_recovered() {
    let mission = Mission::new("fullbag");
    harness::program("hopper-recordings");
    let recording = hostile::recording::seeds().remove(0);
    std::fs::write(mission.path("cut.mcap"), &recording[..recording.len() - 100]).unwrap();
    let script = "
        $HOPPER bag recover cut.mcap /dev/shm/whole.mcap; echo full $? >&2
        ls -A /dev/shm
        $HOPPER bag recover cut.mcap /dev/shm/none/whole.mcap; echo nowhere $? >&2
        mount -o remount,size=16m /dev/shm
        $HOPPER bag recover cut.mcap /dev/shm/whole.mcap && $HOPPER bag info /dev/shm/whole.mcap >/dev/null";
    let Some(output) = in_small_memory(&mission, "16k", script) else { return };
    let told = stderr(&output);
    assert_eq!(output.status.code(), Some(0), "{told}");
    assert!(told.contains("full 1\n") && told.contains("nowhere 2\n"), "{told}");
    assert!(told.contains("/dev/shm/whole.mcap cannot be written: No space left"), "{told}");
    assert!(output.stdout.is_empty(), "left behind: {}", String::from_utf8_lossy(&output.stdout));
}

/// P-DEAF: A monitor that stops reading slows no other process, and receives every decision once it
/// reads again.
#[test]
fn a_monitor_that_stops_reading_slows_nobody() {
    let mission = Mission::new("deaf");
    // So long that it is still flown when the monitor reads again.
    let (_, patrol) = scenario::BUILT_IN.into_iter().find(|(name, _)| *name == "patrol").unwrap();
    let text = patrol.replace("hops_max = 1000000", "hops_max = 2000");
    std::fs::write(mission.path("patrol.toml"), text).unwrap();
    let terms = ["--seed", "2", "--scenario", "patrol.toml"];
    let mut sim = mission.start("sim", &[&terms[..], &["--pace", "500", "--linger", "100s"]].concat());
    let mut perception = mission.start("perception", &[]);
    let mut monitor = mission.start("monitor", &["--format", "json"]);
    monitor.await_log("hop 0");
    monitor.signal(Signal::STOP);
    let mut planner = mission.start("planner", &[]);
    // More states than its queue holds.
    mission.await_decisions(<contract::State as contract::Message>::SERVICE.buffer as u64 + 1);
    assert!(is_stopped(&monitor), "the monitor had no part in it");
    assert_eq!(mission.verified()["outcome"], "underway");
    monitor.signal(Signal::CONT);
    for process in [&mut sim, &mut perception, &mut planner, &mut monitor] {
        assert_eq!(process.code(), 0, "{}", process.log());
        for lost in ["may not have reached", "no free slot"] {
            assert!(!process.log().contains(lost), "{}", process.log());
        }
    }
    let verified = mission.verified();
    let undisturbed =
        lockstep(&["--seed", "2", "--scenario", &mission.path("patrol.toml").to_string_lossy()]);
    assert_eq!(sim.json()["digest"], undisturbed["digest"]);
    let seen = monitor.json();
    assert_eq!((&seen["missing"], &seen["decision"]), (&0.into(), &verified["decisions"]), "{seen}");
    assert_eq!(seen["latency"]["decisions"], verified["decisions"], "{seen}");
}

fn is_stopped(process: &Process) -> bool {
    let mut text = String::new();
    std::io::Read::read_to_string(
        &mut File::open(format!("/proc/{}/stat", process.pid())).unwrap(),
        &mut text,
    )
    .unwrap();
    text.rsplit(')').next().unwrap().trim().starts_with('T')
}
