//! What a team of rovers knows of its ground: the cells it has sensed and how often it has visited each.

use contract::{Cell, Direction, Grid};

/// What the team knows of a cell.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Knowledge {
    /// No rover has sensed it.
    Unknown,
    /// Sensed, and a rover can stand on it.
    Free,
    /// Sensed, and no rover can enter it.
    Obstacle,
    /// Not on the grid. The border is known beforehand and counts as no obstacle.
    Outside,
}

/// The map that all rovers of a team share.
#[derive(Clone, Debug, PartialEq)]
pub struct TeamMap {
    grid: Grid,
    /// Cells row by row with a ring of [`Knowledge::Outside`] around them, so that every cell of the grid has eight
    /// neighbours.
    knowledge: Vec<Knowledge>,
    /// Laid out as `knowledge`.
    visits: Vec<u32>,
    /// Number of cells that are known to be free and have not been visited.
    frontier: usize,
}

/// Index of a cell in a [`TeamMap`].
pub(crate) type Place = usize;

impl TeamMap {
    /// The map before the first rover has sensed anything.
    #[must_use]
    pub fn new(grid: Grid) -> Self {
        let (stride, rows) = (grid.width as usize + 2, grid.height as usize + 2);
        let mut knowledge = vec![Knowledge::Outside; stride * rows];
        for row in knowledge.chunks_exact_mut(stride).skip(1).take(grid.height as usize) {
            row[1..=grid.width as usize].fill(Knowledge::Unknown);
        }
        Self { grid, visits: vec![0; knowledge.len()], knowledge, frontier: 0 }
    }

    /// Shape of the ground.
    #[must_use]
    pub fn grid(&self) -> &Grid {
        &self.grid
    }

    /// What the team knows of `cell`.
    #[must_use]
    pub fn knowledge(&self, cell: Cell) -> Knowledge {
        if self.grid.contains(cell) { self.knowledge[self.place(cell)] } else { Knowledge::Outside }
    }

    /// How often rovers have entered `cell`, starts included: V of P19 eq. 1. 0 outside the grid.
    #[must_use]
    pub fn visits(&self, cell: Cell) -> u32 {
        if self.grid.contains(cell) { self.visits[self.place(cell)] } else { 0 }
    }

    /// Writes down what a rover has sensed of `cell`. Cells outside the grid are ignored.
    pub fn sense(&mut self, cell: Cell, obstacle: bool) {
        if self.grid.contains(cell) {
            let place = self.place(cell);
            self.learn(place, if obstacle { Knowledge::Obstacle } else { Knowledge::Free });
        }
    }

    /// Counts that a rover has entered `cell`, which is therefore free.
    ///
    /// # Panics
    /// If the cell is outside the grid.
    pub fn visit(&mut self, cell: Cell) {
        assert!(self.grid.contains(cell), "a visit needs a cell of the grid, got {cell}");
        let place = self.place(cell);
        self.learn(place, Knowledge::Free);
        if self.visits[place] == 0 {
            self.frontier -= 1;
        }
        self.visits[place] += 1;
    }

    /// Writes down what is known of `cell` and how often rovers have entered it, for a map that is kept elsewhere. Cells
    /// outside the grid are ignored.
    pub fn set(&mut self, cell: Cell, knowledge: Knowledge, visits: u32) {
        if self.grid.contains(cell) {
            let place = self.place(cell);
            self.learn(place, Knowledge::Unknown);
            self.visits[place] = visits;
            self.learn(place, knowledge);
        }
    }

    fn learn(&mut self, place: Place, knowledge: Knowledge) {
        let unvisited = |map: &Self| usize::from(map.is_free(place) && map.visits[place] == 0);
        self.frontier -= unvisited(self);
        self.knowledge[place] = knowledge;
        self.frontier += unvisited(self);
    }

    /// Index of a cell that is on the grid or directly beside it.
    pub(crate) fn place(&self, cell: Cell) -> Place {
        (cell.y + 1) as usize * self.stride() + (cell.x + 1) as usize
    }

    pub(crate) fn cell(&self, place: Place) -> Cell {
        Cell::new((place % self.stride()) as i32 - 1, (place / self.stride()) as i32 - 1)
    }

    /// The neighbour of a cell of the grid.
    pub(crate) fn neighbour(&self, place: Place, direction: Direction) -> Place {
        match direction {
            Direction::North => place + self.stride(),
            Direction::East => place + 1,
            Direction::South => place - self.stride(),
            Direction::West => place - 1,
        }
    }

    /// The eight cells around a cell of the grid, counter-clockwise from east.
    pub(crate) fn around(&self, place: Place) -> [Place; 8] {
        let stride = self.stride();
        let (north, south) = (place + stride, place - stride);
        [place + 1, north + 1, north, north - 1, place - 1, south - 1, south, south + 1]
    }

    pub(crate) fn places(&self) -> usize {
        self.knowledge.len()
    }

    pub(crate) fn is_free(&self, place: Place) -> bool {
        self.knowledge[place] == Knowledge::Free
    }

    pub(crate) fn is_obstacle(&self, place: Place) -> bool {
        self.knowledge[place] == Knowledge::Obstacle
    }

    /// Whether no rover has visited `place`, which may be free as far as the team knows.
    pub(crate) fn is_uncovered(&self, place: Place) -> bool {
        self.visits[place] == 0 && matches!(self.knowledge[place], Knowledge::Free | Knowledge::Unknown)
    }

    /// Number of cells that are known to be free and have not been visited.
    pub(crate) fn frontier(&self) -> usize {
        self.frontier
    }

    pub(crate) fn visits_at(&self, place: Place) -> u32 {
        self.visits[place]
    }

    fn stride(&self) -> usize {
        self.grid.width as usize + 2
    }
}
