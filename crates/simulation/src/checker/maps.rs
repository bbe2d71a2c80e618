//! What is seen, mapped and planned on.

use contract::{Cell, Decision, Digest, Ground, MapPage, MapPatch, PastPage, RunId, SeenCell};
use planner::Situation;

use super::Checker;

impl Checker {
    /// hopper-sim answers for the past.
    pub fn served(&mut self, page: &PastPage) {
        let from = page.from.0 as usize;
        let held = self.records.get(from..from + page.records.len());
        // Whoever saw a journal that is gone asks beyond the end of this one.
        let is_beyond = page.records.is_empty() && from >= self.records.len();
        let right = page.run == self.mission.brief.run && (is_beyond || held == Some(&page.records[..]));
        self.require(right, "nothing is published that the journal does not hold", || {
            format!("the past from decision {from} is not that of the journal")
        });
        let landed = self.pacing.published;
        let in_the_air = page.records.iter().find(|record| landed.is_some_and(|due| record.decision >= due));
        self.require(in_the_air.is_none(), "the past holds landed hops only", || {
            format!("decision {:?} was served before it landed", in_the_air.map(|record| record.decision))
        });
    }

    /// perception publishes a patch.
    pub fn mapped(&mut self, patch: &MapPatch) {
        let MapPatch { run, through, digest, more, after, .. } = *patch;
        self.told(run, through, &patch.cells, &patch.treasures);
        if more == 0 {
            self.right(through, digest, after);
            self.mapped = Some((run, through));
        }
        let record = through.0.checked_sub(1).and_then(|index| self.records.get(index as usize));
        // Another past's patches, and the starts', name whom they like.
        let Some(actor) = record.filter(|record| record.digest == digest).map(|record| record.robot) else {
            return;
        };
        let named = patch.robot;
        self.require(
            run != self.mission.brief.run || named == actor,
            "a patch names the robot that sensed",
            || format!("the patch through decision {through} names robot {named}, robot {actor} acted"),
        );
    }

    /// perception answers for the map.
    pub fn paged(&mut self, page: &MapPage) {
        self.told(page.run, page.through, &page.cells, &page.treasures);
        self.right(page.through, page.digest, page.observation);
    }

    fn told(&mut self, run: RunId, through: Decision, cells: &[SeenCell], treasures: &[Cell]) {
        if run != self.mission.brief.run {
            return;
        }
        let grid = self.mission.brief.grid;
        let treasures = treasures.iter().filter_map(|cell| grid.index(*cell));
        let mut told: Vec<usize> = cells.iter().map(|cell| cell.index as usize).collect();
        told.extend(treasures);
        let unseen = told.into_iter().find(|&index| !self.maps.visible[index]);
        self.require(unseen.is_none(), "the planner never knows an unseen cell", || {
            format!("cell {unseen:?} is on the map through decision {through}")
        });
    }

    fn right(&mut self, through: Decision, digest: Digest, observation: u64) {
        let right = self.maps.prints.get(&digest) == Some(&observation);
        self.require(right, "the map is that of the poses so far", || {
            format!("the map through decision {through}, digest {digest}, is another")
        });
    }

    /// A planner is about to plan for `situation`.
    pub fn plans(&mut self, situation: &Situation<'_>) {
        let state = situation.state;
        let closed = self.model.closed(situation);
        let is_own = self.maps.prints.get(&state.digest) == Some(&situation.map.observation());
        let covered = (is_own || !closed.is_empty())
            && situation.map.through == Some(state.decision)
            && situation.brief.run == state.run;
        self.require(covered, "nobody decides before the map covers the decision", || {
            format!("at decision {} the map goes through {:?}", state.decision, situation.map.through)
        });
        let is_right = self.maps.contents.get(&state.digest).is_some_and(|(cells, treasures)| {
            let cells = cells.iter().enumerate().map(|(index, cell)| {
                cell.map(|ground| Ground { passable: ground.passable && !closed.contains(&index), ..ground })
            });
            cells.eq(situation.map.cells().iter().copied()) && treasures == situation.map.treasures()
        });
        self.require(is_right, "every plan is made on the map of its own past", || {
            format!("at decision {} a cell or a treasure of the map is another", state.decision)
        });
        self.plans_with_robots(situation);
        self.sees(situation);
    }

    /// Whether anything had been seen two decisions before `due`, of which a map may not tell yet.
    pub(crate) fn had_seen(&self, due: Option<Decision>) -> bool {
        let before = Decision(due.unwrap_or_default().0.saturating_sub(2));
        self.state_at(before)
            .and_then(|state| self.maps.prints.get(&state.digest))
            .is_some_and(|print| *print != 0)
    }

    /// The number of cells in view from each pose.
    pub(crate) fn disc_cells(&self) -> &[usize] {
        &self.maps.expected.disc_cells
    }

    /// Treasures that are known and not collected.
    pub(crate) fn treasures_known(&self) -> usize {
        self.maps.expected.treasures().len()
    }
}
