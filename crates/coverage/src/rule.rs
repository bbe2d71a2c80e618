//! The decision rule of P19: step to the neighbour of least cost c = C_static + C_visited · V (eq. 1).

use contract::Direction;

use crate::Situation;

/// C_visited, the cost of each earlier visit. Any value of at least 4 gives the same paths, since the static costs lie
/// within 1 to 4; below, new ground no longer comes first.
const VISITED: i64 = 10;

/// How much cheaper circumnavigation makes an unvisited cell beside a known obstacle.
const BESIDE_OBSTACLE: i64 = 5;

/// A basic motion (P19 fig. 4).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Pattern {
    /// Turn right wherever possible.
    Spiral,
    /// Sweep there and back along the axis of the initial heading.
    Boustrophedon,
}

/// The rule with its two parameters.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Rule {
    /// Static costs.
    pub pattern: Pattern,
    /// Whether unvisited cells that touch a known obstacle, at a side or a corner, are preferred.
    pub circumnavigation: bool,
}

impl Rule {
    /// The direction of the cheapest neighbour; `None` if no neighbour can be entered.
    #[must_use]
    pub fn decide(&self, situation: &Situation<'_>) -> Option<Direction> {
        let (rover, map) = (situation.own(), situation.map);
        let here = map.place(rover.pose.cell);
        let front = rover.pose.heading;
        let directions = [front.right(), front, front.left(), front.left().left()];
        let statics = self.pattern.static_costs(front, rover.start.heading);
        let mut best = None;
        for (direction, cost) in directions.into_iter().zip(statics) {
            let place = map.neighbour(here, direction);
            if !situation.is_open(place) || situation.is_occupied(place) {
                continue;
            }
            let visits = map.visits_at(place);
            let mut cost = cost + VISITED * i64::from(visits);
            if self.circumnavigation
                && visits == 0
                && map.around(place).into_iter().any(|around| map.is_obstacle(around))
            {
                cost -= BESIDE_OBSTACLE;
            }
            if best.is_none_or(|(least, _)| cost < least) {
                best = Some((cost, direction));
            }
        }
        best.map(|(_, direction)| direction)
    }
}

impl Pattern {
    /// C_static of the cells to the right, in front, to the left and behind.
    fn static_costs(self, heading: Direction, start_heading: Direction) -> [i64; 4] {
        let vertical = |direction| matches!(direction, Direction::North | Direction::South);
        match self {
            Pattern::Spiral => [1, 2, 3, 4],
            Pattern::Boustrophedon if vertical(heading) == vertical(start_heading) => [3, 1, 2, 4],
            Pattern::Boustrophedon => [2, 3, 1, 4],
        }
    }
}
