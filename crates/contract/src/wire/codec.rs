//! What the bytes of one field stand for, and which of them are accepted.
//!
//! A codec is a value with its range in it, such as `at_most(100)` or `float(0.0, 1.0)`. A declaration gives each field
//! one, and from it follow both conversions, the refusal and the row in the reference.

use std::fmt::{Debug, Display};
use std::marker::PhantomData;

use crate::limits::{DECISIONS_MAX, GRADIENT_MAX, LENGTH_MAX_M, PAYOFF_MAX, STEPS_MAX, TREASURES_MAX};
use crate::message::Wire;
use crate::{Action, Cell, MonotonicNs, Name, Refusal, RobotId, RunId, Timing};

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
}

/// Values at the ends of a field's range, on both sides.
pub(crate) struct Ends<W> {
    /// Just inside: accepted.
    pub inside: Vec<W>,
    /// Just outside: refused.
    pub outside: Vec<W>,
}

/// A field that stands for itself and is not checked here.
pub(crate) struct AsItIs(&'static str);

/// Every value is accepted.
pub(crate) const ANY: AsItIs = AsItIs("any");

/// A field that is part of a sum or depends on others: its declaration converts it by hand. `range` says what is accepted.
pub(crate) const fn by_hand(range: &'static str) -> AsItIs {
    AsItIs(range)
}

impl<W: Copy> Codec<W> for AsItIs {
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
        self.0.into()
    }
}

/// A field that is converted by hand, with others, within the range of `codec`.
pub(crate) struct Joint<C> {
    codec: C,
    how: &'static str,
}

/// A field that is converted by hand, with others, within the range of `codec`; `how` says what else holds, or when it is
/// read at all.
pub(crate) const fn joint<C>(codec: C, how: &'static str) -> Joint<C> {
    Joint { codec, how }
}

impl<W: Copy, C: Codec<W>> Codec<W> for Joint<C> {
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
        format!("{}; {}", self.codec.range(), self.how)
    }

    fn ends(&self) -> Ends<W> {
        self.codec.ends()
    }
}

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

/// A life or a count of which 0 stands for none, where there must be one.
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

/// A float within `min..=max`, or some of them; NaN is never within.
#[derive(Clone, Copy)]
pub(crate) struct Float {
    min: f64,
    max: f64,
}

pub(crate) const fn float(min: f64, max: f64) -> Float {
    Float { min, max }
}

/// Every number; neither NaN nor infinite.
pub(crate) const FINITE: Float = float(f64::MIN, f64::MAX);

/// A height, a distance or a coordinate, metres.
pub(crate) const LENGTH: Float = float(-LENGTH_MAX_M, LENGTH_MAX_M);

/// A distance that is not negative, metres.
pub(crate) const DISTANCE: Float = float(0.0, LENGTH_MAX_M);

/// The gradient of the ground, metres per metre.
pub(crate) const GRADIENT: Float = float(-GRADIENT_MAX, GRADIENT_MAX);

/// A payoff, a weight or a penalty.
pub(crate) const PAYOFF: Float = float(-PAYOFF_MAX, PAYOFF_MAX);

/// A probability or a share.
pub(crate) const PROBABILITY: Float = float(0.0, 1.0);

impl Float {
    /// What a refusal says is needed.
    fn need(&self) -> String {
        let Self { min, max } = self;
        if *max == f64::MAX { "a finite value".into() } else { format!("{min} to {max}") }
    }
}

impl Codec<f64> for Float {
    type Value = f64;

    #[inline]
    fn to_wire(&self, value: &f64) -> f64 {
        *value
    }

    #[inline]
    fn from_wire(&self, field: &str, wire: f64) -> Result<f64, Refusal> {
        if (self.min..=self.max).contains(&wire) {
            Ok(wire)
        } else {
            Err(Refusal::malformed(field, &self.need(), wire))
        }
    }

    fn range(&self) -> String {
        if self.min == f64::MIN_POSITIVE { format!("above 0, at most {}", self.max) } else { self.need() }
    }

    fn ends(&self) -> Ends<f64> {
        let Self { min, max } = *self;
        let mut outside = vec![min.next_down(), f64::NAN];
        if max < f64::INFINITY {
            outside.push(max.next_up());
        }
        Ends { inside: vec![min, max], outside }
    }
}

/// Each of several floats.
impl<const N: usize> Codec<[f64; N]> for Float {
    type Value = [f64; N];

    #[inline]
    fn to_wire(&self, value: &[f64; N]) -> [f64; N] {
        *value
    }

    #[inline]
    fn from_wire(&self, field: &str, wire: [f64; N]) -> Result<[f64; N], Refusal> {
        for component in wire {
            self.from_wire(field, component)?;
        }
        Ok(wire)
    }

    fn range(&self) -> String {
        Codec::<f64>::range(self)
    }

