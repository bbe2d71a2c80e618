//! Brief and state as a Python planner sees them.

use contract::{Account, Action, Cell, Leg, Team};
use planner::Situation;
use pyo3::prelude::*;

use crate::task::Task;

/// Farther from the first cell than a hop from outside of the largest grid can begin.
const BEYOND: i32 = 1 << 20;

/// What was known before the mission.
#[pyclass(frozen, module = "hopper")]
pub struct Brief {
    pub brief: contract::Brief,
    /// The leg of the hopper that decides; `None` where another robot does.
    pub leg: Option<Leg>,
}

impl Brief {
    /// The brief for the robot that decides.
    pub fn of(situation: &Situation<'_>) -> Self {
        Self { brief: situation.brief.clone(), leg: situation.leg.copied() }
    }

    /// Start and goal of the leg; where another robot decides, the start of the first robot and the goal of the last one that
    /// has a goal.
    fn ends(&self) -> [Cell; 2] {
        let (brief, start) = (&self.brief, self.brief.robots[0].start.cell);
        let goal = || brief.robots.iter().rev().find_map(|robot| robot.goal.cell(&brief.grid, 0));
        self.leg.map_or_else(|| [start, goal().unwrap_or(start)], |leg| [leg.start, leg.goal])
    }
}

#[pymethods]
impl Brief {
    /// Name of the scenario.
    #[getter]
    fn scenario(&self) -> String {
        self.brief.scenario.to_string()
    }

    /// "paper-2023" or "hopper".
    #[getter]
    fn profile(&self) -> &'static str {
        self.brief.profile.as_str()
    }

    /// "reach", "patrol", "accompany" (a hopper with helicopters), "cover", "scout" or "mixed" (robots with tasks of their own).
    #[getter]
    fn task(&self) -> &'static str {
        Task::of(&self.brief).as_str()
    }

    /// Robots of the mission, numbered from 0.
    #[getter]
    fn robots(&self) -> u16 {
        self.brief.robots.count()
    }

    /// Columns of the grid.
    #[getter]
    fn width(&self) -> u32 {
        self.brief.grid.width
    }

    /// Rows of the grid.
    #[getter]
    fn height(&self) -> u32 {
        self.brief.grid.height
    }

    /// Edge of a cell, metres.
    #[getter]
    fn cell_size_m(&self) -> f64 {
        self.brief.grid.cell_size_m
    }

    /// Cells that one hop spans.
    #[getter]
    fn hop_cells(&self) -> u32 {
        self.brief.grid.hop_cells
    }

    /// Cell (x, y) where the mission, or this leg of a patrol, begins.
    #[getter]
    fn start(&self) -> (i32, i32) {
        pair(self.ends()[0])
    }

    /// Cell (x, y) to reach.
    #[getter]
    fn goal(&self) -> (i32, i32) {
        pair(self.ends()[1])
    }

    /// Steps after which the mission is a deadlock.
    #[getter]
    fn steps_max(&self) -> u64 {
        self.brief.limits.steps_max
    }

    /// The cell (x, y) that an action aims at from `cell`; None outside the grid.
    fn target(&self, cell: (i32, i32), action: u32) -> PyResult<Option<(i32, i32)>> {
        // Beyond every grid all is alike, and nothing overflows.
        let [x, y] = [cell.0, cell.1].map(|side| side.clamp(-BEYOND, BEYOND));
        let from = Cell::new(x, y);
        let to = match Action::from_code(action) {
            Some(Action::Hold) => from,
            Some(Action::Hop(direction) | Action::Up(direction)) => self.brief.grid.hop(from, direction),
            Some(Action::Step(direction)) => {
                let (dx, dy) = direction.step();
                Cell::new(from.x + dx, from.y + dy)
            }
            _ => return Err(crate::error(format!("an action needs to be a hopper.Action, got {action}"))),
        };
        Ok(self.brief.grid.contains(to).then_some(pair(to)))
    }

    /// Every field of the brief, as JSON.
    fn json(&self) -> PyResult<String> {
        serde_json::to_string(&self.brief).map_err(crate::error)
    }

    fn __repr__(&self) -> String {
        let contract::Brief { scenario, profile, robots, grid, account, .. } = &self.brief;
        let [start, goal] = self.ends();
        let is_of_hopper = *account == Account::Hopper;
        let ends = if is_of_hopper { format!(", from {start} to {goal}") } else { String::new() };
        format!(
            "<Brief of scenario {scenario}, profile {profile}: task {}, robots {}, {} x {} cells{ends}>",
            self.task(),
            robots.count(),
            grid.width,
            grid.height
        )
    }

    fn __copy__(slf: Bound<'_, Self>) -> Bound<'_, Self> {
        slf
    }

    fn __deepcopy__<'py>(slf: Bound<'py, Self>, _memo: &Bound<'_, PyAny>) -> Bound<'py, Self> {
        slf
    }

    #[allow(clippy::type_complexity, reason = "what pickle asks for")]
    fn __reduce__<'py>(&self, py: Python<'py>) -> PyResult<(Bound<'py, PyAny>, (String, String))> {
        let leg = serde_json::to_string(&self.leg).map_err(crate::error)?;
        Ok((py.import("hopper._native")?.getattr("read_brief")?, (self.json()?, leg)))
    }
}

