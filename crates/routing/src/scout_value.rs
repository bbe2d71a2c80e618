//! The helicopter flies where the expected drop of the rover's travel time is largest: value of information, not spread.
//!
//! 1. Cells that touch and have one prior are a *region*; a region is assumed to have one true speed. This only guides the flight:
//!    the rover still believes no more than what was seen.
//! 2. A *scenario* gives each region a speed, drawn from the prior, or all combinations if they are few. The rover's best route in
//!    each scenario is a *candidate*.
//! 3. After a flight the rover takes the candidate that it believes fastest; in each scenario that takes a certain time. The
//!    average over the scenarios is what a flight is judged by.
//!    What the rover would do after the best flight found joins the candidates, and the search is repeated: so a flight counts for
//!    nothing if it shows a slow strip that the rover would only drive around, over ground just as slow.
//!    Beside it counts, with a small weight, how much of the spread a flight shows.
//! 4. Flights are put together from *scans*, along the uncertain parts of candidates, by a beam search that ranks them by the drop
//!    and by the drop per metre. The best is then improved by random changes.

use helicopter::{RowSums, length_m, swaths, within_budget};
use rover::{Belief, Caution, CostMap, Lattice, Point, Segment, Speed, SpeedDistribution, Surface, traverse};

use std::ops::ControlFlow;
use std::sync::Arc;

use crate::ett_exact::graph_route;
use crate::stream::Stream;
use crate::{Goal, Route, Trip};

/// Parameters of the search.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ScoutValue {
    /// Where the flight begins; by default where the rover starts.
    pub from: Option<Point>,
    /// Longest flight, metres.
    pub budget_m: f64,
    /// Radius of the ground in view.
    pub view_m: f64,
    /// Which cells the rover keeps out of.
    pub caution: Caution,
    /// Scenarios at most.
    pub scenarios: usize,
    /// Flights kept at each step of the beam search, by each of its two rankings.
    pub beam: usize,
    /// Random changes tried after each beam search.
    pub changes: usize,
    /// Beam searches at most, each with the candidates that the flight before gave rise to.
    pub rounds: usize,
}

impl Default for ScoutValue {
    fn default() -> Self {
        Self {
            from: None,
            budget_m: helicopter::BUDGET_M,
            view_m: helicopter::Camera::default().radius_m(),
            caution: Caution::default(),
            scenarios: 64,
            beam: 5,
            changes: 300,
            rounds: 2,
        }
    }
}

/// Cells of the map on which candidates are searched; larger maps are searched in blocks of cells.
const SEARCHED_CELLS: usize = 10_000;
/// Scans through one region at most, those of the likeliest scenarios.
const SCANS_PER_REGION: usize = 4;
/// Scans that one flight is put together from.
const SCANS_MAX: usize = 4;
/// What it would be worth to show all that is uncertain, in Sol. The rover's planner may find other routes than the candidates, so
/// of flights that are worth about the same, the one that shows more is better.
const SPREAD_SOL: f64 = 0.05;
/// What a metre of flight has to save to be flown, in Sol: it settles ties.
const METRE_SOL: f64 = 1e-7;
/// Time that a rover without a way, or one that gets stuck, counts with, in Sol.
const LOST_SOL: f64 = 20.0;

/// The flight of greatest value; its first point alone if no flight is worth anything.
#[must_use]
pub fn scout_value(belief: &Belief, trip: &Trip, settings: &ScoutValue, seed: u64) -> Vec<Point> {
    let mut random = Stream::new(seed, "scout_value");
    let regions = Regions::new(belief);
    let scenarios = Scenarios::new(&regions, settings.scenarios, &mut random);
    let drives = Drives::new(belief, &regions, &scenarios, trip, settings.caution);
    let mut candidates: Vec<Route> = drives.knowing_nothing().into_iter().collect();
    add(&mut candidates, drives.knowing_all());
    let mut flights = vec![vec![settings.from.unwrap_or(trip.start)]];
    for round in 1.. {
        let value = Value::new(&drives, &candidates, settings.view_m);
        // By all that is known by now of what the rover would do.
        flights.sort_by(|a, b| value.drop_sol(b).total_cmp(&value.drop_sol(a)));
        if round > settings.rounds {
            break;
        }
        let scans = scans(&value, settings.view_m);
        let flight = beam_search(&value, &scans, flights[0].clone(), settings);
        let flight = improve(&value, flight, settings, &mut random);
        if !add(&mut candidates, drives.knowing(&flight, settings.view_m)) {
            return flight;
        }
        flights.push(flight);
    }
    flights.swap_remove(0)
}

