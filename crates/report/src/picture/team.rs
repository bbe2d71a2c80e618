//! Several robots in one picture: the cells they visited, their routes, and each robot with its colour and number.

use std::collections::BTreeMap;
use std::fmt::Write as _;

use contract::{Action, Branch, Cell, RobotId, Route, RouteId, Waypoint};

use super::frame::Frame;
use super::mission::Picture;
use super::svg_writer::{Number, SvgWriter};
use super::symbols;
use crate::Layer;
use crate::colour;

/// Opacity of a cell that was visited once, and what each further visit adds.
const ONCE: f64 = 0.22;
const AGAIN: f64 = 0.14;

impl Picture<'_> {
    /// Draws visits, routes and robots; in a hopper's mission the routes of its helicopters only. A robot is shown where its
    /// last decision left it; one that has not decided yet is not on the route.
    pub(super) fn team(&self, svg: &mut SvgWriter, frame: &Frame, layer: Layer) {
        let announced = self.announcements();
        let places = Places::of(self, frame, &announced);
        let mut visits: BTreeMap<Cell, u32> = BTreeMap::new();
        let mut routes: BTreeMap<u16, Vec<Cell>> = BTreeMap::new();
        let mut stranded = Vec::new();
        let is_of_hopper = self.is_of_hopper();
        for record in self.route.iter().filter(|record| !is_of_hopper || record.robot.0 > 0) {
            let (outcome, robot) = (record.outcome, record.robot.0);
            let route = routes.entry(robot).or_insert_with(|| {
                *visits.entry(outcome.from).or_default() += 1;
                vec![outcome.from]
            });
            if route.last() != Some(&outcome.from) {
                // A helicopter that is with its rover again.
                route.push(outcome.from);
            }
            if outcome.from != outcome.to {
                *visits.entry(outcome.to).or_default() += 1;
                route.push(outcome.to);
            }
            if outcome.branch == Branch::Stranded {
                stranded.push(robot);
            }
        }
        let side = Number(frame.pitch * 0.8);
        let shows_visits = !is_of_hopper && self.speeds.is_empty() && layer.range().is_none();
        if shows_visits {
            for (&cell, &count) in &visits {
                let (x, y) = frame.centre(cell);
                svg.raw(&format!(
                    "<rect x=\"{}\" y=\"{}\" width=\"{side}\" height=\"{side}\" fill=\"{}\" fill-opacity=\"{}\"/>",
                    Number(x - frame.pitch * 0.4),
                    Number(y - frame.pitch * 0.4),
                    colour::ROUTE,
                    Number((ONCE + AGAIN * f64::from(count - 1)).min(0.85))
                ));
            }
        }
        self.announced_routes(svg, frame, &announced);
        for (&robot, cells) in &routes {
            let mut path = String::new();
            for (number, &cell) in cells.iter().enumerate() {
                let (x, y) = places.at(robot, cell);
                let _ = write!(path, "{}{} {}", if number == 0 { "M" } else { "L" }, Number(x), Number(y));
            }
            let line = "fill=\"none\" stroke-linejoin=\"round\" stroke-linecap=\"round\"";
            svg.path(&path, &format!("{line} stroke=\"#111\" stroke-width=\"3.4\" stroke-opacity=\".6\""));
            svg.path(&path, &format!("{line} stroke=\"{}\" stroke-width=\"2\"", colour::robot(robot)));
        }
        self.sights(svg, frame, &routes, &places);
        if !is_of_hopper {
            self.ends(svg, frame);
        }
        let size = (frame.pitch * 0.34).clamp(8.0, 12.0);
        for (&robot, cells) in &routes {
            let Some(&cell) = cells.last() else { continue };
            let (x, y) = places.at(robot, cell);
            svg.raw(&symbols::dot(x, y, size, &colour::robot(robot), "#111"));
            let mark = if stranded.contains(&robot) { "×".to_owned() } else { robot.to_string() };
            svg.text(
                x,
                y + 4.2,
                "text-anchor=\"middle\" font-size=\"12\" font-weight=\"bold\" fill=\"#111\"",
                &mark,
            );
        }
    }

    /// The routes that were announced, in the order of their decisions, with who follows them.
    fn announcements(&self) -> Vec<(u16, &Route)> {
        let known: BTreeMap<RouteId, &Route> =
            self.announced.iter().map(|route| (route.id(), route)).collect();
        let announced = self.route.iter().filter_map(|record| {
            let Action::Announce(id) = record.action else { return None };
            Some((record.robot.0, *known.get(&id)?))
        });
        announced.collect()
    }

    /// How far the camera of a robot sees to each side, metres.
    fn view_m(&self, robot: RobotId) -> Option<f64> {
        self.brief.robots.at(robot)?.sensor.view_m()
    }

    /// A place of the map in the document.
    pub(super) fn at(&self, frame: &Frame, place: Waypoint) -> (f64, f64) {
        let scale = frame.pitch / self.brief.grid.cell_size_m;
        (frame.left + place.x_m * scale, frame.top + frame.height - place.y_m * scale)
    }

    fn path_of(&self, frame: &Frame, route: &Route) -> String {
        let mut path = String::new();
        for (number, point) in route.waypoints().iter().enumerate() {
            let (x, y) = self.at(frame, *point);
            let _ = write!(path, "{}{} {}", if number == 0 { "M" } else { "L" }, Number(x), Number(y));
        }
        path
    }

    /// What each camera sees from where its robot is.
    fn sights(
        &self,
        svg: &mut SvgWriter,
        frame: &Frame,
        routes: &BTreeMap<u16, Vec<Cell>>,
        places: &Places<'_>,
    ) {
        let rings: Vec<_> = routes
            .iter()
            .filter_map(|(&robot, cells)| Some((robot, *cells.last()?, self.view_m(RobotId(robot))?)))
            .collect();
        if rings.is_empty() {
            return;
        }
        svg.open("g", &format!("clip-path=\"url(#{})\"", frame.id("plot")));
        for (robot, cell, view_m) in rings {
            let (x, y) = places.at(robot, cell);
            let radius = Number(view_m / self.brief.grid.cell_size_m * frame.pitch);
            for (ink, width) in [("#111", "3.6"), (colour::robot(robot).as_str(), "1.8")] {
                svg.raw(&format!(
                    "<circle cx=\"{}\" cy=\"{}\" r=\"{radius}\" fill=\"none\" stroke=\"{ink}\" stroke-width=\"{width}\"/>",
                    Number(x),
                    Number(y)
                ));
            }
        }
        svg.close("g");
    }

    /// The announced routes, dashed.
    fn announced_routes(&self, svg: &mut SvgWriter, frame: &Frame, announced: &[(u16, &Route)]) {
        // Of helicopters that fly ahead of a hopper again and again, the last flight.
        let from = if self.is_of_hopper() { announced.len().saturating_sub(1) } else { 0 };
        for (robot, route) in announced[from..].iter().copied() {
            let path = self.path_of(frame, route);
            let line = "fill=\"none\" stroke-linejoin=\"round\"";
            svg.path(&path, &format!("{line} stroke=\"#fff\" stroke-width=\"5.4\" stroke-opacity=\".7\""));
            svg.path(&path, &format!("{line} stroke=\"#111\" stroke-width=\"3.8\" stroke-dasharray=\"9 5\""));
            let ink = colour::robot(robot);
            let dash = "stroke-dasharray=\"7 7\" stroke-dashoffset=\"-1\"";
            svg.path(&path, &format!("{line} stroke=\"{ink}\" stroke-width=\"2\" {dash}"));
        }
    }

    /// Start and goals of each robot whose goals are places.
    fn ends(&self, svg: &mut SvgWriter, frame: &Frame) {
        for robot in self.brief.robots.iter() {
            let goals = robot.goal.points(&self.brief.grid);
            if goals.is_empty() {
                continue;
            }
            let (x, y) = self.at(frame, robot.start_at);
            svg.raw(&symbols::start(x, y, 7.0));
            for goal in goals {
                let (x, y) = self.at(frame, goal);
                svg.raw(&symbols::goal(x, y, 8.0));
            }
        }
    }
}

/// Where robots were in cells: at the point of a route of their own that lies there, else in the middle.
struct Places<'a> {
    frame: &'a Frame,
    points: BTreeMap<(u16, Cell), (f64, f64)>,
}

impl<'a> Places<'a> {
    fn of(picture: &Picture<'_>, frame: &'a Frame, announced: &[(u16, &Route)]) -> Self {
        let points = announced.iter().flat_map(|&(robot, route)| {
            let place = move |point: &Waypoint| {
                ((robot, point.cell_of(&picture.brief.grid)), picture.at(frame, *point))
            };
            route.waypoints().iter().map(place)
        });
        Self { frame, points: points.collect() }
    }

    fn at(&self, robot: u16, cell: Cell) -> (f64, f64) {
        self.points.get(&(robot, cell)).copied().unwrap_or_else(|| self.frame.centre(cell))
    }
}
