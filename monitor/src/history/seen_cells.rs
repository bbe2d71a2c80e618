//! The cells of the observed map in the order they were first seen.

use contract::mission::sensor::View;
use contract::{Brief, Cell, Decision, DriveSpeed, Grid, ObservedMap, RobotId, Soil};
use report::Layer;

use super::Hops;
use super::layers::{GroundLayer, of_ground};

/// Value of [`Seen::at`] for a cell whose first sight is not determined yet.
const PENDING: u32 = u32::MAX - 1;

/// Value of [`Seen::at`] for a cell that was not seen.
const UNSEEN: u32 = u32::MAX;

/// One seen cell with the fields that are displayed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Seen {
    /// Height above the datum, metres.
    pub height_m: f32,
    /// Whether it is sand.
    pub sand: bool,
    /// Whether a hopper survives landing there.
    pub passable: bool,
    /// How fast a rover drives there, where speeds are uncertain and it was seen.
    pub speed: Option<DriveSpeed>,
    /// What a camera that errs read for the speed, as long as nobody saw it.
    pub reading: Option<DriveSpeed>,
    /// Decision that was due when it was first seen.
    pub at: u32,
}

/// Every cell with the decision that was due when it was first seen.
#[derive(Clone, Debug)]
pub struct SeenCells {
    brief: Brief,
    grid: Grid,
    cells: Vec<Seen>,
    /// Layers with values of seen ground.
    layers: Vec<GroundLayer>,
    /// Their values: for each cell one of each layer.
    values: Vec<f64>,
    /// Indices of cells in the order they were seen or updated.
    log: Vec<u32>,
    /// Number of times the log was compacted, which invalidates positions.
    revision: u64,
    /// Fingerprint of the map that was added last, and the decision it covers.
    learnt: Option<(u64, u64)>,
    treasures: Vec<Cell>,
    seen: usize,
    /// Lowest and highest seen so far, metres.
    heights_m: Option<(f32, f32)>,
}

impl SeenCells {
    /// No cell of the brief's grid seen yet.
    #[must_use]
    pub fn new(brief: &Brief) -> Self {
        let unseen =
            Seen { height_m: 0.0, sand: false, passable: true, speed: None, reading: None, at: UNSEEN };
        let layers = of_ground(brief);
        Self {
            brief: brief.clone(),
            grid: brief.grid,
            cells: vec![unseen; brief.grid.cells()],
            values: vec![0.0; layers.len() * brief.grid.cells()],
            layers,
            log: Vec::new(),
            revision: 0,
            learnt: None,
            treasures: Vec::new(),
            seen: 0,
            heights_m: None,
        }
    }

    /// Lowest and highest ground seen so far, metres above the datum; `None` before the first.
    #[must_use]
    pub fn heights_m(&self) -> Option<(f32, f32)> {
        self.heights_m
    }

    /// The cell at `index`; `None` if it was not seen.
    #[must_use]
    pub fn get(&self, index: usize) -> Option<&Seen> {
        self.cells.get(index).filter(|seen| seen.at != UNSEEN)
    }

    /// What a layer with values of seen ground shows of the cell at `index`; `None` if the mission has no such layer.
    #[must_use]
    pub fn value(&self, layer: Layer, index: usize) -> Option<f64> {
        let column = self.layers.iter().position(|known| known.layer == layer)?;
        self.values.get(index * self.layers.len() + column).copied()
    }

    /// The layers with values of seen ground.
    pub(super) fn layers(&self) -> &[GroundLayer] {
        &self.layers
    }

    /// Number of cells seen so far.
    #[must_use]
    pub fn seen(&self) -> usize {
        self.seen
    }

    /// Number of cells seen by the time `decision` was due.
    #[must_use]
    pub fn seen_by(&self, decision: Decision) -> usize {
        self.cells.iter().filter(|seen| u64::from(seen.at) <= decision.0).count()
    }

    /// Treasures seen and not yet collected.
    #[must_use]
    pub fn treasures(&self) -> &[Cell] {
        &self.treasures
    }

    /// The log from `position` on, with the revision that positions refer to.
    pub(super) fn log(&self, position: usize) -> (u64, &[u32]) {
        (self.revision, &self.log[position.min(self.log.len())..])
    }

