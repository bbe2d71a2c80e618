//! Who has commanded each robot, under which term.

use std::collections::{BTreeMap, BTreeSet};

use contract::{Incarnation, Record, RobotId, Term};

/// Who has commanded each robot in the run, under which term.
#[derive(Debug, Default)]
pub(super) struct Succession {
    terms: BTreeMap<(RobotId, Term), Incarnation>,
    commanders: BTreeSet<(RobotId, Incarnation)>,
}

impl Succession {
    /// The life that first executed a decision under the term of `record`, which is that of `record` if nobody has.
    pub fn owner(&mut self, record: &Record) -> Incarnation {
        let incarnation = record.leader.incarnation;
        self.commanders.insert((record.robot, incarnation));
        *self.terms.entry((record.robot, record.leader.term)).or_insert(incarnation)
    }

    /// Whether a life has commanded `robot`.
    pub fn has_commanded(&self, robot: RobotId, life: Incarnation) -> bool {
        self.commanders.contains(&(robot, life))
    }

    /// Who has commanded `robot` under `term`.
    pub fn of(&self, robot: RobotId, term: Term) -> Option<Incarnation> {
        self.terms.get(&(robot, term)).copied()
    }
}
