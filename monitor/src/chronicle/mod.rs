//! The account of a mission that page or terminal show: public messages in, frames out.
//!
//! Everything in it only ever grows: hops in order, cells in the order of their discovery, marks of who came
//! and went. A reader holds a [`Cursor`] into it and takes [`Frame`]s at its own speed, so whoever has just
//! come and whoever is slow are served by one mechanism, with no queue that could fill.

mod frame;
mod ground;
mod hops;
mod lives;

use contract::{
    Brief, Cell, Collected, Decision, Heartbeat, MapPage, MapPatch, MapRequest, MonotonicNs, ObservedMap,
    PastPage, Policy, Replica, RobotId, State, Tempo,
};
use report::Executed;

pub use frame::{CELLS_A_FRAME, Cursor, Frame, HOPS_A_FRAME, POLICY_SIDE_MAX};
pub use ground::{Ground, Seen};
pub use hops::{HOPS_KEPT, Hop, Hops, Reign};
pub use lives::{Change, Lives, MARKS_KEPT, Mark, Peer};

use crate::Progress;

/// After the map became whole it is not asked for again earlier: whoever cannot follow the patches shall not keep
/// perception busy.
const SNAPSHOT_PERIOD_NS: u64 = 1_000_000_000;

/// What the account is made of.
#[derive(Clone, Debug)]
pub enum News<'a> {
    /// The brief; one of a new run begins a new account.
    Brief(&'a Brief),
    /// The state.
    State(&'a State),
    /// Records that were asked for.
    Past(&'a PastPage),
    /// What a landing changed in the observed map.
    Patch(MapPatch),
    /// A page of the observed map, after all patches that were there when it came.
    Page(&'a MapPage),
    /// A sign of life.
    Heartbeat(&'a Heartbeat),
    /// The policy behind a decision.
    Policy(Policy),
    /// How hopper-sim paces landings.
    Tempo(Tempo),
    /// Time passes.
    Tick,
}

/// The account of one robot's mission.
#[derive(Debug)]
pub struct Chronicle {
    robot: RobotId,
    /// Counts runs, so that a cursor into another one begins anew.
    epoch: u64,
    story: Option<Story>,
    lives: Lives,
    tempo: Option<Tempo>,
    /// How the mission stands, with its number.
    progress: (u64, Option<Progress>),
}

/// What is known of one run.
#[derive(Debug)]
struct Story {
    brief: Brief,
    state: Option<State>,
    hops: Hops,
    replica: Replica,
    ground: Ground,
    /// Whether the map was whole when it was looked at last, and when it last became so.
    whole: (bool, Option<MonotonicNs>),
    /// The newest policy, with its number.
    policy: (u64, Option<Policy>),
}

impl Chronicle {
    /// An account of nothing yet.
    #[must_use]
    pub fn new(robot: RobotId) -> Self {
        Self { robot, epoch: 0, story: None, lives: Lives::default(), tempo: None, progress: (0, None) }
    }

    /// Takes note of `news` at `now`; what is to be asked of perception, if anything.
    pub fn on(&mut self, news: News<'_>, now: MonotonicNs) -> Option<MapRequest> {
        match news {
            News::Brief(brief) => self.brief(brief),
            News::Heartbeat(beat) => self.lives.hear(beat, self.decision(), now),
            News::Tempo(tempo) => self.tempo = Some(tempo),
            News::Tick => {
                let over = self.progress.1.as_ref().is_some_and(|progress| progress.status.is_over());
                self.lives.listen(self.decision(), over, now);
                return self.story.as_mut().and_then(|story| story.catch_up(now));
            }
            News::State(state) => self.of_run(state.run)?.state(state),
            News::Past(page) => self.of_run(page.run)?.past(page),
            News::Patch(patch) => return self.of_run(patch.run)?.patch(patch, now),
            News::Page(page) => return self.of_run(page.run)?.page(page, now),
            News::Policy(policy) => {
                let known = &mut self.of_run(policy.run)?.policy;
                *known = (known.0 + 1, Some(policy));
            }
        }
        None
    }

    /// Takes note of how the mission stands.
    pub fn stands(&mut self, progress: Progress) {
        self.progress = (self.progress.0 + 1, Some(progress));
    }

    /// The brief, once it is known.
    #[must_use]
    pub fn brief_known(&self) -> Option<&Brief> {
        self.story.as_ref().map(|story| &story.brief)
    }

    /// The state heard last.
    #[must_use]
    pub fn state(&self) -> Option<&State> {
        self.story.as_ref()?.state.as_ref()
    }

    /// The hops so far.
    #[must_use]
    pub fn hops(&self) -> Option<&Hops> {
        self.story.as_ref().map(|story| &story.hops)
    }

    /// The ground seen so far.
    #[must_use]
    pub fn ground(&self) -> Option<&Ground> {
        self.story.as_ref().map(|story| &story.ground)
    }

    /// Treasures that had been seen when `at` was due, and not been collected.
    #[must_use]
    pub fn treasures(&self, at: Decision) -> Vec<Cell> {
        let Some(Story { brief, hops, ground, .. }) = &self.story else { return Vec::new() };
        let at = at.max(hops.first());
        // Of what went before the first hop that is kept, nothing is known.
        let known = at.0.checked_sub(1).map(|before| hops.get(Decision(before)).or_else(|| hops.get(at)));
        let mut collected = known.flatten().map_or(Collected::default(), |hop| hop.collected);
        let mut lying = ground.treasures().to_vec();
        for hop in hops.from(at) {
            if hop.collected != collected && !lying.contains(&hop.to) {
                lying.push(hop.to);
            }
            collected = hop.collected;
        }
        let seen = |cell: &Cell| brief.grid.index(*cell).and_then(|index| ground.get(index));
        lying.retain(|cell| seen(cell).is_some_and(|seen| u64::from(seen.at) <= at.0));
        lying
    }

    /// The newest policy.
    #[must_use]
    pub fn policy(&self) -> Option<&Policy> {
        self.story.as_ref()?.policy.1.as_ref()
    }

    /// Who came and went.
    #[must_use]
    pub fn lives(&self) -> &Lives {
        &self.lives
    }

    /// How hopper-sim paces landings, if it has said so.
    #[must_use]
    pub fn tempo(&self) -> Option<&Tempo> {
        self.tempo.as_ref()
    }

    /// How the mission stands.
    #[must_use]
    pub fn progress(&self) -> Option<&Progress> {
        self.progress.1.as_ref()
    }

    fn of_run(&mut self, run: contract::RunId) -> Option<&mut Story> {
        self.story.as_mut().filter(|story| story.brief.run == run)
    }

    fn decision(&self) -> Decision {
        self.story.as_ref().map_or(Decision(0), Story::decision)
    }

    fn brief(&mut self, brief: &Brief) {
        if self.story.as_ref().is_some_and(|story| story.brief.run == brief.run) {
            return;
        }
        self.epoch += 1;
        self.progress.1 = None;
        self.lives.forget_marks();
        self.story = Some(Story::new(self.robot, brief));
    }
}

impl Story {
    fn new(robot: RobotId, brief: &Brief) -> Self {
        let mut replica = Replica::new(robot);
        replica.begin(brief.run, brief.grid);
        Self {
            brief: *brief,
            state: None,
            hops: Hops::default(),
            replica,
            ground: Ground::new(brief),
            whole: (false, None),
            policy: (0, None),
        }
    }

    fn decision(&self) -> Decision {
        self.state.map_or(self.hops.due(), |state| state.decision.max(self.hops.due()))
    }

    fn state(&mut self, state: &State) {
        self.state = Some(*state);
        if let Some(executed) = Executed::before(state) {
            self.hops.fold(&executed);
        }
    }

    fn past(&mut self, page: &PastPage) {
        for record in page.records.iter().filter(|record| record.robot == page.robot) {
            self.hops.fold(&Executed::from(record));
        }
    }

    fn patch(&mut self, patch: MapPatch, now: MonotonicNs) -> Option<MapRequest> {
        let request = self.replica.patch(patch, now);
        self.allowed(request, now)
    }

    fn page(&mut self, page: &MapPage, now: MonotonicNs) -> Option<MapRequest> {
        let request = self.replica.page(page, now);
        self.allowed(request, now)
    }

    /// A request, unless the map became whole just now.
    fn allowed(&mut self, request: Option<MapRequest>, now: MonotonicNs) -> Option<MapRequest> {
        let (was_whole, since) = self.whole;
        let is_whole = self.replica.map().is_some();
        self.whole = (is_whole, if is_whole && !was_whole { Some(now) } else { since });
        request.filter(|_| self.whole.1.is_none_or(|since| now.since_ns(since) >= SNAPSHOT_PERIOD_NS))
    }

    /// Writes down what is new on the map, once the hops that it was seen from are known.
    fn catch_up(&mut self, now: MonotonicNs) -> Option<MapRequest> {
        let through = |map: &ObservedMap| map.through.map_or(u64::MAX, |through| through.0);
        if let Some(map) = self.replica.map().filter(|map| through(map) <= self.hops.due().0) {
            self.ground.learn(map, &self.hops);
        }
        let request = self.replica.ask(now);
        self.allowed(request, now)
    }
}
