//! One child process of `hopper run`, its lifeline and its lives.

use std::io::Read;
use std::process::{Child, ChildStdin, Command, ExitStatus, Stdio};
use std::thread::JoinHandle;

use contract::{MonotonicNs, Role};
use node::{Failure, Node};

/// How often a child is started again before its supervisor gives up.
pub const RESTARTS_MAX: u64 = 5;

/// A child process that ends when its supervisor does: it holds the read end of a pipe.
#[derive(Debug)]
pub struct Supervised {
    /// The part it plays.
    pub role: Role,
    /// Starts after the first.
    pub restarts: u64,
    /// When the present life began.
    pub started: MonotonicNs,
    /// It has died too often to be started again.
    pub given_up: bool,
    /// Processes of its former lives.
    former: Vec<u32>,
    arguments: Vec<String>,
    child: Child,
    lifeline: Option<ChildStdin>,
    output: Option<JoinHandle<String>>,
    ended: Option<ExitStatus>,
}

impl Supervised {
    /// Starts this executable again as `arguments[0]`, which must know `--lifeline`.
    ///
    /// # Errors
    /// If the process cannot be started.
    pub fn start(role: Role, arguments: Vec<String>) -> Result<Self, Failure> {
        Self::start_as(role, arguments, &|_| {})
    }

    /// As [`Supervised::start`], after `dress` has had its say on the command.
    ///
    /// # Errors
    /// If the process cannot be started.
    pub fn start_as(role: Role, arguments: Vec<String>, dress: Dress<'_>) -> Result<Self, Failure> {
        let (child, lifeline, output) = spawn(role, &arguments, &[], dress)?;
        Ok(Self {
            role,
            restarts: 0,
            started: Node::now(),
            given_up: false,
            former: Vec::new(),
            arguments,
            child,
            lifeline,
            output,
            ended: None,
        })
    }

    /// Starts the process again after its end; a planner is told whom it succeeds.
    ///
    /// # Errors
    /// If the process cannot be started.
    pub fn restart(&mut self) -> Result<(), Failure> {
        self.restart_as(&|_| {})
    }

    /// As [`Supervised::restart`], after `dress` has had its say on the command.
    ///
    /// # Errors
    /// If the process cannot be started.
    pub fn restart_as(&mut self, dress: Dress<'_>) -> Result<(), Failure> {
        let mut extra = Vec::new();
        if self.role == Role::Planner {
            extra = vec!["--succeeds-pid".to_owned(), self.pid().to_string()];
        }
        self.former.push(self.pid());
        (self.child, self.lifeline, self.output) = spawn(self.role, &self.arguments, &extra, dress)?;
        self.restarts += 1;
        self.started = Node::now();
        self.ended = None;
        Ok(())
    }

    /// The process of the present life.
    #[must_use]
    pub fn pid(&self) -> u32 {
        self.child.id()
    }

    /// Whether `pid` is, or was, one of its lives.
    #[must_use]
    pub fn is(&self, pid: u32) -> bool {
        pid == self.pid() || self.former.contains(&pid)
    }

    /// How the present life ended, once it has.
    ///
    /// # Errors
    /// If the operating system does not say.
    pub fn ended(&mut self) -> Result<Option<ExitStatus>, Failure> {
        if self.ended.is_none() {
            self.ended = self.child.try_wait().map_err(Failure::run)?;
        }
        Ok(self.ended)
    }

    /// Kills it outright.
    pub fn kill(&mut self) {
        // Fails only if it has ended already.
        let _ = self.child.kill();
    }

    /// Lets go of the lifeline: the child ends by itself.
    pub fn release(&mut self) {
        self.lifeline = None;
    }

    /// What it wrote to standard output, after its end.
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

/// What else a command needs, e.g. an environment.
pub type Dress<'a> = &'a dyn Fn(&mut Command);

type Spawned = (Child, Option<ChildStdin>, Option<JoinHandle<String>>);

fn spawn(role: Role, arguments: &[String], extra: &[String], dress: Dress<'_>) -> Result<Spawned, Failure> {
    let executable = std::env::current_exe().map_err(Failure::run)?;
    let mut command = Command::new(executable);
    if role != Role::Monitor && std::env::var_os("HOPPER_LOG").is_none() {
        // The monitor tells of progress; from the others only what is out of order.
        command.env("HOPPER_LOG", "warn");
    }
    dress(&mut command);
    let mut child = command
        .args(arguments)
        .args(extra)
        .arg("--lifeline")
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .spawn()
        .map_err(Failure::run)?;
    let lifeline = child.stdin.take();
    let output = child.stdout.take().map(|mut stdout| {
        std::thread::spawn(move || {
            let mut text = String::new();
            // What can be read of a killed child's output is what there is.
            let _ = stdout.read_to_string(&mut text);
            text
        })
    });
    Ok((child, lifeline, output))
}
