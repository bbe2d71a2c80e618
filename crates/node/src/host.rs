//! What the machine is, for records of how results came about.

use std::fs;

/// The processor's model name; its architecture where the kernel does not tell.
#[must_use]
pub fn processor() -> String {
    let text = fs::read_to_string("/proc/cpuinfo").unwrap_or_default();
    let model = text.lines().find_map(|line| line.strip_prefix("model name")?.split_once(':'));
    model.map_or_else(|| std::env::consts::ARCH.to_owned(), |(_, name)| name.trim().to_owned())
}

/// Kernel name, release and architecture.
#[must_use]
pub fn operating_system() -> String {
    let read = |path| fs::read_to_string(path).ok().map(|text| text.trim().to_owned());
    let kernel = read("/proc/sys/kernel/ostype").unwrap_or_else(|| std::env::consts::OS.to_owned());
    let release = read("/proc/sys/kernel/osrelease").unwrap_or_default();
    format!("{kernel} {release} {}", std::env::consts::ARCH)
}

/// The memory of a process.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Memory {
    /// Resident and nobody else's: heap and stacks, bytes.
    pub own_bytes: u64,
    /// All that is resident, files and shared memory included, bytes.
    pub resident_bytes: u64,
}

/// The memory of a process; `None` if there is no such process.
#[must_use]
pub fn memory(pid: u32) -> Option<Memory> {
    let text = fs::read_to_string(format!("/proc/{pid}/status")).ok()?;
    let field = |name: &str| -> Option<u64> {
        let line = text.lines().find_map(|line| line.strip_prefix(name)?.strip_prefix(':'))?;
        Some(line.trim().strip_suffix("kB")?.trim().parse::<u64>().ok()? * 1024)
    };
    Some(Memory { own_bytes: field("RssAnon")?, resident_bytes: field("VmRSS")? })
}

/// Whether the operating system knows a process of this number; one that nobody has buried yet counts.
#[must_use]
pub fn process_exists(pid: u32) -> bool {
    let pid = i32::try_from(pid).ok().and_then(rustix::process::Pid::from_raw);
    pid.is_some_and(|pid| rustix::process::test_kill_process(pid) != Err(rustix::io::Errno::SRCH))
}
