//! Holds a planner to the law of [`Planner`]: what its process and everybody's digests rely on.
//!
//! The planner flies missions in small drawn worlds, beside fresh ones that answer the same questions:
//!
//! ```
//! # use planner::greedy::Greedy;
//! # type MyPlanner = Greedy;
//! planner::conformance::check(MyPlanner::default)?;
//! # Ok::<(), planner::conformance::Violation>(())
//! ```

mod practice_world;

use std::fmt;

use contract::{Action, Cell, Decision, Direction, Profile, State, Vetoed};

use crate::plan::{Budget, Plan, PlanStatus, Planner, Pulse, Situation};
use practice_world::{PracticeWorld, Progress};

/// Drawn worlds, half of them in each profile.
const WORLDS: u64 = 16;

/// Bounds on the work under which plans are compared, in the planner's own units.
const BUDGETS: [u64; 6] = [0, 1, 2, 7, 60, 4_000];

/// Every so many decisions a planner is asked under the bounds of [`BUDGETS`], and with vetoes.
const SAMPLED: u64 = 4;

/// A planner that is started anew in mid-mission begins at each of these decisions.
const RESTARTS: [u64; 3] = [1, 3, 8];

/// A rule of the law.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Rule {
    /// It plans for a hopper that goes to a cell. Planners for rovers are not checked here.
    Task,
    /// It commands what its robot can do: a hopper holds or hops.
    Action,
    /// A planner that knows nothing of the past plans as one that has planned before, bit for bit, and one that is asked
    /// twice answers twice the same.
    EmptyCache,
    /// A planner that is started in mid-mission plans to the end as the one that was killed would have.
    Restart,
    /// What the guard has vetoed is not chosen again.
    Veto,
    /// Of equally good directions the first of north, east, south, west is chosen. Checked where the world is its own
    /// mirror image, so that nothing but the order can tell two directions apart.
    Ties,
    /// A bound on the work is kept; what is planned under it depends on the bound, and not on the past; a plan that is
    /// not [`PlanStatus::Cut`] is that without a bound. A pulse changes nothing.
    Budget,
}

impl fmt::Display for Rule {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(match self {
            Rule::Task => "task",
            Rule::Action => "action",
            Rule::EmptyCache => "empty cache",
            Rule::Restart => "restart",
            Rule::Veto => "veto",
            Rule::Ties => "ties",
            Rule::Budget => "budget",
        })
    }
}

/// A planner broke a rule.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("planner {planner} breaks the law ({rule}) {place}: need {need}, got {got}")]
pub struct Violation {
    /// As [`crate::Planner::name`] gives it.
    pub planner: String,
    /// Which rule was broken.
    pub rule: Rule,
    /// In which world, at which decision.
    pub place: String,
    /// What the rule asks for.
    pub need: String,
    /// What the planner answered.
    pub got: String,
}

/// Flies practice missions with planners that `make` returns, and compares their answers. It takes as long as the planner
/// does for some thousand plans on maps of up to 121 cells.
///
/// # Errors
/// The first violation found.
pub fn check<P: Planner>(mut make: impl FnMut() -> P) -> Result<(), Violation> {
    let veteran = &mut make();
    if !veteran.suits(&PracticeWorld::drawn(0, Profile::Hopper).brief.robots[0]) {
        let place = "before the mission".into();
        return Err(violation(veteran, Rule::Task, place, "a planner for a hopper".into(), "none".into()));
    }
    check_ties(&mut make)?;
    for number in 0..WORLDS {
        let profile = Profile::ALL[number as usize % Profile::ALL.len()];
        let world = &PracticeWorld::drawn(number, profile);
        // One after the other, so that what is kept from one world meets the next.
        check_cache(veteran, &mut make, world, number)?;
        check_restarts(&mut make, world, number)?;
    }
    Ok(())
}

/// A situation with what is needed to name it.
#[derive(Clone, Copy)]
struct Case<'a> {
    number: u64,
    world: &'a PracticeWorld,
    progress: &'a Progress,
}

impl Case<'_> {
    fn plan(&self, planner: &mut dyn Planner, vetoed: Vetoed, budget: &Budget) -> Plan {
        let state = State { vetoed, ..self.progress.state };
        let situation = Situation::alone(&self.world.brief, &self.world.leg, &self.progress.map, &state);
        planner.plan(&situation, budget)
    }

    fn freely(&self, planner: &mut dyn Planner) -> Plan {
        self.plan(planner, Vetoed::NONE, &Budget::default())
    }

    fn place(&self) -> String {
        let State { decision, pose, .. } = self.progress.state;
        format!("in practice world {}, decision {decision}, cell {}", self.number, pose.cell)
    }

    /// `got` needs to be `need`, apart from the work unless `with_work`.
    fn same(
        &self,
        planner: &dyn Planner,
        rule: Rule,
        [need, got]: [&Plan; 2],
        with_work: bool,
    ) -> Result<(), Violation> {
        let same = need.action == got.action
            && need.status == got.status
            && need.error_bound.to_bits() == got.error_bound.to_bits()
            && (need.work == got.work || !with_work);
        if same {
            return Ok(());
        }
        Err(violation(planner, rule, self.place(), told(need), told(got)))
    }
}

