//! Messages: any bytes to a wire type, from there to what engines compute with or one refusal.
//!
//! What is accepted goes the way back, and comes out as it went in: no message holds a number that is not
//! equal to itself, nor one that is read in two ways.

use std::fmt::Debug;

use bytemuck::Zeroable;
use contract::limits::{
    DETAIL_POINTS_MAX, MAP_PAGE_CELLS, MAP_PATCH_CELLS, PAST_PAGE_RECORDS, PRIOR_PAGE_CELLS, ROBOTS_MAX,
    ROUTE_POINTS_MAX, TABLE_PAGE_ROWS, TRUTH_PAGE_CELLS,
};
use contract::wire::{
    AnnouncementV1, BriefV10, CommandV3, ControlV1, DetailPageV1, DetailRequestV1, GroundV2, HeartbeatV2,
    MapPageV2, MapPatchV2, MapRequestV1, MemberV6, MotionRowV1, PastHeaderV1, PastRequestV1, PathPointV1,
    PolicyCellV1, PolicyHeaderV1, PriorCellV1, PriorPageV1, PriorRequestV1, RecordV5, RobotV1, RoutePageV1,
    RouteRequestV1, SeenCellV4, StateV4, TablePageV1, TableRequestV1, TeamHeaderV1, TempoV1, TruthPageV1,
    TruthRequestV1, WaypointV1, Wire, announcement_from_wire, brief_from_wire, detail_page_from_wire,
    map_page_from_wire, page_from_wire, patch_from_wire, policy_from_wire, prior_page_from_wire,
    route_page_from_wire, table_page_from_wire, team_from_wire, truth_page_from_wire,
};
use contract::{
    Announcement, Cell, Command, Control, Decision, Detail, DetailPage, DetailRequest, Direction, Ground,
    Heartbeat, MapPage, MapPatch, MapRequest, Member, MotionModel, MotionRow, Order, Pace, Pacing,
    PastRequest, PathPoint, Placement, Policy, PolicyCell, PriorCell, PriorPage, PriorRequest, Record,
    Refusal, RobotId, Route, RoutePage, RouteRequest, SeenCell, SpeedPrior, Standing, State, TableLanding,
    TablePage, TableRequest, Team, TruthPage, TruthRequest, Waypoint,
};
use hopper_sim::ROBOT;
use perception::Observation;

use crate::{fixtures, told};

/// `hop/brief`: a header with the robots.
pub fn brief(bytes: &[u8]) {
    let (header, rest) = header(bytes);
    paged(brief_from_wire(&header, &payload(rest)), |brief| {
        assert!((1..=ROBOTS_MAX).contains(&brief.robots.len()));
        let robots: Vec<RobotV1> = brief.robots.iter().map(RobotV1::from).collect();
        brief_from_wire(&BriefV10::from(brief), &robots)
    });
}

/// Reads a message of `hop/rN/command`.
pub fn command(bytes: &[u8]) {
    there_and_back::<CommandV3, Command>(&header(bytes).0);
}

/// Reads messages of `hop/control` and `hop/tempo`.
pub fn control(bytes: &[u8]) {
    there_and_back::<ControlV1, Control>(&header(bytes).0);
    there_and_back::<TempoV1, Pacing>(&header(bytes).0);
}

/// Reads a message of `hop/heartbeat`.
pub fn heartbeat(bytes: &[u8]) {
    there_and_back::<HeartbeatV2, Heartbeat>(&header(bytes).0);
}

/// Reads a message of `hop/state`.
pub fn state(bytes: &[u8]) {
    there_and_back::<StateV4, State>(&header(bytes).0);
}

/// `hop/map`: a header with its cells.
pub fn map_patch(bytes: &[u8]) {
    let (header, rest) = header(bytes);
    paged(patch_from_wire(&header, &payload(rest)), |patch| {
        assert!(patch.cells.len() <= MAP_PATCH_CELLS);
        let cells: Vec<SeenCellV4> = patch.cells.iter().map(SeenCellV4::from).collect();
        patch_from_wire(&MapPatchV2::from(patch), &cells)
    });
}

/// Reads an answer of `hop/snapshot`.
pub fn map_page(bytes: &[u8]) {
    let (header, rest) = header(bytes);
    paged(map_page_from_wire(&header, &payload(rest)), |page| {
        assert!(page.cells.len() <= MAP_PAGE_CELLS);
        let cells: Vec<SeenCellV4> = page.cells.iter().map(SeenCellV4::from).collect();
        map_page_from_wire(&MapPageV2::from(page), &cells)
    });
}