    fn ends(&self) -> Ends<[f64; N]> {
        let Ends { inside, outside } = Codec::<f64>::ends(self);
        let one = |(place, end)| std::array::from_fn(|at| if at == place % N { end } else { inside[0] });
        Ends {
            outside: outside.into_iter().enumerate().map(one).collect(),
            inside: inside.iter().map(|end| [*end; N]).collect(),
        }
    }
}

/// Floats that the refusals name one by one.
pub(crate) struct Each<const N: usize> {
    codec: Float,
    names: [&'static str; N],
}

/// Floats of which each has the range of `codec` and a name of its own.
pub(crate) const fn each<const N: usize>(codec: Float, names: [&'static str; N]) -> Each<N> {
    Each { codec, names }
}

impl<const N: usize> Codec<[f64; N]> for Each<N> {
    type Value = [f64; N];

    fn to_wire(&self, value: &[f64; N]) -> [f64; N] {
        *value
    }

    fn from_wire(&self, field: &str, wire: [f64; N]) -> Result<[f64; N], Refusal> {
        for (name, component) in self.names.into_iter().zip(wire) {
            self.codec.from_wire(&format!("{field}.{name}"), component)?;
        }
        Ok(wire)
    }

    fn range(&self) -> String {
        Codec::<f64>::range(&self.codec)
    }

    fn ends(&self) -> Ends<[f64; N]> {
        self.codec.ends()
    }
}

/// A float of which 0 stands for none.
pub(crate) struct OrZero(Float);

pub(crate) const fn or_zero(codec: Float) -> OrZero {
    OrZero(codec)
}

impl Codec<f64> for OrZero {
    type Value = Option<f64>;

    fn to_wire(&self, value: &Option<f64>) -> f64 {
        value.unwrap_or(0.0)
    }

    fn from_wire(&self, field: &str, wire: f64) -> Result<Option<f64>, Refusal> {
        if wire == 0.0 { Ok(None) } else { self.0.from_wire(field, wire).map(Some) }
    }

    fn range(&self) -> String {
        format!("{}, or 0 for none", Codec::<f64>::range(&self.0))
    }

    fn ends(&self) -> Ends<f64> {
        self.0.ends()
    }
}

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

/// Whether something is so: 1 if it is.
pub(crate) const FLAG: Tag<bool> = tag(u32::from, flag_from_code);

fn flag_from_code(code: u32) -> Option<bool> {
    match code {
        0 => Some(false),
        1 => Some(true),
        _ => None,
    }
}

/// An action that announces no route.
pub(crate) const ACTION: Tag<Action> = tag(Action::code, Action::from_code);

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
        let known = (0..256).filter_map(|code| Some(format!("{code} {:?}", (self.decode)(code)?)));
        known.collect::<Vec<_>>().join(", ")
    }

    fn ends(&self) -> Ends<W> {
        let all = || (0..256).map(|code| (code, (self.decode)(code).is_some()));
        let codes = |known| all().filter(|(_, is)| *is == known).map(|(code, _)| W::of(code)).collect();
        Ends { inside: codes(true), outside: codes(false) }
    }
}

/// A set as one bit each.
pub(crate) struct Marks(usize);

/// A mark for each treasure of a scenario.
pub(crate) const TREASURE_MARKS: Marks = Marks(TREASURES_MAX);

/// A mark for each action.
pub(crate) const ACTION_MARKS: Marks = Marks(Action::CODES);

impl Codec<u32> for Marks {
    type Value = u32;

    fn to_wire(&self, value: &u32) -> u32 {
        *value
    }

    fn from_wire(&self, field: &str, wire: u32) -> Result<u32, Refusal> {
        if wire >> self.0 == 0 {
            Ok(wire)
        } else {
            Err(Refusal::malformed(field, &self.range(), format!("{wire:#b}")))
        }
    }

    fn range(&self) -> String {
        format!("at most {} marks", self.0)
    }

    fn ends(&self) -> Ends<u32> {
        Ends { inside: vec![0, (1 << self.0) - 1], outside: vec![1 << self.0] }
    }
}

/// A run nonce as two halves, the high one first.
pub(crate) struct Run;

/// The run that a message belongs to.
pub(crate) const RUN: Run = Run;

impl Codec<[u64; 2]> for Run {
    type Value = RunId;

    #[inline]
    fn to_wire(&self, run: &RunId) -> [u64; 2] {
        [(run.0 >> 64) as u64, run.0 as u64]
    }

    #[inline]
    fn from_wire(&self, _: &str, [high, low]: [u64; 2]) -> Result<RunId, Refusal> {
        Ok(RunId(u128::from(high) << 64 | u128::from(low)))
    }

    fn range(&self) -> String {
        "any; high half first".into()
    }
}

/// The number of a robot.
pub(crate) struct Robot;

/// The number of a robot, which its reader compares with those of the mission.
pub(crate) const ROBOT: Robot = Robot;

impl Codec<u32> for Robot {
    type Value = RobotId;

