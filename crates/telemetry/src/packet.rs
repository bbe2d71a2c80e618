//! A packet: headers, body, checksum.

use arbitrary_int::{u11, u14};
use spacepackets::CcsdsPacket as _;
use spacepackets::SpHeader;
use spacepackets::ecss::tm::{PusTmBuilder, PusTmReader, ReaderConfig};
use spacepackets::{PacketType, SequenceFlags};

use crate::{Kind, MissionTime, PacketError, Telemetry};

/// Bytes of the primary header.
const PRIMARY: usize = 6;

/// Bytes of the secondary header before its time.
const SECONDARY: usize = 7;

/// Bytes of the checksum.
const CHECKSUM: usize = 2;

/// Bytes of a packet without a body.
const EMPTY: usize = PRIMARY + SECONDARY + MissionTime::BYTES + CHECKSUM;

/// Most bytes of a packet: what fits into one UDP datagram of any network.
pub const PACKET_BYTES_MAX: usize = 65_507;

/// A packet of telemetry.
#[derive(Clone, Debug, PartialEq)]
pub struct Packet {
    /// When it was made.
    pub time: MissionTime,
    /// Its place among the packets of its APID, modulo 2¹⁴.
    pub sequence: u16,
    /// What it says.
    pub body: Telemetry,
}

/// What the headers of a packet say.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Headers {
    /// Which kind of message follows.
    pub apid: u16,
    /// Its place among the packets of its APID, modulo 2¹⁴.
    pub sequence: u16,
    /// PUS service and subtype.
    pub service: (u8, u8),
    /// When it was made.
    pub time: MissionTime,
}

impl Packet {
    /// Its bytes.
    ///
    /// # Panics
    /// If the message has more cells than fit into a packet, which none of [`contract`] has but a map patch of more
    /// than 1,024.
    #[must_use]
    pub fn encode(&self) -> Vec<u8> {
        let kind = self.body.kind();
        let mut body = Vec::with_capacity(512);
        body.extend(kind.structure());
        self.body.encode(&mut body);
        let time = self.time.to_bytes();
        let packet = PusTmBuilder::new()
            .with_apid(u11::new(kind.apid()))
            .with_sequence_count(u14::new(self.sequence % (1 << 14)))
            .with_service_type_id(kind.service().0)
            .with_message_subtype_id(self.body.subtype())
            .with_msg_counter(self.sequence % (1 << 14))
            .with_timestamp(&time)
            .with_source_data(&body)
            .build();
        let bytes = packet.to_vec().expect("a body that fits into a packet");
        assert!(bytes.len() <= PACKET_BYTES_MAX, "{} bytes of {kind}", bytes.len());
        bytes
    }

    /// The packet of these bytes, all of which it has to take.
    ///
    /// # Errors
    /// What was needed and what was got; nothing of the bytes is believed before.
    pub fn decode(bytes: &[u8]) -> Result<Self, PacketError> {
        let headers = Headers::read(bytes)?;
        let unknown = || {
            let apids = || Kind::ALL.iter().map(|kind| kind.apid());
            let (first, last) = (apids().min().unwrap_or(0), apids().max().unwrap_or(0));
            PacketError::UnknownApid { first, last, got: headers.apid }
        };
        let kind = Kind::from_apid(headers.apid).ok_or_else(unknown)?;
        let (name, need) = (kind.as_str(), kind.service());
        if headers.service.0 != need.0 || !need.1.contains(&headers.service.1) {
            return Err(PacketError::Service { kind: name, need, got: headers.service });
        }
        let mut body = &bytes[EMPTY - CHECKSUM..bytes.len() - CHECKSUM];
        if let Some(need) = kind.structure() {
            let Some((&got, rest)) = body.split_first() else {
                return Err(PacketError::Body { kind: name, need: 1, got: 0 });
            };
            if got != need {
                return Err(PacketError::Structure { kind: name, need, got });
            }
            body = rest;
        }
        let body = kind.decode(body)?;
        if body.subtype() != headers.service.1 {
            return Err(PacketError::Service { kind: name, need, got: headers.service });
        }
        Ok(Self { time: headers.time, sequence: headers.sequence, body })
    }
}

impl Headers {
    /// The headers of a packet that takes all of `bytes`, whose checksum is right.
    ///
    /// # Errors
    /// If it is no such packet.
    pub fn read(bytes: &[u8]) -> Result<Self, PacketError> {
        if bytes.len() < EMPTY {
            return Err(PacketError::TooShort { need: EMPTY, got: bytes.len() });
        }
        if bytes.len() > PACKET_BYTES_MAX {
            return Err(PacketError::TooLong { need: PACKET_BYTES_MAX, got: bytes.len() });
        }
        let word = |at: usize| u16::from_be_bytes([bytes[at], bytes[at + 1]]);
        let wrong = |need| PacketError::PrimaryHeader { need, got: word(0) };
        let (header, _) =
            SpHeader::from_be_bytes(&bytes[..PRIMARY]).map_err(|_| wrong("six bytes of a space packet"))?;
        if word(0) >> 13 != 0 {
            return Err(wrong("packet version 0"));
        }
        if header.packet_type() != PacketType::Tm || !header.sec_header_flag() {
            return Err(wrong("telemetry with a secondary header"));
        }
        if header.psc.seq_flags != SequenceFlags::Unsegmented {
            return Err(PacketError::PrimaryHeader { need: "an unsegmented packet", got: word(2) });
        }
        if header.packet_len() != bytes.len() {
            return Err(PacketError::Length { need: header.packet_len(), got: bytes.len() });
        }
        if bytes[PRIMARY] >> 4 != 2 {
            return Err(PacketError::PusVersion { got: bytes[PRIMARY] >> 4 });
        }
        let config = ReaderConfig { timestamp_len: MissionTime::BYTES, has_checksum: true };
        let reader = PusTmReader::new_no_checksum_verification(bytes, config)
            .map_err(|_| PacketError::TooShort { need: EMPTY, got: bytes.len() })?;
        let (content, got) = bytes.split_at(bytes.len() - CHECKSUM);
        let need = spacepackets::crc::CRC_CCITT_FALSE.checksum(content);
        let got = u16::from_be_bytes([got[0], got[1]]);
        if need != got {
            return Err(PacketError::Checksum { need, got });
        }
        let time = reader.timestamp().try_into().expect("as many bytes as were asked for");
        Ok(Self {
            apid: reader.apid().value(),
            sequence: reader.seq_count().value(),
            service: (reader.service_type_id(), reader.message_subtype_id()),
            time: MissionTime::from_bytes(time),
        })
    }
}

/// How long the packet is that `bytes` begin with, as its primary header says; `None` while that is not there. For streams
/// without borders, such as TCP.
#[must_use]
pub fn packet_length(bytes: &[u8]) -> Option<usize> {
    let length = bytes.get(4..PRIMARY)?;
    Some(PRIMARY + 1 + usize::from(u16::from_be_bytes([length[0], length[1]])))
}
