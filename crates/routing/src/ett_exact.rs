//! The route of least expected travel time, searched completely.
//!
//! The search is optimal on the graph of cell middles with 16 neighbours each (king's and knight's moves), whose edges cost the
//! exact integral over the cells they cross. The route is then pulled tight, which also frees it from the cell middles. With a
//! clearance, moves and straight lines that come nearer to forbidden cells are left out ([`KeptClear`]).
//! [`lower_bound`](fn@crate::lower_bound) says how much cheaper any route could be.

use std::f64::consts::SQRT_2;

use rover::{CostMap, Point, Segment};

use crate::kept_clear::distance_m;
use crate::shorten::pull_tight;
use crate::{Goal, KeptClear, Route, Trip};

/// The route, or none if no route to the goal keeps the clearance from forbidden cells: 0 for none.
#[must_use]
pub fn ett_exact(costs: &CostMap, trip: &Trip, clearance_m: f64) -> Option<Route> {
    let kept = KeptClear::new(costs, trip, clearance_m);
    let clearance = (clearance_m > 0.0).then(|| Clearance::new(&kept, clearance_m));
    let mut points = Search::new(costs, trip.goal, clearance).run(trip.start)?.points;
    pull_tight(&kept, &mut points);
    Some(Route::new(costs, points))
}

/// The route with the clearance that it keeps: the one asked for or, where no route keeps that, none.
#[must_use]
pub fn ett_exact_or_closer(costs: &CostMap, trip: &Trip, clearance_m: f64) -> Option<(Route, f64)> {
    let clear = ett_exact(costs, trip, clearance_m).map(|route| (route, clearance_m));
    if clearance_m <= 0.0 {
        return clear;
    }
    clear.or_else(|| Some((ett_exact(costs, trip, 0.0)?, 0.0)))
}

/// The cheapest route on the graph alone, before it is pulled tight.
#[must_use]
pub fn graph_route(costs: &CostMap, trip: &Trip) -> Option<Route> {
    Search::new(costs, trip.goal, None).run(trip.start)
}

/// A move to a neighbour: the cells it crosses, each with the same length.
struct Move {
    columns: isize,
    rows: isize,
    /// Cells between the first and the last, as (columns, rows) from the first.
    between: &'static [(isize, isize)],
    /// Metres in each of the cells.
    piece_m: f64,
}

const SQRT_5: f64 = 2.236_067_977_499_79;

const fn step(columns: isize, rows: isize, between: &'static [(isize, isize)]) -> Move {
    let piece_m = match (columns * columns + rows * rows, between.len()) {
        (1, _) => 0.5,
        (2, _) => SQRT_2 / 2.0,
        _ => SQRT_5 / 4.0,
    };
    Move { columns, rows, between, piece_m }
}

const MOVES: [Move; 16] = [
    step(1, 0, &[]),
    step(0, 1, &[]),
    step(-1, 0, &[]),
    step(0, -1, &[]),
    step(1, 1, &[]),
    step(-1, 1, &[]),
    step(-1, -1, &[]),
    step(1, -1, &[]),
    step(2, 1, &[(1, 0), (1, 1)]),
    step(1, 2, &[(0, 1), (1, 1)]),
    step(-1, 2, &[(0, 1), (-1, 1)]),
    step(-2, 1, &[(-1, 0), (-1, 1)]),
    step(-2, -1, &[(-1, 0), (-1, -1)]),
    step(-1, -2, &[(0, -1), (-1, -1)]),
    step(1, -2, &[(0, -1), (1, -1)]),
    step(2, -1, &[(1, 0), (1, -1)]),
];

/// The lines along which moves lead, each both ways: the moves 0, 1, 4, 5 and 8 to 11.
const LINES: [(isize, isize); 8] = [(1, 0), (0, 1), (1, 1), (-1, 1), (2, 1), (1, 2), (-1, 2), (-2, 1)];

/// The line of a move.
const fn line(number: usize) -> usize {
    match number {
        0..4 => number % 2,
        4..8 => 2 + number % 2,
        _ => 4 + number % 4,
    }
}

/// Which moves keep clear of forbidden cells.
struct Clearance<'a> {
    kept: &'a KeptClear<'a>,
    /// For each move, the cells that it comes too near to, as (columns, rows) from its first.
    too_near: [Vec<(isize, isize)>; MOVES.len()],
}

