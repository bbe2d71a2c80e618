//! Why a packet is refused.

use contract::Refusal;

/// Why bytes are no packet of ours: what was needed, and what was got.
#[allow(missing_docs, reason = "the error texts say what each field is")]
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum PacketError {
    /// Fewer bytes than any packet has.
    #[error("a packet needs at least {need} bytes, got {got}")]
    TooShort { need: usize, got: usize },
    /// The length in the primary header is not that of the packet.
    #[error("the primary header says {need} bytes, got {got}")]
    Length { need: usize, got: usize },
    /// More bytes than a packet may have here.
    #[error("a packet needs at most {need} bytes, got {got}")]
    TooLong { need: usize, got: usize },
    /// Not version 1 of a space packet, unsegmented, with a secondary header.
    #[error("the primary header needs {need}, got {got}")]
    PrimaryHeader { need: &'static str, got: u16 },
    /// Another kind of secondary header.
    #[error("the secondary header needs PUS version 2, got {got}")]
    PusVersion { got: u8 },
    /// Bits were changed on the way.
    #[error("the checksum needs to be {need:#06x}, got {got:#06x}")]
    Checksum { need: u16, got: u16 },
    /// Nothing that is sent has this APID.
    #[error("APID {got} is not one of {first} to {last}")]
    UnknownApid { first: u16, last: u16, got: u16 },
    /// Service or subtype are not those of the APID.
    #[error("{kind} needs service {need:?}, got {got:?}")]
    Service { kind: &'static str, need: (u8, &'static [u8]), got: (u8, u8) },
    /// The structure of a housekeeping report is not that of its APID.
    #[error("{kind} needs structure {need}, got {got}")]
    Structure { kind: &'static str, need: u8, got: u8 },
    /// The body is not as long as its number of cells says.
    #[error("the body of {kind} needs {need} bytes, got {got}")]
    Body { kind: &'static str, need: usize, got: usize },
    /// A field is out of its range.
    #[error("{kind}: {refusal}")]
    Refused { kind: &'static str, refusal: Refusal },
}