    #[inline]
    fn to_wire(&self, robot: &RobotId) -> u32 {
        robot.0.into()
    }

    #[inline]
    fn from_wire(&self, _: &str, wire: u32) -> Result<RobotId, Refusal> {
        u16::try_from(wire).map(RobotId).map_err(|_| Refusal::WrongRobot { robots: u16::MAX, got: wire })
    }

    fn range(&self) -> String {
        format!("at most {}", u16::MAX)
    }

    fn ends(&self) -> Ends<u32> {
        Ends { inside: vec![0, u16::MAX.into()], outside: vec![u32::from(u16::MAX) + 1] }
    }
}

/// A name, zero-padded.
pub(crate) struct ShortName {
    may_be_empty: bool,
}

/// A name, or none.
pub(crate) const NAME: ShortName = ShortName { may_be_empty: true };

/// A name that must be given.
pub(crate) const GIVEN_NAME: ShortName = ShortName { may_be_empty: false };

impl Codec<[u8; Name::BYTES]> for ShortName {
    type Value = Name;

    fn to_wire(&self, name: &Name) -> [u8; Name::BYTES] {
        name.bytes()
    }

    fn from_wire(&self, field: &str, wire: [u8; Name::BYTES]) -> Result<Name, Refusal> {
        let name = Name::from_bytes(wire)
            .map_err(|error| Refusal::malformed(field, "printable ASCII", error.got))?;
        if name == Name::NONE && !self.may_be_empty {
            return Err(Refusal::malformed(field, "a name", "nothing"));
        }
        Ok(name)
    }

    fn range(&self) -> String {
        let empty = if self.may_be_empty { "" } else { ", not empty" };
        format!("letters, digits and `._-+`{empty}, then zeros")
    }

    fn ends(&self) -> Ends<[u8; Name::BYTES]> {
        let of = |first| std::array::from_fn(|at| if at == 0 { first } else { 0 });
        let mut ends = Ends {
            inside: vec![of(b'a'), of(b'+')],
            outside: vec![of(b'.'), of(b'/'), of(0x80), [b'a'; Name::BYTES]],
        };
        if self.may_be_empty { &mut ends.inside } else { &mut ends.outside }.push([0; Name::BYTES]);
        ends
    }
}

/// A cell as (x, y).
pub(crate) struct CellAt;

/// A cell of the grid or next to it; which, its reader decides.
pub(crate) const CELL: CellAt = CellAt;

impl CellAt {
    /// Farther than any grid reaches, with room to count on.
    const FAR: i32 = 1 << 20;
}

impl Codec<[i32; 2]> for CellAt {
    type Value = Cell;

    #[inline]
    fn to_wire(&self, cell: &Cell) -> [i32; 2] {
        [cell.x, cell.y]
    }

    #[inline]
    fn from_wire(&self, field: &str, [x, y]: [i32; 2]) -> Result<Cell, Refusal> {
        let near = -Self::FAR..=Self::FAR;
        if near.contains(&x) && near.contains(&y) {
            Ok(Cell::new(x, y))
        } else {
            Err(Refusal::malformed(field, "a cell on or next to the grid", Cell::new(x, y)))
        }
    }

    fn range(&self) -> String {
        format!("x and y from {} to {}", -Self::FAR, Self::FAR)
    }

    fn ends(&self) -> Ends<[i32; 2]> {
        let far = Self::FAR;
        Ends {
            inside: vec![[far, -far], [-far, far]],
            outside: vec![[far + 1, 0], [0, far + 1], [-far - 1, 0], [0, -far - 1]],
        }
    }
}

/// The moments of a decision, monotonic nanoseconds.
pub(crate) struct Moments;

/// The moments of a decision from landing to landing, in the order of [`Timing`].
pub(crate) const MOMENTS: Moments = Moments;

impl Codec<[u64; 8]> for Moments {
    type Value = Timing;

    fn to_wire(&self, timing: &Timing) -> [u64; 8] {
        timing.moments().map(|moment| moment.0)
    }

    fn from_wire(&self, _: &str, wire: [u64; 8]) -> Result<Timing, Refusal> {
        Ok(Timing::from_moments(wire.map(MonotonicNs)))
    }

    fn range(&self) -> String {
        "any".into()
    }
}

/// A wire type inside another, which has its own declaration.
pub(crate) struct Part<D>(PhantomData<D>);

/// A `D` in its own wire form.
pub(crate) const fn part<D>() -> Part<D> {
    Part(PhantomData)
}

impl<W: Wire, D> Codec<W> for Part<D>
where
    W: for<'a> From<&'a D>,
    D: for<'a> TryFrom<&'a W, Error = Refusal>,
{
    type Value = D;

    fn to_wire(&self, value: &D) -> W {
        value.into()
    }

    fn from_wire(&self, _: &str, wire: W) -> Result<D, Refusal> {
        D::try_from(&wire)
    }

    fn range(&self) -> String {
        format!("as `{}`", W::NAME)
    }
}
