//! What simulated perception does of its own: maps, in patches and pages.

use std::rc::Rc;

use contract::{MapPatch, MonotonicNs};

use super::{Machine, Process, Step, page_cells};
use crate::simulate::message::{Message, Topic};
use crate::simulate::stage::Stage;

impl Process {
    pub(super) fn serve_map(&mut self, stage: &mut Stage<'_>) {
        for message in self.take(Topic::MapAsked) {
            let Message::MapAsked(request, number, client) = message else { continue };
            let Machine::Perception { cartographer } = &self.machine else { continue };
            let Some(mut page) = cartographer.page(&request) else { continue };
            // Shorter than a real page, which holds the whole of these worlds.
            if page.cells.len() > page_cells(stage) {
                page.cells.truncate(page_cells(stage));
                page.next = page.cells.last().map_or(page.from, |cell| cell.index + 1);
            }
            stage.witness.paged(&page);
            stage.coverage.count("snapshot", "page");
            self.answer(client, Message::MapAnswered(Rc::new(page), number), stage);
        }
    }

    pub(super) fn chart(&mut self, event: perception::Event, stage: &mut Stage<'_>) {
        let now = stage.now();
        let Machine::Perception { cartographer } = &mut self.machine else { return };
        let Some(event) = stage.meddler.cartographer_hears(cartographer, event) else { return };
        let mut effects = cartographer.on(event, now);
        stage.meddler.cartographer_wants(cartographer, &mut effects);
        self.deferred.extend(effects.into_iter().map(Step::ForCartographer));
    }

    pub(super) fn for_cartographer(&mut self, effect: perception::Effect, stage: &mut Stage<'_>) {
        match effect {
            perception::Effect::RequestPast(request) => self.ask(request, stage),
            perception::Effect::RequestTruth(request) => self.ask_truth(request, stage),
            perception::Effect::Refused(refusal) => stage.coverage.count("refusal", refusal.reason()),
            perception::Effect::PublishMap => {
                let sensed = stage.now();
                self.steps.push_front(Step::PublishMap(sensed));
                self.steps.push_front(Step::Pass("perception.sensed"));
            }
            perception::Effect::Finished(_) => self.ended = Some(stage.now()),
        }
    }

    pub(super) fn publish_map(&mut self, sensed: MonotonicNs, stage: &mut Stage<'_>) {
        let now = stage.now();
        let Machine::Perception { cartographer } = &mut self.machine else { return };
        self.steps.push_front(Step::Pass("perception.published"));
        for patch in cartographer.patches(sensed, &mut || now).into_iter().rev() {
            self.steps.push_front(Step::Pass("perception.part_published"));
            self.steps.push_front(Step::PublishPart(Box::new(patch)));
        }
    }

    pub(super) fn publish_part(&mut self, mut patch: MapPatch, stage: &mut Stage<'_>) {
        let Machine::Perception { cartographer } = &self.machine else { return };
        let Some(map) = cartographer.map() else { return };
        stage.meddler.cartographer_publishes(&mut patch, map, &stage.witness.mission().terrain);
        stage.witness.mapped(&patch);
        stage.coverage.count("map", if patch.more > 0 { "part" } else { "landing" });
        stage.note(|| {
            let MapPatch { sequence, through, more, .. } = patch;
            format!(
                "perception publishes patch {sequence} through {through}, {} cells, {more} more",
                patch.cells.len()
            )
        });
        stage.publish(self.life, Message::Map(Rc::new(patch)));
    }
}
