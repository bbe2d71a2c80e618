//! The single-agent study of Folsom et al. 2021 (eq. 1 to 10): an agent on a small grid that gathers information on its way.
//!
//! Cells of one type are alike: each has the type's lesser or greater travel time, and who has seen one cell knows all of its type.
//! The paper does not define its grids; [`SingleGrid::random`] draws ours. Every simple path from corner to corner is weighed.

use routing::Stream;
use serde::Serialize;

/// Cells to a side, M.
pub const GRID_SIDE: usize = 5;
/// Cells, N.
const CELLS: usize = GRID_SIDE * GRID_SIDE;
/// λ, the discount of what is learned a step later.
const DISCOUNT: f64 = 0.98;
/// ε of eq. 9 at the start of a trip.
const ERROR: f64 = 0.1;

/// Cells of one type.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct CellType {
    /// Number of cells.
    pub cells: usize,
    /// The lesser time for a cell, without unit.
    pub time_min: f64,
    /// The greater one.
    pub time_max: f64,
    /// Probability of the lesser one.
    pub chance_min: f64,
    /// Whether the lesser one is true.
    pub is_min: bool,
}

impl CellType {
    /// Expected time for a cell (eq. 1).
    #[must_use]
    pub fn expected(&self) -> f64 {
        self.chance_min * self.time_min + (1.0 - self.chance_min) * self.time_max
    }

    /// The time that is likelier.
    #[must_use]
    pub fn likeliest(&self) -> f64 {
        if self.chance_min >= 0.5 { self.time_min } else { self.time_max }
    }

    /// The true time.
    #[must_use]
    pub fn true_time(&self) -> f64 {
        if self.is_min { self.time_min } else { self.time_max }
    }

    /// A term of eq. 7 without its discount, with the weight of eq. 9, or of eq. 8 for an error of 0.
    fn reward(&self, error: f64) -> f64 {
        let weight = libm::log2(1.0 / (self.chance_min.max(1.0 - self.chance_min) + error));
        weight * self.cells as f64 * (self.time_max - self.time_min) / CELLS as f64
    }

    /// What it is worth to know the type (eq. 7 and 8).
    #[must_use]
    pub fn information(&self) -> f64 {
        self.reward(0.0)
    }
}

/// A grid with its truth.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct SingleGrid {
    /// The type of each cell, row by row.
    pub type_of: Vec<usize>,
    /// The types.
    pub types: Vec<CellType>,
}

/// How a path is chosen.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Choice {
    /// Greatest utility (eq. 6, 7 and 9).
    Utility,
    /// Least expected travel time.
    ExpectedTime,
    /// Least time if each cell has its likelier time.
    Likeliest,
}

impl Choice {
    /// In the order of the paper's legends.
    pub const ALL: [Self; 3] = [Self::Utility, Self::ExpectedTime, Self::Likeliest];

    /// The name in files, as it is serialised.
    #[must_use]
    pub fn key(self) -> &'static str {
        match self {
            Self::Utility => "utility",
            Self::ExpectedTime => "expected_time",
            Self::Likeliest => "likeliest",
        }
    }

    /// The name for tables.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Utility => "utility",
            Self::ExpectedTime => "least expected travel time",
            Self::Likeliest => "likelier time taken for true",
        }
    }
}

/// Every simple path from the first cell to the last, over the four neighbours of a cell.
#[must_use]
pub fn simple_paths() -> Vec<Vec<usize>> {
    fn extend(path: &mut Vec<usize>, seen: &mut [bool; CELLS], paths: &mut Vec<Vec<usize>>) {
        let at = path[path.len() - 1];
        if at == CELLS - 1 {
            paths.push(path.clone());
            return;
        }
        let (column, row) = (at % GRID_SIDE, at / GRID_SIDE);
        let neighbours = [
            (column + 1 < GRID_SIDE).then_some(at + 1),
            (row + 1 < GRID_SIDE).then_some(at + GRID_SIDE),
            (column > 0).then(|| at - 1),
            (row > 0).then(|| at - GRID_SIDE),
        ];
        for next in neighbours.into_iter().flatten() {
            if !seen[next] {
                seen[next] = true;
                path.push(next);
                extend(path, seen, paths);
                path.pop();
                seen[next] = false;
            }
        }
    }
    let mut seen = [false; CELLS];
    seen[0] = true;
    let mut paths = Vec::new();
    extend(&mut vec![0], &mut seen, &mut paths);
    paths
}

