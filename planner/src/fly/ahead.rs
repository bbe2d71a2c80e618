//! `scout_ahead`: a helicopter that looks ahead for a hopper.
//!
//! The hopper's planner prefers known ground that is good, and takes unseen ground for flat. So the helicopter flies where
//! that assumption decides: along the cheapest way from the hopper to its goal as believed now ([`Costs`]), over the part of
//! it that nobody has seen. Each flight goes straight to the farthest unseen cell that leaves none between unseen, at most
//! [`REACH`] view radii along the way; then the way is searched again, since what was seen may have made another one
//! cheaper. Once the whole way is seen it waits for the hopper's next landing; without budget it is done.

use std::cmp::Reverse;
use std::collections::BinaryHeap;

use contract::{
    Action, Body, Cell, Direction, Grid, Member, Name, Pose, Robot, RobotId, Route, State, Waypoint,
};

use super::ward;
use crate::names;
use crate::others::wait_or_hold;
use crate::plan::{Budget, Plan, PlanStatus, Planner, Situation, leg_at};
use crate::route::Costs;
use crate::route::costs::FORBIDDEN;

/// Length of the way that one flight looks at, in radii of view.
pub const REACH: f64 = 2.0;

/// A planner for the helicopter of a hopper.
#[derive(Debug, Default)]
pub struct LookAhead {
    /// The flight of the last plan that announces one: what is to be sent with the command.
    announced: Option<Route>,
}

/// A helicopter about to announce a flight.
struct Ready {
    at: Waypoint,
    view_m: f64,
    left_m: f64,
}

impl LookAhead {
    fn begin(
        &mut self,
        situation: &Situation<'_>,
        (robot, hopper): (RobotId, &Member),
        ready: &Ready,
        idles: Action,
    ) -> Plan {
        let idle = |action| Plan::at_once(action, PlanStatus::Solved);
        let Some(leg) = leg_at(situation.brief, Some(situation.map), situation.state, robot) else {
            return idle(idles);
        };
        let state =
            &State { pose: Pose { cell: hopper.at.cell, ..situation.state.pose }, ..*situation.state };
        let map = situation.map;
        let situation = &Situation { leg: Some(&leg), state, ..*situation };
        let grid = &leg.grid;
        if ready.left_m < grid.cell_size_m {
            return idle(Action::Done);
        }
        let way = cheapest_way(&Costs::new(situation), grid, state.pose.cell, leg.goal);
        let unseen = |cell: &Cell| map.ground(*cell).is_none();
        let Some(flight) = way.and_then(|way| ready.flight(grid, &way, unseen)) else {
            return idle(idles);
        };
        let Ok(route) = Route::new(flight.to_vec()) else { return idle(idles) };
        let plan = idle(Action::Announce(route.id()));
        self.announced = Some(route);
        plan
    }
}

impl Ready {
    /// From where it is to the end of the unseen part of `way` that it looks at next; `None` if all is seen.
    fn flight(&self, grid: &Grid, way: &[Cell], unseen: impl Fn(&Cell) -> bool) -> Option<[Waypoint; 2]> {
        let first = way.iter().position(&unseen)?;
        let reach = (REACH * self.view_m / grid.hop_distance_m()) as usize;
        let ahead: Vec<Waypoint> =
            way[first..].iter().take(reach + 1).map(|cell| Waypoint::middle_of(grid, *cell)).collect();
        // With a cell's margin: what counts is whether the middle of a cell is in view.
        let view_m = (self.view_m - grid.cell_size_m).max(0.0);
        let shows = |last: &usize| {
            ahead[..*last].iter().all(|between| between.distance_to_leg_m(self.at, ahead[*last]) <= view_m)
        };
        let last = (0..ahead.len()).rev().filter(|last| unseen(&way[first + last])).find(shows).unwrap_or(0);
        let (to, length_m) = (ahead[last], self.at.distance_m(ahead[last]));
        if length_m <= self.left_m {
            return Some([self.at, to]);
        }
        let share = self.left_m / length_m;
        let between = |from: f64, to: f64| from + share * (to - from);
        let end = Waypoint { x_m: between(self.at.x_m, to.x_m), y_m: between(self.at.y_m, to.y_m) };
        Some([self.at, end])
    }
}

/// The cells of a cheapest way, both ends included; `None` if there is none. Of equally cheap ones that which strays least from the
/// straight line from start to goal, so not one along a border; if that is equal too, the one found first when cells are
/// expanded in the order of cost, straying and index.
fn cheapest_way(costs: &Costs, grid: &Grid, start: Cell, goal: Cell) -> Option<Vec<Cell>> {
    let (first, last) = (grid.index(start)?, grid.index(goal)?);
    // Distance from the line, times its length.
    let (dx, dy) = (i64::from(goal.x - start.x), i64::from(goal.y - start.y));
    let off_line =
        |cell: Cell| (dx * i64::from(cell.y - start.y) - dy * i64::from(cell.x - start.x)).unsigned_abs();
    let mut reached = vec![((FORBIDDEN, 0), first); grid.cells()];
    reached[first].0 = (0, 0);
    let mut open = BinaryHeap::from([Reverse(((0, 0), first))]);
    while let Some(Reverse(((cost, strayed), index))) = open.pop() {
        if index == last {
            let mut way = vec![last];
            while *way.last()? != first {
                way.push(reached[*way.last()?].1);
            }
            return Some(way.into_iter().rev().map(|index| grid.cell(index)).collect());
        }
        if (cost, strayed) > reached[index].0 {
            continue;
        }
        for direction in Direction::ALL {
            let hop = costs.hops[index][direction as usize];
            if hop == FORBIDDEN {
                continue;
            }
            let Some(to) = grid.index(grid.hop(grid.cell(index), direction)) else { continue };
            let sum = (cost.saturating_add(hop), strayed + off_line(grid.cell(to)));
            if sum < reached[to].0 {
                reached[to] = (sum, index);
                open.push(Reverse((sum, to)));
            }
        }
    }
    None
}

impl Planner for LookAhead {
    fn name(&self) -> Name {
        names::name(names::SCOUT_AHEAD)
    }

    fn suits(&self, robot: &Robot) -> bool {
        matches!(robot.body, Body::Helicopter(_))
    }

    fn announces(&self) -> bool {
        true
    }

    fn plan(&mut self, situation: &Situation<'_>, _: &Budget) -> Plan {
        let hold = Plan::at_once(Action::Hold, PlanStatus::Infeasible);
        let Some(team) = situation.team else { return hold };
        let brief = situation.brief;
        let (Some(me), Some(robot)) = (team.member(team.due), brief.robots.at(team.due)) else { return hold };
        let (Body::Helicopter(helicopter), Some(view_m), Some(travel)) =
            (robot.body, robot.sensor.view_m(), me.travel)
        else {
            return hold;
        };
        let Some(hopper) = ward(brief, team, |body| body.hops()) else {
            return Plan::at_once(Action::Done, PlanStatus::Solved);
        };
        if travel.is_under_way() {
            return Plan::at_once(Action::Fly, PlanStatus::Solved);
        }
        let ready = Ready { at: travel.at, view_m, left_m: helicopter.budget_m - travel.flown_m };
        self.begin(situation, hopper, &ready, wait_or_hold(team))
    }

    fn announced(&self) -> Option<&Route> {
        self.announced.as_ref()
    }
}