/// Reads an answer of `hop/past`.
pub fn past_page(bytes: &[u8]) {
    let (header, rest) = header(bytes);
    paged(page_from_wire(&header, &payload(rest)), |page| {
        assert!(page.records.len() <= PAST_PAGE_RECORDS);
        let records: Vec<RecordV5> = page.records.iter().map(RecordV5::from).collect();
        page_from_wire(&PastHeaderV1::from(page), &records)
    });
}

/// `hop/team`: a header with the robots.
pub fn team(bytes: &[u8]) {
    let (header, rest) = header(bytes);
    paged(team_from_wire(&header, &payload(rest)), |team| {
        assert!((1..=ROBOTS_MAX).contains(&team.members.len()));
        let members: Vec<MemberV6> = team.members.iter().map(MemberV6::from).collect();
        team_from_wire(&TeamHeaderV1::from(team), &members)
    });
}

/// Reads an announcement of `hop/rN/route`, and an answer of `hop/routes`.
pub fn route(bytes: &[u8]) {
    let (announced, rest) = header(bytes);
    paged(announcement_from_wire(&announced, &payload(rest)), |announcement| {
        assert!((1..=ROUTE_POINTS_MAX).contains(&announcement.route.waypoints().len()));
        let points: Vec<WaypointV1> = announcement.route.waypoints().iter().map(WaypointV1::from).collect();
        announcement_from_wire(&AnnouncementV1::from(announcement), &points)
    });
    let (page, rest) = header(bytes);
    paged(route_page_from_wire(&page, &payload(rest)), |page| {
        let points: Vec<WaypointV1> = page.route.waypoints().iter().map(WaypointV1::from).collect();
        route_page_from_wire(&RoutePageV1::from(page), &points)
    });
    there_and_back::<RouteRequestV1, RouteRequest>(&header(bytes).0);
}

/// Reads an answer of `hop/prior`.
pub fn prior_page(bytes: &[u8]) {
    let (page, rest) = header(bytes);
    paged(prior_page_from_wire(&page, &payload(rest)), |page| {
        assert!(page.cells.len() <= PRIOR_PAGE_CELLS);
        let cells: Vec<PriorCellV1> = page.cells.iter().map(PriorCellV1::from).collect();
        prior_page_from_wire(&PriorPageV1::from(page), &cells)
    });
    there_and_back::<PriorRequestV1, PriorRequest>(&header(bytes).0);
}

/// Reads an answer of `hop/table`.
pub fn table_page(bytes: &[u8]) {
    let (page, rest) = header(bytes);
    paged(table_page_from_wire(&page, &payload(rest)), |page| {
        assert!(page.rows.len() <= TABLE_PAGE_ROWS);
        let rows: Vec<MotionRowV1> = page.rows.iter().map(MotionRowV1::from).collect();
        table_page_from_wire(&TablePageV1::from(page), &rows)
    });
    there_and_back::<TableRequestV1, TableRequest>(&header(bytes).0);
}

/// Reads an answer of `hop/details`.
pub fn detail_page(bytes: &[u8]) {
    let (page, rest) = header(bytes);
    paged(detail_page_from_wire(&page, &payload(rest)), |page| {
        assert!(page.detail.path.len() <= DETAIL_POINTS_MAX);
        let points: Vec<PathPointV1> = page.detail.path.iter().map(PathPointV1::from).collect();
        detail_page_from_wire(&DetailPageV1::from(page), &points)
    });
    there_and_back::<DetailRequestV1, DetailRequest>(&header(bytes).0);
}

/// Reads a message of `hop/rN/policy`.
pub fn policy(bytes: &[u8]) {
    let (header, rest) = header(bytes);
    paged(policy_from_wire(&header, &payload(rest)), |policy| {
        let cells: Vec<PolicyCellV1> = policy.cells.iter().map(PolicyCellV1::from).collect();
        policy_from_wire(&PolicyHeaderV1::from(policy), &cells)
    });
}