impl SingleGrid {
    /// The grid of a seed: 4 to 7 types, each cell's type uniform; the lesser time uniform in 1 to 2, the greater one .2 to 4 more, the
    /// likelier one's probability uniform in .5 to .95, and either of them the likelier one.
    #[must_use]
    pub fn random(seed: u64) -> Self {
        let mut draws = Stream::new(seed, "single-agent grid");
        let count = 4 + (draws.uniform() * 4.0) as usize;
        let type_of: Vec<usize> = (0..CELLS).map(|_| (draws.uniform() * count as f64) as usize).collect();
        let kind = |kind: usize| {
            let time_min = draws.between(1.0, 2.0);
            let time_max = time_min + draws.between(0.2, 4.0);
            let likelier = draws.between(0.5, 0.95);
            let chance_min = if draws.uniform() < 0.5 { likelier } else { 1.0 - likelier };
            let is_min = draws.uniform() < chance_min;
            let cells = type_of.iter().filter(|of| **of == kind).count();
            CellType { cells, time_min, time_max, chance_min, is_min }
        };
        let types = (0..count).map(kind).collect();
        Self { type_of, types }
    }

    /// The time of a path, if a cell of each type takes `time`.
    #[must_use]
    pub fn time(&self, path: &[usize], time: impl Fn(&CellType) -> f64) -> f64 {
        path.iter().map(|cell| time(&self.types[self.type_of[*cell]])).sum()
    }

    /// Utility of a path (eq. 6), where the fastest one is expected to take `fastest`.
    #[must_use]
    pub fn utility(&self, path: &[usize], fastest: f64) -> f64 {
        let mut known = vec![false; self.types.len()];
        let mut reward = 0.0;
        for (step, cell) in path.iter().enumerate() {
            let of = self.type_of[*cell];
            if !std::mem::replace(&mut known[of], true) {
                reward += DISCOUNT.powi(step as i32) * self.types[of].reward(ERROR);
            }
        }
        reward - (self.time(path, CellType::expected) - fastest) / CELLS as f64
    }

    /// [`SingleGrid::utility`] where the error of a type, eq. 9's ε, is halved at each further cell of it, since cells of one type
    /// are alike here: what that adds to the type's weight is a reward too. The paper adapts ε in words and gives no rule.
    #[must_use]
    pub fn adapting_utility(&self, path: &[usize], fastest: f64) -> f64 {
        let mut errors: Vec<Option<f64>> = vec![None; self.types.len()];
        let mut reward = 0.0;
        for (step, cell) in path.iter().enumerate() {
            let of = self.type_of[*cell];
            let kind = &self.types[of];
            let (error, before) = match errors[of] {
                None => (ERROR, 0.0),
                Some(error) => (error / 2.0, kind.reward(error)),
            };
            errors[of] = Some(error);
            reward += DISCOUNT.powi(step as i32) * (kind.reward(error) - before);
        }
        reward - (self.time(path, CellType::expected) - fastest) / CELLS as f64
    }

