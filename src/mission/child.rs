//! A supervised child process: its start, its restarts, and its end.

use std::collections::VecDeque;
use std::ffi::OsString;
use std::io::Read;
use std::path::{Path, PathBuf};
use std::process::{Child, ChildStdin, ChildStdout, Command, ExitStatus, Stdio};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::JoinHandle;

use contract::{MonotonicNs, RobotSet, Role};
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

/// What is known of a program of the user's, which may start others: a script that starts an interpreter, say.
#[derive(Clone, Debug, Default)]
struct OwnProgram {
    environment: Vec<(&'static str, String)>,
    /// The process that sends heartbeats, and when the first of them was heard.
    joined: Option<(u32, MonotonicNs)>,
}

/// A child process that ends when its supervisor does: its standard input is a pipe, and it exits once that closes.
#[derive(Debug)]
pub struct Supervised {
    /// Role it plays in the mission.
    pub role: Role,
    /// The robots that it was started to plan for, if it is a planner.
    pub robots: RobotSet,
    /// Times that it was started again after a crash.
    pub restarts: u64,
    /// When the current process was started.
    pub started: MonotonicNs,
    /// Set by the supervisor once it will not restart this child again.
    pub given_up: bool,
    recent_restarts: Restarts,
    former_pids: Vec<u32>,
    program: PathBuf,
    arguments: Vec<OsString>,
    own: Option<OwnProgram>,
    child: Child,
    lifeline: Option<ChildStdin>,
    output: Option<Output>,
    ended: Option<ExitStatus>,
}

impl Supervised {
    /// Starts `program` with `arguments` and `--lifeline`, which its command must know.
    ///
    /// # Errors
    /// If the process cannot be started.
    pub fn start(
        program: &Path,
        role: Role,
        arguments: impl IntoIterator<Item: Into<OsString>>,
    ) -> Result<Self, Failure> {
        Self::start_with(program, role, arguments, &|_| {})
    }

    /// As [`Supervised::start`], with whatever else `configure` sets on the command.
    ///
    /// # Errors
    /// If the process cannot be started.
    pub fn start_with(
        program: &Path,
        role: Role,
        arguments: impl IntoIterator<Item: Into<OsString>>,
        configure: Configure<'_>,
    ) -> Result<Self, Failure> {
        let arguments = arguments.into_iter().map(Into::into).collect();
        Self::spawned(program, role, arguments, None, configure)
    }