/// Reads an answer of `truth/terrain`.
pub fn truth_page(bytes: &[u8]) {
    let (header, rest) = header(bytes);
    paged(truth_page_from_wire(&header, &payload(rest)), |page| {
        assert!(page.cells.len() <= TRUTH_PAGE_CELLS);
        let cells: Vec<GroundV2> = page.cells.iter().map(GroundV2::from).collect();
        truth_page_from_wire(&TruthPageV1::from(page), &cells)
    });
}

/// Cells of the map and of the truth, and records, each alone.
pub fn cell(bytes: &[u8]) {
    there_and_back::<SeenCellV4, SeenCell>(&header(bytes).0);
    there_and_back::<RecordV5, Record>(&header(bytes).0);
    there_and_back::<GroundV2, Ground>(&header(bytes).0);
}

/// Requests of every kind.
pub fn request(bytes: &[u8]) {
    there_and_back::<PastRequestV1, PastRequest>(&header(bytes).0);
    there_and_back::<MapRequestV1, MapRequest>(&header(bytes).0);
    there_and_back::<TruthRequestV1, TruthRequest>(&header(bytes).0);
}

/// The first bytes as a wire type, filled up with zeros, and what follows them.
#[must_use]
pub fn header<W: Wire>(bytes: &[u8]) -> (W, &[u8]) {
    let (head, rest) = bytes.split_at(bytes.len().min(size_of::<W>()));
    let mut wire = W::zeroed();
    bytemuck::bytes_of_mut(&mut wire)[..head.len()].copy_from_slice(head);
    (wire, rest)
}

/// The whole cells, or records, that the bytes hold.
fn payload<C: Wire>(bytes: &[u8]) -> Vec<C> {
    bytes.chunks_exact(size_of::<C>()).map(bytemuck::pod_read_unaligned).collect()
}

fn there_and_back<W, D>(wire: &W)
where
    W: Wire + for<'a> From<&'a D>,
    D: for<'a> TryFrom<&'a W, Error = Refusal> + PartialEq + Debug,
{
    paged(D::try_from(wire), |message| D::try_from(&W::from(message)));
}

fn paged<D: PartialEq + Debug>(message: Result<D, Refusal>, again: impl Fn(&D) -> Result<D, Refusal>) {
    match message {
        Err(refusal) => told(&refusal),
        Ok(message) => assert_eq!(again(&message).as_ref(), Ok(&message), "there and back"),
    }
}

fn bytes_of<W: Wire, C: Wire>(header: &W, cells: &[C]) -> Vec<u8> {
    [bytemuck::bytes_of(header), bytemuck::cast_slice(cells)].concat()
}

/// The brief of [`fixtures`] in wire form.
#[must_use]
pub fn briefs() -> Vec<Vec<u8>> {
    let brief = fixtures::brief();
    let robots: Vec<RobotV1> = brief.robots.iter().map(RobotV1::from).collect();
    vec![bytes_of(&BriefV10::from(&brief), &robots)]
}

/// An order, and a pacing.
#[must_use]
pub fn controls() -> Vec<Vec<u8>> {
    let (run, robot, pace) = (fixtures::brief().run, ROBOT, Pace::Hertz(2.0));
    let control = ControlV1::from(&Control { run, robot, order: Order::Pace(pace) });
    let pacing = TempoV1::from(&Pacing { run, robot, pace, paused: true, obeys: true });
    vec![bytes_of::<_, GroundV2>(&control, &[]), bytes_of::<_, GroundV2>(&pacing, &[])]
}

/// A command in wire form.
#[must_use]
pub fn commands() -> Vec<Vec<u8>> {
    vec![bytes_of::<_, GroundV2>(&CommandV3::from(&fixtures::command(&fixtures::flown().1[0])), &[])]
}

/// A heartbeat in wire form.
#[must_use]
pub fn heartbeats() -> Vec<Vec<u8>> {
    vec![bytes_of::<_, GroundV2>(&HeartbeatV2::from(&fixtures::heartbeat()), &[])]
}

/// The opening state, one amid the mission, and the last.
#[must_use]
pub fn states() -> Vec<Vec<u8>> {
    let states = fixtures::flown().1;
    let some = [0, states.len() / 2, states.len() - 1];
    some.map(|index| bytes_of::<_, GroundV2>(&StateV4::from(&states[index]), &[])).into()
}

/// What has been seen at the start.
fn observation() -> Observation {
    let (brief, state) = (fixtures::brief(), fixtures::flown().1[0]);
    let mut observation = Observation::unseen(&brief, ROBOT);
    observation.fold(&brief, &fixtures::world().terrain, state.pose, Decision(0));
    observation
}

