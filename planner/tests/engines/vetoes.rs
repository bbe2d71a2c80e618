//! What the guard has vetoed is not chosen again, and what it vetoes besides changes nothing.

use contract::{Action, Direction, Vetoed};
use planner::{ALGORITHMS, Planner, Situation, algorithm};

use crate::world::{PROFILES, World};

/// The action of `planner` with `vetoed` in the state of `situation`.
fn choice(planner: &mut dyn Planner, situation: &Situation<'_>, vetoed: Vetoed) -> Action {
    let state = contract::State { vetoed, ..*situation.state };
    planner.plan(&Situation { state: &state, ..*situation }, &Default::default()).action
}

/// P-VETO-HEEDED: No planner insists on a vetoed action, and a veto of an action that it would not
/// choose changes nothing.
#[test]
fn no_planner_insists_on_a_veto_or_minds_one_that_is_not_its_own() {
    for name in ALGORITHMS {
        let (mut others, mut again) = (0, 0);
        let random = (0..10).map(|seed| World::random(seed, PROFILES[seed as usize % 2]));
        for (seed, world) in (0..).zip(random.chain((0..8).map(World::doubtful))) {
            // One that meets vetoes all along, one that never does, flown by the latter.
            let mut bothered = algorithm(name).unwrap();
            world.fly(&mut *algorithm(name).unwrap(), seed, |situation, plan| {
                let hops = Direction::ALL.map(Action::Hop);
                for other in hops.into_iter().filter(|hop| *hop != plan.action) {
                    let vetoed = Vetoed::NONE.with(other);
                    assert_eq!(choice(&mut *bothered, situation, vetoed), plan.action, "{name} {seed}");
                    others += 1;
                }
                let (mut vetoed, mut action) = (Vetoed::NONE, plan.action);
                while action != Action::Hold {
                    assert!(!vetoed.has(action), "{name} insists on {action}");
                    vetoed = vetoed.with(action);
                    action = choice(&mut *bothered, situation, vetoed);
                    again += 1;
                }
                assert_eq!(choice(&mut *bothered, situation, Vetoed::NONE), plan.action, "{name} {seed}");
            });
        }
        assert!(others > 100, "{name}: {others}");
        assert!(again > 100 || *name == "hold", "{name}: {again}");
    }
}
