//! Facts about the machine, to be recorded beside results.

use std::fs;

use contract::MonotonicNs;

/// The processor's model name, or its architecture where the kernel does not say.
#[must_use]
pub fn processor() -> String {
    let text = fs::read_to_string("/proc/cpuinfo").unwrap_or_default();
    let model = text.lines().find_map(|line| line.strip_prefix("model name")?.split_once(':'));
    model.map_or_else(|| std::env::consts::ARCH.to_owned(), |(_, name)| name.trim().to_owned())
}

/// How many cores this process may use.
#[must_use]
pub fn cores() -> u32 {
    std::thread::available_parallelism().map_or(1, |cores| cores.get() as u32)
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

/// When a process was started, on CLOCK_MONOTONIC, to a hundredth of a second; `None` if there is no such process.
#[must_use]
pub fn started(pid: u32) -> Option<MonotonicNs> {
    let text = fs::read_to_string(format!("/proc/{pid}/stat")).ok()?;
    // The name, in parentheses, may contain anything; the start is the 20th field after it.
    let (_, fields) = text.rsplit_once(')')?;
    let ticks: u64 = fields.split_whitespace().nth(19)?.parse().ok()?;
    let since_boot_ns = ticks.checked_mul(1_000_000_000 / rustix::param::clock_ticks_per_second().max(1))?;
    // The kernel counts the time during which the machine slept, too.
    let uptime = rustix::time::clock_gettime(rustix::time::ClockId::Boottime);
    let uptime_ns = uptime.tv_sec as u64 * 1_000_000_000 + uptime.tv_nsec as u64;
    let age_ns = uptime_ns.saturating_sub(since_boot_ns);
    Some(MonotonicNs(crate::clock::now().0.saturating_sub(age_ns)))
}

/// Work of all cores since the machine started.
#[derive(Clone, Copy, Debug, PartialEq, Default)]
pub struct Load {
    /// Work of all cores, in the kernel's ticks.
    pub busy_ticks: u64,
    /// Work and idleness of all cores, in the kernel's ticks.
    pub ticks: u64,
    /// Load average over a minute.
    pub load_1min: f64,
}

impl Load {
    /// Share of all cores that was busy from `earlier` to here, 0 to 1.
    #[must_use]
    pub fn busy_since(&self, earlier: &Load) -> f64 {
        let ticks = self.ticks.saturating_sub(earlier.ticks);
        let busy = self.busy_ticks.saturating_sub(earlier.busy_ticks);
        if ticks == 0 { 0.0 } else { (busy as f64 / ticks as f64).clamp(0.0, 1.0) }
    }
}

/// The load of the machine at present; zeros where the kernel does not say.
#[must_use]
pub fn load() -> Load {
    let read = |path| fs::read_to_string(path).unwrap_or_default();
    let (stat, average) = (read("/proc/stat"), read("/proc/loadavg"));
    // user nice system idle iowait irq softirq steal; guests count as user already.
    let fields = stat.lines().next().unwrap_or_default().split_whitespace().skip(1).take(8);
    let ticks: Vec<u64> = fields.filter_map(|field| field.parse().ok()).collect();
    let idle: u64 = ticks.iter().skip(3).take(2).sum();
    let all: u64 = ticks.iter().sum();
    let load_1min = average.split_whitespace().next().and_then(|text| text.parse().ok()).unwrap_or(0.0);
    Load { busy_ticks: all - idle, ticks: all, load_1min }
}

/// Seconds since 1970 on the host's clock, for provenance only.
#[must_use]
pub fn unix_time_s() -> f64 {
    let since = std::time::SystemTime::now().duration_since(std::time::UNIX_EPOCH);
    since.map_or(0.0, |since| since.as_secs_f64())
}

/// Whether the operating system knows a process of this number; one that has ended and is not yet waited for counts.
#[must_use]
pub fn process_exists(pid: u32) -> bool {
    let pid = i32::try_from(pid).ok().and_then(rustix::process::Pid::from_raw);
    pid.is_some_and(|pid| rustix::process::test_kill_process(pid) != Err(rustix::io::Errno::SRCH))
}
