//! Possible causes of long decisions.

use std::fmt;

use contract::{MonotonicNs, Role};
use serde::{Serialize, Serializer};

use super::DecisionTiming;

/// A possible cause of a long decision. Several may apply to one decision, or none.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Cause {
    /// The first plan of a planner process: its cache is empty.
    FirstPlan,
    /// The planner in command died, and another process with the same algorithm took over.
    PlannerRestart,
    /// Another algorithm took over.
    Swap,
    /// A process fetched the map page by page, because it missed a patch or started late.
    Snapshot,
    /// A process of this role was restarted.
    Restart(Role),
    /// The guard vetoed an action, so the planner planned again.
    Veto,
    /// No planner commanded in time, and the guard's fallback acted.
    Fallback,
    /// The planner's budget cut the plan short.
    Cut,
    /// Almost all cores of the machine were busy.
    HostLoad,
}

impl Cause {
    /// Whether a process was dead for a while.
    fn is_restart(self) -> bool {
        matches!(self, Cause::PlannerRestart | Cause::Restart(_))
    }

    /// Whether a process that starts again has this effect, which then explains nothing by itself: it asks for the map, and
    /// loads the machine.
    fn is_effect_of_restart(self) -> bool {
        matches!(self, Cause::Snapshot | Cause::HostLoad)
    }
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

/// An event with a duration that may explain every decision it overlaps.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Disturbance {
    /// When it began.
    pub from: MonotonicNs,
    /// When it ended.
    pub until: MonotonicNs,
    /// Cause it stands for.
    pub cause: Cause,
}

/// How long a restart may explain long decisions after the new process was first heard, nanoseconds: it has to catch up.
const RESTART_EFFECT_NS: u64 = 200_000_000;

impl Disturbance {
    /// A process of a role was started again at `at`, when it was dead before.
    #[must_use]
    pub fn restart(role: Role, at: MonotonicNs) -> Self {
        Self { from: at, until: at.plus_ns(RESTART_EFFECT_NS), cause: Cause::Restart(role) }
    }

    fn touches(&self, timed: &DecisionTiming) -> bool {
        self.from <= timed.timing.committed && self.until >= timed.timing.landed
    }
}

/// Disturbances sorted by their begin, so that those that overlap a decision are found without scanning all.
/// Decisions may come in any order: a resumed mission may have decisions of another boot, whose clock restarted.
#[derive(Clone, Debug, Default)]
pub(super) struct Timeline {
    disturbances: Vec<Disturbance>,
    /// For each disturbance the latest end of it and all before it.
    ended: Vec<MonotonicNs>,
}

impl Timeline {
    pub(super) fn new(mut disturbances: Vec<Disturbance>) -> Self {
        disturbances.sort_by_key(|disturbance| disturbance.from);
        let latest = |end: &mut MonotonicNs, disturbance: &Disturbance| {
            *end = disturbance.until.max(*end);
            Some(*end)
        };
        let ended = disturbances.iter().scan(MonotonicNs(0), latest).collect();
        Self { disturbances, ended }
    }

    fn touching(&self, timed: &DecisionTiming) -> impl Iterator<Item = &Disturbance> {
        let begun =
            self.disturbances.partition_point(|disturbance| disturbance.from <= timed.timing.committed);
        let before = self.disturbances[..begun].iter().zip(&self.ended[..begun]).rev();
        let open = before.take_while(|(_, ended)| **ended >= timed.timing.landed);
        open.map(|(disturbance, _)| disturbance).filter(|disturbance| disturbance.touches(timed))
    }
}

/// The causes that apply to `timed`, which follows `before`: sorted, without repetition.
pub(super) fn causes(
    timed: &DecisionTiming,
    before: Option<&DecisionTiming>,
    timeline: &Timeline,
) -> Vec<Cause> {
    let mut causes = Vec::new();
    let led = before.map(|before| before.leader);
    if led.is_none_or(|led| led.incarnation != timed.leader.incarnation) && !timed.origin.is_fallback() {
        causes.push(Cause::FirstPlan);
        if let Some(led) = led {
            let same = led.planner == timed.leader.planner;
            causes.push(if same { Cause::PlannerRestart } else { Cause::Swap });
        }
    }
    causes.extend(timeline.touching(timed).map(|disturbance| disturbance.cause));
    causes.extend((timed.vetoes > 0).then_some(Cause::Veto));
    causes.extend(timed.origin.is_fallback().then_some(Cause::Fallback));
    causes.extend(timed.cut.then_some(Cause::Cut));
    if causes.iter().any(|cause| cause.is_restart()) {
        causes.retain(|cause| !cause.is_effect_of_restart());
    }
    causes.sort_unstable();
    causes.dedup();
    causes
}
