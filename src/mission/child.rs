//! A supervised child process: its start, its restarts, and its end.

use std::collections::VecDeque;
use std::io::Read;
use std::path::{Path, PathBuf};
use std::process::{Child, ChildStdin, ChildStdout, Command, ExitStatus, Stdio};
use std::thread::JoinHandle;

use contract::{MonotonicNs, Role};
use node::{Failure, Node};

/// Restarts of a child within [`RESTART_WINDOW_NS`] before its supervisor gives it up.
pub const RESTARTS_MAX: usize = 5;

/// How long a restart counts, nanoseconds: what dies now and then is restarted for ever, what dies in a loop is given
/// up.
pub const RESTART_WINDOW_NS: u64 = 120_000_000_000;

/// The restarts of a child that count against it.
#[derive(Clone, Debug, Default)]
struct Restarts {
    /// The last ones, the oldest first.
    recent: VecDeque<MonotonicNs>,
}

impl Restarts {
    /// Whether another restart at `now` would not be one too many.
    fn allow(&mut self, now: MonotonicNs) -> bool {
        while self.recent.front().is_some_and(|at| now.since_ns(*at) > RESTART_WINDOW_NS) {
            self.recent.pop_front();
        }
        self.recent.len() < RESTARTS_MAX
    }

    fn note(&mut self, now: MonotonicNs) {
        self.recent.push_back(now);
        if self.recent.len() > RESTARTS_MAX {
            self.recent.pop_front();
        }
    }
}

/// A child process that ends when its supervisor does: its standard input is a pipe, and it exits once that closes.
#[derive(Debug)]
pub struct Supervised {
    /// Role it plays in the mission.
    pub role: Role,
    /// Number of restarts.
    pub restarts: u64,
    /// When the current process was started.
    pub started: MonotonicNs,
    /// Set by the supervisor once it will not restart this child again.
    pub given_up: bool,
    recent_restarts: Restarts,
    former_pids: Vec<u32>,
    program: PathBuf,
    arguments: Vec<String>,
    child: Child,
    lifeline: Option<ChildStdin>,
    output: Option<JoinHandle<String>>,
    ended: Option<ExitStatus>,
}

impl Supervised {
    /// Starts `program` with `arguments` and `--lifeline`, which its command must know.
    ///
    /// # Errors
    /// If the process cannot be started.
    pub fn start(program: &Path, role: Role, arguments: Vec<String>) -> Result<Self, Failure> {
        Self::start_with(program, role, arguments, &|_| {})
    }

    /// As [`Supervised::start`], with whatever else `configure` sets on the command.
    ///
    /// # Errors
    /// If the process cannot be started.
    pub fn start_with(
        program: &Path,
        role: Role,
        arguments: Vec<String>,
        configure: Configure<'_>,
    ) -> Result<Self, Failure> {
        let (child, lifeline, output) = spawn(program, role, &arguments, configure)?;
        Ok(Self {
            role,
            restarts: 0,
            started: Node::now(),
            given_up: false,
            recent_restarts: Restarts::default(),
            former_pids: Vec::new(),
            program: program.into(),
            arguments,
            child,
            lifeline,
            output,
            ended: None,
        })
    }

    /// Starts the process again after its end. A planner is told the process number of its predecessor.
    ///
    /// # Errors
    /// If the process cannot be started.
    pub fn restart(&mut self) -> Result<(), Failure> {
        self.restart_as(&[], &|_| {})
    }

    /// As [`Supervised::restart`], with further arguments.
    ///
    /// # Errors
    /// If the process cannot be started.
    pub fn restart_told(&mut self, more: &[String]) -> Result<(), Failure> {
        self.restart_as(more, &|_| {})
    }

    /// Whether it may be restarted at `now`: not after [`RESTARTS_MAX`] times within [`RESTART_WINDOW_NS`].
    pub fn may_restart(&mut self, now: MonotonicNs) -> bool {
        self.recent_restarts.allow(now)
    }

    /// As [`Supervised::restart`], with whatever else `configure` sets on the command.
    ///
    /// # Errors
    /// If the process cannot be started.
    pub fn restart_with(&mut self, configure: Configure<'_>) -> Result<(), Failure> {
        self.restart_as(&[], configure)
    }