    /// Adds what is new in `map`. The hops must be known up to the decision that the map covers.
    ///
    /// A cell counts as seen from the first pose from which its robot's sensor reaches it, so a history that starts late equals
    /// one from the start.
    pub fn learn(&mut self, map: &ObservedMap, hops: &Hops) {
        let Some(through) = map.through else { return };
        let observation = map.observation();
        self.treasures.clear();
        self.treasures.extend_from_slice(map.treasures());
        if self.learnt.is_some_and(|(learnt, _)| learnt == observation) {
            self.learnt = Some((observation, through.0));
            return;
        }
        let mut fresh = 0;
        let since = self.learnt.and_then(|(learnt, _)| map.changed_since(learnt));
        match since {
            Some(changed) => changed.iter().for_each(|&index| fresh += self.note(map, index as usize)),
            None => (0..map.cells().len()).for_each(|index| fresh += self.note(map, index)),
        }
        let from = self.learnt.map_or(0, |(_, through)| through);
        self.learnt = Some((observation, through.0));
        self.date(hops, from, through.0, fresh);
        if self.log.len() > 4 * self.cells.len() {
            self.log =
                (0..self.cells.len() as u32).filter(|&i| self.cells[i as usize].at != UNSEEN).collect();
            self.revision += 1;
        }
    }

    /// Copies a cell from the map; 1 if it is seen for the first time, else 0.
    fn note(&mut self, map: &ObservedMap, index: usize) -> usize {
        let Some(ground) = map.cells()[index] else { return 0 };
        let known = self.cells[index];
        let sand = ground.soil == Soil::Sand;
        let height_m = ground.height_m as f32;
        let (low, high) = self.heights_m.unwrap_or((height_m, height_m));
        self.heights_m = Some((low.min(height_m), high.max(height_m)));
        let contract::Ground { passable, speed, reading, .. } = ground;
        let now = Seen { height_m, sand, passable, speed, reading, at: known.at };
        let mut has_new_value = false;
        let values = self.values.chunks_mut(self.layers.len().max(1)).nth(index).unwrap_or_default();
        for (value, layer) in values.iter_mut().zip(&self.layers) {
            let new = (layer.of)(&ground, map.visits(index));
            has_new_value |= *value != new;
            *value = new;
        }
        if known.at == UNSEEN {
            self.cells[index] = Seen { at: PENDING, ..now };
            self.seen += 1;
            // It is logged once its first sight is determined.
            return 1;
        }
        if now != known || has_new_value {
            self.cells[index] = now;
            if known.at != PENDING {
                self.log.push(index as u32);
            }
        }
        0
    }

    /// Determines from which pose each of `pending` new cells was seen first.
    fn date(&mut self, hops: &Hops, from: u64, through: u64, mut pending: usize) {
        for decision in from.max(hops.first().0)..=through {
            if pending == 0 {
                return;
            }
            let Some((robot, cell, height_m)) = self.pose(hops, decision) else { continue };
            let Some(view) = self.view(robot, height_m) else { continue };
            for at in view.cells(self.grid, cell) {
                pending -= usize::from(self.stamp(at, decision));
            }
        }
        if pending > 0 {
            for index in 0..self.cells.len() {
                self.stamp(self.grid.cell(index), through);
            }
        }
    }

    /// Sets the first sight of a pending cell; whether it was pending.
    fn stamp(&mut self, cell: Cell, decision: u64) -> bool {
        let Some(index) = self.grid.index(cell).filter(|&index| self.cells[index].at == PENDING) else {
            return false;
        };
        self.cells[index].at = decision.min(u64::from(PENDING - 1)) as u32;
        self.log.push(index as u32);
        true
    }

    /// What a robot sees around it from a height: of one that sees along its way, as far as its camera reaches. What it saw on its way
    /// between two poses is known only from the map.
    fn view(&self, robot: RobotId, height_m: f64) -> Option<View> {
        let sensor = self.brief.robots.at(robot)?.sensor;
        let along_way = View::disc(sensor.view_m().unwrap_or_default() / self.grid.cell_size_m);
        Some(sensor.around(&self.grid, height_m).unwrap_or(along_way))
    }

    /// Number, cell and height of the robot that acted last when a decision was due; `None` if not known.
    fn pose(&self, hops: &Hops, decision: u64) -> Option<(RobotId, Cell, f64)> {
        let Some(before) = decision.checked_sub(1) else {
            let start = self.brief.robots[0].start.cell;
            let height_m = self.cells[self.grid.index(start)?].height_m;
            return Some((RobotId(0), start, f64::from(height_m)));
        };
        let hop = hops.get(Decision(before))?;
        self.grid.contains(hop.to).then_some((hop.robot, hop.to, hop.height_m))
    }
}
