//! A mission in flight, whose processes take their turns as its host calls for them.

use std::collections::{BTreeMap, VecDeque};
use std::rc::Rc;

use contract::{
    Decision, Detail, Incarnation, Name, ObservedMap, PolicyCell, Record, RobotId, RobotSet, Route, State,
};
use hopper_sim::process::{HopperSim, SimTerms};
use hopper_sim::{Arbiter, Fallback, Mission, Pace};
use perception::Cartographer;
use perception::process::Perception;
use planner::process::{Claim, PlannerProcess};
use planner::{Planner, PlannerError};
use process::{Failure, Process, Terms, Turn, block_on};

use crate::ports::{Bus, Clock, DirectPorts};
use crate::records::Records;
use crate::{PlannerSchedule, Successor};

/// Called after each executed decision.
type Observe<'c> = Box<dyn FnMut(&Record) + 'c>;

/// Returns a fresh planner of a name.
type Make<'c> = Box<dyn FnMut(Name, &Mission) -> Result<Box<dyn Planner>, PlannerError> + 'c>;

/// What a flight calls.
pub struct Hooks<'c> {
    /// Returns a fresh planner of the name that a schedule asks for.
    pub make: Make<'c>,
    /// Reads the time: for timing and pace only, no result depends on it.
    pub clock: Clock<'c>,
    /// Called after each executed decision.
    pub observe: Observe<'c>,
}

/// How fast landings follow each other, and whether orders may change that.
#[derive(Clone, Copy, Debug)]
pub struct Tempo {
    /// How fast at first.
    pub pace: Pace,
    /// Whether orders on `hop/control` are obeyed.
    pub control: bool,
}

impl Default for Tempo {
    fn default() -> Self {
        Self { pace: Pace::Max, control: false }
    }
}

/// The processes of one mission.
pub struct Flight<'c> {
    bus: Rc<Bus<'c>>,
    sim: HopperSim<DirectPorts<'c>, Records, Observe<'c>>,
    perception: Perception<DirectPorts<'c>>,
    planners: Vec<HostedPlanner<'c>>,
    make: Make<'c>,
    /// The ports of hopper-sim and perception.
    ports: [DirectPorts<'c>; 2],
    /// Who commands later.
    successors: VecDeque<Successor>,
    fallbacks: BTreeMap<Decision, Fallback>,
    lives: u64,
}

/// A planner with its ports.
struct HostedPlanner<'c> {
    robots: RobotSet,
    process: PlannerProcess<DirectPorts<'c>>,
    ports: DirectPorts<'c>,
}

impl<'c> HostedPlanner<'c> {
    fn join(bus: &Rc<Bus<'c>>, life: u64, robots: RobotSet, planner: Box<dyn Planner>) -> Self {
        let mut ports = bus.ports(Incarnation(life));
        let claim = Claim { robots, takeover: true, succeeds_pid: None };
        let process = block_on(PlannerProcess::join(&mut ports, planner, claim, Terms::default()));
        Self { robots, process: process.expect("direct ports always open"), ports }
    }
}

impl<'c> Flight<'c> {
    /// The mission before its first decision.
    ///
    /// # Errors
    /// If the first planner of the schedule cannot be had.
    ///
    /// # Panics
    /// Never: direct ports always open.
    pub fn begin(
        mission: Mission,
        schedule: &PlannerSchedule,
        tempo: Tempo,
        hooks: Hooks<'c>,
    ) -> Result<Self, PlannerError> {
        let Hooks { mut make, clock, observe } = hooks;
        let bus = Bus::new(clock);
        let PlannerSchedule { planners, fallbacks } = schedule.clone();
        let mut successors = VecDeque::from(planners);
        let nobody = || Successor {
            from: Decision(0),
            robots: RobotSet::ALL,
            planner: "hold".parse().expect("a name"),
        };
        let first = successors.pop_front().unwrap_or_else(nobody);
        let robots = first.robots.of(mission.brief.robots.count());
        let planner = make(first.planner, &mission)?;
        let Tempo { pace, control } = tempo;
        let terms = SimTerms { pace, linger_ns: 0, control, deadlines: false, terms: Terms::default() };
        let records = Records::of(&mission.brief);
        bus.look_at_clock();
        let mut ports = [1, 2].map(|life| bus.ports(Incarnation(life)));
        let [of_sim, of_perception] = &mut ports;
        let never = "direct ports always open";
        let sim = block_on(HopperSim::join(of_sim, mission, (records, None), observe, terms)).expect(never);
        let cartographer = Cartographer::new(RobotId(0));
        let perception =
            block_on(Perception::join(of_perception, cartographer, Terms::default())).expect(never);
        let planners = vec![HostedPlanner::join(&bus, 3, robots, planner)];
        Ok(Self { bus, sim, perception, planners, make, ports, successors, fallbacks, lives: 3 })
    }