/// Adds the routes that are new, and says whether there were any.
fn add(candidates: &mut Vec<Route>, routes: Vec<Route>) -> bool {
    let before = candidates.len();
    for route in routes {
        if candidates.iter().all(|known| known.points != route.points) {
            candidates.push(route);
        }
    }
    candidates.len() > before
}

/// No region: the speed of the cell is certain.
const CERTAIN: u32 = u32::MAX;

/// Connected cells of one prior.
struct Regions {
    /// The region of each cell, or [`CERTAIN`].
    of: Vec<u32>,
    priors: Vec<SpeedDistribution>,
}

impl Regions {
    fn new(belief: &Belief) -> Self {
        let cells = belief.cells();
        let width = belief.surface().lattice().width();
        let uncertain = |cell: &SpeedDistribution| cell.probabilities().iter().all(|p| *p < 1.0);
        let mut of = vec![CERTAIN; cells.len()];
        let mut priors = Vec::new();
        let mut open = Vec::new();
        for first in 0..cells.len() {
            if of[first] != CERTAIN || !uncertain(&cells[first]) {
                continue;
            }
            let region = priors.len() as u32;
            priors.push(cells[first]);
            of[first] = region;
            open.push(first);
            while let Some(cell) = open.pop() {
                let column = cell % width;
                let neighbours = [
                    (column > 0).then(|| cell - 1),
                    (column + 1 < width).then_some(cell + 1),
                    cell.checked_sub(width),
                    (cell + width < cells.len()).then_some(cell + width),
                ];
                for next in neighbours.into_iter().flatten() {
                    if of[next] == CERTAIN && cells[next] == cells[first] {
                        of[next] = region;
                        open.push(next);
                    }
                }
            }
        }
        Self { of, priors }
    }
}

/// A speed for each region, with the probability of all of them.
struct Scenarios(Vec<(f64, Vec<Speed>)>);

impl Scenarios {
    fn new(regions: &Regions, most: usize, random: &mut Stream) -> Self {
        let possible = |prior: &SpeedDistribution| {
            Speed::ALL.into_iter().filter(|speed| prior.probability(*speed) > 0.0).collect::<Vec<_>>()
        };
        let combinations =
            regions.priors.iter().try_fold(1_usize, |count, prior| count.checked_mul(possible(prior).len()));
        if combinations.is_none_or(|count| count > most) {
            let share = 1.0 / most as f64;
            let mut draw = || regions.priors.iter().map(|prior| prior.quantile(random.uniform())).collect();
            return Self((0..most).map(|_| (share, draw())).collect());
        }
        let mut all = vec![(1.0, Vec::new())];
        for prior in &regions.priors {
            let with = |(weight, speeds): &(f64, Vec<Speed>)| {
                possible(prior)
                    .into_iter()
                    .map(|speed| (weight * prior.probability(speed), [speeds.as_slice(), &[speed]].concat()))
                    .collect::<Vec<_>>()
            };
            all = all.iter().flat_map(with).collect();
        }
        // The likeliest first.
        all.sort_by(|a, b| b.0.total_cmp(&a.0));
        Self(all)
    }
}

/// What the rover does if it knows more.
struct Drives<'a> {
    belief: &'a Belief,
    regions: &'a Regions,
    scenarios: &'a Scenarios,
    trip: &'a Trip,
    caution: Caution,
    blocks: Blocks,
    /// Pace of each cell under the belief as it is; infinite if forbidden.
    expected: Vec<f64>,
    /// Standard deviations of the speed, over their sum.
    spread: RowSums,
}

impl<'a> Drives<'a> {
    fn new(
        belief: &'a Belief,
        regions: &'a Regions,
        scenarios: &'a Scenarios,
        trip: &'a Trip,
        caution: Caution,
    ) -> Self {
        let expected = belief.expected_time(caution).costs().to_vec();
        let blocks = Blocks::new(belief.surface().lattice());
        let sd: Vec<f64> = belief.cells().iter().map(SpeedDistribution::sd_m_per_sol).collect();
        let total: f64 = sd.iter().sum();
        let spread =
            RowSums::new(belief.surface().lattice(), sd.iter().map(|sd| sd / total.max(f64::MIN_POSITIVE)));
        Self { belief, regions, scenarios, trip, caution, blocks, expected, spread }
    }

