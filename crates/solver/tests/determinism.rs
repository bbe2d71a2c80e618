//! A solution depends on the world alone.

mod worlds;

use proptest::prelude::*;
use solver::fixtures::Fixture;
use solver::{Effort, GridWorld, Leaving, Simd, Solution, Solver};
use worlds::{hills, inside, random};

fn solve(solver: &mut Solver, world: &GridWorld) -> (Solution, Vec<u64>) {
    let solution = solver.solve(world, &Effort::default());
    (solution, solver.values().iter().map(|value| value.to_bits()).collect())
}

fn agree(world: &GridWorld) {
    let plain = solve(&mut Solver::with_simd(Simd::Portable), world);
    for simd in [Simd::Avx2, Simd::Avx512] {
        assert!(plain == solve(&mut Solver::with_simd(simd), world), "{simd:?} differs");
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(300))]

    /// P-SAME-BITS: Values have the same bits on every instruction set, with one thread or two,
    /// whatever was solved before.
    #[test]
    fn every_instruction_set_gives_the_same_bits(seed: u64) {
        agree(&random(seed));
        agree(&hills(seed));
        agree(&inside(seed));
    }

    #[test]
    fn hills_of_any_shape_give_the_same_bits(width in 1_usize..70, height in 1_usize..70, seed: u64, loses: bool) {
        let leaving = if loses { Leaving::Loses } else { Leaving::Stays };
        agree(&Fixture { width, height, leaving, ..Fixture::plain(1, seed) }.world().unwrap());
    }
}

/// P-SAME-BITS.
#[test]
fn a_second_thread_gives_the_same_bits() {
    let mut pair = Solver::new().with_threads(2);
    let mut alone = Solver::new();
    for seed in 0..6 {
        let [plain, inner, trap] = [Fixture::plain, Fixture::inner, Fixture::trap];
        for fixture in [plain(101, seed), inner(130, seed), trap(101, seed)] {
            // A long shape has diagonals of few nodes, and the first thread is never far ahead.
            for (width, height) in [(fixture.width, fixture.height), (17, 700), (900, 12)] {
                let leaving = if seed % 2 == 0 { Leaving::Stays } else { Leaving::Loses };
                let world = Fixture { width, height, leaving, ..fixture }.world().unwrap();
                for _ in 0..3 {
                    assert!(
                        solve(&mut pair, &world) == solve(&mut alone, &world),
                        "{width} x {height}, {seed}"
                    );
                }
            }
        }
    }
}

/// P-SAME-BITS.
#[test]
fn what_was_solved_before_does_not_matter() {
    let mut used = Solver::new();
    for seed in 0..200 {
        for world in [random(seed), hills(seed), inside(seed)] {
            let mut copy = used.clone();
            let fresh = solve(&mut Solver::new(), &world);
            assert!(solve(&mut used, &world) == fresh, "seed {seed}");
            assert!(solve(&mut copy, &world) == fresh, "a copy, seed {seed}");
        }
    }
    let [wide, tall] = [(30, 20), (20, 30)]
        .map(|(width, height)| Fixture { width, height, ..Fixture::trap(1, 7) }.world().unwrap());
    solve(&mut used, &wide);
    assert!(solve(&mut used, &tall) == solve(&mut Solver::new(), &tall));
}
