//! The plot of one mission: terrain, policy, route, markers.

use std::collections::BTreeSet;
use std::fmt::Write as _;

use contract::{
    Account, Branch, Brief, Cell, Decision, Detail, Direction, Ground, ObservedMap, PolicyCell, Range,
    Record, RobotId, Route, Waypoint,
};

use super::frame::{Frame, SHADES};
use super::quiver::Quiver;
use super::style::PictureStyle;
use super::svg_writer::{Number, SvgWriter};
use super::symbols::{self, TreasureState};
use super::tile_map::TileMap;
use crate::colour;
use crate::layers::{Look, Value};
use crate::phrases::{EndSentence, TeamEffort, counted, planners_in_order, planners_of_team};
use crate::way::{self, Stretch};
use crate::{Ending, Layer, ReportError};

/// Smallest distance of two policy arrows, as a share of the plot's longer side.
const ARROW_PITCH_MIN: f64 = 0.026;
/// Smallest distance of two policy arrows, in the picture's units.
const ARROW_PITCH_LEAST: f64 = 14.0;
/// Smallest side of a cell, in the picture's units, at which stray hops are dashed.
const DASHED_PITCH_MIN: f64 = 12.0;

/// What the picture of one mission shows.
#[derive(Clone, Copy, Debug)]
pub struct Picture<'a> {
    /// Brief of the mission: grid, robots, names.
    pub brief: &'a Brief,
    /// True ground in index order, drawn faintly where nothing was seen; empty if not known.
    pub terrain: &'a [Ground],
    /// Cells of the scenario's treasures; empty if not known.
    pub treasures: &'a [Cell],
    /// The observed map at the end of the route.
    pub map: &'a ObservedMap,
    /// The last policy, one cell for each of the grid; `None` if the planner has none.
    pub policy: Option<&'a [PolicyCell]>,
    /// Executed decisions in order; of a long mission the last ones only.
    pub route: &'a [Record],
    /// How the mission stands at the end of the route, or that it was stopped.
    pub outcome: Ending,
    /// Sensing radius at the last position, metres; `None` to leave it out.
    pub sensing_radius_m: Option<f64>,
    /// Of each cell the expected speed and its standard deviation at the end of the route, m/Sol; empty where speeds are certain.
    pub speeds: &'a [[f64; 2]],
    /// The routes that robots announced, in any order.
    pub announced: &'a [Route],
    /// What the motion model told of decisions, in their order; empty under the law.
    pub details: &'a [(Decision, Detail)],
}

