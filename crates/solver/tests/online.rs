//! Decisions on a growing map: the same hop whatever the history, and the proofs behind it.
//!
//! `ONLINE_HOPS=300000 cargo test --release -p hopper-solver --test online` flies further.

#[path = "support/mission.rs"]
mod mission;

use mission::Mission;
use solver::fixtures::{DISCOUNT, Fixture, GoalPlace, HARD, SAND, SplitMix64};
use solver::online::choice::{CANONICAL_ERROR, TIE};
use solver::online::{DecisionStatus, HopDecision, Method, OnlineSolver};
use solver::{Effort, GoalSearch, GridWorld, Hop, Kind, Leaving, Rules, Site, Soil, Solver, bellman, policy};

/// The kind of a small world.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Land {
    /// Uniform and flat, so that ties are everywhere.
    Flat,
    /// Slopes, sand, and a different payoff at each node.
    Rough,
    /// Payoffs for which lingering beats the goal.
    Trap,
    /// Rocks that are known only when seen, and sometimes surround the goal.
    Rocky,
    /// Flat, with a few payoffs that make gaps close to [`TIE`].
    Doubtful,
}

/// A mission over a small world, drawn from `seed`.
fn mission(land: Land, seed: u64) -> Mission {
    let mut draw = SplitMix64(seed.wrapping_mul(77) ^ 0xabc);
    let mut pick = |from: usize, to: usize| draw.between(from as f64, to as f64) as usize;
    let (width, height) = (pick(4, 15), pick(4, 15));
    let nodes = width * height;
    let goal = if pick(0, 2) == 0 { nodes - 1 - width.min(nodes - 2) } else { pick(0, nodes) };
    let start = (goal + 1 + pick(0, nodes - 1)) % nodes;
    let leaving = if pick(0, 2) == 0 { Leaving::Stays } else { Leaving::Loses };
    let rules = Rules { discount: DISCOUNT, loss: -2500.0, leaving, soils: vec![HARD, SAND] };
    let mut unseen = GridWorld::new(width, height, rules).expect("a world in range");
    let distance = |node: usize| {
        (node % width).abs_diff(goal % width) as f64 + (node / width).abs_diff(goal / width) as f64
    };
    for node in 0..nodes {
        let flat = Site {
            kind: if node == goal { Kind::Goal } else { Kind::Free },
            payoff: if node == goal { 100.0 } else { -10.0 * distance(node) / (width + height) as f64 },
            slope_east: 0.0,
            slope_north: 0.0,
            soil: 0,
        };
        unseen.set(node, flat);
    }
    let mut truth = unseen.clone();
    let scale = if land == Land::Trap { 30.0 } else { 1.0 };
    for node in (0..nodes).filter(|&node| node != goal) {
        let mut site = unseen.site(node);
        let uniform = [(); 6].map(|()| draw.uniform());
        match land {
            Land::Flat => {}
            Land::Doubtful => {
                if uniform[0] < 0.1 {
                    site.payoff += (uniform[1] - 0.5) * 8.0 * TIE;
                }
            }
            Land::Rough | Land::Trap | Land::Rocky => {
                let steep = if uniform[5] < 0.05 { 1.2 } else { 0.4 };
                site.payoff += scale * (uniform[0] - 0.5);
                site.slope_east = steep * (2.0 * uniform[1] - 1.0);
                site.slope_north = steep * (2.0 * uniform[2] - 1.0);
                site.soil = u8::from(uniform[3] < 0.3);
                let walled = seed.is_multiple_of(4) && distance(node) < 1.5;
                if land == Land::Rocky && node != start && (uniform[4] < 0.12 || walled) {
                    site.kind = Kind::Lost;
                }
            }
        }
        truth.set(node, site);
    }
    let radius = 1.0 + 3.0 * draw.uniform();
    Mission { truth, unseen, start, radius }
}

