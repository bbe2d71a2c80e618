//! A reader's copy of the observed map, folded from patches.
//!
//! A patch is applied only if it goes on from exactly what the replica holds, and its cells make exactly
//! what it says they make, by fingerprint; so a replica that follows the chain holds the whole map, and
//! [`Replica::map`] shows nothing else. Where the chain does not fit, because the reader has just come, has
//! missed a patch, or perception has begun anew, it catches up: patches are buffered, the map is asked for
//! page by page, and what a page holds already is dropped from the buffer.
//!
//! Pages are applied to the map in place. They tell of different moments when the map grows meanwhile, so
//! the patches published between two pages are folded in between them, in the order of the stream; **give a
//! replica all patches that were there when a page was received before you give it the page.** If the
//! fingerprint is that of the page, at the end or before, the map is whole. If at the end it is not
//! (a patch was lost in between, or something here is wrong), the next attempt begins from an empty map.

use std::collections::VecDeque;

use contract::limits::PATCHES_BUFFERED;
use contract::{
    Brief, Cell, Grid, MapPage, MapPatch, MapRequest, MonotonicNs, ObservedMap, Refusal, RefusalCounts,
    RobotId, RunId, SeenCell,
};

use crate::page_cursor::PageCursor;

/// The folded map of a mission.
#[derive(Clone, Debug)]
pub struct Replica {
    robot: RobotId,
    /// Robots of the mission, whose sensors patches may come from.
    robots: u16,
    map: Option<ObservedMap>,
    /// How the map is caught up with, unless it is whole.
    pursuit: Option<Pursuit>,
    /// Patches kept for later while the map is not whole, in the order of the stream.
    buffer: VecDeque<MapPatch>,
    refusals: RefusalCounts,
}

/// How far catching up has come.
#[derive(Clone, Copy, Debug, Default)]
struct Pursuit {
    cursor: PageCursor,
    /// The last patch that the last page held.
    sequence: Option<u64>,
}

impl Replica {
    /// A replica that knows nothing, not even the run.
    #[must_use]
    pub fn new(robot: RobotId) -> Self {
        let (buffer, refusals) = (VecDeque::new(), RefusalCounts::default());
        Self { robot, robots: 1, map: None, pursuit: None, buffer, refusals }
    }

    /// Begins with an empty map of the brief's run; the same run again changes nothing.
    pub fn begin(&mut self, brief: &Brief) {
        let (run, grid) = (brief.run, brief.grid);
        self.robots = brief.robots.count();
        if self.map.as_ref().is_some_and(|map| map.run == run && map.grid == grid) {
            return;
        }
        self.map = Some(ObservedMap::unseen(run, self.robot, grid));
        self.pursuit = Some(Pursuit::default());
        self.buffer.clear();
    }

    /// Drops the map, and asks for all of it again: it may be that of hops which a journal has lost.
    pub fn begin_anew(&mut self) {
        if let Some(map) = &mut self.map {
            *map = ObservedMap::unseen(map.run, map.robot, map.grid);
            self.pursuit = Some(Pursuit::default());
            self.buffer.clear();
        }
    }

    /// The whole map; `None` while some of it may be missing.
    #[must_use]
    #[inline]
    pub fn map(&self) -> Option<&ObservedMap> {
        if self.pursuit.is_some() {
            return None;
        }
        self.map.as_ref()
    }

    /// Messages refused, by reason.
    #[must_use]
    pub fn refusals(&self) -> &RefusalCounts {
        &self.refusals
    }

    /// Counts a message that was malformed.
    pub fn refuse(&mut self, refusal: &Refusal) {
        self.refusals.count(refusal);
    }

    /// Takes a patch; what is to be asked for, if it does not fit.
    pub fn patch(&mut self, patch: MapPatch, now: MonotonicNs) -> Option<MapRequest> {
        if let Err(refusal) = check(self.map.as_ref()?, patch.run, patch.robot, self.robots, patch.grid) {
            self.refusals.count(&refusal);
            return None;
        }
        self.drop_void(&patch);
        let map = self.map.as_mut()?;
        // While pages are being applied the map is none that anybody ever had.
        let untouched = self.pursuit.is_none_or(|pursuit| pursuit.sequence.is_none());
        if untouched && repeats(map, &patch) {
            return self.ask(now);
        }
        if untouched && follows(map, &patch) {
            match map.apply(&patch) {
                Ok(()) => {
                    self.follow_buffer();
                    // Whatever is newer than that shows that something is missing.
                    if self.buffer.is_empty() {
                        self.pursuit = None;
                    }
                    return self.ask(now);
                }
                Err(refusal) => self.refusals.count(&refusal),
            }
        } else {
            let place = self.buffer.partition_point(|kept| kept.sequence <= patch.sequence);
            self.buffer.insert(place, patch);
            if self.buffer.len() > PATCHES_BUFFERED {
                self.buffer.pop_front();
            }
        }
        self.pursuit.get_or_insert_default();
        self.ask(now)
    }

