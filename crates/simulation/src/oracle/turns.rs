//! Whose turn it is: the clock of each robot, who waits for whom, who has acted last.

use contract::{Action, Branch, Decision, Digest, Outcome, RobotId, RunId, Standing, Team};
use hopper_sim::Mission;

use super::actor::Actor;

const SECOND_NS: u64 = 1_000_000_000;

/// The robots of a mission, and whose turn it is.
#[derive(Clone, Debug)]
pub(super) struct Turns {
    pub actors: Vec<Actor>,
    /// Who acted last.
    last: Option<usize>,
    /// When the last action began, nanoseconds of simulated time.
    acted_at_ns: u64,
}

impl Turns {
    /// Before the first action.
    pub fn begin_with(mission: &Mission) -> Self {
        let count = usize::from(mission.brief.robots.count());
        let actors = (0..count).map(|number| Actor::begin(mission, number)).collect();
        Self { actors, last: None, acted_at_ns: 0 }
    }

    /// Who acts next; once nobody does, who acted last.
    pub fn due(&self) -> RobotId {
        RobotId(self.next().or(self.last).unwrap_or_default() as u16)
    }

    /// The number of the robot that acts next: of those that can act and wait for nobody the first that is ready.
    pub fn next(&self) -> Option<usize> {
        let can_act = |number: &usize| self.actors[*number].is_active() && !self.actors[*number].waits;
        let numbers = (0..self.actors.len()).filter(can_act);
        numbers.min_by_key(|&number| (self.actors[number].clock_ns, number))
    }

    /// The robot that acts next.
    pub fn next_actor(&self) -> Option<&Actor> {
        self.next().map(|number| &self.actors[number])
    }

    /// Whether nobody acts next because all that still could wait for each other.
    pub fn is_all_waiting(&self) -> bool {
        self.next().is_none() && self.actors.iter().any(|actor| actor.waits)
    }

    /// Simulated time from the beginning of the last action to that of the next, nanoseconds.
    pub fn lasts_ns(&self) -> u64 {
        let next = self.next().or(self.last).map(|number| self.actors[number].clock_ns);
        next.map_or(0, |next_ns| next_ns.saturating_sub(self.acted_at_ns))
    }

    /// A robot begins to act.
    pub fn begin(&mut self, number: usize) {
        (self.last, self.acted_at_ns) = (Some(number), self.actors[number].clock_ns);
    }

    /// A robot is busy for so long; whoever waits for somebody to act waits no longer than that.
    pub fn busy(&mut self, number: usize, seconds: f64) {
        self.actors[number].clock_ns += ((seconds * 1e9).round() as u64).max(SECOND_NS);
        let ended_ns = self.actors[number].clock_ns;
        for waiting in self.actors.iter_mut().filter(|actor| actor.waits) {
            (waiting.waits, waiting.clock_ns) = (false, waiting.clock_ns.max(ended_ns));
        }
    }

    /// The action of a robot that goes from cell to cell has come to `outcome`, which was compared.
    pub fn take_in_cells(&mut self, number: usize, action: Action, outcome: &Outcome) {
        self.begin(number);
        let actor = &mut self.actors[number];
        actor.cell = outcome.to;
        actor.actions += 1;
        if matches!(outcome.branch, Branch::Stranded | Branch::RolledAway) {
            actor.standing = Standing::Stranded;
        } else if action == Action::Wait {
            (actor.waits, actor.waited) = (true, actor.waited + 1);
            return;
        } else if let Action::Step(heading) = action {
            actor.heading = heading;
        }
        let seconds = outcome.flight.flight_time_s * f64::from(outcome.flight.flights);
        self.busy(number, seconds);
    }

    /// The message about all robots as of the state of `decision` with `digest`.
    pub fn team(&self, run: RunId, decision: Decision, digest: Digest) -> Team {
        let members = self.actors.iter().map(Actor::member).collect();
        let actor = self.last.map(|actor| RobotId(actor as u16));
        Team { run, decision, digest, due: self.due(), actor, members }
    }
}
