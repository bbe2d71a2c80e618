//! Who shares a machine: other builds are refused by name, other users can neither read nor inject.

use std::fs::{self, DirBuilder, File};
use std::os::unix::fs::{DirBuilderExt, MetadataExt};
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use crate::harness::{self, Mission, Process, eventually, lockstep, skip, stderr};
use rustix::fs::{FlockOperation, flock};

/// A user that owns nothing.
const NOBODY: &str = "65534";

/// The folder of a live instance as another build keeps it.
struct Foreign {
    root: PathBuf,
    _lock: File,
}

impl Foreign {
    fn new(root: &Path, label: &str) -> Self {
        DirBuilder::new().mode(0o700).create(root).unwrap();
        fs::write(root.join("instance"), label).unwrap();
        let lock = File::create(root.join("presence.lock")).unwrap();
        flock(&lock, FlockOperation::LockShared).unwrap();
        Self { root: root.into(), _lock: lock }
    }
}

impl Drop for Foreign {
    fn drop(&mut self) {
        let _ = fs::remove_dir_all(&self.root);
    }
}

/// What every role, and `hopper run`, says to a foreign instance: exit code 4, and nothing is touched.
fn refusals(mission: &Mission, foreign: &Foreign) -> Vec<String> {
    let commands: [&[&str]; 5] = [
        &["sim", "--journal", "journal"],
        &["perception"],
        &["planner"],
        &["monitor"],
        &["run", "--out", "out"],
    ];
    let told = commands.map(|words| {
        let output = mission.hopper(words).args(["--instance", &mission.name]).output().unwrap();
        assert_eq!(output.status.code(), Some(4), "{words:?}: {}", stderr(&output));
        stderr(&output)
    });
    let mut names: Vec<_> =
        fs::read_dir(&foreign.root).unwrap().map(|entry| entry.unwrap().file_name()).collect();
    names.sort();
    assert_eq!(names, ["instance", "presence.lock"], "{}", foreign.root.display());
    told.into()
}

/// P-BUILD: A process of another version, or with other messages, is refused with exit code 4, and
/// the error names both builds.
#[test]
fn a_process_of_another_build_is_refused_with_both_versions_named() {
    let mut mission = Mission::new("build");
    let root = mission.instance().root().to_path_buf();
    let (name, user) = (mission.name.clone(), rustix::process::getuid().as_raw());
    let own = concat!("version ", env!("CARGO_PKG_VERSION"));
    for (line, shown) in [
        ("version 0.0.9, messages 0badcafe\n".to_owned(), "version 0.0.9, messages 0badcafe"),
        (format!("{own}, messages 0badcafe\n"), "messages 0badcafe"),
        (String::new(), "an older build that does not state its version"),
    ] {
        let foreign = Foreign::new(&root, &format!("{name}\n{user}\n{line}"));
        for told in refusals(&mission, &foreign) {
            let need = format!("instance {name:?} is run by ");
            assert!(told.contains(&need) && told.contains(shown), "{told}");
            assert!(told.contains(&format!("this process is {own}, messages ")), "{told}");
        }
    }
    // What such a build left when it died is removed by whoever comes next.
    let dead = Foreign::new(&root, &format!("{name}\n{user}\nversion 0.0.9, messages 0badcafe\n"));
    flock(&dead._lock, FlockOperation::Unlock).unwrap();
    let output = mission.fly(&["--seed", "61"]);
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    assert_eq!(harness::json(&output)["digest"], lockstep(&["--seed", "61"])["digest"]);
    mission.assert_nothing_left();
}