    /// Ports of one more process of this mission, which its host gives its turns.
    #[must_use]
    pub fn ports(&mut self) -> DirectPorts<'c> {
        self.lives += 1;
        self.bus.ports(Incarnation(self.lives))
    }

    /// The arbiter, for the state and what was refused.
    #[must_use]
    pub fn arbiter(&self) -> &Arbiter {
        self.sim.arbiter()
    }

    /// The newest state.
    #[must_use]
    pub fn state(&self) -> &State {
        self.sim.arbiter().state()
    }

    /// The map observed so far.
    #[must_use]
    pub fn map(&self) -> Option<&ObservedMap> {
        self.perception.cartographer().map()
    }

    /// The map observed at the end.
    #[must_use]
    pub fn into_map(self) -> Option<ObservedMap> {
        self.perception.into_cartographer().into_map()
    }

    /// The policy of the planner that joined last, if it has one.
    pub fn policy(&mut self) -> Option<Vec<PolicyCell>> {
        self.planners.last_mut().and_then(|hosted| hosted.process.planner().policy())
    }

    /// What the motion model told of decisions, in their order; nothing under the law.
    #[must_use]
    pub fn details(&self) -> Vec<(Decision, Detail)> {
        self.sim.records().details().to_vec()
    }

    /// The routes that robots announced.
    #[must_use]
    pub fn routes(&self) -> Vec<Route> {
        self.sim.arbiter().routes().cloned().collect()
    }

    /// Has a fresh planner of this name command all robots from the next decision on that nobody has commanded yet.
    pub fn hand_over(&mut self, planner: Name) {
        let from = self.state().decision;
        self.successors.push_front(Successor { from, robots: RobotSet::ALL, planner });
    }

    /// Why nothing is decided, for whoever waits in vain: the planners that do not suit the mission, or else what was refused.
    pub fn why_it_stands_still(&mut self) -> String {
        let due = self.sim.arbiter().team().map_or(RobotId(0), |team| team.due);
        let Some(hosted) = self.planners.iter_mut().rfind(|hosted| hosted.robots.has(due)) else {
            return format!("robot {due} needs a planner, got none");
        };
        if let Some(unfit) = hosted.process.unfit() {
            return unfit.to_owned();
        }
        let refusals = &self.sim.arbiter().refusals().0;
        let reasons: Vec<&str> = refusals.keys().map(String::as_str).collect();
        format!(
            "planner {} needs to choose what robot {due} may do, got commands refused as {}",
            hosted.process.planner().name(),
            if reasons.is_empty() { "nothing: it commanded none".into() } else { reasons.join(", ") }
        )
    }

    /// Lets every process take its turn; whether the mission is over. After that there is none.
    ///
    /// # Errors
    /// If a planner of the schedule cannot be had.
    ///
    /// # Panics
    /// If a process fails, which would be a defect of the protocol.
    pub fn round(&mut self) -> Result<bool, PlannerError> {
        let over = matches!(self.turn_of_sim(), Turn::Leave(_));
        self.turn_of_perception();
        if over {
            return Ok(true);
        }
        while let Some(fallback) = self.due_fallback() {
            // Nobody commanded it: the planner does not even see its state.
            self.bus.look_at_clock();
            block_on(self.sim.repeat(fallback, &mut self.ports[0])).expect("direct ports always have room");
            self.turn_of_perception();
        }
        self.relieve()?;
        self.bus.look_at_clock();
        for HostedPlanner { process, ports, .. } in &mut self.planners {
            done(block_on(process.turn(ports)));
        }
        Ok(false)
    }

    fn turn_of_sim(&mut self) -> Turn {
        self.bus.look_at_clock();
        done(block_on(self.sim.turn(&mut self.ports[0])))
    }

    fn turn_of_perception(&mut self) {
        done(block_on(self.perception.turn(&mut self.ports[1])));
    }

    /// What the fallback did at the decision that is due, once its landing is mapped.
    fn due_fallback(&mut self) -> Option<Fallback> {
        let state = self.sim.arbiter().state();
        let mapped = self.perception.cartographer().map().and_then(|map| map.through);
        let due = mapped == Some(state.decision) && !state.status.is_over();
        if due { self.fallbacks.remove(&state.decision) } else { None }
    }

    /// Hands over to the next planners of the schedule if their first decision is due.
    fn relieve(&mut self) -> Result<(), PlannerError> {
        let decision = self.sim.arbiter().state().decision;
        while let Some(next) = self.successors.pop_front_if(|next| next.from <= decision) {
            let mission = self.sim.arbiter().mission();
            let robots = next.robots.of(mission.brief.robots.count());
            let planner = (self.make)(next.planner, mission)?;
            self.lives += 1;
            // Whoever commands other robots too goes on with them.
            self.planners.retain(|hosted| hosted.robots != robots);
            self.planners.push(HostedPlanner::join(&self.bus, self.lives, robots, planner));
        }
        Ok(())
    }
}

fn done(turn: Result<Turn, Failure>) -> Turn {
    turn.unwrap_or_else(|failure| panic!("a process in lockstep fails: {failure}"))
}
