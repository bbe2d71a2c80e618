//! The ways that messages take, named for faults and counters: one for each message, two for each request.

use std::any::TypeId;
use std::sync::LazyLock;

use contract::Incarnation;
use contract::message::{Message, Request, Visitor};
use serde::{Serialize, Serializer};

use crate::setup::Missions;

/// A way that messages take: a publish-subscribe service, or one direction of a request-response service.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Stream(u8);

/// A request as it travels: with its number, and who asks.
#[derive(Clone, Debug)]
pub(crate) struct Asked<Q> {
    pub request: Q,
    pub number: u64,
    pub asker: Incarnation,
}

/// A response as it travels: with the number of its request.
#[derive(Clone, Debug)]
pub(crate) struct Answered<R> {
    pub response: R,
    pub number: u64,
    /// Who answers.
    pub server: Incarnation,
}

/// What is known of a stream.
struct Facts {
    of: TypeId,
    name: String,
    /// Messages that a reader's queue holds before the oldest gives way; per writer on the real middleware, per reader
    /// here, which is the harder case.
    buffer: usize,
    /// Whether a late reader gets the writer's last message.
    has_history: bool,
}

static STREAMS: LazyLock<Vec<Facts>> = LazyLock::new(|| {
    let mut streams = Streams(Vec::new());
    contract::wire::visit(&mut streams);
    streams.0
});

struct Streams(Vec<Facts>);

impl Visitor for Streams {
    fn message<M: Message>(&mut self) {
        let service = M::SERVICE;
        self.0.push(Facts {
            of: TypeId::of::<M>(),
            name: service.short_name().into(),
            buffer: service.buffer,
            has_history: service.history > 0,
        });
    }

    fn request<Q: Request>(&mut self) {
        let (name, buffer) = (Q::SERVICE.short_name(), Q::SERVICE.max_clients);
        let has_history = false;
        self.0.push(Facts {
            of: TypeId::of::<Asked<Q>>(),
            name: format!("{name}_asked"),
            buffer,
            has_history,
        });
        let of = TypeId::of::<Answered<Q::Response>>();
        self.0.push(Facts { of, name: format!("{name}_answered"), buffer, has_history });
    }
}

impl Stream {
    /// Every stream of these missions: a lone hopper's have no [`contract::Team`], only helicopters and those they look
    /// ahead for announce routes, only ground of uncertain speed has a prior. Details of hops are left out: only monitors ask for them, in
    /// missions that are not under the law. So is the motion table: no mission that is drawn has one.
    #[must_use]
    pub fn all(missions: Missions) -> Vec<Stream> {
        let teams = Stream::of::<contract::Team>();
        let of_prior =
            [Stream::of::<Asked<contract::PriorRequest>>(), Stream::of::<Answered<contract::PriorPage>>()];
        let of_routes = [
            of_prior[0],
            of_prior[1],
            Stream::of::<contract::Announcement>(),
            Stream::of::<Asked<contract::RouteRequest>>(),
            Stream::of::<Answered<contract::RoutePage>>(),
        ];
        let of_details =
            [Stream::of::<Asked<contract::DetailRequest>>(), Stream::of::<Answered<contract::DetailPage>>()];
        let of_table =
            [Stream::of::<Asked<contract::TableRequest>>(), Stream::of::<Answered<contract::TablePage>>()];
        let has_asker = |stream: &Stream| !of_details.contains(stream) && !of_table.contains(stream);
        let is_used = |stream: &Stream| match missions {
            Missions::Hopper | Missions::Protocol => !of_routes.contains(stream) && *stream != teams,
            Missions::Rovers => !of_routes.contains(stream),
            Missions::Scouts | Missions::Mixed => true,
            Missions::Accompanied => !of_prior.contains(stream),
        };
        (0..STREAMS.len() as u8).map(Stream).filter(has_asker).filter(is_used).collect()
    }

    /// The stream of a message, a request, or a response.
    ///
    /// # Panics
    /// If `T` is not in `contract::wire::visit`.
    pub(crate) fn of<T: 'static>() -> Self {
        let of = TypeId::of::<T>();
        Self(STREAMS.iter().position(|facts| facts.of == of).expect("a message of the registry") as u8)
    }

    /// The name under which faults of the stream are counted.
    #[must_use]
    pub fn as_str(self) -> &'static str {
        &STREAMS[usize::from(self.0)].name
    }

    /// Messages that a reader's queue holds before the oldest gives way.
    #[must_use]
    pub fn buffer(self) -> usize {
        STREAMS[usize::from(self.0)].buffer
    }

    /// Whether a late reader gets the writer's last message.
    #[must_use]
    pub fn has_history(self) -> bool {
        STREAMS[usize::from(self.0)].has_history
    }
}

impl Serialize for Stream {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_str(self.as_str())
    }
}
