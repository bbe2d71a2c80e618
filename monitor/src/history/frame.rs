//! Frames for the page: small pieces of the history, each a named event with JSON data.

use contract::{
    Account, Action, Brief, Cell, Decision, Grid, MonotonicNs, MotionModel, Policy, Robot, RobotId, Role,
    Stage, Vetoed, Waypoint,
};
use report::way::{self, Stretch};
use serde::Serialize;
use serde_json::{Value, json};
use speed_layer::{SpeedEstimate, SpeedLayer, SpeedRow};

use super::layers::GroundLayer;
use super::reason::Ends;
use super::{
    Announced, Announcements, Chances, Details, History, HopReason, Hops, LeaderChange, PeerChange,
    PeerEvent, PeerHistory, Reason, RunHistory, SeenCells, Told, layers,
};

/// Most hops in one frame.
pub const HOPS_A_FRAME: usize = 256;

/// Most details in one frame: each may have two hundred numbers.
pub const DETAILS_A_FRAME: usize = 12;

/// Most cells in one frame.
pub const CELLS_A_FRAME: usize = 4096;

/// Most runs of cells of one distribution in one frame.
pub const SPEED_RUNS_A_FRAME: usize = 1024;

/// Longest side of the part of a policy that is sent, cells around the hopper: more arrows could not be
/// distinguished.
pub const POLICY_SIDE_MAX: u32 = 128;

/// A server-sent event: its name, and one line of JSON.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Frame {
    /// Name of the event: mission, hops, cells, routes, details, speeds, marks, policy or status.
    pub event: &'static str,
    /// JSON data in one line.
    pub data: String,
}

/// Position of a reader in the history or in the policies. A new cursor is at the beginning.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Cursor {
    policy: bool,
    epoch: u64,
    hops: u64,
    leader_changes: u64,
    cells: usize,
    revision: u64,
    events: u64,
    policies: u64,
    status: u64,
    announcements: u64,
    details: u64,
    speeds: usize,
    speed_rows: usize,
}

impl Cursor {
    /// A cursor for policies only.
    #[must_use]
    pub fn of_policies() -> Self {
        Self { policy: true, ..Self::default() }
    }
}

/// One hop as a row: decision, branch, from x and y, to x and y, height, term, steps, status, treasures, visits,
/// origin, letters of vetoed actions, time of the landing before it in milliseconds, robot, how long it lasted in
/// seconds of simulated time, then seven stages in microseconds.
type Row = Vec<Value>;

#[derive(Serialize)]
struct PeerRow<'a> {
    role: &'a str,
    pid: u32,
    planner: &'a str,
    version: &'a str,
    life: String,
    silent_ms: u64,
    alive: bool,
    /// The robots that it commands.
    leads: Vec<RobotId>,
    /// Of a planner the robots that it can plan for.
    plans: Vec<RobotId>,
}

impl History {
    /// The next frame for a reader; `None` if it is up to date. Hops, cells and events are delivered completely and
    /// in order; of status and policy a slow reader gets only the newest.
    pub fn next(&self, cursor: &mut Cursor, now: MonotonicNs) -> Option<Frame> {
        let run = self.run.as_ref()?;
        if cursor.epoch != self.epoch {
            *cursor = Cursor { epoch: self.epoch, policy: cursor.policy, ..Cursor::default() };
            if !cursor.policy {
                return Some(frame("mission", &mission(&run.brief)));
            }
        }
        if cursor.policy {
            return policy(run, cursor);
        }
        hops(&run.hops, cursor)
            .or_else(|| cells(&run.seen_cells, cursor))
            .or_else(|| routes(&run.announcements, cursor))
            .or_else(|| details(&run.brief, &run.details, cursor))
            .or_else(|| speeds(&run.brief, run.speeds.layer(), cursor))
            .or_else(|| events(&self.peers, cursor))
            .or_else(|| self.status(cursor, now))
    }

    /// Whether there is a frame for a reader.
    #[must_use]
    pub fn has_news(&self, cursor: &Cursor) -> bool {
        let Some(run) = &self.run else { return false };
        if cursor.policy {
            return cursor.policies < run.policy.0 || cursor.epoch != self.epoch && run.policy.0 > 0;
        }
        let (revision, log) = run.seen_cells.log(cursor.cells);
        cursor.epoch != self.epoch
            || cursor.hops < run.hops.due().0
            || cursor.revision != revision
            || !log.is_empty()
            || cursor.announcements < run.announcements.count()
            || cursor.details < run.details.count()
            || run.speeds.layer().is_some_and(|layer| cursor.speeds < layer.codes().len())
            || cursor.events < self.peers.events_count()
            || (cursor.status < self.progress.0 && self.progress.1.is_some())
    }

