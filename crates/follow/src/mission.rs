//! The newest brief, state and robots that a reader has heard.

use contract::{Brief, RunId, State, Team, Vetoed};

use crate::timeline::Timeline;

/// The newest brief, state and robots. They come in any order, so the state may be of another run than the brief.
#[derive(Clone, Debug, Default)]
pub struct Mission {
    brief: Option<Brief>,
    state: Option<State>,
    team: Option<Team>,
}

/// What a state is to a reader.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Heard {
    /// No news: the mission has no such robot, or a newer state is known.
    Nothing,
    /// The newest state.
    News,
    /// The newest state, which proves that hops of the one before are not in the journal.
    AnotherPast,
}

impl Mission {
    /// The newest brief.
    #[must_use]
    pub fn brief(&self) -> Option<&Brief> {
        self.brief.as_ref()
    }

    /// The newest state, of whatever run.
    #[must_use]
    pub fn state(&self) -> Option<&State> {
        self.state.as_ref()
    }

    /// The newest robots, of whatever run and decision.
    #[must_use]
    pub fn team(&self) -> Option<&Team> {
        self.team.as_ref()
    }

    /// The newest state, if it is of the brief's run.
    #[must_use]
    pub fn state_of_run(&self) -> Option<&State> {
        let (brief, state) = (self.brief.as_ref()?, self.state.as_ref()?);
        (state.run == brief.run).then_some(state)
    }

    /// The robots of the newest state.
    #[must_use]
    pub fn team_of_state(&self) -> Option<&Team> {
        let (state, team) = (self.state.as_ref()?, self.team.as_ref()?);
        team.is_of(state).then_some(team)
    }

    /// The run that is followed.
    #[must_use]
    pub fn run(&self) -> Option<RunId> {
        self.brief.as_ref().map(|brief| brief.run)
    }

    /// Takes a brief; the one before.
    pub fn hear_brief(&mut self, brief: Brief) -> Option<Brief> {
        self.brief.replace(brief)
    }

    /// Takes a state, unless a newer one is known.
    pub fn hear_state(&mut self, state: &State) -> Heard {
        let known = self.state.as_ref().filter(|known| known.run == state.run);
        let robots = self.brief.as_ref().map_or(1, |brief| brief.robots.count());
        if !state.is_news(robots, known) {
            return Heard::Nothing;
        }
        let heard = match known {
            Some(known) if Timeline::through(known).is_contradicted_by(state) => Heard::AnotherPast,
            _ => Heard::News,
        };
        let same = known.filter(|known| (known.decision, known.digest) == (state.decision, state.digest));
        // A veto stands, though an older copy of the state or another life of hopper-sim may not have it.
        let vetoed = state.vetoed.union(same.map_or(Vetoed::NONE, |known| known.vetoed));
        self.state = Some(State { vetoed, ..*state });
        heard
    }

    /// Takes the robots of a state.
    pub fn hear_team(&mut self, team: Team) {
        self.team = Some(team);
    }
}