    /// Its route without a flight.
    fn knowing_nothing(&self) -> Option<Route> {
        self.blocks.route(self.trip, |cell| self.expected[cell])
    }

    /// Its route in each scenario, if it knew that it is this one.
    fn knowing_all(&self) -> Vec<Route> {
        self.routes(|_| true)
    }

    /// Its route in each scenario after a flight. Among them are those around what was seen to be slow, through parts of the same
    /// region that were not seen.
    fn knowing(&self, flight: &[Point], view_m: f64) -> Vec<Route> {
        let lattice = self.belief.surface().lattice();
        let mut seen = vec![false; lattice.cells()];
        for swath in swaths(lattice, flight, view_m) {
            for cell in swath.cells(lattice) {
                seen[cell] = true;
            }
        }
        self.routes(|cell| seen[cell])
    }

    fn routes(&self, known: impl Fn(usize) -> bool) -> Vec<Route> {
        let routes = self.scenarios.0.iter().filter_map(|(_, speeds)| {
            let paces: Vec<f64> = speeds.iter().map(|speed| speed.pace_sol_per_m()).collect();
            self.blocks.route(self.trip, |cell| match self.regions.of[cell] {
                CERTAIN => self.expected[cell],
                region if known(cell) => paces[region as usize],
                _ => self.expected[cell],
            })
        });
        routes.collect()
    }
}

/// The map in square blocks of cells; each counts with its slowest cell, so what is passable in blocks is so in cells.
struct Blocks {
    fine: Lattice,
    coarse: Lattice,
    surface: Arc<Surface>,
    side: usize,
}

impl Blocks {
    fn new(fine: Lattice) -> Self {
        let mut side = 1;
        while fine.cells() / (side * side) > SEARCHED_CELLS {
            side += 1;
        }
        let coarse = Lattice::new(fine.width().div_ceil(side), fine.height().div_ceil(side))
            .expect("no longer than the sides of the map");
        Self { fine, coarse, surface: Arc::new(Surface::flat(coarse)), side }
    }

    fn route(&self, trip: &Trip, pace: impl Fn(usize) -> f64) -> Option<Route> {
        let side = self.side as f64;
        let mut costs = vec![0.0_f64; self.coarse.cells()];
        for row in 0..self.fine.height() {
            let coarse_row = row / self.side * self.coarse.width();
            for column in 0..self.fine.width() {
                let cost = &mut costs[coarse_row + column / self.side];
                *cost = cost.max(side * pace(row * self.fine.width() + column));
            }
        }
        // Rover and goal may stand in a block with an obstacle.
        let scaled = |point: Point| Point::new(point.x_m / side, point.y_m / side);
        let goal = Goal { at: scaled(trip.goal.at), radius_m: trip.goal.radius_m / side };
        let costs = CostMap::new(Arc::clone(&self.surface), costs);
        let mut route = graph_route(&costs, &Trip { start: scaled(trip.start), goal })?;
        for point in &mut route.points {
            *point = Point::new(point.x_m * side, point.y_m * side);
        }
        Some(route)
    }
}

/// A candidate, cut by what is known of it.
struct Cut {
    certain_sol: f64,
    /// Middles of the uncertain cells, with their region's place in `regions` and the way through them.
    pieces: Vec<(Point, usize, f64)>,
    /// The regions that it crosses.
    regions: Vec<usize>,
    /// Time for a metre in each region by the prior; infinite if forbidden.
    prior_pace: Vec<f64>,
    /// Time for a metre in each of the regions, in scenario after scenario; infinite if forbidden.
    scenario_paces: Vec<f64>,
}

/// What flights are worth.
struct Value {
    cuts: Vec<Cut>,
    weights: Vec<f64>,
    view_squared: f64,
    /// Expected time without a flight.
    without_sol: f64,
    /// Standard deviations of the speed, over their sum.
    spread: RowSums,
    lattice: Lattice,
    view_m: f64,
}

