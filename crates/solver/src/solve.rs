//! The solver: values from nothing, to a certified bound or to the end of the budget.

use crate::{Certificate, Hop, Kind, Leaving, Scatter, World, certify};

/// How far to go.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Effort {
    /// Bound on |V − V*| to reach, in units of payoff.
    pub error_max: f64,
    /// Most sweeps over all nodes; at least one is made.
    pub sweeps_max: u64,
}

impl Default for Effort {
    /// An error of 1e-6, whatever it takes.
    fn default() -> Self {
        Self { error_max: 1e-6, sweeps_max: u64::MAX }
    }
}

/// How a solve ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Status {
    /// The certificate's bound is within the error asked for, or at the limit of floating point.
    Solved,
    /// The budget ended first; values and certificate are valid, the bound is larger.
    Cut,
}

/// How a solve ended, and how good the values are.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Solution {
    /// The bound on the values' error.
    pub certificate: Certificate,
    /// Whether that is what was asked for.
    pub status: Status,
    /// Sweeps made, in node updates over nodes, rounded up; the certificate's sweep is not counted.
    pub sweeps: u64,
}

/// The solver, with buffers that each solve overwrites: repeated solves allocate nothing.
#[derive(Clone, Debug, Default)]
pub struct Solver {
    values: Vec<f64>,
}

impl Solver {
    /// A solver without buffers yet.
    #[must_use]
    pub fn new() -> Self {
        Self::default()
    }

    /// Value of each node of the world solved last, row-major: 0 at a goal, the loss where lost.
    #[must_use]
    pub fn values(&self) -> &[f64] {
        &self.values
    }

    /// Solves `world` from nothing. The result depends on the world and the effort alone.
    pub fn solve(&mut self, world: &World, effort: &Effort) -> Solution {
        let rules = world.rules();
        // Below this the sweeps' own rounding may keep the residual from falling.
        let limit = 64.0 * f64::EPSILON * world.worth_max() / (1.0 - rules.discount);
        let error_max = effort.error_max.max(limit);
        let worst = (0..world.nodes()).map(|node| world.payoff(node)).fold(f64::INFINITY, f64::min);
        self.values.clear();
        self.values.extend((0..world.nodes()).map(|node| match world.kind(node) {
            Kind::Free => worst,
            Kind::Goal => 0.0,
            Kind::Lost => rules.loss,
        }));
        let mut sweeps = 0;
        loop {
            let change = sweep(world, &mut self.values, sweeps % 2 == 1);
            sweeps += 1;
            let out = sweeps >= effort.sweeps_max;
            if out || change <= error_max * (1.0 - rules.discount) {
                let certificate = certify(world, &self.values);
                let solved = certificate.error_bound <= error_max;
                if solved || out {
                    let status = if solved { Status::Solved } else { Status::Cut };
                    return Solution { certificate, status, sweeps };
                }
            }
        }
    }
}

/// One Gauss–Seidel sweep; the largest change of a value.
fn sweep(world: &World, values: &mut [f64], backwards: bool) -> f64 {
    let mut change = 0.0_f64;
    for index in 0..values.len() {
        let node = if backwards { values.len() - 1 - index } else { index };
        if world.kind(node) == Kind::Free {
            let value = backup(world, values, node);
            change = change.max((value - values[node]).abs());
            values[node] = value;
        }
    }
    change
}

/// The value of a free node under its neighbours' values, with what stays at the node solved for:
/// V = a + b V is V = a / (1 − b), which leaves the fixed point where it is.
fn backup(world: &World, values: &[f64], node: usize) -> f64 {
    let rules = world.rules();
    let soil = world.soil(node);
    let (payoff, discount) = (world.payoff(node), soil.discount(rules.discount));
    let around = Hop::ALL.map(|hop| (world.neighbour(node, hop)).map(|to| world.worth(values, to)));
    let value = |hop: Hop| {
        let Scatter { intended, stayed, left, right } = world.scatter(node, hop);
        let mut stays = stayed;
        let mut leaves = 0.0;
        for (probability, towards) in [(intended, hop), (left, hop.left()), (right, hop.right())] {
            match (around[towards as usize], rules.leaving) {
                (Some(worth), _) => leaves += probability * worth,
                (None, Leaving::Stays) => stays += probability,
                (None, Leaving::Loses) => leaves += probability * rules.loss,
            }
        }
        (rules.discount * soil.wait * payoff + discount * (leaves + stays * payoff))
            / (1.0 - discount * stays)
    };
    Hop::ALL.into_iter().map(value).fold(f64::NEG_INFINITY, f64::max)
}