    /// The reason for a hop from `cell` when decision `at` is due, or null, as JSON in one line.
    #[must_use]
    pub fn reason_json(&self, cell: Cell, at: Decision) -> String {
        self.reason(cell, at).as_ref().map_or(Value::Null, reason).to_string()
    }

    fn status(&self, cursor: &mut Cursor, now: MonotonicNs) -> Option<Frame> {
        let (number, progress) = &self.progress;
        let progress = progress.as_ref()?;
        if *number <= cursor.status {
            return None;
        }
        cursor.status = *number;
        let robots = self.brief().map_or(0, |brief| brief.robots.len() as u16);
        let peers = self.peers.peers();
        let peers = peers.iter().map(|peer| PeerRow {
            role: peer.beat.role.as_str(),
            pid: peer.beat.pid,
            planner: peer.beat.planner.as_str(),
            version: peer.beat.version.as_str(),
            life: peer.beat.incarnation.to_string(),
            silent_ms: now.since_ns(peer.heard) / 1_000_000,
            alive: !peer.silent,
            leads: self.led_by(peer.beat.incarnation),
            plans: (0..robots)
                .map(RobotId)
                .filter(|robot| peer.beat.role == Role::Planner && peer.beat.robots.has(*robot))
                .collect(),
        });
        let treasures: &[Cell] = self.seen_cells().map_or(&[], SeenCells::treasures);
        let pacing = self.pacing.map(
            |pacing| json!({ "pace": pacing.pace.to_string(), "paused": pacing.paused, "heeds": pacing.obeys }),
        );
        let status = json!({
            "progress": progress,
            "interrupted": self.is_interrupted(),
            "peers": peers.collect::<Vec<_>>(),
            "missing": self.missing_peer().map(|missing| json!({
                "peer": missing.to_string(),
                "command": self.remedy(),
            })),
            "tempo": pacing,
            "treasures": treasures.iter().map(|cell| [cell.x, cell.y]).collect::<Vec<_>>(),
            "state": self.state().map(|state| json!({
                "cell": [state.pose.cell.x, state.pose.cell.y],
                "height_m": state.pose.height_m,
                "decision": state.decision,
                "term": state.leader.term,
            })),
        });
        Some(frame("status", &status))
    }
}

fn frame(event: &'static str, data: &Value) -> Frame {
    Frame { event, data: data.to_string() }
}

fn mission(brief: &Brief) -> Value {
    let first = &brief.robots[0];
    let goals = first.goal.cells(&brief.grid);
    json!({
        "run": brief.run,
        "scenario": brief.scenario,
        "profile": brief.profile,
        "grid": brief.grid,
        "start": [first.start.cell.x, first.start.cell.y],
        "goals": goals.iter().map(|goal| [goal.x, goal.y]).collect::<Vec<_>>(),
        "hops_max": brief.visits().map(|visit| visit.hops_max),
        "datum_m": brief.datum_m,
        "height_m": [brief.priors.height_m.min, brief.priors.height_m.max],
        "budget_us": brief.limits.decision_budget_ns as f64 / 1e3,
        "robots": brief.robots.iter().map(|one| robot(one, &brief.grid)).collect::<Vec<_>>(),
        "hops": brief.account == Account::Hopper,
        "speeds": brief.sampling.is_some(),
        "layers": layers::for_page(brief),
        "certain": layers::certain(brief),
        "steps_max": brief.limits.steps_max,
        "stages": Stage::ALL.map(Stage::as_str),
    })
}

/// A robot as the page draws it; its places in cells from the south-western corner of the map.
fn robot(robot: &Robot, grid: &Grid) -> Value {
    let place = |point: Waypoint| [point.x_m / grid.cell_size_m, point.y_m / grid.cell_size_m];
    json!({
        "body": robot.body.name(),
        "sensor": robot.sensor,
        "start": place(robot.start_at),
        "goals": robot.goal.points(grid).into_iter().map(place).collect::<Vec<_>>(),
    })
}