/// The canonical hop, by the procedure itself; `None` where the node is not free or no way leads to the goal.
fn canonical(solver: &mut Solver, world: &GridWorld, here: usize) -> Option<Hop> {
    if !GoalSearch::default().leads_to_goal(world, here) {
        return None;
    }
    solver.solve(world, &Effort { error_max: CANONICAL_ERROR, ..Effort::default() });
    policy::hop(world, solver.values(), here, TIE)
}

fn hops_wanted(quick: u64) -> u64 {
    std::env::var("ONLINE_HOPS").ok().and_then(|hops| hops.parse().ok()).unwrap_or(quick)
}

/// Converges all values to the certificate, and checks each of them against it.
fn assert_certified(online: &mut OnlineSolver, of: &dyn std::fmt::Debug) {
    let world = online.world().clone();
    let (values, certificate) = online.values();
    assert!(certificate.error_bound <= 1e-6, "{of:?}: {certificate:?}");
    for node in 0..world.nodes() {
        let residual = bellman::residual(&world, values, node);
        assert!(residual <= certificate.residual, "{of:?}: {residual:e} at {node}, {certificate:?}");
    }
}

/// Number of decisions by method.
#[derive(Clone, Copy, Debug, Default)]
struct Tally {
    focused: u64,
    warm: u64,
    canonical: u64,
    infeasible: u64,
}

impl Tally {
    fn count(&mut self, decision: &HopDecision) {
        match (decision.status, decision.method) {
            (DecisionStatus::Infeasible, _) => self.infeasible += 1,
            (_, Method::Focused) => self.focused += 1,
            (_, Method::Warm) => self.warm += 1,
            (_, Method::Canonical) => self.canonical += 1,
        }
    }

    fn hops(&self) -> u64 {
        self.focused + self.warm + self.canonical + self.infeasible
    }
}

/// Flies one mission with one online solver, and compares each hop with the canonical procedure, and some with a solver
/// that knows nothing.
fn fly(mission: &Mission, seed: u64, tally: &mut Tally) {
    let mut solver = Solver::new();
    let mut online = OnlineSolver::new(mission.unseen.clone());
    let mut flight = mission.fly(seed);
    for hops in 0..60 {
        for (node, site) in flight.seen() {
            online.update(node, site);
        }
        // As when steeper ground than any before is seen: being lost gets worse.
        if hops % 7 == 4 {
            online.set_loss(online.world().rules().loss - 3.0).expect("a finite loss");
        }
        let decision = online.act(flight.here, None);
        tally.count(&decision);
        let expected = canonical(&mut solver, online.world(), flight.here);
        assert_eq!(decision.action, expected, "seed {seed}, hop {hops}, {decision:?}");
        assert_eq!(decision.status == DecisionStatus::Infeasible, expected.is_none());
        if hops % 16 == 3 {
            let novice = OnlineSolver::new(online.world().clone()).act(flight.here, None);
            assert_eq!((novice.action, novice.status), (decision.action, decision.status));
        }
        // Where there is no way, the mission continues in some direction with what was learned.
        let hop = decision.action.unwrap_or(Hop::ALL[(hops % 4) as usize]);
        if !flight.hop(hop) {
            break;
        }
    }
}

/// P-SAME-HOP: Warm, focused and cold decisions are the same hop, whatever the history, including
/// ties: on small maps and on larger ones, with goals in a corner, at a side and well inside.
/// `ONLINE_HOPS=300000` makes the tests compare that many hops.
#[test]
fn warm_cold_and_canonical_decisions_are_the_same_on_every_land() {
    let lands = [Land::Flat, Land::Rough, Land::Trap, Land::Rocky, Land::Doubtful];
    let mut tally = Tally::default();
    let wanted = hops_wanted(6_000);
    for seed in 0.. {
        for land in lands {
            fly(&mission(land, seed), seed, &mut tally);
        }
        if tally.hops() >= wanted {
            break;
        }
    }
    assert!(tally.warm > 0 && tally.canonical > 0 && tally.infeasible > 0, "{tally:?}");
    // Only gaps that happen to lie at the bound need a cold solve, not every tie.
    assert!(10 * tally.canonical < tally.hops(), "{tally:?}");
}