/// P-ELSEWHERE: A build that keeps the same instance under another prefix is refused, and the error
/// names both directories.
///
/// A build that gives its folders another prefix would wait for us, and we for it, in vain: it is
/// refused with both folders named.
#[test]
fn a_build_that_keeps_the_instance_under_another_prefix_is_refused() {
    let mut mission = Mission::new("elsewhere");
    let (name, user) = (mission.name.clone(), rustix::process::getuid().as_raw());
    let root = mission.instance().root().with_file_name(format!("elsewhere-{}", std::process::id()));
    let foreign = Foreign::new(&root, &format!("{name}\n{user}\nversion 0.0.9, messages 0badcafe\n"));
    for told in refusals(&mission, &foreign) {
        for part in [root.to_str().unwrap(), mission.instance().root().to_str().unwrap(), "version 0.0.9"] {
            assert!(told.contains(part), "{part} in {told}");
        }
    }
    // One who has died, or another instance, keeps nobody out.
    flock(&foreign._lock, FlockOperation::Unlock).unwrap();
    let output = mission.hopper(&["monitor", "--instance", &name, "--wait", "100ms"]).output().unwrap();
    assert!(stderr(&output).contains("waited 100ms for"), "{}", stderr(&output));
    mission.assert_nothing_left();
}

/// Every file below `path`, itself included, folders and sockets too.
fn tree(path: &Path) -> Vec<PathBuf> {
    let mut paths = vec![path.to_path_buf()];
    if path.is_dir() && !path.is_symlink() {
        paths.extend(fs::read_dir(path).unwrap().flatten().flat_map(|entry| tree(&entry.path())));
    }
    paths
}

/// A mission under way, with a policy published, in a process that lets everything be created wide open.
fn open_handed(mission: &Mission) -> Process {
    let script = format!(
        "umask 0; exec \"$HOPPER\" run --instance {} --seed 62 --pace 4 --out out --format json",
        mission.name
    );
    let mut command = Command::new("sh");
    command.args(["-c", &script]).env("HOPPER", env!("CARGO_BIN_EXE_hopper")).current_dir(mission.path(""));
    command.env_remove("HOPPER_INSTANCE").env_remove("HOPPER_CRASH").stdin(std::process::Stdio::null());
    let run = Process::spawn("run", command, &mission.path(""));
    let journal = mission.path("out/journal");
    eventually("a mission under way", || {
        journal.join("hops.journal").exists() && harness::verify(&journal)["decisions"].as_u64() >= Some(2)
    });
    run
}

/// P-PRIVATE: Shared memory, journal and output directory are accessible to their owner only,
/// whatever the umask.
#[test]
fn every_file_of_a_mission_is_its_owners_alone() {
    let mission = Mission::new("private");
    let mut run = open_handed(&mission);
    let owned = |path: &Path| fs::symlink_metadata(path).is_ok_and(|data| data.mode() & 0o077 == 0);
    let traces = mission.instance().paths().unwrap();
    let tops: Vec<PathBuf> = traces.into_iter().chain([mission.path("out")]).collect();
    let mut files = 0;
    for top in &tops {
        assert!(owned(top), "{} is open to others", top.display());
        // Below a closed folder only files matter: its own folders cannot be entered.
        for path in tree(top).iter().filter(|path| path.exists() && !path.is_dir()) {
            assert!(owned(path), "{} is open to others", path.display());
            files += 1;
        }
    }
    assert!(files > 100, "{files} files looked at");
    let tag = mission.instance().root().file_name().unwrap().to_str().unwrap().to_owned();
    let elsewhere = tree(Path::new("/tmp/iceoryx2"));
    assert!(!elsewhere.iter().any(|path| path.to_string_lossy().contains(&tag)), "{elsewhere:?}");
    run.signal(rustix::process::Signal::TERM);
    assert_eq!(run.code(), 130, "{}", run.log());
    for path in tree(&mission.path("out")) {
        assert!(owned(&path), "{} is open to others", path.display());
    }
}

/// Runs `words` as a user that owns nothing; `None` if this user may not.
fn as_nobody(what: &str, words: &[&str]) -> Option<Output> {
    let nobody = |words: &[&str]| {
        let mut command = Command::new("setpriv");
        command.args(["--reuid", NOBODY, "--regid", NOBODY, "--clear-groups"]).args(words);
        command.env_remove("HOPPER_INSTANCE").env("TMPDIR", "/tmp").current_dir("/").output()
    };
    match nobody(&[env!("CARGO_BIN_EXE_hopper"), "--version"]) {
        Ok(probe) if probe.status.success() => Some(nobody(words).unwrap()),
        probe => {
            let why = probe.map_or_else(|error| error.to_string(), |probe| stderr(&probe));
            skip(what, &format!("hopper cannot be run as another user here: {}", why.trim()));
            None
        }
    }
}