fn hops(hops: &Hops, cursor: &mut Cursor) -> Option<Frame> {
    let from = cursor.hops.max(hops.first().0);
    if from >= hops.due().0 {
        return None;
    }
    let mut decision = from;
    let mut rows: Vec<Row> = Vec::new();
    for hop in hops.from(Decision(from)).take(HOPS_A_FRAME) {
        let mut row = vec![
            json!(decision),
            json!(hop.branch),
            json!(hop.from.x),
            json!(hop.from.y),
            json!(hop.to.x),
            json!(hop.to.y),
            rounded(hop.height_m, 1e3),
            json!(hop.term),
            json!(hop.steps),
            json!(hop.status),
            json!(hop.collected.count()),
            json!(hop.visits),
            json!(hop.origin),
            json!(letters(hop.vetoed)),
            rounded(hop.landed.0 as f64 / 1e6, 1.0),
            json!(hop.robot),
            rounded(hop.lasts_s, 1e3),
        ];
        row.extend(hop.stages_ns.map(|ns| rounded(ns as f64 / 1e3, 10.0)));
        rows.push(row);
        decision += 1;
    }
    cursor.hops = decision;
    let leader_changes: Vec<Value> =
        hops.leader_changes_from(cursor.leader_changes).map(leader_change).collect();
    cursor.leader_changes = hops.leader_changes_count();
    Some(frame("hops", &json!({ "rows": rows, "leaders": leader_changes })))
}

fn leader_change(leader_change: &LeaderChange) -> Value {
    let LeaderChange { robot, is_first, term, planner, pid, from } = leader_change;
    json!({ "robot": robot, "first": is_first, "term": term, "planner": planner, "pid": pid, "from": from })
}

/// Cells as three lists of equal length: difference of the index to the one before; height in millimetres times
/// four, plus one for sand and two for impassable; difference of the decision of first sight to the one before. Where speeds
/// are uncertain, a fourth has what was observed: 0 nothing, 1 to 4 the speed, 5 to 8 a reading. Layers with values of seen ground
/// have a list each of their values.
fn cells(seen_cells: &SeenCells, cursor: &mut Cursor) -> Option<Frame> {
    let (revision, _) = seen_cells.log(0);
    if cursor.revision != revision {
        (cursor.revision, cursor.cells) = (revision, 0);
    }
    let (_, log) = seen_cells.log(cursor.cells);
    let log = &log[..log.len().min(CELLS_A_FRAME)];
    if log.is_empty() {
        return None;
    }
    let (mut indices, mut heights, mut dates, mut speeds) = (Vec::new(), Vec::new(), Vec::new(), Vec::new());
    let (mut index_before, mut date_before) = (0, 0);
    for &index in log {
        let Some(seen) = seen_cells.get(index as usize) else { continue };
        let millimetres = (f64::from(seen.height_m) * 1e3).round() as i64;
        indices.push(i64::from(index) - index_before);
        heights.push(4 * millimetres + i64::from(seen.sand) + 2 * i64::from(!seen.passable));
        dates.push(i64::from(seen.at) - date_before);
        let reading = seen.reading.map_or(0, |reading| 5 + reading as u8);
        speeds.push(seen.speed.map_or(reading, |speed| 1 + speed as u8));
        (index_before, date_before) = (i64::from(index), i64::from(seen.at));
    }
    cursor.cells += log.len();
    let mut data = json!({ "i": indices, "h": heights, "at": dates });
    if speeds.iter().any(|speed| *speed > 0) {
        data["v"] = json!(speeds);
    }
    let layers = seen_cells.layers().iter();
    let columns: Vec<Vec<Value>> = layers.map(|layer| column(seen_cells, log, layer)).collect();
    if !columns.is_empty() {
        data["values"] = json!(columns);
    }
    Some(frame("cells", &data))
}

/// What a layer shows of the cells of a frame.
fn column(seen_cells: &SeenCells, log: &[u32], layer: &GroundLayer) -> Vec<Value> {
    let cells = log.iter().map(|index| *index as usize).filter(|index| seen_cells.get(*index).is_some());
    let value = |index| seen_cells.value(layer.layer, index).map(|value| rounded(value, layer.parts));
    cells.filter_map(value).collect()
}

