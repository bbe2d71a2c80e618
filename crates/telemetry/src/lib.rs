//! Messages of a mission as CCSDS space packets.
//!
//! A packet has the primary header of a space packet (CCSDS 133.0-B-2), the secondary header of telemetry of the Packet
//! Utilization Standard (ECSS-E-ST-70-41C, "PUS-C") with [mission time](MissionTime), a body, and a checksum of 16
//! bits. There is one APID for each kind of message ([`Kind`]).
//!
//! A body is the wire form of the message ([`contract::wire`]) in big-endian byte order: the fields of its header in their
//! order, the number of its cells in 16 bits, the fields of each cell. Fields named `reserved` are left out. So body,
//! decoder, XTCE and the table in `docs/ground.md` follow from the one declaration of each field.
//!
//! ```
//! use telemetry::{Event, Headers, Kind, MissionTime, Packet, Telemetry};
//!
//! let event = Telemetry::Event(Event::mission_ended(contract::Decision(90), contract::Status::Goal));
//! let packet = Packet { time: MissionTime::from_seconds(5400.0), sequence: 7, body: event };
//! let bytes = packet.encode();
//! assert_eq!(Headers::read(&bytes)?.apid, Kind::Event.apid());
//! assert_eq!(Packet::decode(&bytes)?, packet);
//! # Ok::<(), telemetry::PacketError>(())
//! ```
//!
//! No I/O, no clock.

#![warn(clippy::disallowed_methods)]

mod body;
mod error;
mod event;
mod kind;
mod latency;
mod layout;
mod mission_time;
mod packet;
pub mod table;
#[cfg(test)]
mod tests;
pub mod xtce;

pub use error::PacketError;
pub use event::{Event, EventKind, Severity};
pub use kind::{Kind, Telemetry};
pub use latency::Latency;
pub use layout::{Body, Item};
pub use mission_time::MissionTime;
pub use packet::{Headers, PACKET_BYTES_MAX, Packet, packet_length};