/// Reads a pickled brief.
#[pyfunction]
pub fn read_brief(json: &str, leg: &str) -> PyResult<Brief> {
    let brief = serde_json::from_str(json).map_err(crate::error)?;
    Ok(Brief { brief, leg: serde_json::from_str(leg).map_err(crate::error)? })
}

/// The state at a decision.
#[pyclass(frozen, module = "hopper")]
pub struct State {
    pub state: contract::State,
    pub team: Option<Team>,
}

impl State {
    fn at(&self) -> Cell {
        let due = self.team.as_ref().and_then(|team| team.member(team.due));
        due.map_or(self.state.pose.cell, |member| member.at.cell)
    }
}

#[pymethods]
impl State {
    /// The decision that is due, counted from 0.
    #[getter]
    fn decision(&self) -> u64 {
        self.state.decision.0
    }

    /// Steps so far, in the paper's count.
    #[getter]
    fn steps(&self) -> u64 {
        self.state.steps
    }

    /// Goals visited so far; of rovers, cells covered.
    #[getter]
    fn visits(&self) -> u64 {
        self.state.visits
    }

    /// Treasures collected so far.
    #[getter]
    fn treasures(&self) -> u32 {
        self.state.collected.0.count_ones()
    }

    /// Number of the robot that decides.
    #[getter]
    fn robot(&self) -> u16 {
        self.team.as_ref().map_or(0, |team| team.due.0)
    }

    /// Cell (x, y) of the robot that decides.
    #[getter]
    fn cell(&self) -> (i32, i32) {
        pair(self.at())
    }

    /// Height of the ground under the hopper above the datum, metres.
    #[getter]
    fn height_m(&self) -> f64 {
        self.state.pose.height_m
    }

    /// Actions that the guard has vetoed at this decision, as codes of hopper.Action.
    #[getter]
    fn vetoed(&self) -> Vec<u32> {
        let vetoed = |action: &Action| self.state.vetoed.has(*action);
        Action::ALL.into_iter().filter(vetoed).map(Action::code).collect()
    }

    /// Cells (x, y) of all robots, in the order of their numbers.
    #[getter]
    fn robots(&self) -> Vec<(i32, i32)> {
        match &self.team {
            Some(team) => team.members.iter().map(|member| pair(member.at.cell)).collect(),
            None => vec![pair(self.state.pose.cell)],
        }
    }

    /// Every field of the state, and of the team if there are several robots, as JSON.
    fn json(&self) -> PyResult<String> {
        serde_json::to_string(&(&self.state, &self.team)).map_err(crate::error)
    }

    fn __repr__(&self) -> String {
        let (robot, cell, steps) = (self.robot(), self.at(), self.state.steps);
        format!("<State of decision {}: robot {robot} at {cell}, {steps} steps>", self.state.decision)
    }

    fn __copy__(slf: Bound<'_, Self>) -> Bound<'_, Self> {
        slf
    }

    fn __deepcopy__<'py>(slf: Bound<'py, Self>, _memo: &Bound<'_, PyAny>) -> Bound<'py, Self> {
        slf
    }

    fn __reduce__<'py>(&self, py: Python<'py>) -> PyResult<(Bound<'py, PyAny>, (String,))> {
        Ok((py.import("hopper._native")?.getattr("read_state")?, (self.json()?,)))
    }
}

/// Reads a pickled state.
#[pyfunction]
pub fn read_state(json: &str) -> PyResult<State> {
    let (state, team) = serde_json::from_str(json).map_err(crate::error)?;
    Ok(State { state, team })
}

fn pair(cell: Cell) -> (i32, i32) {
    (cell.x, cell.y)
}
