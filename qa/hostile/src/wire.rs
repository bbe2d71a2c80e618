//! Messages: any bytes to a wire type, from there to what engines compute with or one refusal.
//!
//! What is accepted goes the way back, and comes out as it went in: no message holds a number that is not
//! equal to itself, nor one that is read in two ways.

use std::fmt::Debug;

use bytemuck::Zeroable;
use contract::limits::{MAP_PAGE_CELLS, MAP_PATCH_CELLS, PAST_PAGE_RECORDS, TRUTH_PAGE_CELLS};
use contract::wire::{
    BriefV4, CommandV1, ControlV1, GroundV1, HeartbeatV1, MapPageV1, MapPatchV1, MapRequestV1, PastHeaderV1,
    PastRequestV1, PolicyCellV1, PolicyHeaderV1, RecordV3, SeenCellV1, StateV3, TempoV1, TruthPageV1,
    TruthRequestV1, Wire, map_page_from_wire, page_from_wire, patch_from_wire, policy_from_wire,
    truth_page_from_wire,
};
use contract::{
    Brief, Command, Control, Decision, Ground, Heartbeat, MapPage, MapPatch, MapRequest, Order, Pace, Pacing,
    PastRequest, Policy, PolicyCell, Record, Refusal, RobotId, SeenCell, State, TruthPage, TruthRequest,
};
use hopper_sim::ROBOT;
use perception::Observation;

use crate::{fixtures, told};

/// Reads a message of `hop/brief`.
pub fn brief(bytes: &[u8]) {
    there_and_back::<BriefV4, Brief>(&header(bytes).0);
}

/// Reads a message of `hop/rN/command`.
pub fn command(bytes: &[u8]) {
    there_and_back::<CommandV1, Command>(&header(bytes).0);
}

/// Reads messages of `hop/rN/control` and `hop/rN/tempo`.
pub fn control(bytes: &[u8]) {
    there_and_back::<ControlV1, Control>(&header(bytes).0);
    there_and_back::<TempoV1, Pacing>(&header(bytes).0);
}

/// Reads a message of `hop/heartbeat`.
pub fn heartbeat(bytes: &[u8]) {
    there_and_back::<HeartbeatV1, Heartbeat>(&header(bytes).0);
}

/// Reads a message of `hop/rN/state`.
pub fn state(bytes: &[u8]) {
    there_and_back::<StateV3, State>(&header(bytes).0);
}

/// `hop/rN/map`: a header with its cells.
pub fn map_patch(bytes: &[u8]) {
    let (header, rest) = header(bytes);
    paged(patch_from_wire(&header, &payload(rest)), |patch| {
        assert!(patch.cells.len() <= MAP_PATCH_CELLS);
        let cells: Vec<SeenCellV1> = patch.cells.iter().map(SeenCellV1::from).collect();
        patch_from_wire(&MapPatchV1::from(patch), &cells)
    });
}

/// Reads an answer of `hop/rN/snapshot`.
pub fn map_page(bytes: &[u8]) {
    let (header, rest) = header(bytes);
    paged(map_page_from_wire(&header, &payload(rest)), |page| {
        assert!(page.cells.len() <= MAP_PAGE_CELLS);
        let cells: Vec<SeenCellV1> = page.cells.iter().map(SeenCellV1::from).collect();
        map_page_from_wire(&MapPageV1::from(page), &cells)
    });
}

/// Reads an answer of `hop/past`.
pub fn past_page(bytes: &[u8]) {
    let (header, rest) = header(bytes);
    paged(page_from_wire(&header, &payload(rest)), |page| {
        assert!(page.records.len() <= PAST_PAGE_RECORDS);
        let records: Vec<RecordV3> = page.records.iter().map(RecordV3::from).collect();
        page_from_wire(&PastHeaderV1::from(page), &records)
    });
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
        let cells: Vec<GroundV1> = page.cells.iter().map(GroundV1::from).collect();
        truth_page_from_wire(&TruthPageV1::from(page), &cells)
    });
}