    /// The path of the greatest [`SingleGrid::adapting_utility`]; of equal ones the first.
    ///
    /// # Panics
    /// If there is none.
    #[must_use]
    pub fn best_adapting<'a>(&self, paths: &'a [Vec<usize>]) -> &'a [usize] {
        let fastest = self.time(self.best(paths, Choice::ExpectedTime), CellType::expected);
        let costs = paths.iter().map(|path| (-self.adapting_utility(path, fastest), path));
        costs.min_by(|a, b| a.0.total_cmp(&b.0)).expect("there are paths").1
    }

    /// The best of `paths`; of equal ones the first.
    ///
    /// # Panics
    /// If there is none.
    #[must_use]
    pub fn best<'a>(&self, paths: &'a [Vec<usize>], choice: Choice) -> &'a [usize] {
        let least = |cost: &dyn Fn(&[usize]) -> f64| {
            let costs = paths.iter().map(|path| (cost(path), path));
            costs.min_by(|a, b| a.0.total_cmp(&b.0)).expect("there are paths").1.as_slice()
        };
        match choice {
            Choice::ExpectedTime => least(&|path| self.time(path, CellType::expected)),
            Choice::Likeliest => least(&|path| self.time(path, CellType::likeliest)),
            Choice::Utility => {
                let fastest = self.time(self.best(paths, Choice::ExpectedTime), CellType::expected);
                least(&|path| -self.utility(path, fastest))
            }
        }
    }

    /// Which types are known after a path.
    #[must_use]
    pub fn known(&self, path: &[usize]) -> Vec<bool> {
        let mut known = vec![false; self.types.len()];
        path.iter().for_each(|cell| known[self.type_of[*cell]] = true);
        known
    }

    /// Share of all information that is known after each cell of a path.
    #[must_use]
    pub fn information(&self, path: &[usize]) -> Vec<f64> {
        let share = |known: &[bool]| {
            let worth = |only: &dyn Fn(usize) -> bool| {
                let types = self.types.iter().enumerate().filter(|(of, _)| only(*of));
                types.map(|(_, of)| of.information()).sum::<f64>()
            };
            worth(&|of| known[of]) / worth(&|_| true)
        };
        (1..=path.len()).map(|cells| share(&self.known(&path[..cells]))).collect()
    }

    /// The path of least expected time of an agent that knows the types `known`, and takes the others as expected.
    #[must_use]
    pub fn follower<'a>(&self, paths: &'a [Vec<usize>], known: &[bool]) -> &'a [usize] {
        let times: Vec<f64> = self
            .types
            .iter()
            .zip(known)
            .map(|(of, known)| if *known { of.true_time() } else { of.expected() })
            .collect();
        let cost = |path: &&Vec<usize>| path.iter().map(|cell| times[self.type_of[*cell]]).sum::<f64>();
        paths.iter().min_by(|a, b| cost(a).total_cmp(&cost(b))).expect("there are paths")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// P-SINGLE: The single-agent study weighs every simple path of its grids.
    ///
    /// The number of paths is that of self-avoiding walks between opposite corners of 5 x 5 points.
    #[test]
    fn all_simple_paths_from_corner_to_corner_are_weighed() {
        let paths = simple_paths();
        assert_eq!(paths.len(), 8512);
        for path in &paths {
            let mut cells = path.clone();
            cells.sort_unstable();
            cells.dedup();
            assert_eq!(cells.len(), path.len(), "a simple path");
            assert!(path.len() % 2 == 1 && (9..=25).contains(&path.len()));
        }
    }

    /// Two types, worked out by hand.
    fn halves() -> SingleGrid {
        let of = |chance_min, is_min| CellType { cells: 0, time_min: 1.0, time_max: 3.0, chance_min, is_min };
        let type_of: Vec<usize> = (0..CELLS).map(|cell| usize::from(cell / GRID_SIDE >= 2)).collect();
        let mut types = vec![of(0.5, true), of(0.75, false)];
        types[0].cells = 10;
        types[1].cells = 15;
        SingleGrid { type_of, types }
    }

    #[test]
    fn utility_is_that_of_equations_6_to_9() {
        let grid = halves();
        // East, then north: five cells of the first type, the first cell of the second at step 6.
        let path = [0, 1, 2, 3, 4, 9, 14, 19, 24];
        assert_eq!(grid.time(&path, CellType::expected), 6.0 * 2.0 + 3.0 * 1.5);
        let reward = libm::log2(1.0 / 0.6) * 10.0 * 2.0 / 25.0
            + 0.98_f64.powi(6) * libm::log2(1.0 / 0.85) * 15.0 * 2.0 / 25.0;
        assert!((grid.utility(&path, 15.0) - (reward - 1.5 / 25.0)).abs() < 1e-12);
        // log2(2) · 10 against log2(4/3) · 15.
        let (first, second) = (10.0, libm::log2(4.0 / 3.0) * 15.0);
        let known = grid.information(&path);
        assert!((known[0] - first / (first + second)).abs() < 1e-12 && (known[8] - 1.0).abs() < 1e-12);
        assert_eq!(known[5], known[0]);
    }

    #[test]
    fn a_further_cell_of_a_type_halves_its_error_and_pays_the_difference() {
        let grid = halves();
        let path = [0, 1, 2, 3, 4, 9, 14, 19, 24];
        // Five more cells of the first type (½), two more of the second (¾): ε of 0.05, 0.025, …
        let weight = |chance: f64, error: f64| libm::log2(1.0 / (chance + error));
        let gains = |chance: f64, first: usize, cells: usize| -> f64 {
            let gain = |further: usize| {
                let error = |halvings: usize| 0.1 / (1 << halvings) as f64;
                let more = weight(chance, error(further)) - weight(chance, error(further - 1));
                0.98_f64.powi((first + further) as i32) * more
            };
            (1..=cells).map(gain).sum()
        };
        let more = gains(0.5, 0, 5) * 10.0 * 2.0 / 25.0 + gains(0.75, 6, 2) * 15.0 * 2.0 / 25.0;
        let utility = grid.utility(&path, 15.0);
        assert!((grid.adapting_utility(&path, 15.0) - (utility + more)).abs() < 1e-12);
        assert!(more > 0.0);
    }

    #[test]
    fn no_path_is_better_than_the_best_and_one_who_knows_all_is_never_slower() {
        let paths = simple_paths();
        for seed in 0..20 {
            let grid = SingleGrid::random(seed);
            assert_eq!(grid, SingleGrid::random(seed));
            assert_eq!(grid.types.iter().map(|of| of.cells).sum::<usize>(), CELLS);
            let fastest = grid.best(&paths, Choice::ExpectedTime);
            let expected = grid.time(fastest, CellType::expected);
            let best = grid.best(&paths, Choice::Utility);
            for path in &paths {
                assert!(grid.time(path, CellType::expected) >= expected);
                assert!(grid.utility(path, expected) <= grid.utility(best, expected));
            }
            let knowing = grid.follower(&paths, &vec![true; grid.types.len()]);
            let nothing = grid.follower(&paths, &vec![false; grid.types.len()]);
            assert!(grid.time(knowing, CellType::true_time) <= grid.time(nothing, CellType::true_time));
            assert_eq!(nothing, fastest);
        }
    }
}
