//! A bug planted in the guard is found.

use contract::{Action, Origin, Record, Vetoed};
use hopper::simulate::meddler::Meddler;
use hopper_sim::dynamics::{Execution, execute};
use hopper_sim::{Arbiter, Effect, Event, Guard};

use crate::planted::is_found;

/// The guard at the pose of `arbiter`.
fn guard(arbiter: &Arbiter) -> Guard<'_> {
    let mission = arbiter.mission();
    Guard::new(&mission.brief, &mission.terrain, arbiter.state().pose)
}

/// What the guard should veto is executed.
#[derive(Default)]
struct VetoSkipped {
    action: Option<Action>,
}

impl Meddler for VetoSkipped {
    fn arbiter_hears(&mut self, arbiter: &Arbiter, event: Event) -> Option<Event> {
        self.action = None;
        let Event::Command(Ok(command)) = &event else { return Some(event) };
        if guard(arbiter).veto(command.action).is_none() {
            return Some(event);
        }
        self.action = Some(command.action);
        Some(Event::Command(Ok(contract::Command { action: Action::Hold, ..*command })))
    }

    fn arbiter_wants(&mut self, arbiter: &Arbiter, effects: &mut Vec<Effect>) {
        for effect in effects {
            if let (Effect::Append(record), Some(action)) = (effect, self.action) {
                let Execution { outcome, pose, collected, steps, visits, status } =
                    execute(arbiter.mission(), arbiter.state(), action);
                *record = Record { action, outcome, pose, collected, steps, visits, status, ..*record };
                record.digest = record.previous.chain(record);
            }
        }
    }
}

/// What the fallback did is journaled as if a planner had commanded it.
#[derive(Default)]
struct FallbackNotJournaled;

impl Meddler for FallbackNotJournaled {
    fn arbiter_wants(&mut self, _: &Arbiter, effects: &mut Vec<Effect>) {
        for effect in effects {
            if let Effect::Append(record) = effect {
                record.origin = Origin::Planner;
            }
        }
    }
}

/// The fallback acts as soon as it may tick.
#[derive(Default)]
struct DeadlineIgnored;

impl Meddler for DeadlineIgnored {
    fn arbiter_hears(&mut self, arbiter: &Arbiter, event: Event) -> Option<Event> {
        let due = event == Event::Tick && arbiter.state().decision.0 % 5 == 4;
        Some(if due {
            Event::Repeat(guard(arbiter).fallback(arbiter.mission().brief.goal, None))
        } else {
            event
        })
    }
}

/// Nobody is told of a veto.
#[derive(Default)]
struct VetoUntold;

impl Meddler for VetoUntold {
    fn arbiter_wants(&mut self, _: &Arbiter, effects: &mut Vec<Effect>) {
        for effect in effects {
            if let Effect::Publish(state) = effect {
                state.vetoed = Vetoed::NONE;
            }
        }
    }
}

/// Whatever a planner did not want to do is journaled as vetoed.
#[derive(Default)]
struct SafeActionVetoed;

impl Meddler for SafeActionVetoed {
    fn arbiter_wants(&mut self, _: &Arbiter, effects: &mut Vec<Effect>) {
        for effect in effects {
            if let Effect::Append(record) = effect {
                record.vetoed = record.vetoed.with(Action::Hold);
            }
        }
    }
}

/// P-GUARD-PLANTED.
#[test]
fn a_skipped_veto_is_found() {
    is_found::<VetoSkipped>();
}

#[test]
fn a_fallback_that_is_not_journaled_is_found() {
    is_found::<FallbackNotJournaled>();
}

#[test]
fn a_fallback_before_its_deadline_is_found() {
    is_found::<DeadlineIgnored>();
}

#[test]
fn a_veto_that_nobody_is_told_of_is_found() {
    is_found::<VetoUntold>();
}

#[test]
fn a_veto_of_what_is_safe_is_found() {
    is_found::<SafeActionVetoed>();
}