impl<'a> Clearance<'a> {
    fn new(kept: &'a KeptClear<'a>, clearance_m: f64) -> Self {
        let rings = clearance_m.ceil() as isize + 2;
        let too_near = std::array::from_fn(|number| {
            let Move { columns, rows, .. } = MOVES[number];
            let to = Point::new(columns as f64 + 0.5, rows as f64 + 0.5);
            let segment = Segment { from: Point::new(0.5, 0.5), to };
            let square = -rings..=rings;
            let cells = square.clone().flat_map(|row| square.clone().map(move |column| (column, row)));
            let is_too_near = |(column, row): &(isize, isize)| {
                kept.is_closer(distance_m(segment, Point::new(*column as f64, *row as f64)))
            };
            cells.filter(is_too_near).collect()
        });
        Self { kept, too_near }
    }

    /// The moves from a cell that come too near to a forbidden one, a bit each.
    fn blocked(&self, cell: usize) -> u32 {
        let lattice = self.kept.costs().lattice();
        let (width, height) = (lattice.width() as isize, lattice.height() as isize);
        let (column, row) = (cell as isize % width, cell as isize / width);
        let is_kept_from = |(columns, rows): &(isize, isize)| {
            let (column, row) = (column + columns, row + rows);
            (0..width).contains(&column)
                && (0..height).contains(&row)
                && self.kept.is_kept_from((row * width + column) as usize)
        };
        let blocked = self.too_near.iter().enumerate().filter(|(_, cells)| cells.iter().any(is_kept_from));
        blocked.fold(0, |blocked, (number, _)| blocked | 1 << number)
    }
}

/// A forbidden margin, so that no move has to ask whether it leaves the map.
const MARGIN: usize = 2;
/// In place of a move: the edge from the start.
const FROM_START: u8 = MOVES.len() as u8;
/// How many times finer buckets are on sloping ground.
const FINER: f64 = 32.0;
/// Cells whose middle is within this many columns and rows of the start are joined to it directly.
const JOINED: isize = 2;

/// A* in buckets instead of a heap: within a bucket the order does not matter for what is final, as a cell that gets cheaper is
/// searched again (Denardo & Fox 1979). The heuristic is the distance at the least cost per metre.
struct Search<'a> {
    costs: &'a CostMap,
    goal: Goal,
    clearance: Option<Clearance<'a>>,
    stride: usize,
    /// Cost per metre on the plane with the margin around.
    padded: Vec<f64>,
    /// Cost from the start, infinite if not reached yet.
    reached: Vec<f64>,
    /// The move that led to a cell.
    came_by: Vec<u8>,
    /// Cells to visit by their cost, in a ring of buckets whose number is a power of two.
    buckets: Vec<Vec<(f64, u32)>>,
    queued: usize,
    /// Estimate at the lower edge of bucket 0.
    origin: f64,
    /// Breadth of a bucket: a least edge. Slopes make edges differ by little, so many cells of such a bucket would get cheaper by little,
    /// again and again: there it is [`FINER`] times less.
    breadth: f64,
    /// The bucket in hand, counted from the origin.
    current: usize,
}

impl<'a> Search<'a> {
    fn new(costs: &'a CostMap, goal: Goal, clearance: Option<Clearance<'a>>) -> Self {
        let lattice = costs.lattice();
        let stride = lattice.width() + 2 * MARGIN;
        let cells = stride * (lattice.height() + 2 * MARGIN);
        let mut padded = vec![f64::INFINITY; cells];
        for (row, line) in costs.costs().chunks(lattice.width()).enumerate() {
            let first = (row + MARGIN) * stride + MARGIN;
            padded[first..first + line.len()].copy_from_slice(line);
        }
        let flat = costs.surface().is_flat();
        Self {
            costs,
            goal,
            clearance,
            stride,
            padded,
            reached: vec![f64::INFINITY; cells],
            came_by: vec![FROM_START; cells],
            buckets: Vec::new(),
            queued: 0,
            origin: 0.0,
            breadth: if flat { costs.least() } else { costs.least() / FINER },
            current: 0,
        }
    }

