//! What the hopper is offered, case by case: the collision check, the vertical hop, the edge, sand.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

use contract::Direction::{East, North, South, West};
use contract::{Cell, Soil};
use p22::{Choice, Edge, Experiment, GoalPayoff, HalfHops, Hop, KnownMap, LongHops, Model, P22, Reading};

/// Height of the low rock, metres.
const LOW_M: f64 = 0.25;

struct Offered<'a> {
    world: &'a KnownMap,
    model: &'a Model,
    index: usize,
}

impl Offered<'_> {
    fn hops(&self) -> Vec<Hop> {
        self.model.choices_of(self.index).map(|choice| self.model.choices[choice].hop).collect()
    }

    fn choice(&self, hop: Hop) -> (&Choice, [Option<Cell>; 4]) {
        let found = self.model.choices_of(self.index).find(|&choice| self.model.choices[choice].hop == hop);
        let found = found.unwrap_or_else(|| panic!("{hop:?} needs to be offered, got {:?}", self.hops()));
        let cell = |index: usize| (index < self.model.cells()).then(|| self.world.grid.cell(index));
        (&self.model.choices[found], self.model.landings[found].map(|landing| cell(landing.index)))
    }
}

fn offered<'a>(world: &'a KnownMap, model: &'a Model, x: i32, y: i32) -> Offered<'a> {
    Offered { world, model, index: world.grid.index(Cell::new(x, y)).unwrap() }
}

fn built(experiment: Experiment, reading: &Reading) -> (KnownMap, Model) {
    let world = KnownMap::new(experiment, reading);
    let model = Model::new(&world, reading);
    (world, model)
}

/// P-KNOWN-RULES: A vertical hop replaces a hop that collides, a slip into a rock bounces off, and
/// nothing enters the tall rock.
#[test]
fn where_the_flight_at_45_degrees_collides_the_vertical_hop_takes_its_place() {
    let (world, model) = built(Experiment::Rocks, &P22);
    // The low rock's western border lies between (9, 11) and (10, 11).
    let before_rock = offered(&world, &model, 9, 11);
    assert_eq!(
        before_rock.hops(),
        [Hop::Forward(North), Hop::Up(East), Hop::Forward(South), Hop::Forward(West)]
    );
    let (up, landings) = before_rock.choice(Hop::Up(East));
    let failing = LOW_M / (0.5 * 80f64.to_radians().sin().powi(2));
    assert!((up.scatter.intended - 0.7 * (1.0 - failing)).abs() < 1e-12, "{up:?}");
    assert!((up.scatter.stayed - failing).abs() < 1e-12, "{up:?}");
    assert_eq!(landings, [(10, 11), (9, 11), (9, 12), (9, 10)].map(|(x, y)| Some(Cell::new(x, y))));
}

/// P-KNOWN-RULES.
#[test]
fn nothing_hops_at_the_tall_rock_and_a_slip_into_it_is_bounced_off() {
    let (world, model) = built(Experiment::Rocks, &P22);
    // The tall rock begins at x = 3.
    let beside = offered(&world, &model, 2, 4);
    assert_eq!(beside.hops(), [Hop::Forward(North), Hop::Forward(South), Hop::Forward(West)]);
    let (_, landings) = beside.choice(Hop::Forward(North));
    assert_eq!(landings, [(2, 5), (2, 4), (1, 4), (2, 4)].map(|(x, y)| Some(Cell::new(x, y))));
    let up_there = model.choices.iter().zip(&model.landings).filter(|(choice, _)| choice.hop.is_up());
    for (choice, landings) in up_there {
        assert_eq!(world.ground[landings[0].index].height_m, LOW_M, "{choice:?}");
    }
}

#[test]
fn the_vertical_hop_is_offered_nowhere_but_around_the_low_rock() {
    let (world, model) = built(Experiment::Rocks, &P22);
    let ups = model.choices.iter().filter(|choice| choice.hop.is_up()).count();
    // Three cells on each of four sides.
    assert_eq!(ups, 12);
    for experiment in [Experiment::Hard, Experiment::Heterogeneous, Experiment::Sandy] {
        let (_, model) = built(experiment, &P22);
        assert!(model.choices.iter().all(|choice| !choice.hop.is_up()), "{experiment}: hills never collide");
    }
    let down = offered(&world, &model, 10, 11).choice(Hop::Forward(West)).1;
    assert_eq!(down[0], Some(Cell::new(9, 11)), "off the rock it hops at 45°");
}

