//! What a build must have in common with those it talks to.
//!
//! Its version is the crates'. Its messages are a fingerprint of every service: names, types with their sizes,
//! qualities. Two builds of one version that disagree on a message would otherwise open services side by side
//! and wait for each other in vain.

use std::fmt;
use std::str::FromStr;

use contract::service;
use contract::{
    Brief, Command, Control, Heartbeat, MapPatch, MapRequest, PastRequest, Policy, RobotId, State, Tempo,
    TruthRequest,
};
use xxhash_rust::xxh3::xxh3_64;

use crate::{exchange, port, version};

/// A build as an instance's label tells it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Edition {
    version: String,
    /// Fingerprint of the services.
    messages: String,
}

impl Edition {
    /// This build.
    pub(crate) fn own() -> Self {
        let messages = format!("{:016x}", xxh3_64(services().join("\n").as_bytes()));
        Self { version: version().to_string(), messages: messages[..8].to_owned() }
    }
}

impl fmt::Display for Edition {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "version {}, messages {}", self.version, self.messages)
    }
}

impl FromStr for Edition {
    type Err = ();

    fn from_str(text: &str) -> Result<Self, ()> {
        let (version, messages) = text.split_once(", messages ").ok_or(())?;
        let version = version.strip_prefix("version ").ok_or(())?;
        Ok(Self { version: version.into(), messages: messages.into() })
    }
}

/// Every service of a robot with its types and qualities.
fn services() -> Vec<String> {
    let robot = RobotId(0);
    vec![
        port::plain_text::<Brief>(&service::brief()),
        port::plain_text::<Heartbeat>(&service::heartbeat()),
        port::plain_text::<State>(&service::state(robot)),
        port::plain_text::<Command>(&service::command(robot)),
        port::plain_text::<Control>(&service::control(robot)),
        port::plain_text::<Tempo>(&service::tempo(robot)),
        port::sheet_text::<MapPatch>(&service::map(robot)),
        port::sheet_text::<Policy>(&service::policy(robot)),
        exchange::text::<PastRequest>(&service::past()),
        exchange::text::<TruthRequest>(&service::truth()),
        exchange::text::<MapRequest>(&service::snapshot(robot)),
    ]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_edition_is_read_as_it_is_written() {
        assert_eq!(Edition::own().to_string().parse(), Ok(Edition::own()));
        for foreign in ["", "0.1.0", "version 0.1.0"] {
            assert_eq!(foreign.parse::<Edition>(), Err(()), "{foreign:?}");
        }
    }

    #[test]
    fn every_service_that_the_contract_names_is_in_the_fingerprint_once() {
        let services = services();
        for name in [
            "brief",
            "heartbeat",
            "past",
            "r0/state",
            "r0/command",
            "r0/control",
            "r0/tempo",
            "r0/map",
            "r0/policy",
            "r0/snapshot",
        ] {
            let count = services.iter().filter(|text| text.starts_with(&format!("hop/{name}: "))).count();
            assert_eq!(count, 1, "{name} in {services:?}");
        }
        assert!(services.iter().any(|text| text.starts_with("truth/terrain: ")), "{services:?}");
    }
}
