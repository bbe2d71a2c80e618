//! What processes tell each other while they fly: states, commands, records, robots, heartbeats, and why a message was refused.

pub mod command;
pub mod control;
pub mod detail;
pub mod heartbeat;
pub mod missing_peer;
pub mod past;
pub mod peer_table;
pub mod policy;
pub mod record;
pub mod route;
pub mod state;
pub mod team;
