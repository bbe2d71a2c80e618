//! Planners from outside in missions of every kind.

use contract::{Action, Brief, Direction, MonotonicNs, Name, Robot, RouteId, RunId};
use lockstep::{Mission, PlannerSchedule};
use planner::{Budget, Plan, PlanStatus, Planner, PlannerError, Situation};
use scenario::{Overrides, ResolvedScenario, Scenario};

const HARD: &str = include_str!("../../../scenarios/hard.toml");
const PATROL: &str = include_str!("../../../scenarios/patrol.toml");
const COVERAGE: &str = include_str!("../../../scenarios/coverage.toml");
const HOPPER_SCOUT: &str = include_str!("../../../scenarios/hopper-scout.toml");
const ROVER_HELICOPTER: &str = include_str!("../../../scenarios/rover-helicopter.toml");
const EXPEDITION: &str = include_str!("../../../scenarios/expedition.toml");

/// Always answers the same.
#[derive(Clone, Copy)]
struct Stubborn {
    action: Action,
    /// Whatever there is, or hoppers only.
    suits_all: bool,
    announces: bool,
}

impl Planner for Stubborn {
    fn name(&self) -> Name {
        "stubborn".parse().unwrap()
    }

    fn suits(&self, robot: &Robot) -> bool {
        self.suits_all || robot.body.hops()
    }

    fn announces(&self) -> bool {
        self.announces
    }

    fn plan(&mut self, _: &Situation<'_>, _: &Budget) -> Plan {
        Plan::at_once(self.action, PlanStatus::Solved)
    }
}

fn resolved(text: &str) -> ResolvedScenario {
    Scenario::parse(text, "test").unwrap().with(&Overrides::default()).resolve().unwrap()
}

fn fly(world: &ResolvedScenario, planner: Stubborn) -> Result<u64, PlannerError> {
    let brief = Brief { run: RunId(1), ..world.brief.clone() };
    let mission = Mission { brief, ..Mission::of(world, 1) };
    let schedule = PlannerSchedule::single("stubborn".parse().unwrap());
    let make = &mut |_: Name, _: &Mission| Ok(Box::new(planner) as Box<dyn Planner>);
    let flown = lockstep::fly_with(mission, &schedule, make, &mut || MonotonicNs(1), &mut |_| ())?;
    Ok(flown.state.decision.0)
}

/// P-OWN-UNSUITED: An external planner that does not suit a mission, or insists on what its robot
/// cannot do, is refused by name in lockstep, in Python and on replay of a recording; nothing
/// panics.
#[test]
fn a_planner_that_does_not_suit_a_mission_is_refused_by_name() {
    let worlds = [HARD, PATROL, COVERAGE, HOPPER_SCOUT, ROVER_HELICOPTER, EXPEDITION].map(resolved);
    let actions = [
        Action::Hold,
        Action::Wait,
        Action::Drive,
        Action::Fly,
        Action::Hop(Direction::North),
        Action::Step(Direction::West),
        Action::Announce(RouteId(7)),
    ];
    for world in &worlds {
        let scenario = world.brief.scenario;
        for action in actions {
            let holds = action == Action::Hold;
            let ways = [(true, false), (false, false), (true, true)];
            for &(suits_all, announces) in if holds { &ways[..] } else { &ways[..1] } {
                let flown = fly(world, Stubborn { action, suits_all, announces });
                let Err(error) = flown else { continue };
                let text = error.to_string();
                assert!(text.contains("stubborn"), "{scenario}, {action}: {text}");
                assert!(matches!(error, PlannerError::StandsStill { .. }), "{text}");
            }
        }
    }
    let [hard, _, coverage, hopper_scout, rover_helicopter, expedition] = &worlds;
    let holds = |suits_all| Stubborn { action: Action::Hold, suits_all, announces: false };
    assert_eq!(fly(hard, holds(false)), Ok(150), "holding is a decision");
    let refused = |world, planner| fly(world, planner).unwrap_err().to_string();
    for (world, need) in [
        (coverage, "scenario coverage needs one of the planners"),
        (rover_helicopter, "scenario rover-helicopter needs one of the planners"),
        (
            hopper_scout,
            "robot 1 of scenario hopper-scout needs one of the planners scout_ahead, got stubborn",
        ),
        (expedition, "of scenario expedition needs one of the planners"),
    ] {
        let text = refused(world, holds(false));
        assert!(
            text.starts_with("the mission stands still at decision 0: ") && text.contains(need),
            "{text}"
        );
    }
    for world in [rover_helicopter, hopper_scout, expedition] {
        let text = refused(world, holds(true));
        assert!(
            text.contains("needs one of the planners"),
            "whoever announces nothing moves no such robot: {text}"
        );
    }
    let steps = Stubborn { action: Action::Step(Direction::North), suits_all: true, announces: false };
    let text = refused(hard, steps);
    assert!(
        text.contains(
            "planner stubborn needs to choose what robot 0 may do, got commands refused as malformed"
        ),
        "{text}"
    );
}