    /// Starts a program of the user's as a planner. What other children get by flags, it gets by its environment:
    /// `environment`, `HOPPER_LIFELINE`, and when it is restarted `HOPPER_SUCCEEDS_PID`. What it prints goes to standard
    /// error.
    ///
    /// # Errors
    /// If the process cannot be started.
    pub fn start_own(
        program: &Path,
        arguments: impl IntoIterator<Item: Into<OsString>>,
        environment: Vec<(&'static str, String)>,
    ) -> Result<Self, Failure> {
        let arguments = arguments.into_iter().map(Into::into).collect();
        let own = OwnProgram { environment, joined: None };
        Self::spawned(program, Role::Planner, arguments, Some(own), &|_| {})
    }

    fn spawned(
        program: &Path,
        role: Role,
        arguments: Vec<OsString>,
        own: Option<OwnProgram>,
        configure: Configure<'_>,
    ) -> Result<Self, Failure> {
        let (child, lifeline, output) = spawn(program, role, &arguments, own.as_ref(), configure)?;
        Ok(Self {
            role,
            robots: RobotSet::NONE,
            own,
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

    /// Starts the process again after its end. A planner gets the process number of its predecessor.
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
    pub fn restart_told(&mut self, more: &[OsString]) -> Result<(), Failure> {
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

    fn restart_as(&mut self, more: &[OsString], configure: Configure<'_>) -> Result<(), Failure> {
        let mut arguments = [&self.arguments, more].concat();
        let predecessor = self.beating_pid();
        self.former_pids.extend([self.pid(), predecessor]);
        if let Some(own) = &mut self.own {
            own.joined = None;
            own.environment.retain(|(name, _)| *name != "HOPPER_SUCCEEDS_PID");
            own.environment.push(("HOPPER_SUCCEEDS_PID", predecessor.to_string()));
        } else if self.role == Role::Planner {
            arguments.extend(["--succeeds-pid".into(), predecessor.to_string().into()]);
        }
        (self.child, self.lifeline, self.output) =
            spawn(&self.program, self.role, &arguments, self.own.as_ref(), configure)?;
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
        [self.pid(), self.beating_pid()].contains(&pid) || self.former_pids.contains(&pid)
    }

    /// Process number of the process that sends the heartbeats: the current one, or one that a program of the user's has
    /// started.
    #[must_use]
    pub fn beating_pid(&self) -> u32 {
        let joined = self.own.as_ref().and_then(|own| own.joined);
        joined.map_or(self.pid(), |(pid, _)| pid)
    }

    /// Whether it is a program of the user's.
    #[must_use]
    pub fn is_own(&self) -> bool {
        self.own.is_some()
    }

    /// When the first heartbeat of a program of the user's was heard; `None` before it.
    #[must_use]
    pub fn joined(&self) -> Option<MonotonicNs> {
        self.own.as_ref()?.joined.map(|(_, at)| at)
    }

    /// Takes note of a planner's heartbeat at `now`, which may be the first of a program of the user's.
    pub fn hear(&mut self, pid: u32, now: MonotonicNs) {
        let root = self.pid();
        if let Some(own) = self.own.as_mut().filter(|own| own.joined.is_none())
            && descends(pid, root)
        {
            own.joined = Some((pid, now));
        }
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
        self.output.take().and_then(|output| output.reader.join().ok()).unwrap_or_default()
    }

    /// Whether the current process has written to standard output.
    #[must_use]
    pub fn has_spoken(&self) -> bool {
        self.output.as_ref().is_some_and(|output| output.spoken.load(Ordering::SeqCst))
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
type Spawned = (Child, Option<ChildStdin>, Option<Output>);

/// What a child writes to standard output, as it is read.
#[derive(Debug)]
struct Output {
    /// Whether there was any.
    spoken: Arc<AtomicBool>,
    /// Ends with the output.
    reader: JoinHandle<String>,
}

fn spawn(
    program: &Path,
    role: Role,
    arguments: &[OsString],
    own: Option<&OwnProgram>,
    configure: Configure<'_>,
) -> Result<Spawned, Failure> {
    let mut command = Command::new(program);
    command.args(arguments).stdin(Stdio::piped());
    match own {
        None => command.arg("--lifeline").stdout(Stdio::piped()),
        Some(own) => {
            command.envs(own.environment.iter().cloned()).env("HOPPER_LIFELINE", "true");
            command.stdout(std::io::stderr())
        }
    };
    if role != Role::Monitor && std::env::var_os("HOPPER_LOG").is_none() {
        // The monitor reports progress; the others only what is wrong.
        command.env("HOPPER_LOG", "warn");
    }
    configure(&mut command);
    let failed = |error: std::io::Error| Failure::run(format!("{role} cannot be started: {error}"));
    let mut child = command.spawn().map_err(failed)?;
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

/// Whether `pid` is `ancestor`, or was started by it, directly or through a few others.
fn descends(pid: u32, ancestor: u32) -> bool {
    let parent = |pid: u32| -> Option<u32> {
        let stat = std::fs::read_to_string(format!("/proc/{pid}/stat")).ok()?;
        // The name of the program, in parentheses, may hold anything.
        stat.rsplit_once(')')?.1.split_whitespace().nth(1)?.parse().ok()
    };
    std::iter::successors(Some(pid), |&pid| parent(pid)).take(8).any(|pid| pid == ancestor)
}

/// Starts the thread that reads what a child writes to standard output.
fn collect(mut stdout: ChildStdout) -> std::io::Result<Output> {
    let spoken = Arc::new(AtomicBool::new(false));
    let heard = Arc::clone(&spoken);
    let reader = std::thread::Builder::new().name("child output".into()).spawn(move || {
        let mut bytes = vec![0; 1];
        if stdout.read_exact(&mut bytes).is_err() {
            return String::new();
        }
        heard.store(true, Ordering::SeqCst);
        // If the child was killed, this keeps what it had written.
        let _ = stdout.read_to_end(&mut bytes);
        String::from_utf8_lossy(&bytes).into_owned()
    })?;
    Ok(Output { spoken, reader })
}

#[cfg(test)]
mod tests {
    use super::*;

    const S: u64 = 1_000_000_000;

    /// P-RESTART. Measured by the supervisor's clock.
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

    /// P-SPAWN: A process or thread that cannot be started is an error that names it, not a panic.
    #[test]
    fn a_program_that_cannot_be_started_is_an_error_with_its_role() {
        let error = Supervised::start(Path::new("/no/such/program"), Role::Planner, [""; 0]).unwrap_err();
        assert!(error.message.starts_with("planner cannot be started: "), "{error}");
    }
}
