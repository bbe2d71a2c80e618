//! Which peers are of this build.

use std::collections::BTreeMap;

use contract::{Heartbeat, Incarnation, Name, Refusal};

/// Lives whose build a process remembers.
const LIVES_MAX: usize = 1024;

/// Tells peers of this build from those of another by the first heartbeat of each life. A process of another build is
/// usually refused when it joins; a build too old to check is recognised here.
#[derive(Clone, Debug)]
pub struct Builds {
    own: Name,
    known: BTreeMap<Incarnation, Name>,
}

impl Builds {
    /// Peers of a process whose own version is `own`.
    #[must_use]
    pub fn new(own: Name) -> Self {
        Self { own, known: BTreeMap::new() }
    }

    /// Whether a heartbeat is of this build. The first of another is logged with both versions.
    pub fn admit(&mut self, beat: &Heartbeat) -> bool {
        let own = self.own;
        if beat.version != own && !self.known.contains_key(&beat.incarnation) {
            tracing::error!(
                "{} (process {}) is version {}, this process is version {own}: its messages are ignored; run all \
                 processes of an instance from one build",
                beat.role,
                beat.pid,
                beat.version,
            );
        }
        if self.known.len() < LIVES_MAX {
            self.known.entry(beat.incarnation).or_insert(beat.version);
        }
        beat.version == own && self.refuse(beat.incarnation).is_none()
    }

    /// Why a message of that life is refused, if it is of another build.
    #[must_use]
    pub fn refuse(&self, incarnation: Incarnation) -> Option<Refusal> {
        let got = self.known.get(&incarnation).filter(|got| **got != self.own)?;
        Some(Refusal::malformed("version", self.own.as_str(), got))
    }
}
