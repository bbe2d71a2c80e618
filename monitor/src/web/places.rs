//! Places of event streams, and which stream gives up its place when all are taken.
//!
//! A client that reads nothing could keep a place for hours: what an idle stream sends fits into the buffers of its socket. So a
//! stream begins with the number of its place, and the page sends that number back. A stream whose client has not done so in time
//! makes room for another. One whose client has keeps its place, so that pages do not drive each other out in a circle: a page for
//! which there is no place is refused, and asks again.

use contract::MonotonicNs;

use super::rejection::Rejection;

/// Most streams of the history at once, without and with those that have the key; more get status 503. The operator's page
/// has a place that no other reader can take.
pub const HISTORIES_MAX: usize = 24;
const KEYED_HISTORIES_MAX: usize = HISTORIES_MAX + 4;

/// Most streams of policies at once, without and with those that have the key; more get status 503.
pub const POLICIES_MAX: usize = 8;
const KEYED_POLICIES_MAX: usize = POLICIES_MAX + 4;

/// Time in which a client needs to send back the number of its place, nanoseconds.
pub const PROOF_NS: u64 = 5_000_000_000;

/// What a stream is of.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Kind {
    /// Policies, instead of the history.
    pub policy: bool,
    /// Whether its request had the key of orders.
    pub keyed: bool,
}

/// The places that are taken. `S` is what closes a stream.
#[derive(Debug)]
pub struct Places<S> {
    /// In the order in which they were taken.
    taken: Vec<Place<S>>,
    /// Number of the next place.
    next: u64,
    proof_ns: u64,
}

#[derive(Debug)]
struct Place<S> {
    number: u64,
    kind: Kind,
    since: MonotonicNs,
    /// Whether its client has sent back its number.
    is_read: bool,
    /// `None` until the stream begins.
    stream: Option<S>,
}

impl<S> Places<S> {
    /// Places whose clients have `proof_ns` nanoseconds to send back their numbers.
    #[must_use]
    pub fn new(proof_ns: u64) -> Self {
        Self { taken: Vec::new(), next: 0, proof_ns }
    }

    /// Takes a place; returns its number, and the stream that made room for it, which is to be closed.
    ///
    /// # Errors
    /// If all places are taken and no stream makes room.
    pub fn take(&mut self, kind: Kind, now: MonotonicNs) -> Result<(u64, Option<S>), Rejection> {
        let most = match (kind.policy, kind.keyed) {
            (false, false) => HISTORIES_MAX,
            (false, true) => KEYED_HISTORIES_MAX,
            (true, false) => POLICIES_MAX,
            (true, true) => KEYED_POLICIES_MAX,
        };
        let mut displaced = None;
        if self.taken.iter().filter(|place| place.kind.policy == kind.policy).count() >= most {
            let full = || Rejection::new(503, format!("{most} such streams are open already"));
            let place = self.that_makes_room(kind, now).ok_or_else(full)?;
            displaced = self.taken.remove(place).stream;
        }
        let number = self.next;
        self.next += 1;
        self.taken.push(Place { number, kind, since: now, is_read: false, stream: None });
        Ok((number, displaced))
    }

    /// Which place is given to a new stream: that of the client that came first of those that are late with their number. A
    /// stream with the key also gets the place of one without.
    fn that_makes_room(&self, kind: Kind, now: MonotonicNs) -> Option<usize> {
        let first = |suits: &dyn Fn(&Place<S>) -> bool| {
            self.taken.iter().position(|place| place.kind.policy == kind.policy && suits(place))
        };
        let is_late = |place: &Place<S>| !place.is_read && now.since_ns(place.since) >= self.proof_ns;
        let late = first(&|place| !place.kind.keyed && is_late(place));
        if late.is_some() || !kind.keyed {
            return late;
        }
        first(&|place| !place.kind.keyed && !place.is_read)
            .or_else(|| first(&|place| !place.kind.keyed))
            .or_else(|| first(&is_late))
    }

    /// The stream of a place begins; false if the place was given to another.
    pub fn begin(&mut self, number: u64, stream: S) -> bool {
        let Some(place) = self.taken.iter_mut().find(|place| place.number == number) else { return false };
        place.stream = Some(stream);
        true
    }

    /// The client of a place has sent back its number.
    pub fn is_read(&mut self, number: u64) {
        if let Some(place) = self.taken.iter_mut().find(|place| place.number == number) {
            place.is_read = true;
        }
    }