    /// Takes a page that was asked for; what is to be asked for next, if anything.
    pub fn page(&mut self, page: &MapPage, now: MonotonicNs) -> Option<MapRequest> {
        let map = self.map.as_mut()?;
        if let Err(refusal) = check(map, page.run, page.robot, 1, page.grid) {
            self.refusals.count(&refusal);
            return None;
        }
        // An answer to another request is one that was given up.
        let pursuit =
            self.pursuit.as_mut().filter(|pursuit| pursuit.cursor.next() == u64::from(page.from))?;
        // What was published up to the last page is in it, or was folded in before.
        let held = pursuit.sequence.unwrap_or(page.sequence);
        let told = self.buffer.partition_point(|patch| patch.sequence <= page.sequence);
        for patch in self.buffer.drain(..told).filter(|patch| patch.sequence > held) {
            learn_all(map, &patch.cells, &patch.treasures);
        }
        learn_all(map, &page.cells, &page.treasures);
        if map.observation() == page.observation {
            (map.through, map.digest, map.sequence) = (Some(page.through), page.digest, page.sequence);
            (map.sensed, map.published) = (page.sensed, page.published);
            map.mark();
            self.pursuit = None;
            self.follow_buffer();
            // What does not fit then is dropped: if it was missed indeed, the next patch or reminder tells.
            self.buffer.clear();
            return None;
        }
        pursuit.cursor.accept(page.from.into(), page.next.into());
        pursuit.sequence = Some(page.sequence);
        if page.next <= page.from || page.next as usize >= page.grid.cells() {
            let need = format!("a map of fingerprint {:016x}", page.observation);
            let got = format!("{:016x}", map.observation());
            self.refusals.count(&Refusal::malformed("map.observation", &need, got));
            *map = ObservedMap::unseen(map.run, map.robot, map.grid);
            self.buffer.clear();
            // Asked for again at a later tick, not at once.
            pursuit.cursor.restart(now);
            pursuit.sequence = None;
        }
        self.ask(now)
    }

    /// What is to be asked for at `now`, if something is missing and nothing was asked for just now.
    pub fn ask(&mut self, now: MonotonicNs) -> Option<MapRequest> {
        let (map, pursuit) = (self.map.as_ref()?, self.pursuit.as_mut()?);
        let from = pursuit.cursor.ask(now)? as u32;
        Some(MapRequest { run: map.run, robot: map.robot, from, observation: map.observation() })
    }

    /// Drops what a patch shows to be void: those kept for later that have a higher number, or the same, and
    /// were published before it. They tell of hops that a journal has lost with its tail.
    fn drop_void(&mut self, patch: &MapPatch) {
        let again = |kept: &MapPatch| kept.sequence == patch.sequence && !is_reminder(patch);
        let overtaken = |kept: &MapPatch| kept.sequence > patch.sequence || again(kept);
        self.buffer.retain(|kept| kept.published >= patch.published || !overtaken(kept));
    }

    /// Goes on with what was kept for later, as far as it fits, and drops what is older than that.
    fn follow_buffer(&mut self) {
        let Some(map) = &mut self.map else { return };
        while let Some(patch) = self.buffer.pop_front_if(|patch| patch.sequence <= map.sequence + 1) {
            if follows(map, &patch)
                && let Err(refusal) = map.apply(&patch)
            {
                self.refusals.count(&refusal);
            }
        }
    }
}

/// Whether a message is about this map, and of one of so many robots from the map's own on.
fn check(map: &ObservedMap, run: RunId, robot: RobotId, robots: u16, grid: Grid) -> Result<(), Refusal> {
    if run != map.run {
        return Err(Refusal::WrongRun { need: map.run, got: run });
    }
    let own = map.robot.0..map.robot.0.saturating_add(robots);
    if !own.contains(&robot.0) {
        return Err(Refusal::malformed("map.robot", &map.robot.to_string(), robot));
    }
    if grid != map.grid {
        return Err(Refusal::malformed("map.grid", "the brief's", format!("{grid:?}")));
    }
    Ok(())
}

/// Whether the patch changes nothing, and only tells which was the last.
fn is_reminder(patch: &MapPatch) -> bool {
    patch.cells.is_empty() && patch.after == patch.before
}

/// Whether the patch goes on from exactly this map.
fn follows(map: &ObservedMap, patch: &MapPatch) -> bool {
    let reminder = is_reminder(patch);
    let next = patch.sequence == map.sequence + 1 || (reminder && patch.sequence == map.sequence);
    next && patch.before == map.observation()
}

/// Whether the patch is the one that made this map, heard once more.
fn repeats(map: &ObservedMap, patch: &MapPatch) -> bool {
    patch.sequence == map.sequence && patch.after == map.observation() && patch.after != patch.before
}

fn learn_all(map: &mut ObservedMap, cells: &[SeenCell], treasures: &[Cell]) {
    for cell in cells {
        map.learn_visited(cell.index as usize, cell.ground, cell.visits);
    }
    map.set_treasures(treasures);
}