    fn restart_as(&mut self, more: &[String], configure: Configure<'_>) -> Result<(), Failure> {
        let mut arguments = [&self.arguments, more].concat();
        if self.role == Role::Planner {
            arguments.extend(["--succeeds-pid".to_owned(), self.pid().to_string()]);
        }
        self.former_pids.push(self.pid());
        (self.child, self.lifeline, self.output) = spawn(&self.program, self.role, &arguments, configure)?;
        self.restarts += 1;
        self.started = Node::now();
        self.recent_restarts.note(self.started);
        self.ended = None;
        Ok(())
    }

    /// Process number of the current process.
    #[must_use]
    pub fn pid(&self) -> u32 {
        self.child.id()
    }

    /// Whether `pid` is the current process or one of those before it.
    #[must_use]
    pub fn is(&self, pid: u32) -> bool {
        pid == self.pid() || self.former_pids.contains(&pid)
    }

    /// Exit status of the current process; `None` while it runs.
    ///
    /// # Errors
    /// If the operating system cannot tell.
    pub fn ended(&mut self) -> Result<Option<ExitStatus>, Failure> {
        if self.ended.is_none() {
            self.ended = self.child.try_wait().map_err(Failure::run)?;
        }
        Ok(self.ended)
    }

    /// Kills the current process (SIGKILL).
    pub fn kill(&mut self) {
        // Fails only if it has ended already.
        let _ = self.child.kill();
    }

    /// Closes the child's standard input, on which it exits.
    pub fn release(&mut self) {
        self.lifeline = None;
    }

    /// What the current process wrote to standard output; waits for its end.
    pub fn output(&mut self) -> String {
        self.output.take().and_then(|reader| reader.join().ok()).unwrap_or_default()
    }
}

impl Drop for Supervised {
    fn drop(&mut self) {
        self.release();
        self.kill();
        let _ = self.child.wait();
    }
}

/// Sets what a command needs beyond its arguments, e.g. its environment.
pub type Configure<'a> = &'a dyn Fn(&mut Command);

/// The process, the pipe that keeps it alive, and the thread that reads its standard output.
type Spawned = (Child, Option<ChildStdin>, Option<JoinHandle<String>>);

fn spawn(
    program: &Path,
    role: Role,
    arguments: &[String],
    configure: Configure<'_>,
) -> Result<Spawned, Failure> {
    let mut command = Command::new(program);
    if role != Role::Monitor && std::env::var_os("HOPPER_LOG").is_none() {
        // The monitor reports progress; the others only what is wrong.
        command.env("HOPPER_LOG", "warn");
    }
    configure(&mut command);
    let failed = |error: std::io::Error| Failure::run(format!("{role} cannot be started: {error}"));
    let mut child = command
        .args(arguments)
        .arg("--lifeline")
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .spawn()
        .map_err(failed)?;
    let lifeline = child.stdin.take();
    match child.stdout.take().map(collect).transpose() {
        Ok(output) => Ok((child, lifeline, output)),
        Err(error) => {
            // Nobody would supervise it.
            let _ = child.kill();
            let _ = child.wait();
            Err(failed(error))
        }
    }
}

/// Starts the thread that reads what a child writes to standard output.
fn collect(mut stdout: ChildStdout) -> std::io::Result<JoinHandle<String>> {
    std::thread::Builder::new().name("child output".into()).spawn(move || {
        let mut text = String::new();
        // If the child was killed, this keeps what it had written.
        let _ = stdout.read_to_string(&mut text);
        text
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    const S: u64 = 1_000_000_000;

    /// P-RESTART: by the clock of the supervisor.
    #[test]
    fn what_dies_now_and_then_is_restarted_for_ever_and_what_dies_in_a_loop_is_not() {
        let deaths = |every_s: u64, count: u64| {
            let mut restarts = Restarts::default();
            (0..count)
                .map(|n| MonotonicNs(n * every_s * S))
                .take_while(|at| {
                    let allowed = restarts.allow(*at);
                    restarts.note(*at);
                    allowed
                })
                .count() as u64
        };
        assert_eq!(deaths(0, 100), RESTARTS_MAX as u64);
        // A process that hangs is killed every ten seconds.
        assert_eq!(deaths(11, 100), RESTARTS_MAX as u64);
        assert_eq!(deaths(60, 1000), 1000, "six in 300 s, and on and on");
    }

    /// P-SPAWN: a process.
    #[test]
    fn a_program_that_cannot_be_started_is_an_error_with_its_role() {
        let error = Supervised::start(Path::new("/no/such/program"), Role::Planner, Vec::new()).unwrap_err();
        assert!(error.message.starts_with("planner cannot be started: "), "{error}");
    }
}
