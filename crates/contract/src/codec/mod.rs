//! What the bytes of one field stand for, and which of them are accepted.
//!
//! A codec is a value with its range in it, such as `at_most(100)` or `float(0.0, 1.0)`. A declaration gives each field
//! one, and from it follow both conversions, the refusal and the row in the reference.

mod bits;
mod cell;
mod float;
mod identity;
mod moments;
mod part;
mod tag;
mod whole;

use crate::Refusal;
use crate::field::Meaning;

pub(crate) use bits::{ACTION_BITS, TREASURE_BITS};
pub(crate) use cell::CELL;
pub(crate) use float::{
    Ascending, DISTANCE, FINITE, Float, GRADIENT, LENGTH, PAYOFF, PROBABILITY, RADIUS, SPEED, ascending,
    each, float, or_zero,
};
pub(crate) use identity::{GIVEN_NAME, NAME, ROBOT, RUN};
pub(crate) use moments::MOMENTS;
pub(crate) use part::part;
pub(crate) use tag::{ACTION, Code, FLAG, HEADING, tag, unknown_tag};
pub(crate) use whole::{COUNTED, NOT_ZERO, STEPS, Whole, at_most, narrow, whole};

/// How a field of type `W` is written and read.
pub(crate) trait Codec<W> {
    /// What the field stands for.
    type Value;

    /// The value in its wire form.
    fn to_wire(&self, value: &Self::Value) -> W;

    /// The value of what was received; `field` names it in the refusal of one out of range.
    #[allow(clippy::wrong_self_convention, reason = "the codec converts, not the value")]
    fn from_wire(&self, field: &str, wire: W) -> Result<Self::Value, Refusal>;

    /// What is accepted, in words.
    fn range(&self) -> String;

    /// The ends of the range; none where everything is accepted.
    fn ends(&self) -> Ends<W> {
        Ends { inside: Vec::new(), outside: Vec::new() }
    }

    /// What the bytes stand for, for whoever shows them to people.
    fn meaning(&self) -> Meaning {
        Meaning::Plain
    }
}

/// Values at the ends of a field's range, on both sides.
pub(crate) struct Ends<W> {
    /// Just inside: accepted.
    pub inside: Vec<W>,
    /// Just outside: refused.
    pub outside: Vec<W>,
}

/// A field that its declaration converts by hand, with others: its value is passed on as it is.
pub(crate) struct ByHand<A>(A);

/// What is accepted of a field that is converted by hand.
pub(crate) trait Accepted<W> {
    /// In words.
    fn range(&self) -> String;

    /// The ends of the range; none where only the declaration can tell.
    fn ends(&self) -> Ends<W>;

    /// What the bytes stand for.
    fn meaning(&self) -> Meaning {
        Meaning::Plain
    }
}

/// A value that every reader accepts.
pub(crate) const ANY: ByHand<&str> = by_hand("any");

/// A field that is part of a sum or depends on others. `range` says what is accepted.
pub(crate) const fn by_hand(range: &'static str) -> ByHand<&'static str> {
    ByHand(range)
}

/// A field that is converted with others, within the range of `codec`; `how` says what else holds, or when it is read at
/// all.
pub(crate) const fn joint<C>(codec: C, how: &'static str) -> ByHand<(C, &'static str)> {
    ByHand((codec, how))
}

impl<W> Accepted<W> for &str {
    fn range(&self) -> String {
        (*self).into()
    }

    fn ends(&self) -> Ends<W> {
        Ends { inside: Vec::new(), outside: Vec::new() }
    }
}

impl<W, C: Codec<W>> Accepted<W> for (C, &str) {
    fn range(&self) -> String {
        format!("{}; {}", self.0.range(), self.1)
    }

    fn ends(&self) -> Ends<W> {
        self.0.ends()
    }

    fn meaning(&self) -> Meaning {
        self.0.meaning()
    }
}

impl<W: Copy, A: Accepted<W>> Codec<W> for ByHand<A> {
    type Value = W;

    #[inline]
    fn to_wire(&self, value: &W) -> W {
        *value
    }

    #[inline]
    fn from_wire(&self, _: &str, wire: W) -> Result<W, Refusal> {
        Ok(wire)
    }

    fn range(&self) -> String {
        self.0.range()
    }

    fn ends(&self) -> Ends<W> {
        self.0.ends()
    }

    fn meaning(&self) -> Meaning {
        self.0.meaning()
    }
}