fn seen_cells() -> Vec<SeenCell> {
    let observation = observation();
    let cells = (0..).zip(observation.map().cells());
    cells.filter_map(|(index, ground)| Some(SeenCell { index, visits: 0, ground: (*ground)? })).collect()
}

/// The first patch of the fixtures' mission.
#[must_use]
pub fn patch() -> MapPatch {
    let (observation, cells) = (observation(), seen_cells());
    let map = observation.map();
    MapPatch {
        run: map.run,
        robot: map.robot,
        through: Decision(0),
        digest: map.digest,
        more: 0,
        sequence: 1,
        before: 0,
        after: map.observation(),
        sensed: map.sensed,
        published: map.published,
        grid: map.grid,
        seen_cells: cells.len() as u32,
        treasures: map.treasures().to_vec(),
        cells,
    }
}

/// The page that holds what [`patch`] brings.
#[must_use]
pub fn page() -> MapPage {
    let MapPatch {
        run,
        robot,
        through,
        digest,
        sequence,
        after,
        sensed,
        published,
        grid,
        treasures,
        cells,
        ..
    } = patch();
    let (from, next) = (0, grid.cells() as u32);
    MapPage {
        run,
        robot,
        through,
        digest,
        sequence,
        observation: after,
        sensed,
        published,
        grid,
        from,
        next,
        treasures,
        cells,
    }
}

/// The fixtures' truth, in one page.
#[must_use]
pub fn truth() -> TruthPage {
    let terrain = &fixtures::world().terrain;
    let (cells, treasures) = (terrain.cells.clone(), terrain.treasures.clone());
    TruthPage { run: fixtures::RUN, grid: terrain.grid, from: 0, cells, treasures }
}

/// [`patch`] in wire form.
#[must_use]
pub fn map_patches() -> Vec<Vec<u8>> {
    let patch = patch();
    let cells: Vec<_> = patch.cells.iter().map(SeenCellV4::from).collect();
    vec![bytes_of(&MapPatchV2::from(&patch), &cells)]
}

/// [`page`] in wire form.
#[must_use]
pub fn map_pages() -> Vec<Vec<u8>> {
    let page = page();
    let cells: Vec<_> = page.cells.iter().map(SeenCellV4::from).collect();
    vec![bytes_of(&MapPageV2::from(&page), &cells)]
}

/// The first records of the fixtures' mission.
#[must_use]
pub fn past_pages() -> Vec<Vec<u8>> {
    let header = PastHeaderV1 {
        run: CommandV3::from(&fixtures::command(&fixtures::flown().1[0])).run,
        ..PastHeaderV1::zeroed()
    };
    let records: Vec<_> = fixtures::flown().0.iter().take(3).map(RecordV5::from).collect();
    vec![bytes_of(&header, &records)]
}

/// A route of three points, as it is announced and as it is answered.
#[must_use]
pub fn routes() -> Vec<Vec<u8>> {
    let run = fixtures::flown().1[0].run;
    let points = [0.0, 1.5, 9.0].map(|x_m| Waypoint { x_m, y_m: 2.5 });
    let route = Route::new(points.to_vec()).expect("three points");
    let points: Vec<WaypointV1> = points.iter().map(WaypointV1::from).collect();
    let announcement = Announcement { run, robot: RobotId(1), route: route.clone() };
    let page = RoutePage { run, route };
    vec![
        bytes_of(&AnnouncementV1::from(&announcement), &points),
        bytes_of(&RoutePageV1::from(&page), &points),
    ]
}

/// A page of two cells.
#[must_use]
pub fn prior_pages() -> Vec<Vec<u8>> {
    let state = &fixtures::flown().1[0];
    let prior = |stuck| SpeedPrior::new([stuck, 0.0, 0.0, 1.0 - stuck]).expect("probabilities");
    let cell = |stuck| PriorCell { speeds: prior(stuck), height_m: 1.5 };
    let cells = vec![cell(0.5), cell(0.0)];
    let page = PriorPage { run: state.run, grid: fixtures::brief().grid, from: 1, cells };
    let cells: Vec<PriorCellV1> = page.cells.iter().map(PriorCellV1::from).collect();
    vec![bytes_of(&PriorPageV1::from(&page), &cells)]
}

