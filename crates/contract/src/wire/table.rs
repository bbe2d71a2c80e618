//! `hop/table`.

use super::cells_at_most;
use super::declaration::wire;
use crate::codec::{ANY, RUN, at_most, by_hand, joint};
use crate::limits::TABLE_PAGE_ROWS;
use crate::message::{Request, RequestResponse};
use crate::{
    MotionRow, MotionTable, Refusal, Role, TableLanding, TablePage, TableRequest, fixed_payload,
    slice_payload,
};

wire! {
    /// Asks for the motion table from a class on.
    pub struct TableRequestV1 = "hop.TableRequest.v1", 24 bytes, refused as "table" {
        /// Run whose table is wanted.
        run: [u64; 2] = RUN,
        /// First class wanted; beyond the last there is nothing.
        from: u32 = ANY,
        reserved: u32,
    }
    of TableRequest { run, from }
}

wire! {
    /// Which run's table follows, and where in it; the payload is its rows.
    pub struct TablePageV1 = "hop.TablePage.v1", 24 bytes, refused as "table" {
        /// Run it belongs to.
        run: [u64; 2] = RUN,
        /// Class of the first row; beyond the last there is none.
        from: u32 = ANY,
        reserved: u32,
    }
    of TablePage { run, from, rows }
    from_wire(wire) {
        let most = TABLE_PAGE_ROWS.min(MotionTable::ROWS.saturating_sub(from as usize));
        cells_at_most("table.rows", most, rows)?;
        let rows = rows.iter().map(MotionRow::try_from).collect::<Result<_, _>>()?;
    }
    /// The page of a copied answer.
    ///
    /// # Errors
    /// If there are too many rows, or the landings of one cannot be.
    pub fn table_page_from_wire(rows: &[MotionRowV1]);
}

wire! {
    /// Where the hops of one class end; what is left of 1 is lost.
    pub struct MotionRowV1 = "hop.MotionRow.v1", 216 bytes, refused as "table" {
        /// Landings.
        count: u32 = joint(at_most(MotionRow::LANDINGS_MAX as u64), "those behind are not read") => "table.landings",
        reserved: u32,
        /// Hops forward and to the left of each landing.
        offsets: [[i32; 2]; MotionRow::LANDINGS_MAX] = by_hand("each −8 to 8") => "table.offset",
        /// Their probabilities.
        probabilities: [f64; MotionRow::LANDINGS_MAX] = by_hand("each 0 to 1, and at most 1 in all") => "table.sum",
    }
    of MotionRow { count, landings }
    to_wire {
        let (count, offsets) = (&(*count as u32), &landings.map(|at| [at.forward, at.left].map(i32::from)));
        let probabilities = &landings.map(|at| at.probability);
    }
    from_wire(wire) {
        let need = format!("at most {}", MotionRow::LANDINGS_MAX);
        let told = offsets.iter().zip(&probabilities).take(count as usize);
        let landing = |([forward, left], probability): (&[i32; 2], &f64)| {
            let hops = |hops: i32| i8::try_from(hops).unwrap_or(i8::MAX);
            TableLanding { forward: hops(*forward), left: hops(*left), probability: *probability }
        };
        if count as usize > MotionRow::LANDINGS_MAX {
            return Err(Refusal::malformed("table.landings", &need, count));
        }
        let MotionRow { count, landings } = MotionRow::new(&told.map(landing).collect::<Vec<_>>())?;
    }
}

fixed_payload!(TableRequest => TableRequestV1);

slice_payload!(TablePage => TablePageV1, MotionRowV1, rows, table_page_from_wire);

/// Where hops end, as planners are to believe it. Served only where the brief has a fingerprint of it.
impl Request for TableRequest {
    type Response = TablePage;
    const SERVICE: RequestResponse = RequestResponse {
        name: "hop/table",
        server: Role::HopperSim,
        max_clients: 24,
        page: TABLE_PAGE_ROWS,
    };
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::RunId;
    use crate::message::Payload;

    #[test]
    fn pages_that_cannot_be_are_refused_by_name() {
        let landing = |forward, probability| TableLanding { forward, left: -2, probability };
        let row = MotionRow::new(&[landing(1, 0.75), landing(-8, 0.25)]).unwrap();
        let from = MotionTable::ROWS as u32 - 3;
        let page = TablePage { run: RunId(1 << 90), from, rows: vec![row, MotionRow::default()] };
        let (header, cells) = (page.header(), [page.cell(0), page.cell(1)]);
        assert_eq!(TablePage::from_wire(&header, &cells).unwrap(), page);
        let [mut far, mut more, mut none, mut many] = [cells[0]; 4];
        far.offsets[0][1] = 300;
        more.probabilities[1] = 0.3;
        none.probabilities[0] = f64::NAN;
        many.count = MotionRow::LANDINGS_MAX as u32 + 1;
        let cases = [
            ("at most 3 cells", vec![cells[0]; 4]),
            ("table.offset", vec![far]),
            ("table.sum", vec![more]),
            ("table.probability", vec![none]),
            ("table.landings", vec![many]),
        ];
        for (need, cells) in cases {
            let refusal = TablePage::from_wire(&header, &cells).unwrap_err().to_string();
            assert!(refusal.contains(need), "{need}: {refusal}");
        }
    }
}
