//! What processes tell each other while they fly: states, commands, records, heartbeats, and why a message was refused.

pub mod command;
pub mod control;
pub mod digest;
pub mod heartbeat;
pub mod identity;
pub mod name;
pub mod origin;
pub mod page_cursor;
pub mod past;
pub mod peer_table;
pub mod policy;
pub mod record;
pub mod refusal;
pub mod route;
pub mod state;
pub mod timeline;
pub mod timing;