/// A page of two rows.
#[must_use]
pub fn table_pages() -> Vec<Vec<u8>> {
    let state = &fixtures::flown().1[0];
    let landing = |forward, probability| TableLanding { forward, left: -1, probability };
    let row = MotionRow::new(&[landing(1, 0.5), landing(-8, 0.25)]).expect("landings within reach");
    let page = TablePage { run: state.run, from: 1, rows: vec![row, MotionRow::default()] };
    let rows: Vec<MotionRowV1> = page.rows.iter().map(MotionRowV1::from).collect();
    vec![bytes_of(&TablePageV1::from(&page), &rows)]
}

/// A hop of two points.
#[must_use]
pub fn detail_pages() -> Vec<Vec<u8>> {
    let state = &fixtures::flown().1[0];
    let point = |seconds| PathPoint { seconds, at_m: [0.5, 1.5, 2.0], leaves_mps: [1.0, 0.0, 1.0] };
    let detail = Detail {
        model: MotionModel::Contact,
        rest_m: [1.5, 1.5, 2.0],
        path: vec![point(0.0), point(0.7)],
        figures: [0.0; contract::motion_model::FIGURES],
    };
    let page = DetailPage { run: state.run, decision: state.decision, detail };
    let points: Vec<PathPointV1> = page.detail.path.iter().map(PathPointV1::from).collect();
    vec![bytes_of(&DetailPageV1::from(&page), &points)]
}

/// Two rovers, the second of which is due.
#[must_use]
pub fn teams() -> Vec<Vec<u8>> {
    let state = &fixtures::flown().1[0];
    let at = |x| Placement { cell: Cell::new(x, 1), heading: Direction::North };
    let member = |x| Member {
        at: at(x),
        ready_at_ns: 2_000_000_000,
        standing: Standing::Active,
        waits: false,
        leader: state.leader,
        last: None,
        travel: None,
    };
    let team = Team {
        run: state.run,
        decision: state.decision,
        digest: state.digest,
        due: RobotId(1),
        actor: Some(ROBOT),
        members: [member(1), member(2)].into(),
    };
    let members: Vec<MemberV6> = team.members.iter().map(MemberV6::from).collect();
    vec![bytes_of(&TeamHeaderV1::from(&team), &members)]
}

/// A policy of three cells.
#[must_use]
pub fn policies() -> Vec<Vec<u8>> {
    let command = fixtures::command(&fixtures::flown().1[0]);
    let cells = vec![PolicyCell { action: command.action, value: 12.5 }; 3];
    let policy = Policy {
        run: fixtures::RUN,
        robot: ROBOT,
        decision: Decision(0),
        planner: command.planner,
        error_bound: 1e-5,
        cells,
    };
    let cells: Vec<_> = policy.cells.iter().map(PolicyCellV1::from).collect();
    vec![bytes_of(&PolicyHeaderV1::from(&policy), &cells)]
}

/// [`truth`] in wire form.
#[must_use]
pub fn truth_pages() -> Vec<Vec<u8>> {
    let page = truth();
    let cells: Vec<_> = page.cells.iter().map(GroundV2::from).collect();
    vec![bytes_of(&TruthPageV1::from(&page), &cells)]
}

/// A seen cell, a cell of the truth, a record.
#[must_use]
pub fn cells() -> Vec<Vec<u8>> {
    let (seen, ground) = (seen_cells()[0], fixtures::world().terrain.cells[0]);
    vec![
        bytes_of::<_, GroundV2>(&SeenCellV4::from(&seen), &[]),
        bytes_of::<_, GroundV2>(&GroundV2::from(&ground), &[]),
        bytes_of::<_, GroundV2>(&RecordV5::from(&fixtures::flown().0[0]), &[]),
    ]
}

/// One request of each kind.
#[must_use]
pub fn requests() -> Vec<Vec<u8>> {
    let (run, robot) = (fixtures::RUN, RobotId(0));
    vec![
        bytes_of::<_, GroundV2>(&PastRequestV1::from(&PastRequest { run, robot, from: Decision(2) }), &[]),
        bytes_of::<_, GroundV2>(
            &MapRequestV1::from(&MapRequest { run, robot, from: 3, observation: 9 }),
            &[],
        ),
        bytes_of::<_, GroundV2>(&TruthRequestV1::from(&TruthRequest { run, from: 5 }), &[]),
    ]
}
