//! Makes a failing plan small: fewer faults first, then milder ones.

use crate::fault::{Fault, Kind, Plan};
use crate::violation::Violation;

/// Simulations that shrinking may take.
const TRIES_MAX: usize = 400;

/// The smallest plan found that still violates the same rule.
///
/// `fails` simulates a plan and gives what it violates.
pub fn shrink(plan: &Plan, rule: &str, mut fails: impl FnMut(&Plan) -> Option<Violation>) -> Plan {
    let mut smallest = plan.clone();
    let mut tries = 0;
    let mut still_fails = |candidate: &Plan| {
        tries += 1;
        tries <= TRIES_MAX && fails(candidate).is_some_and(|violation| violation.rule == rule)
    };
    let mut width = smallest.faults.len();
    while width > 0 {
        let mut from = 0;
        while from < smallest.faults.len() {
            let mut candidate = smallest.clone();
            candidate.faults.drain(from..(from + width).min(smallest.faults.len()));
            if still_fails(&candidate) {
                smallest = candidate;
            } else {
                from += width;
            }
        }
        width /= 2;
    }
    for index in 0..smallest.faults.len() {
        while let Some(milder) = milder(&smallest.faults[index]).into_iter().find_map(|fault| {
            let mut candidate = smallest.clone();
            candidate.faults[index] = fault;
            candidate.faults.sort_by_key(|fault| fault.decision);
            still_fails(&candidate).then_some(candidate)
        }) {
            smallest = milder;
        }
    }
    smallest
}

/// Faults of the same kind, each a little milder.
fn milder(fault: &Fault) -> Vec<Fault> {
    let mut milder = Vec::new();
    let mut less = |change: &dyn Fn(&mut Fault)| {
        let mut candidate = fault.clone();
        change(&mut candidate);
        if candidate != *fault {
            milder.push(candidate);
        }
    };
    less(&|fault| fault.after_ns = 0);
    less(&|fault| fault.after_ns /= 2);
    less(&|fault| match &mut fault.kind {
        Kind::Lose { messages, .. }
        | Kind::Duplicate { messages, .. }
        | Kind::Delay { messages, .. }
        | Kind::Reorder { messages, .. } => *messages = (*messages / 2).max(1),
        Kind::Kill { restart_ns, .. }
        | Kind::KillAt { restart_ns, .. }
        | Kind::PowerLoss { restart_ns, .. }
        | Kind::NewRun { restart_ns } => *restart_ns /= 2,
        Kind::Stop { ns, .. } | Kind::StopAt { ns, .. } | Kind::Full { ns, .. } => *ns /= 2,
        _ => {}
    });
    milder
}
