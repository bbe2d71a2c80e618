//! A supervised child process: its start, its restarts, and its end.

use std::io::Read;
use std::path::{Path, PathBuf};
use std::process::{Child, ChildStdin, Command, ExitStatus, Stdio};
use std::thread::JoinHandle;

use contract::{MonotonicNs, Role};
use node::{Failure, Node};

/// Restarts of a child before its supervisor gives it up.
pub const RESTARTS_MAX: u64 = 5;

/// A child process that ends when its supervisor does: its standard input is a pipe, and it exits once that closes.
#[derive(Debug)]
pub struct Supervised {
    /// Role it plays in the mission.
    pub role: Role,
    /// Number of restarts, at most [`RESTARTS_MAX`].
    pub restarts: u64,
    /// When the current process was started.
    pub started: MonotonicNs,
    /// Set by the supervisor once it will not restart this child again.
    pub given_up: bool,
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
        self.restart_with(&|_| {})
    }

    /// As [`Supervised::restart`], with whatever else `configure` sets on the command.
    ///
    /// # Errors
    /// If the process cannot be started.
    pub fn restart_with(&mut self, configure: Configure<'_>) -> Result<(), Failure> {
        let mut arguments = self.arguments.clone();
        if self.role == Role::Planner {
            arguments.extend(["--succeeds-pid".to_owned(), self.pid().to_string()]);
        }
        self.former_pids.push(self.pid());
        (self.child, self.lifeline, self.output) = spawn(&self.program, self.role, &arguments, configure)?;
        self.restarts += 1;
        self.started = Node::now();
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
    let mut child = command
        .args(arguments)
        .arg("--lifeline")
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .spawn()
        .map_err(Failure::run)?;
    let lifeline = child.stdin.take();
    let output = child.stdout.take().map(|mut stdout| {
        std::thread::spawn(move || {
            let mut text = String::new();
            // If the child was killed, this keeps what it had written.
            let _ = stdout.read_to_string(&mut text);
            text
        })
    });
    Ok((child, lifeline, output))
}
