//! A Python planner as a planner process.
//!
//! Two threads: the process with its ports and heartbeats, and the caller's, which runs Python. The first asks the second
//! for each decision, sends heartbeats while it waits, and holds once the time is up. No Python object and no reference
//! to a map crosses: what crosses is the state, and the cells that changed.

use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::mpsc::{Receiver, RecvTimeoutError, Sender, channel};
use std::sync::{Arc, Once};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use contract::{Action, Name, Robot, RobotId, RobotSet, Team};
use node::ShutdownSignal;
use node::peer::PeerArgs;
use planner::shell::ClaimArgs;
use planner::{Budget, Plan, PlanStatus, Planner, Situation};
use process::{Exit, Failure};
use pyo3::exceptions::{PyException, PyKeyboardInterrupt};
use pyo3::ffi;
use pyo3::prelude::*;
use pyo3::types::PyType;

use crate::answer::{self, Decider};
use crate::arrays::{News, Watch};
use crate::boundary::{self, guarded};
use crate::view::{Brief, State};
use crate::{DecideTimeout, HopperError};

/// Pause between two heartbeats that may be due while Python decides.
const BEAT: Duration = Duration::from_millis(10);

/// Longest time that a user may name: some 30 years.
const SECONDS_MAX: Duration = Duration::from_secs(1_000_000_000);

/// What ends the process's thread from within a plan.
const LEFT: &str = "the caller's thread has left";

/// How often the caller's thread looks for signals.
const TICK: Duration = Duration::from_millis(100);

/// A decision that is due.
struct Question {
    number: u64,
    brief: Brief,
    news: News,
    state: contract::State,
    team: Option<Team>,
}

/// The answer to a question; `None` if there was no valid one.
type Answer = (u64, Option<Action>);

/// The planner in the process's thread.
struct Remote {
    name: Name,
    questions: Sender<Question>,
    answers: Receiver<Answer>,
    watch: Watch,
    asked: u64,
    timeout: Duration,
    interrupt: Interrupt,
    shutdown: ShutdownSignal,
}

impl Planner for Remote {
    fn name(&self) -> Name {
        self.name
    }

    fn suits(&self, robot: &Robot) -> bool {
        answer::suits(robot)
    }

    fn plan(&mut self, situation: &Situation<'_>, budget: &Budget) -> Plan {
        let Situation { map, state, team, .. } = *situation;
        self.asked += 1;
        let question = Question {
            number: self.asked,
            brief: Brief::of(situation),
            news: self.watch.news(map),
            state: *state,
            team: team.cloned(),
        };
        if self.questions.send(question).is_err() {
            leave();
        }
        let asked = Instant::now();
        loop {
            match self.answers.recv_timeout(BEAT) {
                Ok((number, Some(action))) if number == self.asked => {
                    return Plan::at_once(action, PlanStatus::Solved);
                }
                Ok((number, None)) if number == self.asked => {
                    return Plan::at_once(Action::Hold, PlanStatus::Cut);
                }
                // It comes too late.
                Ok(_) => {}
                Err(RecvTimeoutError::Timeout) => budget.pulse.beat(),
                Err(RecvTimeoutError::Disconnected) => leave(),
            }
            if self.shutdown.stop_reason().is_some() {
                self.interrupt.raise(|py| py.get_type::<PyKeyboardInterrupt>());
                leave();
            }
            if asked.elapsed() >= self.timeout {
                tracing::error!(
                    "decide needs to answer within {:?}, and has not at decision {}: holding",
                    self.timeout,
                    state.decision
                );
                self.interrupt.raise(|py| py.get_type::<DecideTimeout>());
                return Plan::at_once(Action::Hold, PlanStatus::Cut);
            }
        }
    }
}

/// Ends the process's thread from within a plan, so that nothing is commanded that the planner did not choose.
fn leave() -> ! {
    std::panic::resume_unwind(Box::new(LEFT))
}

/// Raises an exception in the caller's thread while it is in `decide`.
#[derive(Clone)]
struct Interrupt {
    thread: u64,
    /// Number of the question that Python is at; 0 for none. Changes only while the interpreter is held.
    at: Arc<AtomicU64>,
}

impl Interrupt {
    /// In a thread of its own, since the interpreter may be held for long.
    fn raise(&self, kind: for<'py> fn(Python<'py>) -> Bound<'py, PyType>) {
        let (thread, at, number) = (self.thread, Arc::clone(&self.at), self.at.load(Ordering::Relaxed));
        let raise = move || {
            Python::attach(|py| {
                if number == 0 || at.load(Ordering::Relaxed) != number {
                    return;
                }
                // SAFETY: the interpreter is held, and what is raised is a class of exceptions, held until it is set.
                unsafe { ffi::PyThreadState_SetAsyncExc(thread as _, kind(py).as_ptr()) };
            });
        };
        if let Err(error) = std::thread::Builder::new().name("interruption".into()).spawn(raise) {
            tracing::warn!("decide cannot be interrupted: {error}");
        }
    }
}

