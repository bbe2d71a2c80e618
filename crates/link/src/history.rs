//! Executed decisions on their way down, with the routes and details that belong to them.

use std::collections::{BTreeSet, VecDeque};

use contract::{
    Brief, DetailPage, DetailRequest, MonotonicNs, PastPage, PastRequest, Record, RobotId, RoutePage,
    RouteRequest, RunId, State,
};
use follow::{DetailFollower, Link, MissingRoutes, PastFollower};

/// Records that wait before no more are asked for: the journal keeps them.
const RECORDS_WAITING: usize = 256;

/// The same once the mission is over, since hopper-sim leaves then: 100 MB.
const RECORDS_AT_THE_END: usize = 1 << 18;

/// Decisions that the ground asks for again at most; of more the first are forgotten.
const GAPS_MAX: usize = 4096;

/// Details that wait; of more the first are passed over.
const DETAILS_WAITING: usize = 1024;

/// Sends every executed decision once, in order. They are read from the journal's public projection only as fast as
/// they go down.
#[derive(Clone, Debug, Default)]
pub struct History {
    run: RunId,
    /// What was read.
    past: PastFollower,
    /// The newest decision that is due.
    due: u64,
    /// Whether the mission is over.
    is_over: bool,
    records: VecDeque<Record>,
    /// Decisions that the ground asks for again.
    gaps: BTreeSet<u64>,
    routes: MissingRoutes<u64>,
    details: DetailFollower,
    pages: VecDeque<Page>,
}

/// What belongs to a decision.
#[derive(Clone, Debug)]
pub enum Page {
    Route(RoutePage),
    Detail(DetailPage),
}

impl History {
    pub fn begin(&mut self, brief: &Brief) {
        if self.run != brief.run {
            *self = Self { run: brief.run, ..Self::default() };
            self.details.begin(brief.run);
        }
    }

    /// The journal has lost decisions: all are sent again.
    pub fn begin_anew(&mut self) {
        let run = self.run;
        *self = Self { run, ..Self::default() };
        self.details.begin(run);
    }

    pub fn state(&mut self, state: &State) {
        (self.due, self.is_over) = (state.decision.0, state.status.is_over());
    }

    /// Whether every decision before `decision` was read, or as many as may wait.
    pub fn is_read_until(&self, decision: u64) -> bool {
        self.past.due().0 >= decision || self.records.len() >= RECORDS_AT_THE_END
    }

    /// Takes a page; whether it shows that the journal has lost decisions which were sent.
    pub fn page(&mut self, page: &PastPage) -> bool {
        if page.run != self.run {
            return false;
        }
        for record in &page.records {
            if self.gaps.remove(&record.decision.0) {
                self.records.push_back(*record);
                self.follow(record);
            }
            match self.past.link(record) {
                Link::Next => {
                    self.past.fold(record);
                    self.records.push_back(*record);
                    self.follow(record);
                }
                Link::PastIsLost => return true,
                Link::OtherDecision | Link::Broken => {}
            }
        }
        false
    }

    /// Whether no route and no detail of what was read is missing.
    pub fn has_all_pages(&self) -> bool {
        self.routes.is_empty() && self.details.is_whole()
    }

    /// Notes what belongs to `record`.
    fn follow(&mut self, record: &Record) {
        self.details.record(record);
        self.details.keep_last(DETAILS_WAITING);
        if let Some(((decision, _), route)) = record.announced() {
            self.routes.need(decision.0, route);
        }
    }

    pub fn route(&mut self, page: RoutePage) {
        if page.run == self.run && !self.routes.found(page.route.id()).is_empty() {
            self.pages.push_back(Page::Route(page));
        }
    }

    pub fn detail(&mut self, page: DetailPage) {
        let run = page.run;
        if let Some((decision, detail)) = self.details.page(page) {
            self.pages.push_back(Page::Detail(DetailPage { run, decision, detail }));
        }
    }

    /// Sends the decisions `first..=last` again.
    pub fn again(&mut self, first: u64, last: u64) {
        let sent = self.past.due().0.saturating_sub(1);
        self.gaps.extend((first..=last.min(sent)).take(GAPS_MAX));
        while self.gaps.len() > GAPS_MAX {
            self.gaps.pop_first();
        }
    }

    /// What is to be asked for.
    pub fn ask_past(&mut self, now: MonotonicNs) -> Option<PastRequest> {
        let most = if self.is_over { RECORDS_AT_THE_END } else { RECORDS_WAITING };
        if self.records.len() >= most {
            return None;
        }
        if let Some(first) = self.gaps.first() {
            // Asked for at once each time: the answer is waited for, since a client asks one question at a time.
            let request = self.past.ask(self.run, RobotId(0), now)?;
            return Some(PastRequest { from: contract::Decision(*first), ..request });
        }
        if self.past.due().0 >= self.due { None } else { self.past.ask(self.run, RobotId(0), now) }
    }

    pub fn ask_route(&mut self, now: MonotonicNs) -> Option<RouteRequest> {
        self.routes.ask(self.run, now)
    }

    pub fn ask_detail(&mut self, now: MonotonicNs) -> Option<DetailRequest> {
        self.details.ask(now)
    }

    /// Whether there is something to send.
    pub fn has(&self) -> bool {
        !self.records.is_empty() || !self.pages.is_empty()
    }

    /// Decisions that wait here or in the journal.
    pub fn waiting(&self) -> u64 {
        self.records.len() as u64 + self.gaps.len() as u64 + self.due.saturating_sub(self.past.due().0)
    }

    /// What belongs to a decision that was sent, if something waits.
    pub fn next_page(&mut self) -> Option<Page> {
        self.pages.pop_front()
    }

    /// The next decisions, at most so many; none if none wait.
    pub fn next(&mut self, most: usize) -> Option<PastPage> {
        let first = *self.records.front()?;
        let mut records = Vec::new();
        while records.len() < most
            && let Some(record) = self.records.front()
            && record.decision.0 == first.decision.0 + records.len() as u64
        {
            records.push(*record);
            self.records.pop_front();
        }
        Some(PastPage { run: self.run, robot: RobotId(0), from: first.decision, records })
    }

    /// Whether `state` proves that what was read is not in the journal.
    pub fn is_contradicted_by(&self, state: &State) -> bool {
        state.run == self.run && !self.past.is_late(state) && self.past.is_contradicted_by(state)
    }
}