/// A mission over hills and sand, large enough for frozen levels behind the hopper.
fn hills_mission(fixture: Fixture, radius: f64) -> Mission {
    Mission {
        truth: fixture.world().expect("a size in range"),
        unseen: fixture.unseen().expect("a size in range"),
        start: fixture.start(),
        radius,
    }
}

/// P-SAME-HOP.
#[test]
fn focused_decisions_are_the_canonical_ones() {
    let places = [GoalPlace::Corner, GoalPlace::Inside, GoalPlace::Side];
    let mut tallies = [Tally::default(); 3];
    let mut solver = Solver::new();
    let wanted = hops_wanted(900);
    for seed in 0.. {
        let side = 92 + 8 * (seed % 3) as usize;
        let leaving = if seed % 2 == 0 { Leaving::Stays } else { Leaving::Loses };
        let (safety, information) = [(0.5, 0.5), (1.0, 0.0), (2.0, 3.0)][(seed / 2 % 3) as usize];
        let (place, tally) = (places[(seed % 3) as usize], &mut tallies[(seed % 3) as usize]);
        let fixture = Fixture { leaving, safety, information, place, ..Fixture::plain(side, seed) };
        let mission = hills_mission(fixture, [2.5, 4.0, 6.0][(seed / 3 % 3) as usize]);
        let mut online = OnlineSolver::new(mission.unseen.clone());
        let mut flight = mission.fly(seed);
        for _ in 0..3 * side {
            for (node, site) in flight.seen() {
                online.update(node, site);
            }
            let decision = online.act(flight.here, None);
            tally.count(&decision);
            let expected = canonical(&mut solver, online.world(), flight.here);
            assert_eq!(decision.action, expected, "seed {seed}, {decision:?}");
            if !decision.action.is_some_and(|hop| flight.hop(hop)) {
                break;
            }
        }
        if tallies.iter().map(Tally::hops).sum::<u64>() >= wanted {
            break;
        }
    }
    for tally in tallies {
        assert!(2 * tally.focused > tally.hops() && tally.focused > 100, "{tallies:?}");
    }
}

#[test]
fn the_margin_and_the_bound_of_a_decision_hold() {
    let mission = hills_mission(Fixture::plain(40, 5), 3.0);
    let mut solver = Solver::new();
    let mut online = OnlineSolver::new(mission.unseen.clone());
    let mut flight = mission.fly(5);
    loop {
        for (node, site) in flight.seen() {
            online.update(node, site);
        }
        let decision = online.act(flight.here, None);
        let Some(hop) = decision.action else { break };
        solver.solve(online.world(), &Effort { error_max: 1e-8, ..Effort::default() });
        let values = bellman::action_values(online.world(), solver.values(), flight.here);
        let others = Hop::ALL.iter().filter(|other| **other != hop).map(|other| values[*other as usize]);
        let margin = values[hop as usize] - others.fold(f64::NEG_INFINITY, f64::max);
        assert!(decision.margin <= margin + 1e-7, "{decision:?}, but {margin}");
        assert!(decision.margin >= margin - 2.0 * decision.bound - 1e-7, "{decision:?}, but {margin}");
        if !flight.hop(hop) {
            break;
        }
    }
}

/// P-AT-REST: Values updated after a change satisfy Bellman's equation everywhere, within the
/// certificate.
#[test]
fn every_warm_residual_is_within_the_certificate_wherever_it_was_measured_last() {
    for land in [Land::Rough, Land::Trap, Land::Rocky] {
        for seed in 0..12 {
            let mission = mission(land, seed);
            let mut online = OnlineSolver::new(mission.unseen.clone());
            let mut flight = mission.fly(seed);
            for _ in 0..12 {
                for (node, site) in flight.seen() {
                    online.update(node, site);
                }
                let hop = online.act(flight.here, None).action;
                assert_certified(&mut online, &(land, seed));
                if !flight.hop(hop.unwrap_or(Hop::North)) {
                    break;
                }
            }
        }
    }
}