/// P-OTHER-USER: Another user cannot read, write, join or remove a mission, and the error names its
/// owner.
#[test]
fn another_user_can_neither_read_nor_inject() {
    let mission = Mission::new("other");
    let mut run = open_handed(&mission);
    let traces = mission.instance().paths().unwrap();
    let paths: Vec<PathBuf> = traces.iter().chain([&mission.path("out")]).flat_map(|top| tree(top)).collect();
    let probe = r#"for path in "$@"; do
        if head -c 1 "$path" >/dev/null 2>&1 || ls "$path/." >/dev/null 2>&1; then echo "reads $path"; fi
        if : 2>/dev/null >> "$path"; then echo "writes $path"; fi
    done"#;
    let mut words = vec!["sh", "-c", probe, "probe"];
    words.extend(paths.iter().map(|path| path.to_str().unwrap()));
    let Some(output) = as_nobody("a second user", &words) else {
        run.signal(rustix::process::Signal::TERM);
        run.code();
        return;
    };
    assert_eq!(String::from_utf8_lossy(&output.stdout), "", "{}", stderr(&output));

    let hopper = |words: &[&str]| {
        let mut command = vec![env!("CARGO_BIN_EXE_hopper")];
        command.extend(words);
        as_nobody("a second user", &command).unwrap()
    };
    let closed = format!("user 0 has an instance {:?} too, closed to user {NOBODY}", mission.name);
    for words in [
        &["topic", "echo", "state", "--instance", &mission.name, "--wait", "200ms"][..],
        &["planner", "--takeover", "--instance", &mission.name, "--wait", "200ms"],
    ] {
        let output = hopper(words);
        assert_eq!(output.status.code(), Some(4), "{}", stderr(&output));
        assert!(stderr(&output).contains(&closed), "{}", stderr(&output));
    }
    // Of all instances there are: that user's own, which are none.
    let output = hopper(&["doctor", "--clean", "--format", "json"]);
    assert_eq!(harness::json(&output)["cleaned"], serde_json::json!([]), "{}", stderr(&output));
    assert!(traces.iter().all(|path| path.exists()));
    run.signal(rustix::process::Signal::TERM);
    assert_eq!(run.code(), 130, "{}", run.log());
    let output = mission.fly(&["--seed", "62"]);
    assert_eq!(harness::json(&output)["digest"], lockstep(&["--seed", "62"])["digest"]);
}

/// P-SQUAT: A directory that another user created in place of ours is refused with both users
/// named, and left untouched.
#[test]
fn a_folder_of_another_user_in_our_place_is_refused_and_left_alone() {
    let mission = Mission::new("squat");
    let root = mission.instance().root().to_path_buf();
    let file = root.join("theirs");
    let script =
        format!("mkdir -m 755 {root} && echo theirs > {file}", root = root.display(), file = file.display());
    let Some(output) = as_nobody("a squatter", &["sh", "-c", &script]) else { return };
    assert!(output.status.success(), "{}", stderr(&output));
    let commands: [(&[&str], i32); 3] =
        [(&["sim", "--journal", "j"], 4), (&["planner"], 4), (&["doctor", "--clean"], 4)];
    for (words, code) in commands {
        let output = mission.hopper(words).args(["--instance", &mission.name]).output().unwrap();
        let told = stderr(&output);
        assert!(
            told.contains(&format!("needs to be a folder of user 0, got one of user {NOBODY}")),
            "{told}"
        );
        assert_eq!(output.status.code(), Some(code), "{told}");
    }
    assert_eq!(fs::read_to_string(&file).unwrap(), "theirs\n");
    fs::remove_dir_all(&root).unwrap();
}
