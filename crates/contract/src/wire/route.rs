//! `hop/rN/route` and `hop/routes`.

use bytemuck::{Pod, Zeroable};

use super::{Wire, robot_from_wire, run_from_wire, run_to_wire};
use crate::limits::ROUTE_POINTS_MAX;
use crate::message::{Capacity, Message, PublishSubscribe, Request, RequestResponse};
use crate::{Announcement, Refusal, Role, Route, RouteId, RoutePage, RouteRequest, Waypoint, fixed_payload};

/// Header of an announcement; the payload is its points.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq, Pod, Zeroable)]
pub struct AnnouncementV1 {
    pub run: [u64; 2],
    pub robot: u32,
    pub reserved: u32,
}

/// A point, metres.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct WaypointV1 {
    pub x_m: f64,
    pub y_m: f64,
}

/// Asks for the points of a route.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq, Pod, Zeroable)]
pub struct RouteRequestV1 {
    pub run: [u64; 2],
    pub id: u64,
}

/// Header of an answer; the payload is the points.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq, Pod, Zeroable)]
pub struct RoutePageV1 {
    pub run: [u64; 2],
}

const _: () = assert!(size_of::<AnnouncementV1>() == 24);
const _: () = assert!(size_of::<WaypointV1>() == 16);
const _: () = assert!(size_of::<RouteRequestV1>() == 24);
const _: () = assert!(size_of::<RoutePageV1>() == 16);

impl Wire for AnnouncementV1 {
    const NAME: &'static str = "hop.Announcement.v1";
}

impl Wire for WaypointV1 {
    const NAME: &'static str = "hop.Waypoint.v1";
}

impl Wire for RouteRequestV1 {
    const NAME: &'static str = "hop.RouteRequest.v1";
}

impl Wire for RoutePageV1 {
    const NAME: &'static str = "hop.RoutePage.v1";
}

impl From<&Waypoint> for WaypointV1 {
    fn from(point: &Waypoint) -> Self {
        Self { x_m: point.x_m, y_m: point.y_m }
    }
}

impl From<&Announcement> for AnnouncementV1 {
    fn from(announcement: &Announcement) -> Self {
        Self { run: run_to_wire(announcement.run), robot: announcement.robot.0.into(), reserved: 0 }
    }
}

impl From<&RoutePage> for RoutePageV1 {
    fn from(page: &RoutePage) -> Self {
        Self { run: run_to_wire(page.run) }
    }
}

impl From<&RouteRequest> for RouteRequestV1 {
    fn from(request: &RouteRequest) -> Self {
        Self { run: run_to_wire(request.run), id: request.id.0 }
    }
}

impl TryFrom<&RouteRequestV1> for RouteRequest {
    type Error = Refusal;

    fn try_from(wire: &RouteRequestV1) -> Result<Self, Refusal> {
        Ok(Self { run: run_from_wire(wire.run), id: RouteId(wire.id) })
    }
}

fn route(points: &[WaypointV1]) -> Result<Route, Refusal> {
    // Counted before they are copied.
    if points.len() > ROUTE_POINTS_MAX {
        return Err(Refusal::malformed("route.waypoints", &format!("1 to {ROUTE_POINTS_MAX}"), points.len()));
    }
    Route::new(points.iter().map(|point| Waypoint { x_m: point.x_m, y_m: point.y_m }).collect())
}

/// The announcement of a copied message.
///
/// # Errors
/// If the robot cannot be, or the points are no [`Route`].
pub fn announcement_from_wire(
    header: &AnnouncementV1,
    points: &[WaypointV1],
) -> Result<Announcement, Refusal> {
    Ok(Announcement {
        run: run_from_wire(header.run),
        robot: robot_from_wire(header.robot)?,
        route: route(points)?,
    })
}

/// The page of a copied answer.
///
/// # Errors
/// If the points are no [`Route`].
pub fn route_page_from_wire(header: &RoutePageV1, points: &[WaypointV1]) -> Result<RoutePage, Refusal> {
    Ok(RoutePage { run: run_from_wire(header.run), route: route(points)? })
}

/// The wire form of a header and the points of `route`, which has its own rules for them.
macro_rules! route_payload {
    ($message:ty => $header:ty, $from_wire:expr) => {
        impl crate::message::Payload for $message {
            type Header = $header;
            type Cell = WaypointV1;

            fn header(&self) -> $header {
                self.into()
            }

            fn cells(&self) -> usize {
                self.route.waypoints().len()
            }

            fn cell(&self, index: usize) -> WaypointV1 {
                (&self.route.waypoints()[index]).into()
            }

            fn from_wire(header: &$header, cells: &[WaypointV1]) -> Result<Self, Refusal> {
                $from_wire(header, cells)
            }
        }
    };
}

route_payload!(Announcement => AnnouncementV1, announcement_from_wire);
route_payload!(RoutePage => RoutePageV1, route_page_from_wire);
fixed_payload!(RouteRequest => RouteRequestV1);

/// Written before the command that announces the route. Read only where robots have routes.
impl Message for Announcement {
    const SERVICE: PublishSubscribe = PublishSubscribe {
        max_publishers: 8,
        expected_publishers: 2,
        max_subscribers: 4,
        history: 0,
        capacity: Capacity::Cells(ROUTE_POINTS_MAX),
        ..PublishSubscribe::new("hop/rN/route", &[Role::Planner])
    };
}

/// The routes that robots have announced, by their fingerprints. Served only where robots have routes.
impl Request for RouteRequest {
    type Response = RoutePage;
    const SERVICE: RequestResponse = RequestResponse {
        name: "hop/routes",
        server: Role::HopperSim,
        max_clients: 24,
        page: ROUTE_POINTS_MAX,
    };
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::message::Payload;
    use crate::{RobotId, RunId};

    fn announcement(points: usize) -> Announcement {
        let waypoints = (0..points).map(|x| Waypoint { x_m: 0.1 * x as f64, y_m: 7.25 }).collect();
        Announcement { run: RunId(3 << 80 | 1), robot: RobotId(2), route: Route::new(waypoints).unwrap() }
    }

    #[test]
    fn an_announcement_survives_its_wire_form_bit_for_bit() {
        let sent = announcement(256);
        let cells: Vec<WaypointV1> = (0..sent.cells()).map(|index| sent.cell(index)).collect();
        let got = Announcement::from_wire(&sent.header(), &cells).unwrap();
        assert_eq!((got.route.id(), &got), (sent.route.id(), &sent));
        let page = RoutePage { run: sent.run, route: sent.route };
        assert_eq!(RoutePage::from_wire(&page.header(), &cells).unwrap(), page);
    }

    /// P-ROUTE-POINTS.
    #[test]
    fn announcements_that_cannot_be_are_refused_by_name() {
        let header = announcement(1).header();
        let point = WaypointV1 { x_m: 1.0, y_m: 1.0 };
        let cases = [
            ("1 to 256, got 257", header, vec![point; 257]),
            ("1 to 256, got 0", header, vec![]),
            ("finite metres", header, vec![WaypointV1 { x_m: f64::INFINITY, ..point }]),
            ("route.leg_m", header, vec![point, WaypointV1 { x_m: 1e5, ..point }]),
            ("robot below", AnnouncementV1 { robot: 1 << 20, ..header }, vec![point]),
        ];
        for (need, header, points) in cases {
            let refusal = Announcement::from_wire(&header, &points).unwrap_err().to_string();
            assert!(refusal.contains(need), "{need}: {refusal}");
        }
    }
}