impl Value {
    fn new(drives: &Drives<'_>, candidates: &[Route], view_m: f64) -> Self {
        let mut value = Self {
            cuts: candidates.iter().map(|route| cut(drives, route)).collect(),
            weights: drives.scenarios.0.iter().map(|scenario| scenario.0).collect(),
            view_squared: view_m * view_m,
            without_sol: 0.0,
            spread: drives.spread.clone(),
            lattice: drives.belief.surface().lattice(),
            view_m,
        };
        value.without_sol = value.expected_sol(&[]);
        value
    }

    /// The rover's expected time after a flight.
    fn expected_sol(&self, flight: &[Point]) -> f64 {
        let lengths: Vec<Vec<(f64, f64)>> = self.cuts.iter().map(|cut| self.lengths(cut, flight)).collect();
        let mut sum = 0.0;
        for (scenario, weight) in self.weights.iter().enumerate() {
            let mut best = (f64::INFINITY, LOST_SOL);
            for (cut, lengths) in self.cuts.iter().zip(&lengths) {
                let (mut believed, mut true_sol) = (cut.certain_sol, cut.certain_sol);
                let paces = &cut.scenario_paces[scenario * cut.regions.len()..];
                for (((seen_m, unseen_m), pace), prior) in lengths.iter().zip(paces).zip(&cut.prior_pace) {
                    believed += part(*seen_m, *pace) + part(*unseen_m, *prior);
                    true_sol += part(seen_m + unseen_m, *pace);
                }
                if believed < best.0 {
                    best = (believed, true_sol);
                }
            }
            sum += weight * best.1.min(LOST_SOL);
        }
        sum
    }

    /// Metres of a candidate in each of its regions, seen and unseen.
    fn lengths(&self, cut: &Cut, flight: &[Point]) -> Vec<(f64, f64)> {
        let mut lengths = vec![(0.0, 0.0); cut.regions.len()];
        for (middle, region, piece_m) in &cut.pieces {
            let seen = flight.windows(2).any(|leg| distance_squared(*middle, leg) <= self.view_squared);
            let (seen_m, unseen_m) = &mut lengths[*region];
            *(if seen { seen_m } else { unseen_m }) += piece_m;
        }
        lengths
    }

    /// The drop of the expected time, with what settles ties: the spread shown, and then the length.
    fn drop_sol(&self, flight: &[Point]) -> f64 {
        self.without_sol - self.expected_sol(flight) - METRE_SOL * length_m(flight)
            + SPREAD_SOL * self.spread_shown(flight)
    }

    /// Σ SD over the cells that a flight shows, over that of the whole map.
    fn spread_shown(&self, flight: &[Point]) -> f64 {
        let swaths: Vec<_> = swaths(self.lattice, flight, self.view_m).collect();
        let fresh = |at: usize| self.spread.fresh(&swaths[at], &swaths[..at].iter().collect::<Vec<_>>());
        (0..swaths.len()).map(fresh).sum()
    }
}

/// The time for a way; 0 for none, also where it would take forever.
fn part(length_m: f64, pace: f64) -> f64 {
    if length_m > 0.0 { length_m * pace } else { 0.0 }
}

fn distance_squared(point: Point, leg: &[Point]) -> f64 {
    let (dx, dy) = (leg[1].x_m - leg[0].x_m, leg[1].y_m - leg[0].y_m);
    let (px, py) = (point.x_m - leg[0].x_m, point.y_m - leg[0].y_m);
    let squared = dx * dx + dy * dy;
    let share = if squared > 0.0 { ((px * dx + py * dy) / squared).clamp(0.0, 1.0) } else { 0.0 };
    (px - share * dx).powi(2) + (py - share * dy).powi(2)
}