    fn run(mut self, start: Point) -> Option<Route> {
        if self.costs.least() == f64::INFINITY {
            return None;
        }
        if self.goal.distance_m(start) == 0.0 {
            return Some(Route { points: vec![start], cost: 0.0 });
        }
        self.open(start);
        let surface = self.costs.surface().as_ref();
        let width = self.costs.lattice().width() as isize;
        let directions = LINES.map(|(columns, rows)| {
            let to = Point::new(columns as f64, rows as f64);
            Segment { from: Point::new(0.0, 0.0), to }.direction()
        });
        let goal = self.goal;
        let near_m = SQRT_5 + 0.1;
        let mut best: Option<(f64, usize)> = None;
        let direct = Segment { from: start, to: goal.nearest(start) };
        let mut direct_cost =
            if goal.distance_m(start) < near_m { self.segment(direct) } else { f64::INFINITY };
        while self.queued > 0 {
            let limit = best.map_or(f64::INFINITY, |best| best.0);
            if self.origin + self.current as f64 * self.breadth > limit {
                break;
            }
            let slot = self.current & (self.buckets.len() - 1);
            let Some((reached, cell)) = self.buckets[slot].pop() else {
                self.current += 1;
                continue;
            };
            self.queued -= 1;
            let cell = cell as usize;
            if reached > self.reached[cell] {
                continue;
            }
            let centre = self.centre(cell);
            if goal.distance_m(centre) < near_m {
                let last = Segment { from: centre, to: goal.nearest(centre) };
                let cost = reached + self.segment(last);
                if cost < best.map_or(f64::INFINITY, |best| best.0) {
                    best = Some((cost, cell));
                }
            }
            if surface.is_flat() {
                self.relax(cell, reached, centre, |search, (columns, rows), _| {
                    search.padded[search.offset(cell, columns, rows)]
                });
            } else {
                let on_map = self.on_map(cell);
                self.relax(cell, reached, centre, |search, (columns, rows), line| {
                    let rate = search.padded[search.offset(cell, columns, rows)];
                    if rate == f64::INFINITY {
                        return rate;
                    }
                    let cell = on_map.wrapping_add_signed(rows * width + columns);
                    rate * surface.stretch(cell, directions[line])
                });
            }
        }
        if best.is_some_and(|best| best.0 < direct_cost) {
            direct_cost = f64::INFINITY;
        }
        if direct_cost < f64::INFINITY {
            return Some(Route { points: vec![direct.from, direct.to], cost: direct_cost });
        }
        best.map(|(cost, cell)| Route { points: self.way(start, cell), cost })
    }

    /// Opens the cells around the start.
    fn open(&mut self, start: Point) {
        let stretch_max = self.costs.surface().stretch_max();
        let longest = SQRT_5 * (self.costs.most() * stretch_max + self.costs.least());
        let spread = (longest / self.breadth).ceil() as usize;
        // The cells around the start differ by less than two moves.
        self.buckets = vec![Vec::new(); (2 * spread + 4).next_power_of_two()];
        let lattice = self.costs.lattice();
        let middle = lattice.cell(start);
        let (column, row) = ((middle % lattice.width()) as isize, (middle / lattice.width()) as isize);
        let mut opened = Vec::new();
        for row in (row - JOINED).max(0)..=(row + JOINED).min(lattice.height() as isize - 1) {
            for column in (column - JOINED).max(0)..=(column + JOINED).min(lattice.width() as isize - 1) {
                let cell = (row as usize + MARGIN) * self.stride + column as usize + MARGIN;
                let cost = self.segment(Segment { from: start, to: self.centre(cell) });
                if cost < f64::INFINITY {
                    opened.push((cost, cell));
                }
            }
        }
        let estimates = opened.iter().map(|(cost, cell)| cost + self.ahead(self.centre(*cell)));
        self.origin = estimates.fold(f64::INFINITY, f64::min);
        for (cost, cell) in opened {
            self.reached[cell] = cost;
            self.push(cost, cell, self.centre(cell));
        }
    }

    /// The cost of a segment that is no move.
    fn segment(&self, segment: Segment) -> f64 {
        match &self.clearance {
            Some(clearance) => clearance.kept.segment(segment),
            None => self.costs.segment(segment),
        }
    }

