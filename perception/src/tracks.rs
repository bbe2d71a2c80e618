//! Where robots are that go from point to point, and what they see on their way.

use contract::{Action, Body, Branch, Brief, Record, Robot, RouteId, Waypoint};
use follow::RouteFollower;
use scout_world::{StageClock, TrueGround};
use terrain::Terrain;

/// The robots of a mission, folded from records.
#[derive(Clone, Debug, Default)]
pub(crate) struct Tracks {
    /// `None` before the mission's start is folded.
    ground: Option<TrueGround>,
    robots: Vec<Track>,
    /// Kept whatever is forgotten: a route never changes.
    routes: RouteFollower,
}

#[derive(Clone, Copy, Debug)]
struct Track {
    robot: Robot,
    at: Waypoint,
    route: Option<RouteId>,
    /// Points of the route that were reached after the first.
    reached: usize,
    clock: StageClock,
}

impl Tracks {
    /// Puts all robots back to where nothing is known of them.
    pub fn forget(&mut self) {
        self.ground = None;
        self.robots.clear();
    }

    /// The routes that are known, and the one that is needed.
    pub fn routes(&mut self) -> &mut RouteFollower {
        &mut self.routes
    }

    /// Puts the robots of a mission to their starts; the cells seen from there. A helicopter sees nothing before it flies.
    pub fn begin(&mut self, brief: &Brief, terrain: &Terrain) -> Vec<usize> {
        self.routes.begin(brief.run);
        self.ground = TrueGround::new(terrain.grid, &terrain.cells).ok();
        let clock = StageClock::new(brief.sampling.map_or(1, |sampling| sampling.stages));
        let track =
            |robot: &Robot| Track { robot: *robot, at: robot.start_at, route: None, reached: 0, clock };
        self.robots = brief.robots.iter().map(track).collect();
        let Some(ground) = &self.ground else { return Vec::new() };
        let drivers = self.robots.iter().filter(|track| track.robot.body.drives());
        drivers.flat_map(|track| ground.seen(track.robot.sensor, track.at, track.at)).collect()
    }

    /// Moves the robot of a record; the cells that it sees. `None`, and nothing moves, if the points of its route are not
    /// known: they are needed then.
    pub fn fold(&mut self, record: &Record) -> Option<Vec<usize>> {
        let Some(track) = self.robots.get_mut(usize::from(record.robot.0)) else { return Some(Vec::new()) };
        match record.action {
            Action::Announce(id) if record.outcome.branch != Branch::Stranded => {
                (track.route, track.reached) = (Some(id), 0);
                Some(Vec::new())
            }
            Action::Drive | Action::Fly => {
                let Some(id) = track.route else { return Some(Vec::new()) };
                let Some(route) = self.routes.known().get(id) else {
                    self.routes.need(id);
                    return None;
                };
                let Some(to) = route.waypoints().get(track.reached + 1).copied() else {
                    return Some(Vec::new());
                };
                let stranded = record.outcome.branch == Branch::Stranded;
                if stranded && record.outcome.flight.range_m == 0.0 {
                    return Some(Vec::new());
                }
                let ground = self.ground.as_ref()?;
                let from = track.at;
                if !stranded {
                    (track.at, track.reached) = (to, track.reached + 1);
                }
                if record.action == Action::Fly {
                    return Some(ground.seen(track.robot.sensor, from, to));
                }
                let drive = ground.drive(from, to, track.clock.allowance());
                track.clock.drove(&drive);
                if record.outcome.branch == Branch::Halted {
                    (track.at, track.reached) =
                        (Waypoint { x_m: drive.at.x_m, y_m: drive.at.y_m }, track.reached - 1);
                    track.clock.begin_next();
                    let at = track.at;
                    self.rejoin(at);
                }
                Some(drive.sensed)
            }
            _ => Some(Vec::new()),
        }
    }

    /// A stage is over: the helicopters are with the rover, which is at `at`. One that acts no more sees nothing anyway.
    fn rejoin(&mut self, at: Waypoint) {
        let flies = |track: &&mut Track| matches!(track.robot.body, Body::Helicopter(_));
        for track in self.robots.iter_mut().filter(flies) {
            (track.at, track.route, track.reached) = (at, None, 0);
        }
    }
}
