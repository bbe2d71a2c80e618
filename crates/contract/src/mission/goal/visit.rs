//! The goal of a hopper that visits cells in turn, without end but for a count of hops.

use serde::{Deserialize, Serialize};

use super::GoalKind;
use crate::block::Block;
use crate::codec::whole;
use crate::limits::{DECISIONS_MAX, GOALS_MAX};
use crate::mission::kind::Kind;
use crate::{Cell, Grid};

/// Goals to be visited in turn, from the last to the first again.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(try_from = "VisitAsWritten")]
pub struct Visit {
    /// The goals, the first `count` of them.
    cells: [Cell; GOALS_MAX],
    count: u32,
    /// Decisions after which it is done.
    pub hops_max: u64,
}

impl Visit {
    /// Visits of `goals`; `None` unless there are 2 to [`GOALS_MAX`], each another than the one before it,
    /// and at least one hop.
    #[must_use]
    pub fn new(goals: &[Cell], hops_max: u64) -> Option<Self> {
        let differ = goals.iter().zip(goals.iter().cycle().skip(1)).all(|(goal, next)| goal != next);
        if !(2..=GOALS_MAX).contains(&goals.len()) || !differ || hops_max == 0 {
            return None;
        }
        let mut cells = [Cell::default(); GOALS_MAX];
        cells[..goals.len()].copy_from_slice(goals);
        Some(Self { cells, count: goals.len() as u32, hops_max })
    }

    /// The goals in order.
    #[must_use]
    pub fn goals(&self) -> &[Cell] {
        &self.cells[..self.count as usize]
    }

    /// The goal in force after so many visits.
    #[must_use]
    pub fn goal(&self, visits: u64) -> Cell {
        self.cells[(visits % u64::from(self.count)) as usize]
    }
}

impl Default for Visit {
    /// No goals: before it is read.
    fn default() -> Self {
        Self { cells: [Cell::default(); GOALS_MAX], count: 2, hops_max: 1 }
    }
}

impl Kind for Visit {
    const NAME: &'static str = "visit";

    fn parameters(&mut self, block: &mut Block<'_>) {
        block.whole(
            "hops_max",
            "Decisions after which it is done.",
            whole(1, DECISIONS_MAX),
            &mut self.hops_max,
        );
        block.whole("count", "How many goals there are.", whole(2, GOALS_MAX as u64), &mut self.count);
        block.cell(
            "goals",
            "Goals (x, y), cells, each another than the one before; the rest zero.",
            &mut self.cells[0],
        );
        for goal in &mut self.cells[1..] {
            block.further_cell("goals", goal);
        }
        let is_sound = Visit::new(self.goals(), self.hops_max).is_some_and(|sound| sound == *self);
        block.check("goals", is_sound, "each another than the one before, the rest zero", self.count);
    }
}

impl GoalKind for Visit {
    fn cell(&self, _: &Grid, visits: u64) -> Option<Cell> {
        Some(self.goal(visits))
    }

    fn is_place(&self) -> bool {
        true
    }

    fn cells(&self, _: &Grid) -> Vec<Cell> {
        self.goals().to_vec()
    }
}

/// The fields of a [`Visit`] as read, not yet checked.
#[derive(Deserialize)]
struct VisitAsWritten {
    cells: [Cell; GOALS_MAX],
    count: u32,
    hops_max: u64,
}

impl TryFrom<VisitAsWritten> for Visit {
    type Error = String;

    fn try_from(VisitAsWritten { cells, count, hops_max }: VisitAsWritten) -> Result<Self, String> {
        let goals = cells.get(..count as usize);
        goals.and_then(|goals| Visit::new(goals, hops_max)).ok_or_else(|| {
            format!(
                "visits in turn need 2 to {GOALS_MAX} goals, each another than the one before, and a hop, got {count} goals and {hops_max} \
                 hops"
            )
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn goals_come_in_turn_from_the_last_to_the_first_again() {
        let goals = [Cell::new(1, 1), Cell::new(5, 2), Cell::new(0, 3)];
        let visit = Visit::new(&goals, 10).unwrap();
        assert_eq!(visit.goals(), goals);
        assert_eq!(
            [0, 1, 2, 3, 3_000_000].map(|visits| visit.goal(visits)),
            [goals[0], goals[1], goals[2], goals[0], goals[0]]
        );
    }

    #[test]
    fn too_few_too_many_or_repeated_goals_are_refused() {
        let [a, b] = [Cell::new(1, 1), Cell::new(5, 2)];
        assert!(Visit::new(&[a, b], 1).is_some());
        for (goals, hops_max) in [(&[a][..], 9), (&[a, b, b], 9), (&[a, b, a], 9), (&[], 9), (&[a, b], 0)] {
            assert!(Visit::new(goals, hops_max).is_none(), "{goals:?} {hops_max}");
        }
        let many: Vec<Cell> = (0..=GOALS_MAX as i32).map(|x| Cell::new(x, 0)).collect();
        assert!(Visit::new(&many, 9).is_none() && Visit::new(&many[1..], 9).is_some());
    }
}