/// P-AT-REST. A word of marks covers 64 blocks of 8 nodes; here changes cross from word to word.
#[test]
fn news_crosses_long_rings() {
    for (width, height, place) in [
        (5, 1_150, GoalPlace::Corner),
        (1_150, 5, GoalPlace::Corner),
        (90, 560, GoalPlace::Corner),
        (1_150, 24, GoalPlace::Inside),
        (24, 1_150, GoalPlace::Inside),
        (1_200, 9, GoalPlace::Side),
    ] {
        let mut draw = SplitMix64((width * height) as u64);
        let rules =
            Rules { discount: DISCOUNT, loss: -900.0, leaving: Leaving::Stays, soils: vec![HARD, SAND] };
        let mut world = GridWorld::new(width, height, rules).expect("a world in range");
        for node in 0..world.nodes() {
            let soil = u8::from(draw.uniform() < 0.1);
            let [east, north] = [(); 2].map(|()| draw.between(-0.2, 0.2));
            let payoff = -draw.uniform();
            world.set(node, Site { kind: Kind::Free, payoff, slope_east: east, slope_north: north, soil });
        }
        let goal = Fixture { width, height, place, ..Fixture::plain(1, 1) }.goal();
        world.set(goal, Site { kind: Kind::Goal, payoff: 100.0, ..world.site(goal) });
        let mut online = OnlineSolver::new(world);
        for _ in 0..24 {
            for _ in 0..4 {
                let node = (draw.uniform() * (width * height) as f64) as usize;
                let site = online.world().site(node);
                if site.kind == Kind::Free {
                    online.update(node, Site { payoff: site.payoff - 30.0 * draw.uniform(), ..site });
                }
            }
            assert_certified(&mut online, &(width, height));
        }
    }
}

#[test]
fn values_after_focused_decisions_come_back_to_the_certificate() {
    let mission = hills_mission(Fixture::plain(96, 2), 4.0);
    let mut online = OnlineSolver::new(mission.unseen.clone());
    let mut flight = mission.fly(2);
    let mut focused = 0;
    for hops in 0..60 {
        for (node, site) in flight.seen() {
            online.update(node, site);
        }
        let decision = online.act(flight.here, None);
        focused += u32::from(decision.method == Method::Focused);
        if hops % 13 == 12 {
            assert_certified(&mut online, &hops);
        }
        if !decision.action.is_some_and(|hop| flight.hop(hop)) {
            break;
        }
    }
    assert!(focused > 30, "{focused}");
}

#[test]
fn a_walled_in_goal_is_infeasible_and_a_spent_budget_is_cut() {
    let mut mission = mission(Land::Rough, 3);
    let goal = (0..mission.unseen.nodes()).find(|&node| mission.unseen.kind(node) == Kind::Goal).unwrap();
    for hop in Hop::ALL {
        if let Some(wall) = mission.unseen.neighbour(goal, hop) {
            let site = Site { kind: Kind::Lost, ..mission.unseen.site(wall) };
            mission.truth.set(wall, site);
        }
    }
    mission.start = (0..mission.truth.nodes()).find(|&node| mission.truth.kind(node) == Kind::Free).unwrap();
    let mut online = OnlineSolver::new(mission.unseen.clone());
    assert_eq!(online.act(mission.start, None).status, DecisionStatus::Solved);
    let cut = OnlineSolver::new(mission.unseen.clone()).act(mission.start, Some(1));
    assert_eq!(cut.status, DecisionStatus::Cut);
    assert!(cut.action.is_some() && cut.bound > 1e-6 && cut.bound.is_finite());
    for node in 0..mission.truth.nodes() {
        online.update(node, mission.truth.site(node));
    }
    let walled = online.act(mission.start, None);
    assert_eq!((walled.status, walled.action), (DecisionStatus::Infeasible, None));
    assert_eq!(online.act(goal, None).action, None);
    // The wall was a mistake.
    for node in 0..mission.truth.nodes() {
        online.update(node, mission.unseen.site(node));
    }
    assert_eq!(online.act(mission.start, None).status, DecisionStatus::Solved);
}