    /// The stream of a place has ended.
    pub fn leave(&mut self, number: u64) {
        self.taken.retain(|place| place.number != number);
    }

    /// Number of streams.
    #[must_use]
    pub fn len(&self) -> usize {
        self.taken.len()
    }

    /// Whether no place is taken.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.taken.is_empty()
    }

    /// Whether a stream is of policies.
    #[must_use]
    pub fn has_policies(&self) -> bool {
        self.taken.iter().any(|place| place.kind.policy)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const HISTORY: Kind = Kind { policy: false, keyed: false };
    const KEYED: Kind = Kind { policy: false, keyed: true };

    const fn seconds(count: u64) -> MonotonicNs {
        MonotonicNs(count * 1_000_000_000)
    }

    /// A place with a stream, whose client does nothing; and whose stream made room.
    fn take(places: &mut Places<u64>, kind: Kind, second: u64) -> Option<(u64, Option<u64>)> {
        let (number, displaced) = places.take(kind, seconds(second)).ok()?;
        assert!(places.begin(number, number));
        Some((number, displaced))
    }

    /// P-WEB-DEAF: A client that opens an event stream and does not show within 5 s that it reads
    /// it makes room for another when all slots are taken, so such clients keep no page out for
    /// longer. Pages show that they read and do not displace each other; a page without a slot says
    /// so and asks again every 5 s.
    #[test]
    fn clients_that_read_nothing_make_room() {
        for (kind, most) in [(HISTORY, HISTORIES_MAX), (Kind { policy: true, keyed: false }, POLICIES_MAX)] {
            let mut places = Places::new(PROOF_NS);
            for number in 0..most as u64 {
                assert_eq!(take(&mut places, kind, 0), Some((number, None)));
            }
            assert_eq!(take(&mut places, kind, 4), None, "they may still show that they read");
            places.is_read(0);
            assert_eq!(take(&mut places, kind, 5), Some((most as u64, Some(1))));
            assert_eq!(take(&mut places, kind, 5), Some((most as u64 + 1, Some(2))));
            assert!(!places.begin(1, 1), "its place is another's");
            assert_eq!(places.len(), most);
        }
    }

    /// P-WEB-DEAF. Pages do not displace each other, however many there are and however often they
    /// ask again.
    #[test]
    fn more_pages_than_places_do_not_drive_each_other_out() {
        let mut places = Places::new(PROOF_NS);
        let mut shown = Vec::new();
        for second in 0..600 {
            // Forty pages: those without a place ask for one.
            for page in 0..40 {
                if shown.contains(&page) {
                    continue;
                }
                if let Some((number, displaced)) = take(&mut places, HISTORY, second) {
                    assert_eq!(displaced, None, "page {page} in second {second}");
                    places.is_read(number);
                    shown.push(page);
                }
            }
        }
        assert_eq!(shown.len(), HISTORIES_MAX);
        places.leave(7);
        assert!(take(&mut places, HISTORY, 600).is_some(), "a page that leaves makes room");
    }

    /// P-WEB-ROOM. A stream with the key takes a slot of its own, the slot of a client that does
    /// not read, or that of a page without the key, but never that of another page with the key.
    #[test]
    fn a_stream_with_the_key_has_a_place() {
        let mut places = Places::new(PROOF_NS);
        for number in 0..HISTORIES_MAX as u64 {
            take(&mut places, HISTORY, 0).unwrap();
            if number != 3 {
                places.is_read(number);
            }
        }
        let mut displaced = Vec::new();
        for _ in 0..KEYED_HISTORIES_MAX {
            let (number, stream) = take(&mut places, KEYED, 1).unwrap();
            places.is_read(number);
            displaced.push(stream);
        }
        let others = (0..HISTORIES_MAX as u64).filter(|number| *number != 3).map(Some);
        let expected: Vec<_> = [None; 4].into_iter().chain([Some(3)]).chain(others).collect();
        assert_eq!(displaced, expected);
        assert_eq!(take(&mut places, KEYED, 1000), None, "all have the key and are read");
        assert_eq!(take(&mut places, HISTORY, 1000), None);
        places.leave(30);
        take(&mut places, KEYED, 1000).unwrap();
        assert!(take(&mut places, KEYED, 1005).unwrap().1.is_some(), "one with the key that reads nothing");
    }
}
