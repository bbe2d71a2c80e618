//! Whole numbers.

use std::fmt::Display;

use super::{Codec, Ends};
use crate::Refusal;
use crate::limits::{DECISIONS_MAX, STEPS_MAX};

/// A whole number within `min..=max`.
#[derive(Clone, Copy)]
pub(crate) struct Whole {
    min: u64,
    max: u64,
}

pub(crate) const fn whole(min: u64, max: u64) -> Whole {
    Whole { min, max }
}

pub(crate) const fn at_most(max: u64) -> Whole {
    whole(0, max)
}

/// A number that must be given; 0 stands for none.
pub(crate) const NOT_ZERO: Whole = whole(1, u64::MAX);

/// A decision, a term or a count of them: it leaves room to count on.
pub(crate) const COUNTED: Whole = at_most(DECISIONS_MAX);

/// Steps that a run can come to.
pub(crate) const STEPS: Whole = at_most(STEPS_MAX);

impl<W: Copy + Display + Into<u64> + TryFrom<u64>> Codec<W> for Whole {
    type Value = W;

    #[inline]
    fn to_wire(&self, value: &W) -> W {
        *value
    }

    #[inline]
    fn from_wire(&self, field: &str, wire: W) -> Result<W, Refusal> {
        if (self.min..=self.max).contains(&wire.into()) {
            Ok(wire)
        } else {
            Err(Refusal::malformed(field, &Codec::<W>::range(self), wire))
        }
    }

    fn range(&self) -> String {
        match (self.min, self.max) {
            (0, max) => format!("at most {max}"),
            (1, u64::MAX) => "not zero".into(),
            (min, max) if max == min + 1 => format!("{min} or {max}"),
            (min, max) => format!("{min} to {max}"),
        }
    }

    fn ends(&self) -> Ends<W> {
        let numbers = |numbers: [Option<u64>; 2]| {
            numbers.into_iter().flatten().filter_map(|number| W::try_from(number).ok()).collect()
        };
        Ends {
            inside: numbers([Some(self.min), Some(self.max)]),
            outside: numbers([self.min.checked_sub(1), self.max.checked_add(1)]),
        }
    }
}

/// A whole number that stands for one of two bytes.
pub(crate) struct Narrow(Whole);

pub(crate) const fn narrow(min: u16, max: u16) -> Narrow {
    Narrow(whole(min as u64, max as u64))
}

impl Codec<u32> for Narrow {
    type Value = u16;

    fn to_wire(&self, value: &u16) -> u32 {
        (*value).into()
    }

    fn from_wire(&self, field: &str, wire: u32) -> Result<u16, Refusal> {
        Ok(self.0.from_wire(field, wire)? as u16)
    }

    fn range(&self) -> String {
        Codec::<u32>::range(&self.0)
    }

    fn ends(&self) -> Ends<u32> {
        self.0.ends()
    }
}
