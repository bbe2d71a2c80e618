//! Gathers what a bag needs to know of a run before its first message is written.

use std::collections::BTreeMap;

use contract::{Announcement, Brief, Decision, DetailPage, DetailRequest, Policy, Team};
use recording::{Channel, Entry, JsonMessage, RecordedMessage, Recording, RecordingError, SkippedMessages};

use crate::landing::{Decisions, Landing};
use crate::map_follower::MapFollower;
use crate::seen_box::SeenBox;
use crate::{Clock, Ros2Error};

/// The last run of a recording.
#[derive(Clone, Debug)]
pub struct Mission<'a> {
    /// What the mission is.
    pub brief: Brief,
    /// Every landing, in the order of the decisions.
    pub landings: Vec<Landing>,
    /// How its times become times of ROS.
    pub clock: Clock,
    /// Messages of the file that cannot be decoded.
    pub skipped: SkippedMessages,
    pub(crate) decisions: Decisions,
    /// Each change of the map: the decision it was for, and what was seen then.
    pub(crate) changes: Vec<(Decision, SeenBox)>,
    /// The recorded policies of robot 0.
    policies: BTreeMap<Decision, &'a [u8]>,
}

/// A run that is being gathered.
struct Run<'a> {
    brief: Brief,
    decisions: Decisions,
    map: MapFollower,
    changes: Vec<(Decision, SeenBox)>,
    policies: BTreeMap<Decision, &'a [u8]>,
}

impl<'a> Mission<'a> {
    /// Gathers the last run of a recording.
    ///
    /// # Errors
    /// If there is no brief, or no map that is whole.
    pub fn of(recording: &'a Recording<'_>) -> Result<Self, Ros2Error> {
        let mut run: Option<Run<'a>> = None;
        let mut skipped = SkippedMessages::default();
        let mut messages = 0;
        for entry in recording.entries() {
            messages += 1;
            if entry.known.is_none() {
                if let Some(run) = &mut run {
                    skipped.skip(run.on_json(&entry));
                }
                continue;
            }
            let Some(Some(message)) = skipped.skip(entry.message()) else { continue };
            match message {
                RecordedMessage::Brief(brief) => {
                    if run.as_ref().is_none_or(|run| run.brief.run != brief.run) {
                        run = Some(Run::begin(brief));
                    }
                }
                message => {
                    if let Some(run) = &mut run {
                        run.on(message, &entry);
                    }
                }
            }
        }
        let Run { brief, decisions, map, changes, policies } =
            run.ok_or(RecordingError::NoBrief { messages })?;
        let Some((map, _)) = map.map().filter(|_| !changes.is_empty()) else {
            return Err(Ros2Error::NoMap { messages });
        };
        let landings = decisions.landings(&brief, map);
        let digest = landings.last().map(|landing| landing.state.digest);
        let clock = Clock::of(&recording.metadata_of(Some(brief.run), digest));
        Ok(Self { brief, landings, clock, skipped, decisions, changes, policies })
    }

    /// The policy that was made for `decision`, if it was recorded.
    pub(crate) fn policy(&self, decision: Decision) -> Option<Policy> {
        match RecordedMessage::decode(Channel::Policy, self.policies.get(&decision)?) {
            Ok(Some(RecordedMessage::Policy(policy))) => Some(policy),
            _ => None,
        }
    }

    /// Whether there is such a policy.
    pub(crate) fn has_policy(&self, decision: Decision) -> bool {
        self.policies.contains_key(&decision)
    }
}

impl<'a> Run<'a> {
    fn begin(brief: Brief) -> Self {
        let map = MapFollower::new(&brief);
        Self { brief, decisions: Decisions::default(), map, changes: Vec::new(), policies: BTreeMap::new() }
    }

    fn on(&mut self, message: RecordedMessage, entry: &Entry<'a>) {
        let run = self.brief.run;
        match message {
            RecordedMessage::State(state) => {
                if state.run == run && state.robot.0 < self.brief.robots.count() {
                    self.decisions.states.insert(state.decision, state);
                }
            }
            RecordedMessage::Past(page) if page.run == run => {
                let robots = self.brief.robots.count();
                let records = page.records.iter().filter(|record| record.robot.0 < robots);
                self.decisions.records.extend(records.map(|record| (record.decision, *record)));
            }
            RecordedMessage::Policy(policy)
                if policy.run == run && policy.robot == recording::channel::ROBOT =>
            {
                self.policies.insert(policy.decision, entry.data);
            }
            message => {
                let has_changed = self.map.on(message, entry.logged);
                if has_changed
                    && let Some((map, seen)) = self.map.map()
                    && let Some(through) = map.through
                {
                    self.changes.push((through, *seen));
                }
            }
        }
    }

    /// Takes a message without a schema.
    fn on_json(&mut self, entry: &Entry<'_>) -> Result<(), RecordingError> {
        if let Some(error) = entry.undecodable() {
            return Err(error);
        }
        let run = self.brief.run;
        if JsonMessage::is_topic_of::<Team>(&entry.topic)
            && let Ok(team) = serde_json::from_slice::<Team>(entry.data)
            && team.run == run
        {
            self.decisions.teams.insert(team.decision, team);
        } else if JsonMessage::is_topic_of_answers::<DetailRequest>(&entry.topic)
            && let Ok(page) = serde_json::from_slice::<DetailPage>(entry.data)
            && page.run == run
        {
            self.decisions.details.insert(page.decision, page.detail);
        }
        Ok(())
    }
}

/// The announcement of a message of a recording, if it is one of that run.
pub(crate) fn announcement(entry: &Entry<'_>, brief: &Brief) -> Option<Announcement> {
    if entry.known.is_some()
        || !JsonMessage::is_topic_of::<Announcement>(&entry.topic)
        || entry.undecodable().is_some()
    {
        return None;
    }
    let announcement = serde_json::from_slice::<Announcement>(entry.data).ok()?;
    (announcement.run == brief.run && announcement.robot.0 < brief.robots.count()).then_some(announcement)
}