    fn centre(&self, cell: usize) -> Point {
        Point::new(
            (cell % self.stride) as f64 + 0.5 - MARGIN as f64,
            (cell / self.stride) as f64 + 0.5 - MARGIN as f64,
        )
    }

    /// No way from the point to the goal is cheaper.
    fn ahead(&self, at: Point) -> f64 {
        self.goal.distance_m(at) * self.costs.least()
    }

    #[inline]
    fn push(&mut self, cost: f64, cell: usize, centre: Point) {
        let estimate = cost + self.ahead(centre);
        let bucket = ((estimate - self.origin) / self.breadth) as usize;
        // The heuristic is consistent, so only rounding could ask for a bucket that is done.
        let slot = bucket.max(self.current) & (self.buckets.len() - 1);
        self.buckets[slot].push((cost, cell as u32));
        self.queued += 1;
    }

    #[inline]
    fn offset(&self, cell: usize, columns: isize, rows: isize) -> usize {
        cell.wrapping_add_signed(rows * self.stride as isize + columns)
    }

    /// The number of a cell without the margin.
    #[inline]
    fn on_map(&self, cell: usize) -> usize {
        (cell / self.stride - MARGIN) * self.costs.lattice().width() + cell % self.stride - MARGIN
    }

    /// Leads neighbours through a cell where that is cheaper. `rate` is the cost per metre so many columns and rows away, along a line.
    #[inline(always)]
    fn relax(
        &mut self,
        cell: usize,
        reached: f64,
        centre: Point,
        rate: impl Fn(&Self, (isize, isize), usize) -> f64,
    ) {
        let blocked = self.clearance.as_ref().map_or(0, |clearance| clearance.blocked(self.on_map(cell)));
        let mut own = [0.0; LINES.len()];
        for (line, own) in own.iter_mut().enumerate() {
            *own = rate(self, (0, 0), line);
        }
        let mut improved = [(0.0, 0, Point::default()); MOVES.len()];
        let mut count = 0;
        // Move by move, not in a loop: there all moves would share branches, which are then predicted badly; a whole map takes a third longer.
        macro_rules! lead {
            ($($number:literal)*) => {$({
                const STEP: &Move = &MOVES[$number];
                let (line, to) = (const { line($number) }, self.offset(cell, STEP.columns, STEP.rows));
                // Most moves lead back: their cost need not be looked up.
                if reached + own[line] * STEP.piece_m < self.reached[to] && blocked & (1 << $number) == 0 {
                    // Infinite if one of them is forbidden.
                    let mut rates = own[line] + rate(self, (STEP.columns, STEP.rows), line);
                    for between in STEP.between {
                        rates += rate(self, *between, line);
                    }
                    let cost = reached + rates * STEP.piece_m;
                    if cost < self.reached[to] {
                        self.reached[to] = cost;
                        self.came_by[to] = $number;
                        let at = Point::new(centre.x_m + STEP.columns as f64, centre.y_m + STEP.rows as f64);
                        improved[count] = (cost, to, at);
                        count += 1;
                    }
                }
            })*};
        }
        lead!(0 1 2 3 4 5 6 7 8 9 10 11 12 13 14 15);
        for (cost, to, at) in &improved[..count] {
            self.push(*cost, *to, *at);
        }
    }

