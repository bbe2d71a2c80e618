//! The motion table that planners believe, gathered once.

use contract::{Brief, MonotonicNs, MotionRow, MotionTable, Refusal, RunId, TablePage, TableRequest};

use crate::gathering::Gathering;

/// Gathers the motion table of one run page by page, asking until it is whole.
#[derive(Clone, Debug, Default)]
pub struct TableFollower {
    /// The run, and the fingerprint of its table; `None` where planners believe the four branches.
    of: Option<(RunId, u64)>,
    pages: Gathering<MotionRow>,
    table: Option<MotionTable>,
}

impl TableFollower {
    /// Begins to gather the table of the brief's run, if it has one; the same run again changes nothing.
    pub fn begin(&mut self, brief: &Brief) {
        let of = Some((brief.run, brief.motion_table())).filter(|(_, fingerprint)| *fingerprint != 0);
        if self.of != of {
            *self = Self { of, ..Self::default() };
            self.of.iter().for_each(|(run, _)| self.pages.begin(*run));
        }
    }

    /// The table, once it is whole and the one that the brief names.
    #[must_use]
    pub fn table(&self) -> Option<&MotionTable> {
        self.table.as_ref()
    }

    /// Whether rows of it are missing.
    #[must_use]
    pub fn is_missing(&self) -> bool {
        self.of.is_some() && self.table.is_none()
    }

    /// Takes a page that was asked for; one of another run or place changes nothing.
    ///
    /// # Errors
    /// If the page makes no progress or goes beyond the last class, or the whole is not the table of the brief: then it is gathered
    /// again.
    pub fn page(&mut self, page: TablePage) -> Result<(), Refusal> {
        let TablePage { run, from, rows } = page;
        let Some(rows) = self.pages.page("table.rows", (run, MotionTable::ROWS, from), rows)? else {
            return Ok(());
        };
        let (table, need) = (MotionTable::new(rows), self.of.map(|(_, fingerprint)| fingerprint));
        let got = table.as_ref().map(MotionTable::fingerprint);
        if got != need {
            self.pages = Gathering::default();
            self.pages.begin(run);
            let words = |fingerprint: Option<u64>| format!("{:014x}", fingerprint.unwrap_or_default());
            return Err(Refusal::malformed("table.fingerprint", &words(need), words(got)));
        }
        self.table = table;
        Ok(())
    }

    /// What to ask for at `now`: the next page, or the same again if it does not come.
    pub fn ask(&mut self, now: MonotonicNs) -> Option<TableRequest> {
        self.pages.ask(now).map(|(run, from)| TableRequest { run, from })
    }
}

#[cfg(test)]
mod tests {
    use contract::TableLanding;
    use contract::limits::TABLE_PAGE_ROWS;

    use super::*;

    #[test]
    fn only_the_whole_table_of_the_brief_is_believed() {
        let row = |probability| MotionRow::new(&[TableLanding { forward: 1, left: 0, probability }]).unwrap();
        let table = MotionTable::new(vec![row(0.5); MotionTable::ROWS]).unwrap();
        let mut follower = TableFollower::default();
        assert!(follower.ask(MonotonicNs(1)).is_none() && !follower.is_missing(), "no run yet");
        let begun = |fingerprint| {
            let mut begun = TableFollower { of: Some((RunId(4), fingerprint)), ..Default::default() };
            begun.pages.begin(RunId(4));
            begun
        };
        let gather = |follower: &mut TableFollower| {
            let mut pages = 0;
            while let Some(TableRequest { run, from }) = follower.ask(MonotonicNs(pages << 40)) {
                pages += 1;
                let rows = table.rows()[from as usize..].iter().take(TABLE_PAGE_ROWS).copied().collect();
                follower.page(TablePage { run, from, rows })?;
                assert!(follower.is_missing() != follower.table().is_some());
            }
            Ok::<_, Refusal>(pages)
        };
        follower = begun(table.fingerprint());
        assert!(follower.is_missing());
        assert_eq!(gather(&mut follower), Ok(MotionTable::ROWS.div_ceil(TABLE_PAGE_ROWS) as u64));
        assert_eq!(follower.table(), Some(&table));
        follower = begun(table.fingerprint() ^ 1);
        assert!(gather(&mut follower).unwrap_err().to_string().contains("table.fingerprint"));
        assert!(
            follower.is_missing() && follower.ask(MonotonicNs(u64::MAX)).is_some_and(|next| next.from == 0)
        );
    }
}