#[test]
fn the_slope_of_a_goal_is_no_news() {
    let mission = mission(Land::Rough, 3);
    let nodes = 0..mission.unseen.nodes();
    let goal = nodes.clone().find(|&node| mission.unseen.kind(node) == Kind::Goal).unwrap();
    let mut online = OnlineSolver::new(mission.unseen.clone());
    let before = online.act(mission.start, None);
    online.update(goal, Site { slope_east: 0.3, soil: 1, ..mission.unseen.site(goal) });
    let after = online.act(mission.start, None);
    assert_eq!((after.action, after.work), (before.action, 0));
}

/// P-ENDS: Every solve and every decision ends, on steep and slippery ground too.
///
/// Over-relaxed steps cycled here.
#[test]
fn a_relaxation_that_would_go_round_in_circles_comes_to_rest() {
    let rules = Rules { discount: DISCOUNT, loss: -100.0, leaving: Leaving::Stays, soils: vec![HARD, SAND] };
    let mut world = GridWorld::new(2, 3, rules).expect("a world in range");
    let sites = [
        (1.0, -1.0, 1.0, 0),
        (-1.0, 1.0, 0.0, 0),
        (4.0, 0.6, -0.6, 1),
        (12.0, 0.4, -1.0, 0),
        (-7.0, 1.0, -1.0, 0),
        (10.0, 0.0, 0.0, 1),
    ];
    for (node, (payoff, slope_east, slope_north, soil)) in sites.into_iter().enumerate() {
        let kind = if node == 5 { Kind::Goal } else { Kind::Free };
        world.set(node, Site { kind, payoff, slope_east, slope_north, soil });
    }
    let mut online = OnlineSolver::new(world);
    online.act(0, None);
    online.update(3, Site { payoff: 2.0, ..online.world().site(3) });
    let decision = online.act(0, Some(1_000_000));
    assert_eq!((decision.status, decision.method), (DecisionStatus::Solved, Method::Warm), "{decision:?}");
    assert_eq!(decision.action, canonical(&mut Solver::new(), online.world(), 0));
}

/// P-ENDS.
#[test]
fn every_relaxation_ends_on_steep_ground_too() {
    for seed in 0..400 {
        let mut draw = SplitMix64(seed);
        let mut pick = |from: usize, to: usize| draw.between(from as f64, to as f64) as usize;
        let (width, height) = (pick(1, 9), pick(2, 9));
        let leaving = if pick(0, 2) == 0 { Leaving::Stays } else { Leaving::Loses };
        let discount = [0.95, 0.99, 0.999][pick(0, 3)];
        let wild = Soil { intended: 0.0, stuck: 0.0, sideways: 0.5, wait: 0.0 };
        let rules = Rules { discount, loss: -100.0, leaving, soils: vec![HARD, SAND, wild] };
        let mut world = GridWorld::new(width, height, rules).expect("a world in range");
        let nodes = world.nodes();
        let soils = if seed % 4 == 0 { 3 } else { 2 };
        let site = |draw: &mut SplitMix64, node: usize| {
            let uniform = [(); 4].map(|()| draw.uniform());
            let slope = |uniform: f64| [-1.0, -0.4, 0.0, 0.4, 1.0][(5.0 * uniform) as usize];
            Site {
                kind: if node + 1 == nodes { Kind::Goal } else { Kind::Free },
                payoff: 30.0 * (uniform[0] - 0.5),
                slope_east: slope(uniform[1]),
                slope_north: slope(uniform[2]),
                soil: (f64::from(soils) * uniform[3]) as u8,
            }
        };
        for node in 0..nodes {
            world.set(node, site(&mut draw, node));
        }
        let mut online = OnlineSolver::new(world);
        for _ in 0..8 {
            for _ in 0..3 {
                let node = (draw.uniform() * (nodes - 1) as f64) as usize;
                online.update(node, site(&mut draw, node));
            }
            let decision = online.act(0, Some(10_000_000));
            assert_ne!(decision.status, DecisionStatus::Cut, "seed {seed}, {decision:?}");
            assert_certified(&mut online, &seed);
        }
    }
}