/// Cells of the map and of the truth, and records, each alone.
pub fn cell(bytes: &[u8]) {
    there_and_back::<SeenCellV1, SeenCell>(&header(bytes).0);
    there_and_back::<RecordV3, Record>(&header(bytes).0);
    there_and_back::<GroundV1, Ground>(&header(bytes).0);
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
    vec![bytes_of::<_, GroundV1>(&BriefV4::from(&fixtures::brief()), &[])]
}

/// An order, and a pacing.
#[must_use]
pub fn controls() -> Vec<Vec<u8>> {
    let (run, robot, pace) = (fixtures::brief().run, ROBOT, Pace::Hertz(2.0));
    let control = ControlV1::from(&Control { run, robot, order: Order::Pace(pace) });
    let pacing = TempoV1::from(&Pacing { run, robot, pace, paused: true, obeys: true });
    vec![bytes_of::<_, GroundV1>(&control, &[]), bytes_of::<_, GroundV1>(&pacing, &[])]
}

/// A command in wire form.
#[must_use]
pub fn commands() -> Vec<Vec<u8>> {
    vec![bytes_of::<_, GroundV1>(&CommandV1::from(&fixtures::command(&fixtures::flown().1[0])), &[])]
}

/// A heartbeat in wire form.
#[must_use]
pub fn heartbeats() -> Vec<Vec<u8>> {
    vec![bytes_of::<_, GroundV1>(&HeartbeatV1::from(&fixtures::heartbeat()), &[])]
}

/// The opening state, one amid the mission, and the last.
#[must_use]
pub fn states() -> Vec<Vec<u8>> {
    let states = fixtures::flown().1;
    let some = [0, states.len() / 2, states.len() - 1];
    some.map(|index| bytes_of::<_, GroundV1>(&StateV3::from(&states[index]), &[])).into()
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
    cells.filter_map(|(index, ground)| Some(SeenCell { index, ground: (*ground)? })).collect()
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
    let MapPatch { run, robot, through, sequence, after, sensed, published, grid, treasures, cells, .. } =
        patch();
    let (from, next) = (0, grid.cells() as u32);
    MapPage {
        run,
        robot,
        through,
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
    let cells: Vec<_> = patch.cells.iter().map(SeenCellV1::from).collect();
    vec![bytes_of(&MapPatchV1::from(&patch), &cells)]
}

/// [`page`] in wire form.
#[must_use]
pub fn map_pages() -> Vec<Vec<u8>> {
    let page = page();
    let cells: Vec<_> = page.cells.iter().map(SeenCellV1::from).collect();
    vec![bytes_of(&MapPageV1::from(&page), &cells)]
}

/// The first records of the fixtures' mission.
#[must_use]
pub fn past_pages() -> Vec<Vec<u8>> {
    let header = PastHeaderV1 {
        run: CommandV1::from(&fixtures::command(&fixtures::flown().1[0])).run,
        ..PastHeaderV1::zeroed()
    };
    let records: Vec<_> = fixtures::flown().0.iter().take(3).map(RecordV3::from).collect();
    vec![bytes_of(&header, &records)]
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
    let cells: Vec<_> = page.cells.iter().map(GroundV1::from).collect();
    vec![bytes_of(&TruthPageV1::from(&page), &cells)]
}

/// A seen cell, a cell of the truth, a record.
#[must_use]
pub fn cells() -> Vec<Vec<u8>> {
    let (seen, ground) = (seen_cells()[0], fixtures::world().terrain.cells[0]);
    vec![
        bytes_of::<_, GroundV1>(&SeenCellV1::from(&seen), &[]),
        bytes_of::<_, GroundV1>(&GroundV1::from(&ground), &[]),
        bytes_of::<_, GroundV1>(&RecordV3::from(&fixtures::flown().0[0]), &[]),
    ]
}

/// One request of each kind.
#[must_use]
pub fn requests() -> Vec<Vec<u8>> {
    let (run, robot) = (fixtures::RUN, RobotId(0));
    vec![
        bytes_of::<_, GroundV1>(&PastRequestV1::from(&PastRequest { run, robot, from: Decision(2) }), &[]),
        bytes_of::<_, GroundV1>(
            &MapRequestV1::from(&MapRequest { run, robot, from: 3, observation: 9 }),
            &[],
        ),
        bytes_of::<_, GroundV1>(&TruthRequestV1::from(&TruthRequest { run, from: 5 }), &[]),
    ]
}