/// At each decision of a mission: fresh planners, vetoes, and bounds on the work.
fn check_cache<P: Planner>(
    veteran: &mut P,
    make: &mut impl FnMut() -> P,
    world: &PracticeWorld,
    number: u64,
) -> Result<(), Violation> {
    let mut progress = world.begin();
    loop {
        let case = Case { number, world, progress: &progress };
        let plan = case.freely(veteran);
        if matches!(plan.action, Action::Step(_)) {
            let need = "hold or a hop".into();
            return Err(violation(veteran, Rule::Action, case.place(), need, told(&plan)));
        }
        let fresh = case.freely(&mut make());
        case.same(veteran, Rule::EmptyCache, [&fresh, &plan], false)?;
        if (number + progress.state.decision.0).is_multiple_of(SAMPLED) {
            check_vetoes(veteran, &case, plan)?;
            check_budgets(veteran, make, &case, &plan)?;
        }
        let again = case.freely(veteran);
        case.same(veteran, Rule::EmptyCache, [&plan, &again], false)?;
        match world.act(progress, plan.action, number) {
            Some(next) => progress = next,
            None => return Ok(()),
        }
    }
}

/// Vetoes what is chosen until it holds.
fn check_vetoes(planner: &mut dyn Planner, case: &Case<'_>, mut plan: Plan) -> Result<(), Violation> {
    let mut vetoed = Vetoed::NONE;
    while plan.action != Action::Hold {
        vetoed = vetoed.with(plan.action);
        plan = case.plan(planner, vetoed, &Budget::default());
        if vetoed.has(plan.action) {
            let need = "an action that is not vetoed".into();
            return Err(violation(planner, Rule::Veto, case.place(), need, told(&plan)));
        }
    }
    Ok(())
}

fn check_budgets<P: Planner>(
    veteran: &mut P,
    make: &mut impl FnMut() -> P,
    case: &Case<'_>,
    unbounded: &Plan,
) -> Result<(), Violation> {
    for work_max in BUDGETS {
        let budget = Budget::of(Some(work_max));
        let plan = case.plan(veteran, Vetoed::NONE, &budget);
        if plan.work > work_max {
            let need = format!("at most {work_max} units of work");
            return Err(violation(veteran, Rule::Budget, case.place(), need, told(&plan)));
        }
        let beat = || {};
        let pulsed = Budget { pulse: Pulse::new(&beat), ..budget };
        let fresh = case.plan(&mut make(), Vetoed::NONE, &pulsed);
        case.same(veteran, Rule::Budget, [&fresh, &plan], true)?;
        if plan.status != PlanStatus::Cut && plan.action != unbounded.action {
            let need = format!("{}, as without a bound, or a plan that is cut", unbounded.action);
            return Err(violation(veteran, Rule::Budget, case.place(), need, told(&plan)));
        }
    }
    Ok(())
}

/// Kills the planner before some decision, and compares the next one with it to the end.
fn check_restarts<P: Planner>(
    make: &mut impl FnMut() -> P,
    world: &PracticeWorld,
    number: u64,
) -> Result<(), Violation> {
    for restart in RESTARTS.map(Decision) {
        let (mut first, mut second) = (make(), make());
        let mut next = Some(world.begin());
        while let Some(progress) = next {
            let case = Case { number, world, progress: &progress };
            let plan = case.freely(&mut first);
            if progress.state.decision >= restart {
                let restarted = case.freely(&mut second);
                case.same(&first, Rule::Restart, [&plan, &restarted], false)?;
            }
            next = world.act(progress, plan.action, number);
        }
    }
    Ok(())
}

/// Flat ground, with the goal in each corner.
fn check_ties<P: Planner>(make: &mut impl FnMut() -> P) -> Result<(), Violation> {
    use Direction::{East, North, South, West};
    // What the mirror at the diagonal through the goal makes of north, east, south, west.
    let [main, other] = [[East, North, West, South], [West, South, East, North]];
    // In profile paper-2022 the order of the sweeps decides between equals.
    for profile in [Profile::Paper2023, Profile::Hopper] {
        for (goal, mirrored) in [((8, 8), main), ((0, 0), main), ((0, 8), other), ((8, 0), other)] {
            let world = &PracticeWorld::flat(Cell::new(goal.0, goal.1), profile);
            let case = Case { number: 0, world, progress: &world.begin() };
            let planner = &mut make();
            let plan = case.freely(planner);
            let Action::Hop(chosen) = plan.action else { continue };
            let equal = mirrored[chosen as usize];
            if equal < chosen {
                let place = format!("on flat ground, goal {:?} from the middle of 9 x 9 cells", goal);
                let need = format!("{equal}, which is as good and comes first");
                return Err(violation(planner, Rule::Ties, place, need, told(&plan)));
            }
        }
    }
    Ok(())
}

fn violation(planner: &dyn Planner, rule: Rule, place: String, need: String, got: String) -> Violation {
    Violation { planner: planner.name().to_string(), rule, place, need, got }
}

fn told(plan: &Plan) -> String {
    let Plan { action, status, work, error_bound } = plan;
    format!("{action} ({status:?}, work {work}, error bound {error_bound})")
}
