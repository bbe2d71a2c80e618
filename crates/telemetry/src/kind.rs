//! What goes down: the one list of packets.

use std::fmt;
use std::sync::OnceLock;

use contract::{Brief, DetailPage, MapPatch, PastPage, RoutePage, State, Team};

use crate::layout::Body;
use crate::{Event, Latency, PacketError, body};

/// Declares the kinds of packets: name, type of message, APID, PUS service with its subtypes, and the structure of a
/// housekeeping report or 0.
macro_rules! packets {
    ($($(#[doc = $what:literal])+ $name:ident: $message:ty = $apid:literal, $service:literal $subtypes:tt, $structure:literal;)+) => {
        /// A kind of packet.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
        pub enum Kind {
            $($(#[doc = $what])+ $name,)+
        }

        /// What a packet says.
        #[derive(Clone, Debug, PartialEq)]
        #[allow(clippy::large_enum_variant, reason = "one at a time is encoded or was decoded")]
        pub enum Telemetry {
            $($(#[doc = $what])+ $name($message),)+
        }

        impl Kind {
            /// Every kind.
            pub const ALL: &'static [Kind] = &[$(Kind::$name),+];

            /// Its APID.
            #[must_use]
            pub fn apid(self) -> u16 {
                match self { $(Kind::$name => $apid,)+ }
            }

            /// Its PUS service, and the subtypes that it has.
            #[must_use]
            pub fn service(self) -> (u8, &'static [u8]) {
                match self { $(Kind::$name => ($service, &$subtypes),)+ }
            }

            /// The structure identifier of a housekeeping report, which stands before its body in 8 bits.
            #[must_use]
            pub fn structure(self) -> Option<u8> {
                match self { $(Kind::$name => (($structure) != 0).then_some($structure),)+ }
            }

            /// Its name.
            #[must_use]
            pub fn as_str(self) -> &'static str {
                match self { $(Kind::$name => stringify!($name),)+ }
            }

            /// What it is, in a sentence.
            #[must_use]
            pub fn what(self) -> &'static str {
                match self { $(Kind::$name => concat!($($what),+).trim_ascii(),)+ }
            }

            /// What its body consists of.
            #[must_use]
            pub fn body(self) -> &'static Body {
                match self {
                    $(Kind::$name => {
                        static BODY: OnceLock<Body> = OnceLock::new();
                        BODY.get_or_init(Body::of::<$message>)
                    })+
                }
            }

            /// What a body of this kind says.
            pub(crate) fn decode(self, bytes: &[u8]) -> Result<Telemetry, PacketError> {
                match self {
                    $(Kind::$name => body::decode::<$message>(self.as_str(), self.body(), bytes).map(Telemetry::$name),)+
                }
            }
        }

        impl Telemetry {
            /// Its kind.
            #[must_use]
            pub fn kind(&self) -> Kind {
                match self { $(Telemetry::$name(_) => Kind::$name,)+ }
            }

            /// Appends its body.
            pub(crate) fn encode(&self, bytes: &mut Vec<u8>) {
                match self {
                    $(Telemetry::$name(message) => body::encode(self.kind().body(), message, bytes),)+
                }
            }
        }
    };
}

packets! {
    /// Something happened that people on the ground want to know first.
    Event: Event = 256, 5 [1, 2, 3, 4], 0;
    /// What the mission asks for, and who flies.
    Brief: Brief = 257, 128 [1], 0;
    /// Where the mission stands.
    State: State = 258, 3 [25], 1;
    /// Where each robot stands, if there are several.
    Team: Team = 259, 128 [2], 0;
    /// Cells of the observed map that were seen for the first time or better.
    Map: MapPatch = 260, 128 [3], 0;
    /// Executed decisions, as the journal has them.
    Past: PastPage = 261, 128 [4], 0;
    /// The points of a route that a robot has announced.
    Route: RoutePage = 262, 128 [5], 0;
    /// What the motion model tells of a hop beyond its outcome.
    Detail: DetailPage = 263, 128 [6], 0;
    /// Where the time of many decisions went.
    Latency: Latency = 264, 3 [25], 2;
}

impl Kind {
    /// The kind of an APID, if there is one.
    #[must_use]
    pub fn from_apid(apid: u16) -> Option<Self> {
        Self::ALL.iter().copied().find(|kind| kind.apid() == apid)
    }
}

impl Telemetry {
    /// The subtype of its service: of an event how much it matters.
    #[must_use]
    pub fn subtype(&self) -> u8 {
        match self {
            Telemetry::Event(event) => event.kind.severity().subtype(),
            _ => self.kind().service().1[0],
        }
    }
}

impl fmt::Display for Kind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.as_str())
    }
}
