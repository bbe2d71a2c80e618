//! Who holds a lock on a file.

use std::fmt;
use std::fs::{self, File};
use std::os::unix::fs::MetadataExt as _;

/// A process that holds a lock which others wait for.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct LockHolder {
    /// Number of the process.
    pub pid: u32,
    /// Its command line, words separated by blanks.
    pub command: String,
    /// Whether it is stopped, by Ctrl-Z or SIGSTOP.
    pub is_stopped: bool,
}

impl LockHolder {
    /// The process that alone holds an `flock` on this file, as the kernel lists it; `None` if none does, or it cannot be seen from
    /// here, as one of another container.
    pub(crate) fn of(file: &File) -> Option<Self> {
        let file = file.metadata().ok()?;
        let locks = fs::read_to_string("/proc/locks").ok()?;
        let mut holders = locks.lines().filter_map(|line| holder(line, file.ino()));
        let pid = holders.find(|pid| has_open(*pid, &file))?;
        let words = fs::read(format!("/proc/{pid}/cmdline")).ok()?;
        let words: Vec<_> = words.split(|byte| *byte == 0).map(String::from_utf8_lossy).collect();
        Some(Self { pid, command: words.join(" ").trim_end().to_owned(), is_stopped: is_stopped(pid) })
    }
}

impl fmt::Display for LockHolder {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { pid, command, is_stopped } = self;
        write!(f, "process {pid} ({command})")?;
        match is_stopped {
            true => write!(f, ", which is stopped: continue it with `kill -CONT {pid}`, or end it"),
            false => Ok(()),
        }
    }
}

/// The process of a line of /proc/locks, if that tells of an exclusive lock on a file with that number. Files of other devices may have
/// it too, and some file systems list another device than that of their files.
fn holder(line: &str, inode: u64) -> Option<u32> {
    // 1: FLOCK  ADVISORY  WRITE 1234 00:1a:5678 0 EOF; who waits has an arrow behind the number.
    let mut words = line.split_whitespace().skip(1);
    let (kind, _advisory, mode) = (words.next()?, words.next()?, words.next()?);
    let (pid, file) = (words.next()?, words.next()?);
    let is_it = (kind, mode) == ("FLOCK", "WRITE") && file.rsplit(':').next()?.parse() == Ok(inode);
    if is_it { pid.parse().ok() } else { None }
}

/// Whether the process has that very file open.
fn has_open(pid: u32, file: &fs::Metadata) -> bool {
    let open = fs::read_dir(format!("/proc/{pid}/fd")).into_iter().flatten().flatten();
    open.filter_map(|link| fs::metadata(link.path()).ok())
        .any(|open| (open.dev(), open.ino()) == (file.dev(), file.ino()))
}

/// Whether the kernel shows the process as stopped.
fn is_stopped(pid: u32) -> bool {
    let stat = fs::read_to_string(format!("/proc/{pid}/stat")).unwrap_or_default();
    // The name of the program, in parentheses, may hold anything.
    stat.rsplit_once(')').is_some_and(|(_, rest)| rest.trim_start().starts_with(['T', 't']))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_line_of_the_kernel_names_the_holder_of_a_lock_and_nobody_who_waits_for_it() {
        let held = "1: FLOCK  ADVISORY  WRITE 4242 00:1a:777 0 EOF";
        assert_eq!(holder(held, 777), Some(4242));
        assert_eq!(holder(held, 77), None);
        for other in [
            "1: -> FLOCK  ADVISORY  WRITE 4243 00:1a:777 0 EOF",
            "1: FLOCK  ADVISORY  READ 4243 00:1a:777 0 EOF",
            "2: POSIX  ADVISORY  WRITE 4242 00:1a:777 0 EOF",
            "2: FLOCK",
            "",
        ] {
            assert_eq!(holder(other, 777), None, "{other}");
        }
    }

    #[test]
    fn a_holder_has_the_file_open_and_not_another_of_the_same_number() {
        let path = std::env::temp_dir().join(format!("hopper-lock-holder-{}", std::process::id()));
        let file = File::create(&path).unwrap();
        fs::remove_file(path).unwrap();
        let open = file.metadata().unwrap();
        assert!(has_open(std::process::id(), &open));
        drop(file);
        assert!(!has_open(std::process::id(), &open));
    }
}