fn cut(drives: &Drives<'_>, route: &Route) -> Cut {
    let (belief, regions, scenarios) = (drives.belief, drives.regions, drives.scenarios);
    let (surface, lattice) = (belief.surface(), belief.surface().lattice());
    let mut cut = Cut {
        certain_sol: 0.0,
        pieces: Vec::new(),
        regions: Vec::new(),
        prior_pace: Vec::new(),
        scenario_paces: Vec::new(),
    };
    for pair in route.points.windows(2) {
        let segment = Segment { from: pair[0], to: pair[1] };
        let direction = segment.direction();
        let _ = traverse(lattice, segment, |cell, piece_m| {
            let ground_m = piece_m * surface.stretch(cell, direction);
            if regions.of[cell] == CERTAIN {
                cut.certain_sol += ground_m * drives.expected[cell];
            } else {
                let region = regions.of[cell] as usize;
                let place = cut.regions.iter().position(|known| *known == region).unwrap_or_else(|| {
                    cut.regions.push(region);
                    cut.regions.len() - 1
                });
                cut.pieces.push((lattice.centre(cell), place, ground_m));
            }
            ControlFlow::<()>::Continue(())
        });
    }
    cut.prior_pace =
        cut.regions.iter().map(|region| drives.caution.pace_sol_per_m(&regions.priors[*region])).collect();
    let pace = |speeds: &Vec<Speed>| {
        cut.regions.iter().map(|region| speeds[*region].pace_sol_per_m()).collect::<Vec<_>>()
    };
    cut.scenario_paces = scenarios.0.iter().flat_map(|(_, speeds)| pace(speeds)).collect();
    cut
}

/// Ways over the uncertain parts of the candidates: begin and end, shortened by what the camera sees ahead.
fn scans(value: &Value, view_m: f64) -> Vec<[Point; 2]> {
    let mut scans: Vec<(usize, [Point; 2])> = Vec::new();
    for cut in &value.cuts {
        for (place, region) in cut.regions.iter().enumerate() {
            let within = || cut.pieces.iter().filter(|piece| piece.1 == place).map(|piece| piece.0);
            let (Some(first), Some(last)) = (within().next(), within().next_back()) else { continue };
            let span_m = first.distance_m(last);
            let inset = if span_m > 0.0 { (0.6 * view_m / span_m).min(0.5) } else { 0.0 };
            let scan = [first.towards(last, inset), last.towards(first, inset)];
            let alike =
                |other: &[Point; 2]| scan[0].distance_m(other[0]) < 4.0 && scan[1].distance_m(other[1]) < 4.0;
            let known = scans.iter().filter(|other| other.0 == *region);
            if known.clone().count() < SCANS_PER_REGION && !known.into_iter().any(|other| alike(&other.1)) {
                scans.push((*region, scan));
            }
        }
    }
    scans.into_iter().map(|scan| scan.1).collect()
}

/// The best flight over some scans in some order.
///
/// `known` is the best so far, by what was known of the rover's routes then; it stays if nothing is better.
fn beam_search(value: &Value, scans: &[[Point; 2]], known: Vec<Point>, settings: &ScoutValue) -> Vec<Point> {
    let mut beam = vec![known[..1].to_vec()];
    let mut best = (value.drop_sol(&known), known);
    for _ in 0..SCANS_MAX {
        let mut longer: Vec<(f64, Vec<Point>)> = Vec::new();
        for flight in &beam {
            for [a, b] in scans {
                for scan in [[*a, *b], [*b, *a]] {
                    let mut flight = flight.clone();
                    flight.extend(scan);
                    let flight = within_budget(&flight, settings.budget_m);
                    longer.push((value.drop_sol(&flight), flight));
                }
            }
        }
        longer.sort_by(|a, b| b.0.total_cmp(&a.0));
        match longer.first() {
            Some(first) if first.0 > best.0 => best = first.clone(),
            Some(_) => {}
            None => break,
        }
        beam = longer.iter().take(settings.beam).map(|flight| flight.1.clone()).collect();
        longer.sort_by(|a, b| (b.0 / length_m(&b.1)).total_cmp(&(a.0 / length_m(&a.1))));
        let by_metre = longer.into_iter().take(settings.beam).map(|flight| flight.1);
        beam.extend(by_metre.filter(|flight| !beam.contains(flight)).collect::<Vec<_>>());
    }
    best.1
}

