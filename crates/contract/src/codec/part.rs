//! Wire types inside others.

use std::marker::PhantomData;

use super::Codec;
use crate::Refusal;
use crate::message::Wire;

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
