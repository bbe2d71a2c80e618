//! Floats, and several of them.

use super::{Codec, Ends};
use crate::limits::{CAMERA_RADIUS_MAX_M, GRADIENT_MAX, LENGTH_MAX_M, PAYOFF_MAX};
use crate::{Range, Refusal};

/// A float within `min..=max`, or each of several; NaN is never within.
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

/// A speed, m/s: from 0.1 mm a Sol to what is faster than any vehicle.
pub(crate) const SPEED: Float = float(1.0e-9, 1.0e3);

/// How far a camera sees, metres.
pub(crate) const RADIUS: Float = float(f64::MIN_POSITIVE, CAMERA_RADIUS_MAX_M);

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
            Err(Refusal::malformed(field, &Codec::<f64>::range(self), wire))
        }
    }

    fn range(&self) -> String {
        match (self.min, self.max) {
            (f64::MIN, f64::MAX) => "a finite value".into(),
            (f64::MIN_POSITIVE, max) => format!("above 0, at most {max}"),
            (min, f64::INFINITY) => format!("at least {min}"),
            (min, max) => format!("{min} to {max}"),
        }
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

/// Two floats within a bound, the lower one first, with what the refusals add to the name of the field for each.
pub(crate) struct Ascending {
    bound: Float,
    names: [&'static str; 2],
}

pub(crate) const fn ascending(bound: Float, names: [&'static str; 2]) -> Ascending {
    Ascending { bound, names }
}

impl Codec<[f64; 2]> for Ascending {
    type Value = Range;

    fn to_wire(&self, range: &Range) -> [f64; 2] {
        [range.min, range.max]
    }

    fn from_wire(&self, field: &str, [min, max]: [f64; 2]) -> Result<Range, Refusal> {
        let [lower, upper] = self.names;
        let min = self.bound.from_wire(&format!("{field}{lower}"), min)?;
        let max = float(min, self.bound.max).from_wire(&format!("{field}{upper}"), max)?;
        Ok(Range { min, max })
    }

    fn range(&self) -> String {
        format!("{}, the lower one first", Codec::<f64>::range(&self.bound))
    }

    fn ends(&self) -> Ends<[f64; 2]> {
        let mut ends: Ends<[f64; 2]> = self.bound.ends();
        ends.outside.push([1.0, 1.0_f64.next_down()]);
        ends
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
