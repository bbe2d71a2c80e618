//! Keyed draws against a ChaCha8 written apart from this crate.

use contract::{Decision, RobotId};
use motion::{Domain, Draw};

fn draw(seed: u64, robot: u16, decision: u64) -> Draw {
    Draw::new(seed, Domain::Motion, RobotId(robot), Decision(decision))
}

/// P-DRAW: Draws are keyed, and equal those of an independent ChaCha8.
#[test]
fn draws_are_those_of_an_independent_chacha8() {
    // The first three and the last of a decision's uniforms, times 2^53: computed by a direct
    // transcription of Bernstein's quarter round in another language, under the law of `draw`.
    let golden: [(u64, u16, u64, [u64; 4]); 4] = [
        (0, 0, 0, [0x1d_dc30_0273_237a, 0x09_367d_5adb_8f84, 0x18_17aa_69ff_d297, 0x0c_8928_5827_0650]),
        (1, 0, 0, [0x11_c0cf_2a47_f09e, 0x0e_f010_e25b_54c0, 0x00_b69d_ba60_34e3, 0x1c_3148_e398_56a0]),
        (42, 0, 17, [0x0c_5cb9_7592_2119, 0x1e_ac8b_b71e_56c1, 0x16_53a2_0eb1_3642, 0x1d_71d6_425e_5bd0]),
        (
            u64::MAX,
            3,
            1 << 32,
            [0x00_c5c1_317d_7bc8, 0x0b_fadd_7021_7c05, 0x08_cf07_4467_fd76, 0x12_1bc7_9ce9_f356],
        ),
    ];
    for (seed, robot, decision, need) in golden {
        let mut draw = draw(seed, robot, decision);
        let uniforms: [f64; 8] = std::array::from_fn(|_| draw.uniform());
        let got = [0, 1, 2, 7].map(|k: usize| (uniforms[k] * (1_u64 << 53) as f64) as u64);
        assert_eq!(got, need, "seed {seed}, robot {robot}, decision {decision}");
    }
}

/// P-DRAW.
#[test]
fn a_draw_depends_on_nothing_but_its_key() {
    let alone = draw(7, 0, 1000).uniform();
    for decision in (0..2000).rev() {
        let _ = draw(7, 0, decision).uniform();
    }
    assert_eq!(draw(7, 0, 1000).uniform(), alone);
    for other in [draw(8, 0, 1000), draw(7, 1, 1000), draw(7, 0, 1001)] {
        assert_ne!(other.clone().uniform(), alone);
    }
}

#[test]
fn draws_are_uniform() {
    const DRAWS: u64 = 40_000;
    let mut bins = [0_u32; 20];
    for decision in 0..DRAWS {
        let uniform = draw(3, 0, decision).uniform();
        assert!((0.0..1.0).contains(&uniform));
        bins[(uniform * 20.0) as usize] += 1;
    }
    // Pearson's chi-square with 19 degrees of freedom exceeds 43.8 once in a thousand.
    let expected = DRAWS as f64 / 20.0;
    let chi_square: f64 = bins.iter().map(|&n| (f64::from(n) - expected).powi(2) / expected).sum();
    assert!(chi_square < 43.8, "{chi_square}");
}

#[test]
#[should_panic(expected = "a decision has 16 words")]
fn a_decision_has_a_bounded_number_of_words() {
    let mut draw = draw(0, 0, 0);
    for _ in 0..9 {
        let _ = draw.uniform();
    }
}