/// Moves, adds and leaves out waypoints at random, and keeps what is better.
fn improve(value: &Value, flight: Vec<Point>, settings: &ScoutValue, random: &mut Stream) -> Vec<Point> {
    let mut best = (value.drop_sol(&flight), flight);
    for _ in 0..settings.changes {
        let mut flight = best.1.clone();
        if flight.len() < 2 {
            break;
        }
        let at = 1 + (random.uniform() * (flight.len() - 1) as f64) as usize;
        let reach_m = settings.view_m * random.uniform();
        let mut moved = |point: Point| {
            Point::new(
                point.x_m + random.between(-reach_m, reach_m),
                point.y_m + random.between(-reach_m, reach_m),
            )
        };
        match (moved(Point::default()).x_m.abs() * 8.0 / reach_m.max(1e-9)) as usize {
            0 => {
                flight.remove(at);
            }
            1 => flight.insert(at, moved(flight[at - 1].towards(flight[at], 0.5))),
            _ => flight[at] = moved(flight[at]),
        }
        // Beyond the border there is nothing to see, and no such flight would be let pass.
        if !flight.iter().all(|point| value.lattice.contains(*point)) {
            continue;
        }
        let flight = within_budget(&flight, settings.budget_m);
        let drop = value.drop_sol(&flight);
        if drop > best.0 {
            best = (drop, flight);
        }
    }
    best.1
}

#[cfg(test)]
mod tests {
    use super::*;
    use rover::Truth;

    /// 120 x 80 cells: a wall with a sure but slow gap in the north and an uncertain one in the south. A patch far behind the start
    /// is more uncertain than both, and helps nobody.
    fn gaps() -> (Belief, Trip) {
        let lattice = Lattice::new(120, 80).unwrap();
        let cell = |cell: usize| match (cell % 120, cell / 120) {
            (50..70, 60..70) => SpeedDistribution::certain(Speed::Slow),
            (50..70, 10..20) => SpeedDistribution::new([0.4, 0.0, 0.0, 0.6]).unwrap(),
            (50..70, _) => SpeedDistribution::certain(Speed::Zero),
            (0..10, 40..80) => SpeedDistribution::new([0.5, 0.0, 0.0, 0.5]).unwrap(),
            _ => SpeedDistribution::certain(Speed::Fast),
        };
        let belief =
            Belief::new(Arc::new(Surface::flat(lattice)), (0..lattice.cells()).map(cell).collect()).unwrap();
        let goal = Goal { at: Point::new(110.0, 30.0), radius_m: 3.0 };
        (belief, Trip { start: Point::new(15.0, 40.0), goal })
    }

    #[test]
    fn the_flight_shows_the_gap_that_would_save_most_and_not_what_is_spread_most() {
        let (belief, trip) = gaps();
        let flight = scout_value(&belief, &trip, &ScoutValue { view_m: 12.0, ..ScoutValue::default() }, 1);
        assert_eq!(flight[0], trip.start);
        let apart = Point::new(20.0, 20.0);
        let settings = ScoutValue { view_m: 12.0, from: Some(apart), ..ScoutValue::default() };
        let flight = scout_value(&belief, &trip, &settings, 1);
        assert!(
            flight[0] == apart && flight.len() > 1,
            "it looks at the gap for the rover from elsewhere: {flight:?}"
        );
        assert!(length_m(&flight) <= helicopter::BUDGET_M + 1e-9);
        let truth = Truth { speeds: vec![Speed::Fast; belief.cells().len()] };
        let mut known = belief.clone();
        helicopter::scout(&mut known, &truth, &flight, 12.0);
        let costs = known.expected_time(Caution::default());
        let route = crate::ett_exact(&costs, &trip, 0.0).unwrap();
        assert!(route.points.iter().all(|point| point.y_m < 50.0), "{:?} after {flight:?}", route.points);
    }

    #[test]
    fn knowing_where_nothing_is_uncertain_is_worth_no_flight() {
        let (belief, trip) = gaps();
        let known = Truth { speeds: vec![Speed::Fast; belief.cells().len()] };
        let belief = known.known(Arc::clone(belief.surface())).unwrap();
        assert_eq!(scout_value(&belief, &trip, &ScoutValue::default(), 1), [trip.start]);
    }

    #[test]
    fn few_combinations_are_enumerated_and_their_probabilities_sum_to_one() {
        let (belief, _) = gaps();
        let regions = Regions::new(&belief);
        assert_eq!(regions.priors.len(), 2);
        let scenarios = Scenarios::new(&regions, 64, &mut Stream::new(1, "test"));
        assert_eq!(scenarios.0.len(), 4);
        assert!((scenarios.0.iter().map(|scenario| scenario.0).sum::<f64>() - 1.0).abs() < 1e-12);
        assert_eq!(Scenarios::new(&regions, 3, &mut Stream::new(1, "test")).0.len(), 3);
    }
}