#[test]
fn what_a_lost_node_would_pay_is_without_meaning() {
    let mut world = Fixture::plain(100, 1).unseen().expect("a size in range");
    let lost = Site { kind: Kind::Lost, payoff: -1e307, ..world.site(5_050) };
    world.set(5_050, lost);
    assert_certified(&mut OnlineSolver::new(world), &lost);
}

/// A large loss makes the canonical procedure coarser, whatever was seen before.
#[test]
fn a_loss_that_nobody_can_meet_is_no_reason_to_fail() {
    let sure = Soil { intended: 1.0, stuck: 0.0, sideways: 0.0, wait: 0.0 };
    let rules = Rules { discount: 0.9, loss: -1.0, leaving: Leaving::Stays, soils: vec![sure] };
    let mut world = GridWorld::new(2, 2, rules).expect("a world in range");
    for (node, payoff) in [(1, 1.0 + TIE / 0.9), (2, 1.0)] {
        world.set(node, Site { kind: Kind::Goal, payoff, ..world.site(node) });
    }
    let mut online = OnlineSolver::new(world);
    online.act(0, None);
    online.set_loss(-1e8).expect("a finite loss");
    let novice = OnlineSolver::new(online.world().clone()).act(0, None);
    assert_eq!(online.act(0, None).action, novice.action);
}

#[test]
fn another_loss_is_taken_in_from_where_values_are() {
    for leaving in [Leaving::Loses, Leaving::Stays] {
        let fixture = Fixture { leaving, ..Fixture::plain(120, 5) };
        let mut world = fixture.world().expect("a size in range");
        for node in [40 * 120 + 60, 80 * 120 + 30] {
            world.set(node, Site { kind: Kind::Lost, ..world.site(node) });
        }
        let here = fixture.start();
        let mut online = OnlineSolver::new(world);
        let first = online.act(here, None).work;
        for change in [-1.0, -40.0, 25.0] {
            online.set_loss(online.world().rules().loss + change).expect("a finite loss");
            let decision = online.act(here, None);
            let mut solver = Solver::new();
            assert_eq!(decision.action, canonical(&mut solver, online.world(), here));
            assert!(decision.work < first / 2, "{} backups, the first time {first}", decision.work);
            assert_certified(&mut online, &(leaving, change));
        }
    }
}

#[test]
fn an_online_solver_may_change_its_goal_its_rules_and_its_loss() {
    let mut solver = Solver::new();
    for seed in 0..6 {
        let mission = mission(Land::Rocky, 4 * seed + 1);
        let mut online = OnlineSolver::new(mission.unseen.clone());
        let here = mission.start;
        let same = |online: &mut OnlineSolver, solver: &mut Solver| {
            let expected = canonical(solver, online.world(), here);
            assert_eq!(online.act(here, None).action, expected);
        };
        same(&mut online, &mut solver);
        online.set_loss(-4000.0).unwrap();
        same(&mut online, &mut solver);
        let goal = (0..mission.unseen.nodes()).find(|&node| mission.unseen.kind(node) == Kind::Goal).unwrap();
        online.update(goal, Site { kind: Kind::Free, payoff: 0.0, ..mission.unseen.site(goal) });
        assert_eq!(online.act(here, None).status, DecisionStatus::Infeasible);
        let other = (here + 2) % mission.unseen.nodes();
        online.update(other, Site { kind: Kind::Goal, payoff: 50.0, ..mission.unseen.site(other) });
        same(&mut online, &mut solver);
        online.replace(mission.truth.clone());
        same(&mut online, &mut solver);
    }
}
