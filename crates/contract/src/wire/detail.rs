//! `hop/details`.

use super::declaration::wire;
use crate::codec::{COUNTED, DISTANCE, FINITE, LENGTH, RUN, tag};
use crate::fixed_payload;
use crate::limits::DETAIL_POINTS_MAX;
use crate::message::{Payload, Request, RequestResponse};
use crate::motion_model::{FIGURES, MotionModel};
use crate::{Decision, Detail, DetailPage, DetailRequest, PathPoint, Refusal, Role, RunId};

wire! {
    /// Asks for what a motion model tells of a decision.
    pub struct DetailRequestV1 = "hop.DetailRequest.v1", 24 bytes, refused as "detail" {
        /// Run that is meant.
        run: [u64; 2] = RUN,
        /// The decision.
        decision: u64 = COUNTED,
    }
    of DetailRequest { run, decision: Decision(decision) }
}

wire! {
    /// Header of an answer; the payload is the points of the way.
    pub struct DetailPageV1 = "hop.DetailPage.v1", 104 bytes, refused as "detail" {
        /// Run it belongs to.
        run: [u64; 2] = RUN,
        /// The decision.
        decision: u64 = COUNTED,
        /// Motion model: [`MotionModel::code`](crate::MotionModel::code).
        model: u32 = tag(MotionModel::code, MotionModel::from_code),
        reserved: u32,
        /// Where the body rests: east, north and up, metres.
        rest_m: [f64; 3] = LENGTH,
        /// What the model tells, in the order of [`MotionModel::figures`](crate::MotionModel::figures); the rest 0.
        figures: [f64; FIGURES] = FINITE,
    }
    of DetailPage { run, decision: Decision(decision), detail: Detail { model, rest_m, figures, path } }
    from_wire(wire) {
        if points.len() > DETAIL_POINTS_MAX {
            let need = format!("at most {DETAIL_POINTS_MAX} points");
            return Err(Refusal::malformed("detail.path", &need, points.len()));
        }
        let path = points.iter().map(PathPoint::try_from).collect::<Result<_, _>>()?;
    }
    /// The page of a copied answer.
    ///
    /// # Errors
    /// If a number is out of range, or there are too many points.
    pub fn detail_page_from_wire(points: &[PathPointV1]);
}

wire! {
    /// A place on the way of a hop: the launch, or an impact.
    pub struct PathPointV1 = "hop.PathPoint.v1", 56 bytes, refused as "detail" {
        /// Since the launch, seconds.
        seconds: f64 = DISTANCE,
        /// Where: east, north and up, metres.
        at_m: [f64; 3] = LENGTH,
        /// Velocity with which the body leaves it, m/s.
        leaves_mps: [f64; 3] = LENGTH,
    }
    of PathPoint { seconds, at_m, leaves_mps }
}

fixed_payload!(DetailRequest => DetailRequestV1);

impl Payload for DetailPage {
    type Header = DetailPageV1;
    type Cell = PathPointV1;

    fn header(&self) -> DetailPageV1 {
        self.into()
    }

    fn cells(&self) -> usize {
        self.detail.path.len()
    }

    fn cell(&self, index: usize) -> PathPointV1 {
        (&self.detail.path[index]).into()
    }

    fn from_wire(header: &DetailPageV1, cells: &[PathPointV1]) -> Result<Self, Refusal> {
        detail_page_from_wire(header, cells)
    }
}

impl Detail {
    /// Checks the bounds that wire and journal share.
    ///
    /// # Errors
    /// The field that is out of bounds, by name.
    pub fn checked(self) -> Result<Self, Refusal> {
        let page = DetailPage { run: RunId(1), decision: Decision(0), detail: self };
        let points: Vec<PathPointV1> = (0..page.cells()).map(|index| page.cell(index)).collect();
        Ok(DetailPage::from_wire(&page.header(), &points)?.detail)
    }
}

/// What the motion model tells of decisions. Served only where it tells more than the outcome.
impl Request for DetailRequest {
    type Response = DetailPage;
    const SERVICE: RequestResponse = RequestResponse {
        name: "hop/details",
        server: Role::HopperSim,
        max_clients: 8,
        page: DETAIL_POINTS_MAX,
    };
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_detail_survives_its_wire_form_bit_for_bit_and_is_refused_out_of_range() {
        let point = PathPoint { seconds: 0.1, at_m: [0.3, -0.0, 7.0], leaves_mps: [1.0, -2.0, 1e-300] };
        let detail = Detail {
            model: MotionModel::Law,
            rest_m: [1.0, 2.0, 0.1 + 0.2],
            figures: [0.7; FIGURES],
            path: vec![point; 3],
        };
        let page = DetailPage { run: RunId(1 << 90 | 5), decision: Decision(9), detail };
        let cells: Vec<PathPointV1> = (0..page.cells()).map(|index| page.cell(index)).collect();
        let got = DetailPage::from_wire(&page.header(), &cells).unwrap();
        assert_eq!((got.detail.id(), &got), (page.detail.id(), &page));
        let header = page.header();
        let cases = [
            ("at most", header, vec![cells[0]; DETAIL_POINTS_MAX + 1]),
            ("rest_m", DetailPageV1 { rest_m: [f64::NAN; 3], ..header }, cells.clone()),
            ("figures", DetailPageV1 { figures: [f64::INFINITY; FIGURES], ..header }, cells.clone()),
            ("model", DetailPageV1 { model: 0, ..header }, cells.clone()),
            ("seconds", header, vec![PathPointV1 { seconds: -1.0, ..cells[0] }]),
        ];
        for (need, header, cells) in cases {
            let refusal = DetailPage::from_wire(&header, &cells).unwrap_err().to_string();
            assert!(refusal.contains(need), "{need}: {refusal}");
        }
    }
}