#[test]
fn a_rock_of_the_steep_apex_is_too_high_and_one_a_little_lower_is_not() {
    for (rock_m, climbed) in [(0.26, true), (0.484, true), (0.485, false), (0.6, false)] {
        let mut world = KnownMap::new(Experiment::Rocks, &P22);
        let low = world.grid.index(Cell::new(11, 11)).unwrap();
        for ground in &mut world.ground {
            ground.height_m = 0.0;
        }
        world.ground[low].height_m = rock_m;
        let model = Model::new(&world, &P22);
        let hops = offered(&world, &model, 10, 11).hops();
        assert_eq!(hops.contains(&Hop::Up(East)), climbed, "{rock_m} m: {hops:?}");
        assert!(!hops.contains(&Hop::Forward(East)), "{rock_m} m: {hops:?}");
    }
}

#[test]
fn beyond_the_edge_a_hop_is_dropped_or_stays_or_ends() {
    for (edge, offered_west, west, slip) in [
        (Edge::Dropped, false, None, Some(Cell::new(0, 5))),
        (Edge::Stays, true, Some(Cell::new(0, 5)), Some(Cell::new(0, 5))),
        (Edge::Ends, true, None, None),
    ] {
        let (world, model) = built(Experiment::Hard, &Reading { edge, ..P22 });
        let at = offered(&world, &model, 0, 5);
        assert_eq!(at.hops().contains(&Hop::Forward(West)), offered_west, "{edge:?}");
        if offered_west {
            assert_eq!(at.choice(Hop::Forward(West)).1[0], west, "{edge:?}");
        }
        assert_eq!(at.choice(Hop::Forward(North)).1[2], slip, "{edge:?}");
    }
}

#[test]
fn sand_holds_one_hop_in_five_and_takes_two_periods_where_it_halves_the_hop() {
    let cell = (8, 6);
    let (world, one) = built(Experiment::Heterogeneous, &Reading { half_hops: HalfHops::OnePeriod, ..P22 });
    let at = offered(&world, &one, cell.0, cell.1);
    assert_eq!(world.ground[at.index].soil, Soil::Sand);
    let east = at.choice(Hop::Forward(East)).0.scatter;
    let sum = east.intended + east.stayed + east.left + east.right;
    assert!((sum - 1.0).abs() < 1e-12 && east.stayed >= 0.2 && east.intended <= 0.5, "{east:?}");
    let (_, two) = built(Experiment::Heterogeneous, &P22);
    let choice = one.choices_of(at.index).next().unwrap();
    let factor = |model: &Model| model.landings[choice].iter().map(|landing| landing.factor).sum::<f64>();
    assert!((factor(&one) - 1.0).abs() < 1e-12);
    assert!((factor(&two) - P22.discount).abs() < 1e-12);
    let (now, later) = (one.choices[choice].terms, two.choices[choice].terms);
    for (now, later) in now.into_iter().zip(later) {
        assert!((later - (now + P22.discount * now)).abs() < 1e-12, "stands, then hops, at the same cell");
    }
}

#[test]
fn a_hop_of_two_metres_leads_two_cells_on_in_the_sandy_world() {
    for (long_hops, on, aside) in
        [(LongHops::TwoCells, 2, 2), (LongHops::TwoCellsSlippingOne, 2, 1), (LongHops::OneCell, 1, 1)]
    {
        let (world, model) = built(Experiment::Sandy, &Reading { long_hops, ..P22 });
        let hard = world.grid.iter().find(|cell| {
            world.at(*cell).unwrap().soil == Soil::Hard
                && (3..16).contains(&cell.x)
                && (3..16).contains(&cell.y)
        });
        let Cell { x, y } = hard.expect("some hard ground");
        let landings = offered(&world, &model, x, y).choice(Hop::Forward(North)).1;
        assert_eq!(landings[0], Some(Cell::new(x, y + on)), "{long_hops:?}");
        assert_eq!(landings[2], Some(Cell::new(x - aside, y)), "{long_hops:?}");
    }
}

#[test]
fn where_the_goal_ends_the_journey_nothing_is_offered_there() {
    for (goal_payoff, offers) in
        [(GoalPayoff::Once, 0), (GoalPayoff::ForEver, 0), (GoalPayoff::EveryPeriod, 4)]
    {
        let (world, model) = built(Experiment::Hard, &Reading { goal_payoff, ..P22 });
        assert_eq!(offered(&world, &model, 18, 18).hops().len(), offers, "{goal_payoff:?}");
    }
}

#[test]
fn safety_and_information_span_their_whole_intervals() {
    for experiment in Experiment::ALL {
        let (world, model) = built(experiment, &Reading { half_hops: HalfHops::OnePeriod, ..P22 });
        let reaches = |term: usize, end: f64| {
            model.choices.iter().map(|choice| (choice.terms[term] - end).abs()).fold(f64::INFINITY, f64::min)
        };
        let ends = [(0, -1.0), (0, 0.0), (1, 0.0), (1, 1.0)];
        for (term, end) in ends {
            assert!(reaches(term, end) < 1e-12, "{experiment}, term {term} at {end}");
        }
        assert!(world.ground.iter().all(|ground| ground.height_m.is_finite()));
    }
}