impl Picture<'_> {
    /// The cells as tiles: the truth if it is known, what was seen otherwise.
    pub(super) fn tiles(&self, layer: Layer) -> TileMap {
        let is_seen = |index: usize| self.map.cells()[index].is_some();
        let scale = layer.scale();
        let value = |index: usize| match scale?.value {
            Value::Speed { of, .. } => self.speeds.get(index).copied().map(of),
            Value::Ground { of, .. } => {
                let ground = self.map.cells()[index].as_ref();
                ground.map(|ground| of(ground, self.map.visits(index)))
            }
        };
        TileMap::new(&self.brief.grid, is_seen, |index| self.ground_at(index), value)
    }

    /// What its plots show: the relief or, in its place, expected speeds of uncertain ground; then the other layers with a scale.
    /// Marks of what robots entered are drawn on the relief.
    pub(super) fn layers(&self) -> Vec<Layer> {
        let has_speeds = !self.speeds.is_empty();
        let is_plotted = |layer: &Layer| match layer.definition().look {
            Look::Relief => !has_speeds,
            Look::Entries => false,
            Look::Scale(_) if layer.is_of_speeds() => has_speeds,
            Look::Scale(_) => (layer.definition().exists)(self.brief),
        };
        Layer::ALL.iter().copied().filter(is_plotted).collect()
    }

    /// Draws the plot inside its frame; heights have the range given with the layer.
    pub(super) fn plot(
        &self,
        svg: &mut SvgWriter,
        frame: &Frame,
        tiles: &TileMap,
        (layer, heights): (Layer, Range),
    ) {
        svg.open("defs", "");
        self.patterns(svg, frame, tiles);
        svg.close("defs");
        self.ground(svg, frame, tiles, (layer, heights));
        self.arrows(svg, frame);
        if self.brief.robots.count() > 1 {
            self.team(svg, frame, layer);
        }
        if !self.is_of_hopper() {
            return;
        }
        self.route_lines(svg, frame);
        if frame.style == PictureStyle::Paper {
            self.hop_numbers(svg, frame);
        }
        self.markers(svg, frame);
    }

    pub(super) fn check(&self) -> Result<(), ReportError> {
        let need = self.brief.grid.cells();
        let terrain = if self.terrain.is_empty() { need } else { self.terrain.len() };
        let policy = self.policy.map_or(need, <[PolicyCell]>::len);
        let speeds = if self.speeds.is_empty() { need } else { self.speeds.len() };
        let map = self.map.cells().len();
        for (layer, got) in [("terrain", terrain), ("map", map), ("policy", policy), ("speeds", speeds)] {
            if got != need {
                return Err(ReportError::Cells { layer, need, got });
            }
        }
        Ok(())
    }

    fn patterns(&self, svg: &mut SvgWriter, frame: &Frame, tiles: &TileMap) {
        let Frame { left, top, width, height, .. } = *frame;
        let id = |name: &str| frame.id(name);
        svg.raw(&format!(
            "<clipPath id=\"{}\"><rect x=\"{}\" y=\"{}\" width=\"{}\" height=\"{}\"/></clipPath>",
            id("plot"),
            Number(left),
            Number(top),
            Number(width),
            Number(height)
        ));
        // Cells are drawn in units of a tile; patterns are given in those units, too.
        let unit = 1.0 / (frame.pitch * f64::from(tiles.block));
        let stripes = |id: &str, pitch: f64, line: f64, turn: u32, colour: &str| {
            let (pitch, line) = (Number(pitch * unit), Number(line * unit));
            format!(
                "<pattern id=\"{id}\" width=\"{pitch}\" height=\"{pitch}\" patternUnits=\"userSpaceOnUse\" \
                 patternTransform=\"rotate({turn})\"><rect width=\"{line}\" height=\"{pitch}\" fill=\"{colour}\"/></pattern>"
            )
        };
        svg.raw(&stripes(&id("unseen-hatch"), 7.0, 0.9, 45, colour::HATCH));
        svg.raw(&stripes(&id("blocked-hatch"), 4.0, 1.6, 135, colour::BLOCKED));
        if frame.style == PictureStyle::Paper {
            svg.raw(&stripes(&id("sand-hatch"), 5.0, 0.8, 90, colour::BLOCKED));
        }
    }

    fn ground(&self, svg: &mut SvgWriter, frame: &Frame, tiles: &TileMap, (layer, heights): (Layer, Range)) {
        let scale = frame.pitch * f64::from(tiles.block);
        svg.open("g", &format!("clip-path=\"url(#{})\"", frame.id("plot")));
        svg.open(
            "g",
            &format!(
                "transform=\"translate({} {}) scale({} {})\" shape-rendering=\"crispEdges\"",
                Number(frame.left),
                Number(frame.top + frame.height),
                Number(scale),
                Number(-scale)
            ),
        );
        match frame.ground {
            None => match layer.range() {
                None => draw_terrain(svg, frame, tiles, heights),
                Some(range) => draw_values(svg, frame, tiles, layer, range),
            },
            Some(place) => svg.raw(&format!("<use href=\"#ground-{place}\"/>")),
        }
        let unseen = tiles.fill(|tile| !tile.seen);
        if layer.range().is_none() {
            svg.path(&unseen, "fill=\"#fff\" fill-opacity=\".72\"");
        }
        let hatch = format!("fill=\"url(#{})\" shape-rendering=\"auto\"", frame.id("unseen-hatch"));
        svg.path(&unseen, &hatch);
        let edge = format!(
            "fill=\"none\" stroke=\"{}\" stroke-width=\"{}\" shape-rendering=\"auto\"",
            colour::EDGE,
            Number(1.2 / scale)
        );
        svg.path(&tiles.outline(|tile| tile.seen), &edge);
        svg.close("g");
        svg.close("g");
    }

    /// Draws an arrow where the policy hops, thinned out to stay readable, faint over unseen ground.
    fn arrows(&self, svg: &mut SvgWriter, frame: &Frame) {
        let Some(policy) = self.policy else { return };
        let span = self.brief.grid.hop_cells;
        let pitch_min = (ARROW_PITCH_MIN * frame.width.max(frame.height)).max(ARROW_PITCH_LEAST);
        let hops = ((pitch_min / (frame.pitch * f64::from(span))).ceil() as u32).max(1);
        let stride = (hops * span) as i32;
        let share = if frame.style == PictureStyle::Paper { 0.46 } else { 0.66 };
        let quiver = Quiver::new((share * frame.pitch * f64::from(stride)).min(26.0));
        let (start, goal) = (self.start(), self.goal());
        let drawn = |cell: &Cell| {
            (cell.x - start.x).rem_euclid(stride) == 0 && (cell.y - start.y).rem_euclid(stride) == 0
        };
        quiver.open(svg);
        let layers: &[(bool, &str)] = match frame.style {
            PictureStyle::Screen => &[(false, ".4"), (true, "1")],
            PictureStyle::Paper => &[(true, ".7")],
        };
        for &(seen, opacity) in layers {
            for direction in Direction::ALL {
                let mut at = Vec::new();
                for (index, cell) in self.brief.grid.iter().enumerate().filter(|(_, cell)| drawn(cell)) {
                    let passable = self.ground_at(index).is_none_or(|ground| ground.passable);
                    let points =
                        policy[index].action.hop() == Some(direction) && passable && Some(cell) != goal;
                    if points && self.map.cells()[index].is_some() == seen {
                        at.push(frame.centre(cell));
                    }
                }
                let ink = colour::arrow(direction);
                let path = quiver.path(direction, at);
                svg.path(&path, &format!("fill=\"{ink}\" fill-opacity=\"{opacity}\""));
            }
        }
        svg.close("g");
    }

    /// What the motion model told of a decision.
    pub(super) fn detail(&self, record: &Record) -> Option<&Detail> {
        let place = self.details.binary_search_by_key(&record.decision, |(decision, _)| *decision).ok()?;
        Some(&self.details[place].1)
    }

    /// Where the decision left its robot, in the document: exactly where that is told, else the middle of its cell.
    pub(super) fn place(&self, frame: &Frame, record: &Record) -> (f64, f64) {
        let cell = record.pose.cell;
        match self.detail(record) {
            Some(Detail { rest_m: [x_m, y_m, _], .. }) if self.brief.grid.contains(cell) => {
                self.at(frame, Waypoint { x_m: *x_m, y_m: *y_m })
            }
            _ => frame.centre(cell),
        }
    }

    /// Draws what rolled, and where bodies hit the ground.
    fn ways(&self, svg: &mut SvgWriter, frame: &Frame, breadth: f64) {
        let (mut rolled, mut hits) = (String::new(), String::new());
        let size = (frame.pitch * 0.09).clamp(2.4, 5.0);
        for detail in self.hopper_route().filter_map(|record| self.detail(record)) {
            for stretch in way::stretches(detail).iter().filter(|stretch| stretch.launch_mps.is_none()) {
                rolled += &self.stroke(frame, stretch);
            }
            for [x_m, y_m, _] in way::impacts(detail) {
                let (x, y) = self.at(frame, Waypoint { x_m, y_m });
                hits += &symbols::impact(x, y, size);
            }
        }
        let line = "fill=\"none\" stroke-linecap=\"round\"";
        svg.path(
            &rolled,
            &format!("{line} stroke=\"{}\" stroke-width=\"{}\"", colour::ROLLED, Number(breadth)),
        );
        let rim = format!("stroke=\"{}\" stroke-width=\"1\"", colour::DARK);
        svg.path(&hits, &format!("class=\"impacts\" fill=\"{}\" {rim}", colour::IMPACT));
    }

    /// A stretch of a way on the ground.
    fn stroke(&self, frame: &Frame, stretch: &Stretch) -> String {
        let end = |[x_m, y_m, _]: [f64; 3]| self.at(frame, Waypoint { x_m, y_m });
        let ((x, y), (to_x, to_y)) = (end(stretch.from_m), end(stretch.to_m));
        format!("M{} {}L{} {}", Number(x), Number(y), Number(to_x), Number(to_y))
    }

    /// Draws the route: one line for hops as intended, one for stray hops, rings where the hopper stayed.
    fn route_lines(&self, svg: &mut SvgWriter, frame: &Frame) {
        let breadth = (frame.pitch * 0.16).clamp(2.4, 5.0);
        let (intended, stray) =
            (self.line(frame, |branch| branch == Branch::Intended), self.line(frame, is_slip));
        let line = |colour: &str, width: f64, rest: &str| {
            format!(
                "fill=\"none\" stroke=\"{colour}\" stroke-width=\"{}\" stroke-linecap=\"round\" \
                 stroke-linejoin=\"round\"{rest}",
                Number(width)
            )
        };
        svg.path(&intended, &line("#fff", breadth + 2.4, " stroke-opacity=\".85\""));
        svg.path(&stray, &line("#fff", breadth + 2.4, " stroke-opacity=\".85\""));
        svg.path(&intended, &line(colour::ROUTE, breadth, ""));
        let dashes = match frame.pitch > DASHED_PITCH_MIN {
            true => format!(" stroke-dasharray=\"{} {}\"", Number(breadth * 1.2), Number(breadth * 1.8)),
            false => String::new(),
        };
        svg.path(&stray, &line(colour::STRAY, breadth, &dashes));
        self.ways(svg, frame, breadth);
        let stayed = self.hopper_route().filter(|record| record.outcome.branch == Branch::Stayed);
        let (told, untold): (Vec<&Record>, Vec<&Record>) =
            stayed.partition(|record| self.detail(record).is_some());
        let stuck: BTreeSet<Cell> = untold.iter().map(|record| record.outcome.from).collect();
        let stuck = stuck.into_iter().map(|cell| frame.centre(cell));
        let radius = (frame.pitch * 0.24).clamp(2.6, 8.0);
        let (radius, rim) = (Number(radius), Number((radius * 0.4).min(2.4)));
        for (x, y) in stuck.chain(told.iter().map(|record| self.place(frame, record))) {
            svg.raw(&format!(
                "<circle cx=\"{}\" cy=\"{}\" r=\"{radius}\" fill=\"#fff\" stroke=\"{}\" stroke-width=\"{rim}\"/>",
                Number(x),
                Number(y),
                colour::STRAY
            ));
        }
    }

    /// Numbers every tenth hop beside where it landed, in the first corner where no other number stands; none where all are taken.
    fn hop_numbers(&self, svg: &mut SvgWriter, frame: &Frame) {
        let tenth = |record: &&Record| (record.decision.0 + 1).is_multiple_of(10);
        let mut taken: Vec<[f64; 4]> = Vec::new();
        for record in self.hopper_route().filter(tenth) {
            let (x, y) = self.place(frame, record);
            let number = (record.decision.0 + 1).to_string();
            let width = 8.5 * number.len() as f64;
            let corners = [(5.0, -5.0), (5.0, 16.0), (-5.0 - width, -5.0), (-5.0 - width, 16.0)];
            // Left, right, top and bottom of the number.
            let boxes = corners.map(|(dx, dy)| [x + dx, x + dx + width, y + dy - 12.0, y + dy + 2.0]);
            let is_free = |own: &&[f64; 4]| {
                let apart = |other: &[f64; 4]| {
                    own[1] <= other[0] || other[1] <= own[0] || own[3] <= other[2] || other[3] <= own[2]
                };
                taken.iter().all(apart)
            };
            let Some(own) = boxes.iter().find(is_free).copied() else { continue };
            taken.push(own);
            let attributes = "font-size=\"13\" stroke=\"#fff\" stroke-width=\"3\" paint-order=\"stroke\"";
            svg.text(own[0], own[3] - 2.0, attributes, &number);
        }
    }

    /// Path over the hops whose branch is `wanted`; hops between the same two cells are drawn once, but for those whose way is told.
    fn line(&self, frame: &Frame, wanted: impl Fn(Branch) -> bool) -> String {
        let mut path = String::new();
        let mut drawn = BTreeSet::new();
        let mut pen = None;
        for record in self.hopper_route().filter(|record| wanted(record.outcome.branch)) {
            if let Some(detail) = self.detail(record) {
                let stretches = way::stretches(detail);
                let flights = stretches.iter().filter(|stretch| stretch.launch_mps.is_some());
                flights.for_each(|stretch| path += &self.stroke(frame, stretch));
                pen = None;
                continue;
            }
            let (from, to) = (record.outcome.from, record.outcome.to);
            if !drawn.insert((from.min(to), from.max(to))) {
                continue;
            }
            if pen != Some(from) {
                let (x, y) = frame.centre(from);
                let _ = write!(path, "M{} {}", Number(x), Number(y));
            }
            let (x, y) = frame.centre(to);
            let _ = write!(path, "L{} {}", Number(x), Number(y));
            pen = Some(to);
        }
        path
    }

    /// Whether the treasure on `cell` was collected, seen or neither.
    pub(super) fn treasure_state(&self, cell: Cell) -> TreasureState {
        let seen = self.brief.grid.index(cell).is_some_and(|index| self.map.cells()[index].is_some());
        match self.route.iter().any(|record| record.pose.cell == cell) {
            true => TreasureState::Collected,
            false if seen => TreasureState::Seen,
            false => TreasureState::Unseen,
        }
    }

    /// Draws start, goals, treasures, and the hopper with its sensing disc.
    fn markers(&self, svg: &mut SvgWriter, frame: &Frame) {
        let here = self.route.last().map_or(frame.centre(self.start()), |last| self.place(frame, last));
        let size = (frame.pitch * 0.3).clamp(6.0, 10.0);
        if let Some(radius_m) = self.sensing_radius_m {
            let (x, y) = here;
            let radius = Number(radius_m / self.brief.grid.cell_size_m * frame.pitch);
            svg.open("g", &format!("clip-path=\"url(#{})\"", frame.id("plot")));
            for (colour, width, dash) in [("#fff", 3.2, ""), ("#111", 1.4, " stroke-dasharray=\"5 4\"")] {
                svg.raw(&format!(
                    "<circle cx=\"{}\" cy=\"{}\" r=\"{radius}\" fill=\"none\" stroke=\"{colour}\" stroke-width=\"{width}\"{dash}/>",
                    Number(x),
                    Number(y)
                ));
            }
            svg.close("g");
        }
        for &cell in self.treasures {
            let (x, y) = frame.centre(cell);
            svg.raw(&symbols::treasure(x, y, size * 0.72, self.treasure_state(cell)));
        }
        let (x, y) = frame.centre(self.start());
        svg.raw(&symbols::start(x, y, size));
        for goal in self.brief.robots[0].goal.cells(&self.brief.grid) {
            let (x, y) = frame.centre(goal);
            svg.raw(&symbols::goal(x, y, size));
        }
        let (x, y) = here;
        svg.raw(&symbols::hopper(x, y, size * 0.62));
    }

    /// How the mission ended, in one sentence.
    pub(super) fn title(&self) -> String {
        let last = self.route.last();
        let cell = self.position();
        // The route of a long mission is its end only, so its hops cannot be counted.
        let whole = self.route.first().is_none_or(|record| record.decision == Decision(0));
        let decisions = last.map_or(0, |record| record.decision.next().0);
        let visits = last.map_or(0, |record| record.visits);
        let ending = EndSentence {
            outcome: self.outcome,
            hops: if whole { self.hops(|_| true) } else { decisions },
            steps: last.map_or(0, |record| record.steps),
            steps_max: self.brief.limits.steps_max,
            cell,
            distance_to_goal_m: self
                .goal()
                .map_or(0.0, |goal| cell.distance_cells(goal) * self.brief.grid.cell_size_m),
            visited: self.brief.visits().map(|_| visits),
            team: TeamEffort::of(self.brief, decisions, visits),
        };
        ending.to_string()
    }

    /// Scenario, planners, profile and number of stray hops.
    pub(super) fn caption(&self) -> String {
        let Brief { scenario, profile, .. } = self.brief;
        let names = self.route.iter().map(|record| record.leader.planner);
        let planners =
            if self.brief.robots.count() > 1 { planners_of_team(names) } else { planners_in_order(names) };
        let stray = counted(self.hops(|branch| branch != Branch::Intended), "stray hop");
        format!("Scenario {scenario}, planner {planners}, profile {profile}, {stray}")
    }

    fn hops(&self, wanted: impl Fn(Branch) -> bool) -> u64 {
        let branches = self.hopper_route().map(|record| record.outcome.branch);
        branches.filter(|&branch| branch != Branch::Held && wanted(branch)).count() as u64
    }

    /// The decisions of the hopper; of robots that are none, all.
    fn hopper_route(&self) -> impl Iterator<Item = &Record> {
        let is_of_hopper = self.is_of_hopper();
        self.route.iter().filter(move |record| !is_of_hopper || record.robot == RobotId(0))
    }

    /// Whether it is the mission of a hopper, robot 0, for which any others look ahead.
    pub(super) fn is_of_hopper(&self) -> bool {
        self.brief.account == Account::Hopper
    }

    /// The cell that robot 0 started from.
    fn start(&self) -> Cell {
        self.brief.robots[0].start.cell
    }

    /// The goal of robot 0 in force at the end of the route; `None` if it has none.
    fn goal(&self) -> Option<Cell> {
        let visits = self.route.last().map_or(0, |record| record.visits);
        self.brief.goal_after(visits)
    }

    /// Cell of the hopper at the end of the route.
    fn position(&self) -> Cell {
        self.route.last().map_or(self.start(), |record| record.pose.cell)
    }

    /// The true ground of a cell, or what was seen of it if the truth is not known.
    pub(super) fn ground_at(&self, index: usize) -> Option<&Ground> {
        self.terrain.get(index).or(self.map.cells()[index].as_ref())
    }
}

