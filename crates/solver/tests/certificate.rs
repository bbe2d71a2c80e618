//! The certificate against exact solutions.

use nalgebra::{DMatrix, DVector};
use solver::specimen::Specimen;
use solver::{Effort, Hop, Kind, Leaving, Solver, Status, World, action_values};

/// V* by policy iteration, each policy evaluated by a dense linear solve.
fn exact(world: &World) -> Vec<f64> {
    let nodes = world.nodes();
    let rules = world.rules();
    let mut values: Vec<f64> =
        (0..nodes).map(|node| if world.kind(node) == Kind::Lost { rules.loss } else { 0.0 }).collect();
    let mut policy = vec![Hop::North; nodes];
    for _ in 0..100 {
        let mut a = DMatrix::<f64>::identity(nodes, nodes);
        let mut b = DVector::from_column_slice(&values);
        for node in (0..nodes).filter(|&node| world.kind(node) == Kind::Free) {
            let hop = policy[node];
            let s = world.scatter(node, hop);
            let wait = world.soil(node).wait;
            let g = rules.discount * (1.0 - wait + wait * rules.discount);
            b[node] = rules.discount * wait * world.payoff(node);
            let lands = [
                (Some(node), s.stayed),
                (world.neighbour(node, hop), s.intended),
                (world.neighbour(node, hop.left()), s.left),
                (world.neighbour(node, hop.right()), s.right),
            ];
            for (to, p) in lands {
                let to = to.or((rules.leaving == Leaving::Stays).then_some(node));
                match to {
                    Some(to) if world.kind(to) == Kind::Free => {
                        b[node] += g * p * world.payoff(to);
                        a[(node, to)] -= g * p;
                    }
                    Some(to) if world.kind(to) == Kind::Goal => b[node] += g * p * world.payoff(to),
                    _ => b[node] += g * p * rules.loss,
                }
            }
        }
        values = a.lu().solve(&b).expect("regular").as_slice().to_vec();
        let mut changed = false;
        for node in (0..nodes).filter(|&node| world.kind(node) == Kind::Free) {
            let q = action_values(world, &values, node);
            let best = q.into_iter().fold(f64::NEG_INFINITY, f64::max);
            if q[policy[node] as usize] < best - 1e-10 {
                policy[node] = *Hop::ALL.iter().find(|h| q[**h as usize] == best).unwrap();
                changed = true;
            }
        }
        if !changed {
            return values;
        }
    }
    panic!("policy iteration ends");
}

#[test]
fn values_lie_within_the_certificate_of_the_linear_solve() {
    for seed in 0..20 {
        for specimen in [Specimen::plain(9, seed), Specimen::trap(9, seed)] {
            for leaving in [Leaving::Stays, Leaving::Loses] {
                let world = Specimen { leaving, ..specimen }.world().unwrap();
                let mut solver = Solver::new();
                let solution = solver.solve(&world, &Effort::default());
                assert_eq!(solution.status, Status::Solved);
                assert!(solution.certificate.error_bound <= 1e-6);
                let exact = exact(&world);
                for node in 0..world.nodes() {
                    assert!(
                        (solver.values()[node] - exact[node]).abs()
                            <= solution.certificate.error_bound + 1e-9
                    );
                }
            }
        }
    }
}
