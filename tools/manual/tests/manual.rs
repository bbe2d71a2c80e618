//! What the command line says about itself: help, completions, manual pages.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

use std::process::Command;

use hopper_manual::hopper_command;

fn manual(words: &[&str]) -> String {
    let output = Command::new(env!("CARGO_BIN_EXE_hopper-manual")).args(words).output().unwrap();
    let errors = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(0), "{words:?}: {errors}");
    String::from_utf8(output.stdout).unwrap()
}

/// Every command of `hopper`.
fn commands() -> Vec<String> {
    let names: Vec<String> =
        hopper_command().get_subcommands().map(|command| command.get_name().to_owned()).collect();
    assert!(names.len() > 10, "{names:?}");
    names
}

/// P-HELP: Every command's `--help` ends with examples.
#[test]
fn every_command_is_helped_with_examples() {
    fn check(command: &mut clap::Command, path: &str) {
        let help = command.render_long_help().to_string();
        let examples = help.split("Examples:\n").nth(1).unwrap_or_else(|| panic!("{path} has no examples"));
        assert!(examples.contains(path), "{path}: {examples}");
        // `help` of a command with commands below it is clap's own.
        for below in command.get_subcommands_mut().filter(|below| below.get_name() != "help") {
            let path = format!("{path} {}", below.get_name());
            check(below, &path);
        }
    }
    check(&mut hopper_command(), "hopper");
}

#[test]
fn every_command_of_a_tool_is_listed_with_its_program() {
    for (program, served) in hopper::tool::TOOLS {
        for name in served {
            let command = hopper_command();
            let about = command.find_subcommand(name).and_then(clap::Command::get_about).unwrap().to_string();
            assert!(about.starts_with(&format!("[{program}] ")), "{name}: {about}");
        }
    }
}

/// P-MANUAL: The completions of five shells and the manual pages know every command.
#[test]
fn completions_and_manual_pages_know_every_command() {
    let page = manual(&["man"]);
    let dir = tempfile::tempdir().unwrap();
    manual(&["man", "--out", &dir.path().to_string_lossy()]);
    /// What a shell's completions say of a command.
    type Form = fn(&str) -> String;
    let forms: [(&str, Form); 5] = [
        ("bash", |command| format!("hopper,{command})\n")),
        ("zsh", |command| format!("\n'{command}:")),
        ("fish", |command| format!("-n \"__fish_hopper_needs_command\" -f -a \"{command}\" ")),
        ("elvish", |command| format!("&'hopper;{command}'= {{")),
        ("powershell", |command| format!("'hopper;{command}' {{")),
    ];
    for (shell, form) in forms {
        let text = manual(&["completions", shell]);
        for command in commands() {
            assert!(text.contains(&form(&command)), "{shell} does not know {command}");
        }
        assert!(!text.contains(&form("no-such")), "{shell} knows anything");
    }
    for command in commands() {
        // A hyphen of a manual page is written as \-.
        assert!(page.contains(&format!("\nhopper\\-{command}(1)\n")), "the manual does not know {command}");
        let own = std::fs::read_to_string(dir.path().join(format!("hopper-{command}.1"))).unwrap();
        assert!(own.contains(&format!("\n.TH hopper-{command} 1")), "{command}: {own}");
    }
}

/// P-COMPLETE: Shells complete the names of scenarios, planners, campaigns and topics, and files
/// where those are allowed too.
#[test]
fn shells_offer_the_names_that_arguments_know() {
    let bash = manual(&["completions", "bash"]);
    let scenarios = scenario::BUILT_IN.map(|(name, _)| name).join(" ");
    let planners = planner::ALGORITHMS.join(" ");
    assert!(bash.contains(&format!("compgen -f -W \"{scenarios}\"")), "scenarios");
    for (what, names) in [("planners", planners), ("topics", "state".to_owned())] {
        let offered = |line: &str| line.contains("-W \"") && line.contains(&names);
        assert!(bash.lines().any(offered), "{what}: {names}");
    }
    let fish = manual(&["completions", "fish"]);
    assert!(fish.contains(" -r -F -a \"hard\\t") && !fish.contains(" -r -f -a \"hard\\t"));
    let zsh = manual(&["completions", "zsh"]);
    assert!(zsh.contains(&format!(":{{_files; compadd {scenarios}}}")));
    assert!(zsh.contains("{_files; compadd p23-tables "), "campaigns");
    // The script is one that bash runs, and it completes.
    let dir = tempfile::tempdir().unwrap();
    let script = dir.path().join("hopper.bash");
    std::fs::write(&script, &bash).unwrap();
    let ask = "source $0; COMP_WORDS=(hopper run --scenario sa); COMP_CWORD=3; _hopper hopper sa --scenario; \
               echo ${COMPREPLY[@]}";
    let output =
        Command::new("bash").args(["-c", ask]).arg(&script).current_dir(dir.path()).output().unwrap();
    assert_eq!(String::from_utf8_lossy(&output.stdout).trim(), "sandy", "{output:?}");
}
