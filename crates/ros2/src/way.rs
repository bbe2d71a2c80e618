//! Ways as `nav_msgs/Path`: where a robot has come from, and where it says it goes.

use contract::{MonotonicNs, ObservedMap, Route};
use recording::view::Point;

use crate::Clock;
use crate::message::{Path, Pose, PoseStamped};
use crate::pose::MAP;

/// Most poses of a way. Of a longer one every second is kept, and so on.
pub(crate) const POSES_MAX: usize = 1 << 14;

/// Bytes of a pose in a way: the moment, the name of the frame, seven numbers.
pub(crate) const POSE_BYTES: u64 = 72;

/// The way that a robot has come.
#[derive(Clone, Debug)]
pub(crate) struct Way {
    poses: Vec<(MonotonicNs, Point)>,
    /// Every so many of the points passed are kept.
    stride: u64,
    passed: u64,
    /// The last point passed, which a path always ends with.
    last: Option<(MonotonicNs, Point)>,
}

impl Default for Way {
    fn default() -> Self {
        Self { poses: Vec::new(), stride: 1, passed: 0, last: None }
    }
}

impl Way {
    /// Adds a point passed on the way to the landing at `moment`.
    pub fn push(&mut self, moment: MonotonicNs, point: Point) {
        if self.passed.is_multiple_of(self.stride) {
            if self.poses.len() == POSES_MAX {
                let mut is_kept = false;
                self.poses.retain(|_| {
                    is_kept = !is_kept;
                    is_kept
                });
                self.stride = self.stride.saturating_mul(2);
            }
            self.poses.push((moment, point));
        }
        self.passed = self.passed.saturating_add(1);
        self.last = Some((moment, point));
    }

    /// The way, with `pose` of the last landing at its end.
    pub fn path(&self, moment: MonotonicNs, clock: &Clock) -> Path {
        let ends = self.last.filter(|last| self.poses.last() != Some(last));
        let poses = self.poses.iter().chain(&ends);
        let poses = poses.map(|(moment, point)| stamped([point.x, point.y, point.z], *moment, clock));
        Path { header: clock.header(moment, MAP), poses: poses.collect() }
    }
}

/// An announced route, on the ground as far as that is seen and else at the datum.
pub(crate) fn plan(route: &Route, map: Option<&ObservedMap>, moment: MonotonicNs, clock: &Clock) -> Path {
    let poses = route.waypoints().iter().map(|waypoint| {
        let ground = map.and_then(|map| map.ground(waypoint.cell_of(&map.grid)));
        let z = ground.map_or(0.0, |ground| ground.height_m);
        stamped([waypoint.x_m, waypoint.y_m, z], moment, clock)
    });
    Path { header: clock.header(moment, MAP), poses: poses.collect() }
}

fn stamped(at: [f64; 3], moment: MonotonicNs, clock: &Clock) -> PoseStamped {
    PoseStamped { header: clock.header(moment, MAP), pose: Pose::at(at, 0.0) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_long_way_is_thinned_and_ends_where_the_robot_is() {
        let mut way = Way::default();
        let count = 3 * POSES_MAX as u64 + 1;
        for n in 0..count {
            way.push(MonotonicNs(n), Point { x: n as f64, ..Point::default() });
        }
        let path = way.path(MonotonicNs(count), &Clock::default());
        assert!(path.poses.len() <= POSES_MAX + 1 && path.poses.len() > POSES_MAX / 2);
        let xs: Vec<f64> = path.poses.iter().map(|stamped| stamped.pose.position.x).collect();
        assert_eq!((xs[0], xs[xs.len() - 1]), (0.0, (count - 1) as f64));
        assert!(xs.windows(2).all(|pair| pair[0] < pair[1]));
    }
}
