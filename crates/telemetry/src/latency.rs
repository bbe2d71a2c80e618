//! Where the time of many decisions went.

use std::mem::offset_of;

use bytemuck::{Pod, Zeroable};
use contract::message::Wire;
use contract::wire::Field;
use contract::{Decision, Refusal, Timing, fixed_payload};
use serde::Serialize;

/// A summary of the times of consecutive decisions, nanoseconds. The first number of each list is from landing to
/// commit; the others are the stages of [`contract::Stage::ALL`].
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Latency {
    /// The first decision.
    pub first: Decision,
    /// The last decision.
    pub last: Decision,
    /// How many of them were measured: fewer than there were where states were passed over.
    pub count: u64,
    /// Least.
    pub min_ns: [u64; 8],
    /// Sum, of which the mean follows.
    pub sum_ns: [u64; 8],
    /// Most.
    pub max_ns: [u64; 8],
}

impl Latency {
    /// Counts one more decision, which is after all others.
    pub fn add(&mut self, decision: Decision, timing: &Timing) {
        let [a, b, c, d, e, f, g] = timing.stages_ns();
        if self.count == 0 {
            *self = Self { first: decision, min_ns: [u64::MAX; 8], ..Self::default() };
        }
        for (place, ns) in [timing.total_ns(), a, b, c, d, e, f, g].into_iter().enumerate() {
            self.min_ns[place] = self.min_ns[place].min(ns);
            self.sum_ns[place] = self.sum_ns[place].saturating_add(ns);
            self.max_ns[place] = self.max_ns[place].max(ns);
        }
        (self.last, self.count) = (decision, self.count + 1);
    }
}

/// The wire form of a [`Latency`].
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
#[allow(missing_docs, reason = "the fields have their words below")]
pub struct LatencyV1 {
    pub first: u64,
    pub last: u64,
    pub count: u64,
    pub min_ns: [u64; 8],
    pub sum_ns: [u64; 8],
    pub max_ns: [u64; 8],
}

impl Wire for LatencyV1 {
    const NAME: &'static str = "link.Latency.v1";

    fn fields() -> Vec<Field> {
        const LIST: &str = "any; landing to commit, then its seven stages";
        vec![
            Field::of::<u64>("first", offset_of!(Self, first), "at most `last`", "First decision."),
            Field::of::<u64>("last", offset_of!(Self, last), "any", "Last decision."),
            Field::of::<u64>("count", offset_of!(Self, count), "not zero", "Decisions that were measured."),
            Field::of::<[u64; 8]>("min_ns", offset_of!(Self, min_ns), LIST, "Least, nanoseconds."),
            Field::of::<[u64; 8]>("sum_ns", offset_of!(Self, sum_ns), LIST, "Sum, nanoseconds."),
            Field::of::<[u64; 8]>("max_ns", offset_of!(Self, max_ns), LIST, "Most, nanoseconds."),
        ]
    }
}

impl From<&Latency> for LatencyV1 {
    fn from(latency: &Latency) -> Self {
        let Latency { first, last, count, min_ns, sum_ns, max_ns } = *latency;
        Self { first: first.0, last: last.0, count, min_ns, sum_ns, max_ns }
    }
}

impl TryFrom<&LatencyV1> for Latency {
    type Error = Refusal;

    fn try_from(wire: &LatencyV1) -> Result<Self, Refusal> {
        let LatencyV1 { first, last, count, min_ns, sum_ns, max_ns } = *wire;
        if first > last {
            return Err(Refusal::malformed("latency.first", &format!("at most {last}"), first));
        }
        if count == 0 {
            return Err(Refusal::malformed("latency.count", "not zero", count));
        }
        Ok(Self { first: Decision(first), last: Decision(last), count, min_ns, sum_ns, max_ns })
    }
}

fixed_payload!(Latency => LatencyV1);
