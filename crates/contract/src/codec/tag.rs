//! Codes of things, such as those of an action.

use std::fmt::Debug;

use super::{Codec, Ends};
use crate::field::Meaning;
use crate::{Action, Direction, Refusal};

/// An integer that holds a code.
pub(crate) trait Code: Copy {
    fn of(code: u32) -> Self;
    fn get(self) -> u32;
}

impl Code for u32 {
    #[inline]
    fn of(code: u32) -> Self {
        code
    }

    #[inline]
    fn get(self) -> u32 {
        self
    }
}

impl Code for u8 {
    #[inline]
    fn of(code: u32) -> Self {
        code as u8
    }

    #[inline]
    fn get(self) -> u32 {
        self.into()
    }
}

/// The refusal of a code that stands for nothing.
pub(crate) fn unknown_tag(field: &str, code: u32) -> Refusal {
    Refusal::malformed(field, "a known tag", code)
}

/// One of several things, by its code.
pub(crate) struct Tag<T> {
    code: fn(T) -> u32,
    decode: fn(u32) -> Option<T>,
}

/// The code of a `T`.
pub(crate) const fn tag<T>(code: fn(T) -> u32, decode: fn(u32) -> Option<T>) -> Tag<T> {
    Tag { code, decode }
}

/// A boolean: 1 true, 0 false.
pub(crate) const FLAG: Tag<bool> = tag(u32::from, flag_from_code);

fn flag_from_code(code: u32) -> Option<bool> {
    match code {
        0 => Some(false),
        1 => Some(true),
        _ => None,
    }
}

/// Where a robot faces.
pub(crate) const HEADING: Tag<Direction> =
    tag(|heading| heading as u32, |code| Direction::ALL.get(code as usize).copied());

/// An action that announces no route.
pub(crate) const ACTION: Tag<Action> = tag(Action::code, Action::from_code);

impl<T: Debug> Tag<T> {
    /// The codes that stand for something, and for what.
    fn known(&self) -> Vec<(u32, String)> {
        (0..256).filter_map(|code| Some((code, format!("{:?}", (self.decode)(code)?)))).collect()
    }
}

impl<W: Code, T: Copy + Debug> Codec<W> for Tag<T> {
    type Value = T;

    #[inline]
    fn to_wire(&self, value: &T) -> W {
        W::of((self.code)(*value))
    }

    #[inline]
    fn from_wire(&self, field: &str, wire: W) -> Result<T, Refusal> {
        (self.decode)(wire.get()).ok_or_else(|| unknown_tag(field, wire.get()))
    }

    fn range(&self) -> String {
        let known = self.known().into_iter().map(|(code, name)| format!("{code} {name}"));
        known.collect::<Vec<_>>().join(", ")
    }

    fn meaning(&self) -> Meaning {
        Meaning::Codes(self.known())
    }

    fn ends(&self) -> Ends<W> {
        let all = || (0..256).map(|code| (code, (self.decode)(code).is_some()));
        let codes = |known| all().filter(|(_, is)| *is == known).map(|(code, _)| W::of(code)).collect();
        Ends { inside: codes(true), outside: codes(false) }
    }
}
