//! `hop/rN/route` and `hop/routes`.

use super::declaration::wire;
use crate::codec::{ANY, FINITE, ROBOT, RUN};
use crate::limits::ROUTE_POINTS_MAX;
use crate::message::{Capacity, Message, PublishSubscribe, Request, RequestResponse};
use crate::{Announcement, Refusal, Role, Route, RouteId, RoutePage, RouteRequest, Waypoint, fixed_payload};

wire! {
    /// Header of an announcement; the payload is its points.
    pub struct AnnouncementV1 = "hop.Announcement.v1", 24 bytes, refused as "route" {
        /// Run that is meant.
        run: [u64; 2] = RUN,
        /// Robot that shall take the route.
        robot: u32 = ROBOT,
        reserved: u32,
    }
    of Announcement { run, robot, route }
    from_wire(wire) {
        let route = route_from_wire(points)?;
    }
    /// The announcement of a copied message.
    ///
    /// # Errors
    /// If the robot cannot be, or the points are no [`Route`].
    pub fn announcement_from_wire(points: &[WaypointV1]);
}

wire! {
    /// A point of a route, of which a leg is at most 500 m long.
    pub struct WaypointV1 = "hop.Waypoint.v1", 16 bytes, refused as "route" {
        /// Metres to the east of the origin.
        x_m: f64 = FINITE => "route.waypoints",
        /// Metres to the north of the origin.
        y_m: f64 = FINITE => "route.waypoints",
    }
    of Waypoint { x_m, y_m }
}

wire! {
    /// Asks for the points of a route.
    pub struct RouteRequestV1 = "hop.RouteRequest.v1", 24 bytes, refused as "route" {
        /// Run that is meant.
        run: [u64; 2] = RUN,
        /// Fingerprint of the route, which commands and records name.
        id: u64 = ANY,
    }
    of RouteRequest { run, id: RouteId(id) }
}

wire! {
    /// Header of an answer; the payload is the points.
    pub struct RoutePageV1 = "hop.RoutePage.v1", 16 bytes, refused as "route" {
        /// Run it belongs to.
        run: [u64; 2] = RUN,
    }
    of RoutePage { run, route }
    from_wire(wire) {
        let route = route_from_wire(points)?;
    }
    /// The page of a copied answer.
    ///
    /// # Errors
    /// If the points are no [`Route`].
    pub fn route_page_from_wire(points: &[WaypointV1]);
}

/// The route of these points, which are counted before they are copied.
fn route_from_wire(points: &[WaypointV1]) -> Result<Route, Refusal> {
    if points.len() > ROUTE_POINTS_MAX {
        return Err(Refusal::malformed("route.waypoints", &format!("1 to {ROUTE_POINTS_MAX}"), points.len()));
    }
    Route::new(points.iter().map(Waypoint::try_from).collect::<Result<_, _>>()?)
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
            ("a finite value", header, vec![WaypointV1 { x_m: f64::INFINITY, ..point }]),
            ("route.leg_m", header, vec![point, WaypointV1 { x_m: 1e5, ..point }]),
            ("robot below", AnnouncementV1 { robot: 1 << 20, ..header }, vec![point]),
        ];
        for (need, header, points) in cases {
            let refusal = Announcement::from_wire(&header, &points).unwrap_err().to_string();
            assert!(refusal.contains(need), "{need}: {refusal}");
        }
    }
}