/// Draws heights, sand and impassable ground as a group that other plots can reuse.
fn draw_terrain(svg: &mut SvgWriter, frame: &Frame, tiles: &TileMap, heights: Range) {
    svg.open("g", &format!("id=\"{}\"", frame.id("ground")));
    svg.path(&tiles.fill(|_| true), &format!("fill=\"{}\"", colour::NOTHING));
    let shade_of =
        |height_m: f64| (heights.normalise(height_m) * SHADES as f64).min(SHADES as f64 - 1.0) as usize;
    for shade in 0..SHADES {
        let colour = colour::height((shade as f64 + 0.5) / SHADES as f64);
        let cells = tiles.fill(|tile| tile.height_m.is_some_and(|height_m| shade_of(height_m) == shade));
        svg.path(&cells, &format!("fill=\"{colour}\""));
    }
    let sand = tiles.fill(|tile| tile.sand);
    match frame.style {
        PictureStyle::Screen => svg.path(&sand, &format!("fill=\"{}\" fill-opacity=\".5\"", colour::SAND)),
        PictureStyle::Paper => svg.path(&sand, &format!("fill=\"url(#{})\"", frame.id("sand-hatch"))),
    }
    let blocked = tiles.fill(|tile| tile.blocked);
    svg.path(&blocked, &format!("fill=\"{}\" fill-opacity=\".45\"", colour::BLOCKED));
    svg.path(&blocked, &format!("fill=\"url(#{})\"", frame.id("blocked-hatch")));
    svg.close("g");
}

/// Draws what else than heights the ground shows, as a group.
fn draw_values(svg: &mut SvgWriter, frame: &Frame, tiles: &TileMap, layer: Layer, range: Range) {
    svg.open("g", &format!("id=\"{}\"", frame.id("ground")));
    svg.path(&tiles.fill(|_| true), &format!("fill=\"{}\"", colour::NOTHING));
    let shade_of = |value: f64| (range.normalise(value) * SHADES as f64).min(SHADES as f64 - 1.0) as usize;
    for shade in 0..SHADES {
        let colour = colour::hex(layer.colour((shade as f64 + 0.5) / SHADES as f64));
        let cells = tiles.fill(|tile| tile.value.is_some_and(|value| shade_of(value) == shade));
        svg.path(&cells, &format!("fill=\"{colour}\""));
    }
    svg.close("g");
}

pub(super) fn is_slip(branch: Branch) -> bool {
    matches!(branch, Branch::Left | Branch::Right | Branch::Elsewhere | Branch::RolledAway)
}
