//! What may explain that a decision took long.

use std::fmt;

use contract::{MonotonicNs, Role};
use serde::{Serialize, Serializer};

use super::Step;

/// One explanation. Several may hold for one decision, or none that is known.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Cause {
    /// The first plan of a planner's life: nothing is kept from the decision before.
    FirstPlan,
    /// The planner in command had died, and its successor of the same algorithm took over.
    PlannerRestart,
    /// Another algorithm took over.
    Swap,
    /// The map was asked for page by page: somebody had missed a patch or had come late.
    Snapshot,
    /// A process of this role was started again.
    Restart(Role),
    /// The guard vetoed an action, so it was planned again.
    Veto,
    /// No planner commanded in time: the fallback acted.
    Fallback,
    /// A budget cut the plan short.
    Cut,
    /// Hardly a core was idle.
    HostLoad,
}

impl fmt::Display for Cause {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Cause::FirstPlan => f.pad("first plan"),
            Cause::PlannerRestart => f.pad("planner restart"),
            Cause::Swap => f.pad("swap"),
            Cause::Snapshot => f.pad("snapshot"),
            Cause::Restart(role) => write!(f, "{role} restart"),
            Cause::Veto => f.pad("veto"),
            Cause::Fallback => f.pad("fallback"),
            Cause::Cut => f.pad("cut"),
            Cause::HostLoad => f.pad("host load"),
        }
    }
}

impl Serialize for Cause {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_str(&self.to_string().replace([' ', '-'], "_"))
    }
}

/// Something that went on for a while, and may explain every decision that was open meanwhile.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Happening {
    /// Its begin.
    pub from: MonotonicNs,
    /// Its end.
    pub until: MonotonicNs,
    /// What it explains.
    pub cause: Cause,
}

impl Happening {
    fn touches(&self, step: &Step) -> bool {
        self.from <= step.timing.committed && self.until >= step.timing.landed
    }
}

/// Happenings in the order of their begins, so that those which touch a decision are found without a look at all.
/// Decisions may come in any order: a resumed mission has those of another boot of the machine, whose clock began anew.
#[derive(Clone, Debug, Default)]
pub(super) struct Timeline {
    happenings: Vec<Happening>,
    /// The latest end up to each.
    ended: Vec<MonotonicNs>,
}

impl Timeline {
    pub(super) fn new(mut happenings: Vec<Happening>) -> Self {
        happenings.sort_by_key(|happening| happening.from);
        let latest = |end: &mut MonotonicNs, happening: &Happening| {
            *end = happening.until.max(*end);
            Some(*end)
        };
        let ended = happenings.iter().scan(MonotonicNs(0), latest).collect();
        Self { happenings, ended }
    }

    fn touching(&self, step: &Step) -> impl Iterator<Item = &Happening> {
        let begun = self.happenings.partition_point(|happening| happening.from <= step.timing.committed);
        let before = self.happenings[..begun].iter().zip(&self.ended[..begun]).rev();
        let open = before.take_while(|(_, ended)| **ended >= step.timing.landed);
        open.map(|(happening, _)| happening).filter(|happening| happening.touches(step))
    }
}

/// What explains `step`, which follows `before`: in order, each once.
pub(super) fn causes(step: &Step, before: Option<&Step>, timeline: &Timeline) -> Vec<Cause> {
    let mut causes = Vec::new();
    let led = before.map(|before| before.leader);
    if led.is_none_or(|led| led.incarnation != step.leader.incarnation) && !step.origin.is_fallback() {
        causes.push(Cause::FirstPlan);
        if let Some(led) = led {
            let same = led.planner == step.leader.planner;
            causes.push(if same { Cause::PlannerRestart } else { Cause::Swap });
        }
    }
    causes.extend(timeline.touching(step).map(|happening| happening.cause));
    causes.extend((step.vetoes > 0).then_some(Cause::Veto));
    causes.extend(step.origin.is_fallback().then_some(Cause::Fallback));
    causes.extend(step.cut.then_some(Cause::Cut));
    causes.sort_unstable();
    causes.dedup();
    causes
}
