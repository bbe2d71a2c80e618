//! Other users put files, folders and links where a mission writes: they are refused by path and owner.

use std::collections::BTreeSet;
use std::fs;
use std::os::unix::fs::{PermissionsExt, chown, symlink};
use std::path::{Path, PathBuf};

use crate::harness::{Mission, json, lockstep, skip, stderr};

/// A user that owns nothing.
const NOBODY: u32 = 65534;

/// Gives `path` to another user; false if this user may not.
fn give(path: &Path) -> bool {
    match chown(path, Some(NOBODY), Some(NOBODY)) {
        Ok(()) => true,
        Err(error) => {
            skip("files of another user", &error.to_string());
            false
        }
    }
}

/// Files of an instance beside its folder, by what follows its tag.
fn endings(mission: &Mission) -> BTreeSet<String> {
    let tag = mission.instance().root().file_name().unwrap().to_str().unwrap().to_owned();
    let files = mission.instance().files();
    let names = files.iter().map(|(path, _)| path.file_name().unwrap().to_str().unwrap());
    names.map(|name| name.strip_prefix(&tag).unwrap().to_owned()).collect()
}

/// The path of a file of the instance that ends in `ending`.
fn path_of(mission: &Mission, ending: &str) -> PathBuf {
    let tag = mission.instance().root().file_name().unwrap().to_str().unwrap().to_owned();
    mission.instance().root().with_file_name(format!("{tag}{ending}"))
}

/// P-FOREIGN-SHM: No process uses a file in shared memory that bears an instance's name and belongs
/// to another user, or is a symbolic link. Every process and `doctor` name its path and owner, and
/// `doctor --clean` removes it where that is allowed.
#[test]
fn a_file_of_another_user_in_shared_memory_is_refused_told_and_cleaned() {
    // The names that can be foretold are those that two instances share.
    let both = [Mission::new("foretold"), Mission::new("foretold")];
    let names = both.each_ref().map(|mission| {
        let sim = mission.start("sim", &[]);
        sim.await_log("joined");
        endings(mission)
    });
    let foretold: Vec<&String> = names[0].intersection(&names[1]).collect();
    assert!(!foretold.is_empty(), "{names:?}");
    drop(both);

    let mut mission = Mission::new("foreign");
    let name = mission.name.clone();
    let doctor =
        |words: &[&str]| mission.hopper(&["doctor", "--instance", &name]).args(words).output().unwrap();
    for (ending, is_link) in foretold.iter().flat_map(|ending| [(ending, false), (ending, true)]) {
        let path = path_of(&mission, ending);
        let precious = mission.path("precious");
        fs::write(&precious, [0; 16]).unwrap();
        if is_link {
            symlink(&precious, &path).unwrap();
        } else {
            fs::write(&path, [0; 16]).unwrap();
            fs::set_permissions(&path, fs::Permissions::from_mode(0o666)).unwrap();
            if !give(&path) {
                fs::remove_file(&path).unwrap();
                return;
            }
        }
        let what =
            if is_link { "a symbolic link of user 0".into() } else { format!("a file of user {NOBODY}") };
        let told = format!("{}, {what},", path.display());
        for words in [&["sim", "--journal", "j"][..], &["planner"], &["run", "--out", "out"]] {
            let output = mission.hopper(words).args(["--instance", &name]).output().unwrap();
            assert_eq!(output.status.code(), Some(4), "{words:?}: {}", stderr(&output));
            assert!(stderr(&output).contains(&told), "{words:?}: {}", stderr(&output));
            assert!(path.symlink_metadata().is_ok(), "{words:?} has removed it");
        }
        let output = doctor(&[]);
        let text = String::from_utf8_lossy(&output.stdout).into_owned();
        assert!(output.status.success() && text.contains(&told), "{text}{}", stderr(&output));
        let output = doctor(&["--clean"]);
        let text = String::from_utf8_lossy(&output.stdout).into_owned();
        assert!(text.contains(&format!("removed {told}")), "{text}{}", stderr(&output));
        assert!(path.symlink_metadata().is_err() && fs::read(&precious).unwrap() == [0; 16]);
    }
    let output =
        mission.hopper(&["run", "--instance", &name, "--out", "fly", "--seed", "81", "--format", "json"]);
    let output = { output }.output().unwrap();
    assert_eq!(json(&output)["digest"], lockstep(&["--seed", "81"])["digest"]);
    mission.assert_nothing_left();
}

/// P-NO-LINK.
/// P-FOREIGN-OWNER. Here an output directory and a journal of another user, and links in place of
/// files to write.
#[test]
fn output_folders_of_others_and_links_in_them_are_refused_before_anything_is_written() {
    let mission = Mission::new("theirs");
    let refused = |out: &str, told: &str| {
        let output = mission.hopper(&["run", "--lockstep", "--out", out]).output().unwrap();
        assert_eq!(output.status.code(), Some(2), "{}", stderr(&output));
        assert!(stderr(&output).contains(told), "{told} in {}", stderr(&output));
        assert!(output.stdout.is_empty());
    };
    let precious = mission.path("precious");
    fs::write(&precious, "theirs").unwrap();
    for name in ["scenario.toml", "provenance.json", "timing.csv", "mission.svg", "summary.json"] {
        let out = mission.path(name);
        fs::create_dir(&out).unwrap();
        symlink(&precious, out.join(name)).unwrap();
        refused(name, &format!("{name}/{name} needs to be a file, got a symbolic link of user"));
        assert_eq!(fs::read_dir(&out).unwrap().count(), 1);
    }
    assert_eq!(fs::read_to_string(&precious).unwrap(), "theirs");

    let out = mission.path("out");
    fs::create_dir(&out).unwrap();
    if !give(&out) {
        return;
    }
    let told = |path: &str| format!("{path} belongs to user {NOBODY}, and this process is user 0");
    refused("out", &told("out"));
    assert_eq!(fs::read_dir(&out).unwrap().count(), 0);
    chown(&out, Some(0), Some(0)).unwrap();
    fs::create_dir(out.join("journal")).unwrap();
    give(&out.join("journal"));
    refused("out", &told("out/journal"));
    assert_eq!(fs::read_dir(out.join("journal")).unwrap().count(), 0);
    let mut sim = mission.start("sim", &["--journal", "out/journal"]);
    assert_eq!(sim.code(), 2, "{}", sim.log());
    assert!(sim.log().contains(&told("out/journal")), "{}", sim.log());
}