/// Flies a planner in an instance until the mission ends; see `hopper.fly`.
#[pyfunction]
#[pyo3(signature = (planner, *, instance, robots, takeover, stay, wait_s, timeout_s, lifeline, succeeds_pid))]
#[allow(clippy::too_many_arguments, reason = "called by hopper.fly alone, which has the defaults")]
pub fn fly(
    py: Python<'_>,
    planner: &Bound<'_, PyAny>,
    instance: String,
    robots: Vec<u16>,
    takeover: bool,
    stay: bool,
    wait_s: Option<f64>,
    timeout_s: f64,
    lifeline: bool,
    succeeds_pid: Option<u32>,
) -> PyResult<u8> {
    guarded(|| {
        static LOG: Once = Once::new();
        LOG.call_once(|| node::log_to_stderr("planner", 0));
        let seconds = |what: &str, s: f64| {
            let duration = Duration::try_from_secs_f64(s).ok().filter(|duration| *duration <= SECONDS_MAX);
            duration.ok_or_else(|| crate::error(format!("{what} needs seconds, 0 to 1e9, got {s}")))
        };
        let robots = robots.into_iter().map(RobotId).fold(RobotSet(0), RobotSet::with);
        let wait = wait_s.map(|s| seconds("wait", s)).transpose()?;
        let peer = PeerArgs { instance, wait, stay, lifeline };
        let claim = ClaimArgs { robot: robots, takeover, succeeds_pid };
        let mut decider = Decider::new(planner)?;
        let (questions, inbox) = channel();
        let (outbox, answers) = channel();
        let thread = py.import("threading")?.call_method0("get_ident")?.extract()?;
        let interrupt = Interrupt { thread, at: Arc::new(AtomicU64::new(0)) };
        let remote = Remote {
            name: answer::name(planner)?,
            questions,
            answers,
            watch: Watch::default(),
            asked: 0,
            timeout: seconds("timeout", timeout_s)?,
            interrupt: interrupt.clone(),
            shutdown: ShutdownSignal::new().map_err(crate::error)?,
        };
        let process = std::thread::Builder::new()
            .name("planner".into())
            .spawn(move || planner::shell::fly(&peer, &claim, Box::new(remote)))?;
        let pid = std::process::id();
        let left = serve(py, &mut decider, inbox, outbox, &interrupt);
        if pid != std::process::id() {
            // The thread is the parent's, and so is the mission.
            std::mem::forget(process);
            left?;
            return Err(crate::error(format!(
                "a mission needs the process that flies it, {pid}, got a fork of it that came back from decide"
            )));
        }
        let has_left = !matches!(left, Ok(Left::ProcessEnded));
        let ended = py.detach(move || join(process, has_left));
        left?;
        match ended {
            Ok(exit) => Ok(exit.code()),
            Err(failure) => {
                let error = HopperError::new_err(failure.message);
                error.value(py).setattr("exit_code", failure.exit.code())?;
                Err(error)
            }
        }
    })
}

/// The end of the process's thread. If the caller's has `left`, it is not waited for long: it may stand by for ever.
fn join(process: JoinHandle<Result<Exit, Failure>>, left: bool) -> Result<Exit, Failure> {
    let since = Instant::now();
    while left && !process.is_finished() {
        if since.elapsed() > Duration::from_secs(1) {
            return Ok(Exit::Interrupted);
        }
        std::thread::sleep(Duration::from_millis(1));
    }
    process.join().unwrap_or_else(|panic| match boundary::message(panic.as_ref()) {
        LEFT => Ok(Exit::Interrupted),
        defect => Err(Failure::new(Exit::Failed, format!("this is a defect of hopper: {defect}"))),
    })
}

/// Why no more questions are answered.
enum Left {
    ProcessEnded,
    Interrupted,
}

/// Answers questions until the process has ended, or the user interrupts it.
fn serve(
    py: Python<'_>,
    decider: &mut Decider,
    mut inbox: Receiver<Question>,
    outbox: Sender<Answer>,
    interrupt: &Interrupt,
) -> PyResult<Left> {
    let pid = std::process::id();
    loop {
        let received;
        (inbox, received) = py.detach(move || {
            let received = inbox.recv_timeout(TICK);
            (inbox, received)
        });
        py.check_signals()?;
        let mut question = match received {
            Ok(question) => question,
            Err(RecvTimeoutError::Timeout) => continue,
            Err(RecvTimeoutError::Disconnected) => return Ok(Left::ProcessEnded),
        };
        // Of questions that came while Python was busy only the last still matters.
        while let Ok(next) = inbox.try_recv() {
            decider.learn(py, &question.news)?;
            question = next;
        }
        let Question { number, brief, news, state, team } = question;
        let decision = state.decision;
        interrupt.at.store(number, Ordering::Relaxed);
        let decided = decider.decide(py, brief, &news, State { state, team });
        interrupt.at.store(0, Ordering::Relaxed);
        if pid != std::process::id() {
            // Nobody asks a fork of this process, and nobody reads its answers.
            std::mem::forget((inbox, outbox));
            return decided.map(|_| Left::ProcessEnded);
        }
        // An interruption that came just too late is raised here.
        let _ = py.run(c"pass", None, None);
        let action = match decided {
            Ok(action) => Some(action),
            Err(error) if error.is_instance_of::<HopperError>(py) => {
                tracing::error!("decision {decision}: {}: holding", error.value(py));
                None
            }
            Err(error) if error.is_instance_of::<DecideTimeout>(py) => {
                error.print(py);
                None
            }
            Err(error) if error.is_instance_of::<PyException>(py) => {
                tracing::error!("decide raised an exception at decision {decision}: holding");
                error.print(py);
                None
            }
            Err(error) if error.is_instance_of::<PyKeyboardInterrupt>(py) => return Ok(Left::Interrupted),
            // SystemExit.
            Err(error) => return Err(error),
        };
        if outbox.send((number, action)).is_err() {
            return Ok(Left::ProcessEnded);
        }
    }
}