/// A route that a robot announced, with its points in metres from the south-western corner of the map.
fn routes(announcements: &Announcements, cursor: &mut Cursor) -> Option<Frame> {
    let announced = announcements.from(cursor.announcements).next()?;
    let left = announcements.from(cursor.announcements).count() as u64;
    cursor.announcements = announcements.count() - left + 1;
    let Announced { decision, robot, route } = announced;
    let point = |point: &Waypoint| [rounded(point.x_m, 1e3), rounded(point.y_m, 1e3)];
    let points: Vec<_> = route.waypoints().iter().map(point).collect();
    Some(frame("routes", &json!({ "decision": decision, "robot": robot, "points": points })))
}

/// What the motion model told of the next hops, as `hopper journal show --format json` has it; beside each which stretches of the way are
/// flights, how long it took, how it ended and the energy that is lost. What the figures of each model are called goes with them.
fn details(brief: &Brief, details: &Details, cursor: &mut Cursor) -> Option<Frame> {
    let told = details.from(cursor.details).take(DETAILS_A_FRAME);
    if told.len() == 0 {
        return None;
    }
    let left = details.from(cursor.details).len();
    cursor.details = details.count() - (left - told.len()) as u64;
    // All hoppers of a mission are under the same gravity.
    let gravity_mps2 =
        brief.robots.iter().find_map(|robot| robot.as_hopper()).map(|(motion, _)| motion.gravity_mps2);
    let row = |told: &Told| {
        let Told { decision, detail } = told;
        let stretches = way::stretches(detail);
        json!({
            "decision": decision,
            "detail": detail,
            "stretches": stretches.iter().map(stretch).collect::<Vec<_>>(),
            "ended": way::ending(detail),
            "lost_j_per_kg": gravity_mps2.and_then(|gravity_mps2| way::lost_j_per_kg(detail, gravity_mps2)),
        })
    };
    let names: serde_json::Map<String, Value> =
        MotionModel::ALL.iter().map(|model| (model.name().to_owned(), json!(model.figures()))).collect();
    Some(frame("details", &json!({ "rows": told.map(row).collect::<Vec<_>>(), "figures": names })))
}

/// A stretch of a way: when it begins and ends, where, the speed of the climb if it is a flight, and whether it leads to rest.
fn stretch(stretch: &Stretch) -> Value {
    let Stretch { from_m, to_m, begins_s, ends_s, launch_mps, is_last } = *stretch;
    json!({
        "begins_s": begins_s,
        "ends_s": ends_s,
        "from_m": from_m,
        "to_m": to_m,
        "climb_mps": launch_mps.map(|[_, _, climb_mps]| climb_mps),
        "last": is_last,
    })
}

/// Speeds of the next cells in index order: distributions that are new to the reader, each as what the layers of speeds show
/// under the prior and, where a camera errs, after each of the four readings; then pairs of a distribution's number and how many
/// cells in a row have it.
fn speeds(brief: &Brief, layer: Option<&SpeedLayer>, cursor: &mut Cursor) -> Option<Frame> {
    let layer = layer.filter(|layer| cursor.speeds < layer.codes().len())?;
    let (from, known) = (cursor.speeds, cursor.speed_rows);
    let mut runs = Vec::new();
    for run in layer.codes()[from..].chunk_by(PartialEq::eq).take(SPEED_RUNS_A_FRAME) {
        runs.extend([run[0], run.len() as u32]);
        cursor.speeds += run.len();
        // Rows are numbered in the order of their first cells.
        cursor.speed_rows = cursor.speed_rows.max(run[0] as usize + 1);
    }
    let columns = layers::of_speeds(brief);
    let row = |row: &SpeedRow| {
        let read: &[SpeedEstimate] = if row.read == [row.unseen; 4] { &[] } else { &row.read };
        let mut numbers = Vec::new();
        for estimate in std::iter::once(&row.unseen).chain(read) {
            let values =
                columns.iter().map(|(of, parts)| rounded(of(estimate.mean_and_sd_m_per_sol()), *parts));
            numbers.extend(values);
        }
        numbers
    };
    let rows: Vec<_> = layer.rows()[known..cursor.speed_rows].iter().map(row).collect();
    Some(frame("speeds", &json!({ "from": from, "rows": rows, "runs": runs })))
}

fn events(peers: &PeerHistory, cursor: &mut Cursor) -> Option<Frame> {
    if cursor.events >= peers.events_count() {
        return None;
    }
    let events: Vec<Value> = peers.events_from(cursor.events).map(event).collect();
    cursor.events = peers.events_count();
    Some(frame("marks", &Value::Array(events)))
}

