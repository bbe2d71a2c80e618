//! What a simulated monitor does of its own: it watches.

use super::{Machine, Process, Step};
use crate::simulate::stage::Stage;

impl Process {
    pub(super) fn watch(&mut self, event: monitor::Event, stage: &mut Stage<'_>) {
        let now = stage.now();
        let Machine::Monitor { watcher } = &mut self.machine else { return };
        let Some(event) = stage.meddler.watcher_hears(watcher, event) else { return };
        let effects = watcher.on(event, now);
        if let Some(tally) = watcher.tally() {
            stage.witness.watched(tally, watcher.seen().0);
        }
        self.steps.extend(effects.into_iter().map(Step::ForWatcher));
    }

    pub(super) fn for_watcher(&mut self, effect: monitor::Effect, stage: &mut Stage<'_>) {
        match effect {
            monitor::Effect::RequestPast(request) => self.ask(request, stage),
            monitor::Effect::Progress(_) => {}
            monitor::Effect::Finished(_) => self.ended = Some(stage.now()),
        }
    }
}
