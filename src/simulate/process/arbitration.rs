//! What simulated hopper-sim does of its own: arbitration, commits, answers about past and truth.

use std::rc::Rc;

use contract::{Origin, Record};
use hopper_sim::crash;

use super::{Machine, Process, Step, Turned, page_cells};
use crate::simulate::message::{Message, Topic};
use crate::simulate::stage::Stage;

impl Process {
    pub(super) fn announce(&mut self, stage: &mut Stage<'_>) {
        let brief = Rc::new(stage.witness.mission().brief);
        stage.publish(self.life, Message::Brief(brief));
    }

    pub(super) fn arbitrate(&mut self, event: hopper_sim::Event, stage: &mut Stage<'_>) {
        let now = stage.now();
        let Machine::Sim { arbiter, .. } = &mut self.machine else { return };
        let Some(event) = stage.meddler.arbiter_hears(arbiter, event) else { return };
        let mut effects = arbiter.on(event, now);
        stage.meddler.arbiter_wants(arbiter, &mut effects);
        self.steps.extend(effects.into_iter().map(Step::ForArbiter));
    }

    pub(super) fn for_arbiter(&mut self, effect: hopper_sim::Effect, stage: &mut Stage<'_>) {
        match effect {
            hopper_sim::Effect::Append(record) => {
                self.steps.push_front(Step::Commit(Box::new(record)));
                self.steps.push_front(Step::Pass(crash::BEFORE_APPEND));
            }
            hopper_sim::Effect::Announce => {
                stage.coverage.count("run", "announced_again");
                stage.note(|| "hopper-sim tells of the run again".into());
                self.announce(stage);
            }
            hopper_sim::Effect::Publish(state) => {
                stage.witness.published(&state);
                stage.note(|| format!("hopper-sim publishes state {} ({})", state.decision, state.status));
                stage.publish(self.life, Message::State(Rc::new(state)));
                self.steps.push_front(Step::Pass(crash::PUBLISHED));
            }
            hopper_sim::Effect::Refused(refusal) => {
                stage.coverage.count("refusal", refusal.reason());
                stage.note(|| format!("hopper-sim refuses: {refusal}"));
            }
            hopper_sim::Effect::Finished(status) => {
                let due = stage.witness.status();
                if status != due {
                    stage.witness.accuse("the end is that of the journal", || format!("{status}, not {due}"));
                }
                let Machine::Sim { finished, .. } = &mut self.machine else { return };
                *finished = Some(status);
            }
        }
    }

    /// The commit point.
    pub(super) fn commit(&mut self, record: &Record, stage: &mut Stage<'_>) -> Turned {
        let Machine::Sim { journal, .. } = &mut self.machine else { return Turned::Done };
        let written = if stage.meddler.commits(record) { journal.append(record) } else { Ok(()) };
        if stage.disk.take_torn() {
            stage.coverage.count("journal", "killed_writing");
            stage.note(|| format!("hopper-sim dies writing decision {}", record.decision));
            return Turned::Died(stage.torn_restart_ns);
        }
        match written {
            Ok(()) => {
                if journal.last() == Some(record) {
                    stage.witness.committed(record);
                }
                stage.decisions += 1;
                stage.stirred_ns = stage.stirred_ns.max(stage.time_ns);
                let leader = record.leader;
                if record.origin.is_fallback() {
                    stage.coverage.count("fallback", record.origin.as_str());
                }
                stage.note(|| {
                    let Record { decision, action, origin, .. } = record;
                    match origin {
                        Origin::Planner => format!(
                            "committed: decision {decision}, {action}, by {} in term {}",
                            leader.planner, leader.term
                        ),
                        _ => format!("committed: decision {decision}, {action}, by the fallback ({origin})"),
                    }
                });
                self.steps.push_front(Step::Arbiter(hopper_sim::Event::Appended));
                self.steps.push_front(Step::Pass(crash::APPENDED));
            }
            Err(error) => {
                stage.coverage.count("journal", "append_failed");
                stage.note(|| format!("holding at decision {}: {error}", record.decision));
                self.steps.push_front(Step::Arbiter(hopper_sim::Event::AppendFailed));
            }
        }
        Turned::Done
    }

    pub(super) fn serve(&mut self, stage: &mut Stage<'_>) {
        for message in self.take(Topic::Asked) {
            let Message::Asked(request, number, client) = message else { continue };
            let Machine::Sim { journal, arbiter, .. } = &self.machine else { continue };
            if request.run != journal.header().run() {
                continue;
            }
            let Ok(mut page) = journal.page(request.from) else { continue };
            let due = arbiter.state().decision;
            page.records.truncate(stage.setup.page_records);
            page.records.retain(|record| record.decision < due);
            stage.witness.served(&page);
            stage.coverage.count("past", "page");
            self.answer(client, Message::Answered(Rc::new(page), number), stage);
        }
    }

    pub(super) fn serve_truth(&mut self, stage: &mut Stage<'_>) {
        for message in self.take(Topic::TruthAsked) {
            let Message::TruthAsked(request, number, client) = message else { continue };
            let Machine::Sim { arbiter, .. } = &self.machine else { continue };
            let Some(page) = arbiter.mission().truth_page(&request, page_cells(stage)) else { continue };
            stage.coverage.count("truth", "page");
            self.answer(client, Message::TruthAnswered(Rc::new(page), number), stage);
        }
    }
}