fn event(event: &PeerEvent) -> Value {
    let PeerEvent { decision, change, beat } = event;
    let change: &PeerChange = change;
    json!({
        "decision": decision,
        "change": change.as_str(),
        "role": beat.role,
        "pid": beat.pid,
        "planner": beat.planner,
    })
}

fn policy(run: &RunHistory, cursor: &mut Cursor) -> Option<Frame> {
    let (number, policy) = &run.policy;
    let policy = policy.as_ref()?;
    if *number <= cursor.policies {
        return None;
    }
    cursor.policies = *number;
    let centre = run.state.map_or(run.brief.robots[0].start.cell, |state| state.pose.cell);
    let window = Window::around(&run.brief.grid, centre, policy)?;
    Some(frame("policy", &window.json(&run.brief.grid, policy)))
}

/// The part of a policy that is sent.
struct Window {
    x: u32,
    y: u32,
    width: u32,
    height: u32,
}

impl Window {
    fn around(grid: &Grid, centre: Cell, policy: &Policy) -> Option<Self> {
        let span = |at: i32, side: u32| {
            let length = side.min(POLICY_SIDE_MAX);
            ((at - length as i32 / 2).clamp(0, (side - length) as i32) as u32, length)
        };
        let ((x, width), (y, height)) = (span(centre.x, grid.width), span(centre.y, grid.height));
        (policy.cells.len() == grid.cells()).then_some(Self { x, y, width, height })
    }

    fn json(&self, grid: &Grid, policy: &Policy) -> Value {
        let (mut actions, mut values) = (String::new(), Vec::new());
        for y in self.y..self.y + self.height {
            let row = (y * grid.width + self.x) as usize;
            for cell in &policy.cells[row..row + self.width as usize] {
                actions.push(letter(cell.action));
                values.push(rounded(cell.value, 1e3));
            }
        }
        let (planner, decision) = (policy.planner, policy.decision);
        json!({
            "decision": decision, "planner": planner, "error_bound": policy.error_bound, "x": self.x, "y": self.y,
            "width": self.width, "height": self.height, "actions": actions, "values": values,
        })
    }
}

/// The reason for a hop as the page shows it; chances in the order as aimed, stuck, left, right, elsewhere, lost.
fn reason(reason: &Reason) -> Value {
    let hop = |hop: &HopReason| {
        let Chances { aimed, stayed, left, right, elsewhere, lost } = hop.chances;
        let chances = [aimed, stayed, left, right, elsewhere, lost];
        let ends = hop.ends.map(|ends| match ends {
            Ends::AtGoal => "goal",
            Ends::OffMap => "off the map",
            Ends::Impassable => "impassable",
        });
        json!({
            "action": letter(Action::Hop(hop.direction)).to_string(),
            "chances": chances.map(|chance| rounded(chance, 1e4)).to_vec(),
            "terms": hop.terms.map(|terms| terms.map(|term| rounded(term, 1e3)).to_vec()),
            "ends": ends,
            "value": hop.value.map(|value| rounded(value, 1e4)),
        })
    };
    let policy = reason.policy.map(|(planner, decision, action)| {
        json!({ "planner": planner, "decision": decision, "action": letter(action).to_string() })
    });
    json!({
        "cell": [reason.cell.x, reason.cell.y],
        "seen": reason.ground.is_some(),
        "sand": reason.ground.is_some_and(|ground| ground.soil == contract::Soil::Sand),
        "slope_deg": reason.ground.map(|ground| rounded(libm::atan(ground.steepness()).to_degrees(), 10.0)),
        "policy": policy,
        "vetoed": letters(reason.vetoed),
        "hops": reason.hops.iter().map(hop).collect::<Vec<_>>(),
    })
}

fn letter(action: Action) -> char {
    match action {
        Action::Hold => '-',
        Action::Hop(direction) | Action::Up(direction) | Action::Step(direction) => {
            ['n', 'e', 's', 'w'][direction as usize]
        }
        // Robots that go from point to point have no arrows.
        _ => '*',
    }
}

fn letters(vetoed: Vetoed) -> String {
    Action::ALL.into_iter().filter(|&action| vetoed.has(action)).map(letter).collect()
}

/// A number rounded to the decimals that the page displays.
fn rounded(value: f64, scale: f64) -> Value {
    let value = (value * scale).round() / scale;
    if value == value.trunc() && value.abs() < 9e15 { json!(value as i64) } else { json!(value) }
}
