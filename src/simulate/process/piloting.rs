//! What a simulated planner does of its own: plans, commands, policies.

use std::rc::Rc;

use contract::{Command, Leader, Policy};
use planner::Budget;

use super::{Machine, Process, Step, Turned, pid_of};
use crate::simulate::message::Message;
use crate::simulate::stage::{Happening, MS, Stage};

impl Process {
    pub(super) fn fly(&mut self, event: planner::pilot::Event, stage: &mut Stage<'_>) {
        let now = stage.now();
        let Machine::Planner { pilot, blind, .. } = &mut self.machine else { return };
        if matches!(event, planner::pilot::Event::Tick) {
            // The shell asks the operating system before it ticks.
            let exists = |pid| stage.readers.iter().any(|reader| pid_of(reader.life) == pid);
            if let Some(gone) = pilot.rival_pid().filter(|&pid| *blind || !exists(pid)) {
                let effects = pilot.on(planner::pilot::Event::Gone(gone), now);
                self.deferred.extend(effects.into_iter().map(Step::ForPilot));
            }
        }
        let Some(event) = stage.meddler.pilot_hears(pilot, self.life, event) else { return };
        let mut effects = pilot.on(event, now);
        stage.meddler.pilot_wants(pilot, self.life, &mut effects);
        let queue = if self.executing { &mut self.steps } else { &mut self.deferred };
        queue.extend(effects.into_iter().map(Step::ForPilot));
    }

    pub(super) fn for_pilot(&mut self, effect: planner::pilot::Effect, stage: &mut Stage<'_>) -> Turned {
        let now = stage.now();
        let life = self.life;
        let Machine::Planner { pilot, commission, planner, .. } = &mut self.machine else {
            return Turned::Done;
        };
        match effect {
            planner::pilot::Effect::RequestMap(request) => self.ask_map(request, stage),
            planner::pilot::Effect::Plan => {
                let Some(situation) = pilot.situation().filter(|_| pilot.awaits_plan()) else {
                    return Turned::Done;
                };
                stage.witness.plans(&situation);
                let plan = planner.plan(&situation, &Budget::default());
                let slow = stage.chance.one_in(60);
                let ns = if slow {
                    stage.chance.duration_ns(MS, 1500 * MS)
                } else {
                    stage.chance.between(10_000, 900_000)
                };
                self.planning = Some((plan, now));
                stage.schedule(stage.time_ns + ns, Happening::Planned(self.slot, life));
                return Turned::Pending;
            }
            planner::pilot::Effect::Send(command) => {
                let leader = pilot.situation().map_or(Leader::default(), |situation| situation.state.leader);
                let sent = stage.monotonic();
                if let Some(cause) = stage.witness.sent(&command, commission, leader, sent) {
                    stage.coverage.count("takeover_asked", cause);
                }
                stage.note(|| {
                    let Command { decision, action, term, planner, .. } = command;
                    format!("{planner} {life} sends decision {decision}, {action}, term {term}")
                });
                stage.commanded = Some(command);
                // Policies are published for listeners alone, and hopper-sim listens where it may fall back.
                let listened = pilot.situation().filter(|now| now.brief.guard.deadline_ns > 0);
                if let Some((situation, cells)) = listened.zip(planner.policy()) {
                    let Command { run, robot, decision, planner, .. } = command;
                    debug_assert_eq!(situation.state.decision, decision);
                    let policy = Policy { run, robot, decision, planner, error_bound: 0.0, cells };
                    self.steps.push_front(Step::PublishPolicy(Box::new(policy)));
                }
                stage.publish(life, Message::Command(Rc::new(Ok(command))));
                self.steps.push_front(Step::Pass("planner.sent"));
            }
            planner::pilot::Effect::Leads(term) => {
                stage.coverage.count("pilot", "leads");
                stage.note(|| format!("{life} commands, term {term}"));
            }
            planner::pilot::Effect::StepsBack(term) => {
                stage.coverage.count("pilot", "steps_back");
                stage.note(|| format!("{life} steps back, term {term}"));
            }
            planner::pilot::Effect::StandsBy(_) => stage.coverage.count("pilot", "stands_by"),
            planner::pilot::Effect::Finished(_) => self.ended = Some(now),
        }
        Turned::Done
    }
}