    fn way(&self, start: Point, last: usize) -> Vec<Point> {
        let end = self.centre(last);
        let mut points = vec![end];
        if self.goal.distance_m(end) > 0.0 {
            points.insert(0, self.goal.nearest(end));
        }
        let mut cell = last;
        while self.came_by[cell] != FROM_START {
            let step = &MOVES[self.came_by[cell] as usize];
            cell = cell.wrapping_add_signed(-(step.rows * self.stride as isize + step.columns));
            points.push(self.centre(cell));
        }
        points.push(start);
        points.reverse();
        points
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use rover::{Lattice, Surface};
    use std::sync::Arc;

    /// A map with costs 1 to 5 and some forbidden cells on bumpy or flat ground, made of a number.
    fn map(seed: u64, flat: bool, side: usize) -> CostMap {
        let lattice = Lattice::new(side, side).unwrap();
        let noise =
            |cell: usize| (cell as u64 + 1).wrapping_mul(seed | 1).wrapping_mul(0x9e37_79b9_7f4a_7c15) >> 32;
        let heights_m: Vec<f64> = (0..side * side).map(|cell| (noise(cell) % 100) as f64 / 100.0).collect();
        let surface =
            if flat { Surface::flat(lattice) } else { Surface::from_heights(lattice, &heights_m).unwrap() };
        let cost = |cell: usize| match noise(cell) % 7 {
            0 => f64::INFINITY,
            noise => 0.8 + noise as f64 * 0.7,
        };
        CostMap::new(Arc::new(surface), (0..side * side).map(cost).collect())
    }

    /// The cost of a segment, infinite if one of all forbidden cells of the map is nearer than the clearance, but for those that are
    /// as near to the ends of the trip.
    fn clear(costs: &CostMap, trip: &Trip, clearance_m: f64, segment: Segment) -> f64 {
        let width = costs.lattice().width();
        let far = |segment: Segment, cell: usize| {
            let corner = Point::new((cell % width) as f64, (cell / width) as f64);
            distance_m(segment, corner) >= clearance_m - 1e-9
        };
        let ends = [trip.start, trip.goal.at].map(|at| Segment { from: at, to: at });
        let forbidden = (0..costs.lattice().cells()).filter(|cell| costs.costs()[*cell] == f64::INFINITY);
        let mut counted = forbidden.filter(|cell| ends.iter().all(|end| far(*end, *cell)));
        if counted.all(|cell| far(segment, cell)) { costs.segment(segment) } else { f64::INFINITY }
    }

    /// Bellman-Ford over the same graph, with the edges integrated by traversal.
    fn reference(costs: &CostMap, trip: &Trip, clearance_m: f64) -> f64 {
        let lattice = costs.lattice();
        let (width, height) = (lattice.width() as isize, lattice.height() as isize);
        let middle = lattice.cell(trip.start);
        let near = |cell: usize| {
            let columns = (cell % width as usize).abs_diff(middle % width as usize);
            let rows = (cell / width as usize).abs_diff(middle / width as usize);
            columns <= 2 && rows <= 2
        };
        let mut reached: Vec<f64> = (0..lattice.cells())
            .map(|cell| {
                let segment = Segment { from: trip.start, to: lattice.centre(cell) };
                if near(cell) { clear(costs, trip, clearance_m, segment) } else { f64::INFINITY }
            })
            .collect();
        loop {
            let before = reached.clone();
            for cell in 0..lattice.cells() {
                for step in &MOVES {
                    let (column, row) =
                        (cell as isize % width + step.columns, cell as isize / width + step.rows);
                    if (0..width).contains(&column) && (0..height).contains(&row) {
                        let to = (row * width + column) as usize;
                        let segment = Segment { from: lattice.centre(cell), to: lattice.centre(to) };
                        let cost = clear(costs, trip, clearance_m, segment);
                        reached[to] = reached[to].min(reached[cell] + cost);
                    }
                }
            }
            if before == reached {
                break;
            }
        }
        let mut best = f64::INFINITY;
        for (cell, reached) in reached.iter().enumerate() {
            let centre = lattice.centre(cell);
            if trip.goal.distance_m(centre) < SQRT_5 + 0.1 {
                let last = Segment { from: centre, to: trip.goal.nearest(centre) };
                best = best.min(reached + clear(costs, trip, clearance_m, last));
            }
        }
        best
    }

    #[test]
    fn each_move_leads_along_its_line() {
        for (number, step) in MOVES.iter().enumerate() {
            let (columns, rows) = LINES[line(number)];
            assert!(
                [(columns, rows), (-columns, -rows)].contains(&(step.columns, step.rows)),
                "move {number}"
            );
        }
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(64))]
        /// P-ROUTE-EXACT: `ett_exact` is optimal on its graph, and its route never costs more after
        /// it is pulled tight.
        #[test]
        fn the_search_agrees_with_bellman_ford_and_pulling_never_costs_more(
            seed in any::<u64>(), flat in any::<bool>(), radius_m in 0.0..3.0_f64,
            from in (0.0..=5.0_f64, 0.0..=14.0_f64), to in (9.0..=14.0_f64, 0.0..=14.0_f64),
        ) {
            let map = map(seed, flat, 14);
            let goal = Goal { at: Point::new(to.0, to.1), radius_m };
            let trip = Trip { start: Point::new(from.0, from.1), goal };
            let expected = reference(&map, &trip, 0.0);
            match graph_route(&map, &trip) {
                None => prop_assert_eq!(expected, f64::INFINITY),
                Some(route) => {
                    prop_assert!((route.cost - expected).abs() < 1e-9, "{} against {}", route.cost, expected);
                    prop_assert!((map.way(&route.points) - route.cost).abs() < 1e-6);
                    let pulled = ett_exact(&map, &trip, 0.0).unwrap();
                    prop_assert!(pulled.cost <= route.cost + 1e-9);
                    prop_assert!(goal.distance_m(*pulled.points.last().unwrap()) < 1e-9);
                }
            }
        }
        /// P-ROUTE-CLEAR: With a clearance `ett_exact` is optimal among the ways of its graph that keep it,
        /// and its route keeps it after it is pulled tight.
        #[test]
        fn a_route_with_a_clearance_is_the_best_that_keeps_it(
            seed in any::<u64>(), flat in any::<bool>(), radius_m in 0.0..3.0_f64,
            clearance_m in prop_oneof![Just(0.5), 0.01..1.6_f64],
            from in (0.0..=5.0_f64, 0.0..=14.0_f64), to in (9.0..=14.0_f64, 0.0..=14.0_f64),
        ) {
            let map = map(seed, flat, 14);
            let goal = Goal { at: Point::new(to.0, to.1), radius_m };
            let trip = Trip { start: Point::new(from.0, from.1), goal };
            let expected = reference(&map, &trip, clearance_m);
            let route = ett_exact(&map, &trip, clearance_m);
            prop_assert_eq!(route.is_some(), expected < f64::INFINITY, "{}", expected);
            if let Some(route) = route {
                prop_assert!(route.cost <= expected + 1e-9, "{} against {}", route.cost, expected);
                for pair in route.points.windows(2) {
                    let segment = Segment { from: pair[0], to: pair[1] };
                    prop_assert!(clear(&map, &trip, clearance_m - 1e-6, segment) < f64::INFINITY);
                }
                prop_assert!(goal.distance_m(*route.points.last().unwrap()) < 1e-9);
                let (kept, asked) = ett_exact_or_closer(&map, &trip, clearance_m).unwrap();
                prop_assert_eq!((kept, asked), (route, clearance_m));
            }
        }
    }

    #[test]
    fn where_no_route_keeps_the_clearance_there_is_one_without() {
        let lattice = Lattice::new(9, 9).unwrap();
        // A wall with a gap of one cell.
        let cost = |cell: usize| if cell % 9 == 4 && cell / 9 != 4 { f64::INFINITY } else { 1.0 };
        let map = CostMap::new(Arc::new(Surface::flat(lattice)), (0..81).map(cost).collect());
        let goal = Goal { at: Point::new(7.5, 4.5), radius_m: 1.0 };
        let trip = Trip { start: Point::new(1.5, 2.5), goal };
        assert!(ett_exact(&map, &trip, 0.6).is_none());
        let (closer, clearance_m) = ett_exact_or_closer(&map, &trip, 0.6).unwrap();
        assert_eq!((closer, clearance_m), (ett_exact(&map, &trip, 0.0).unwrap(), 0.0));
        let half = ett_exact(&map, &trip, 0.5).unwrap();
        assert!(half.cost > ett_exact(&map, &trip, 0.0).unwrap().cost, "it costs something to keep clear");
    }

    #[test]
    fn on_even_ground_the_route_is_the_straight_line() {
        let lattice = Lattice::new(100, 60).unwrap();
        let map = CostMap::new(Arc::new(Surface::flat(lattice)), vec![0.005; 6000]);
        let goal = Goal { at: Point::new(93.0, 47.0), radius_m: 3.0 };
        let trip = Trip { start: Point::new(4.2, 7.7), goal };
        let route = ett_exact(&map, &trip, 0.0).unwrap();
        let straight = 0.005 * goal.distance_m(trip.start);
        assert!((route.cost / straight - 1.0).abs() < 1e-3, "{} against {straight}", route.cost);
    }
}
