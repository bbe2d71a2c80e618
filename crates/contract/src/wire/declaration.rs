//! The declaration of a wire type: one line a field.

use bytemuck::Pod;

use crate::codec::Codec;
use crate::field::{Field, Shaped, layout_name};

impl Field {
    /// A field of type `W` that `codec` converts. `names` has its own name and that in refusals.
    pub(crate) fn new<W: Pod + Shaped>(
        names: [&'static str; 2],
        offset: usize,
        reason: &'static str,
        codec: &impl Codec<W>,
    ) -> Self {
        let ends = codec.ends();
        let bytes = |ends: Vec<W>| ends.iter().map(|end| bytemuck::bytes_of(end).to_vec()).collect();
        Self {
            name: names[0],
            refused_as: names[1],
            layout: layout_name::<W>(),
            shape: W::shape(),
            meaning: codec.meaning(),
            offset,
            range: codec.range(),
            reason: reason.trim(),
            inside: bytes(ends.inside),
            outside: bytes(ends.outside),
        }
    }
}

/// Declares a wire type: a name with version, a size, and one entry a field. The struct, both conversions, the refusals and
/// the row in the reference follow.
///
/// ```text
/// wire! {
///     /// How much is left.
///     pub struct BatteryV1 = "hop.Battery.v1", 16 bytes, refused as "battery" {
///         /// Energy left, joules; the upper end is more than any hopper can carry.
///         charge_j: f64 = float(0.0, CHARGE_MAX_J),
///         /// Whose battery.
///         robot: u32 = ROBOT,
///         reserved: u32,
///     }
///     of Battery { robot, charge_j }
/// }
/// ```
///
/// - A field has its reason, its type, and the [`Codec`] that says what it stands for and which values are accepted. A refusal
///   names it `battery.charge_j`, or as what stands after `=>`; the first one out of range is refused, in the order of the
///   layout.
/// - `of` is followed by the domain type as a pattern, which is also the expression that builds it. Its names are those of the
///   fields, so a domain field that is forgotten does not compile.
/// - A field that is part of a sum, or depends on another, has a codec that leaves it as it is, `by_hand` or `joint`, and is
///   converted in two blocks. `to_wire` begins with references to what the pattern names, and binds references to what such
///   fields hold. `from_wire(wire)` begins with the values of all fields, and binds what the pattern names.
/// - `check(wire)` is done before all fields, for what must be refused first.
/// - A header, whose message has cells, ends with the function that reads both.
macro_rules! wire {
    (
        $(#[doc = $about:literal])+
        pub struct $wire:ident = $version:literal, $bytes:literal bytes, refused as $prefix:literal {
            $(
                $(#[doc = $reason:literal])*
                $field:ident: $layout:tt $(= $codec:expr $(=> $name:literal)?)?,
            )*
        }
        of $domain:ident $shape:tt
        $(check($checked:ident) { $($check:tt)* })?
        $(to_wire { $($to:tt)* })?
        $(from_wire($read:ident) { $($from:tt)* })?
        $($(#[doc = $how:literal])+ $visible:vis fn $function:ident($cells:ident: $payload:ty);)?
    ) => {
        $(#[doc = $about])+
        #[repr(C)]
        #[derive(Clone, Copy, Debug, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
        #[allow(missing_docs, reason = "`reserved` needs no words; a test holds that every other field has some")]
        pub struct $wire {
            $($(#[doc = $reason])* pub $field: $layout,)*
        }

        const _: () = assert!(size_of::<$wire>() == $bytes);

        impl $crate::message::Wire for $wire {
            const NAME: &'static str = $version;

            fn fields() -> Vec<$crate::wire::Field> {
                vec![$($crate::wire::Field::new::<$layout>(
                    [
                        stringify!($field),
                        $crate::wire::declaration::wire!(@name $prefix $field $($($name)?)?),
                    ],
                    std::mem::offset_of!($wire, $field),
                    concat!($($reason),*),
                    &$crate::wire::declaration::wire!(@codec $($codec)?),
                )),*]
            }
        }

        impl $crate::field::Shaped for $wire {
            fn shape() -> $crate::field::Shape {
                $crate::field::Shape::Parts(<Self as $crate::message::Wire>::fields())
            }
        }

        impl From<&$domain> for $wire {
            #[inline]
            #[allow(unused_variables, reason = "cells are not part of their header")]
            fn from(value: &$domain) -> Self {
                let $domain $shape = value;
                $($($to)*)?
                Self { $($field: $crate::wire::declaration::wire!(@to $field: $layout $(= $codec)?)),* }
            }
        }

        impl $wire {
            #[inline]
            #[allow(unused_variables, clippy::let_unit_value, reason = "what is reserved is not read")]
            fn read(&self $(, $cells: $payload)?) -> Result<$domain, $crate::Refusal> {
                let wire = self;
                $(let $checked = wire; $($check)*)?
                $(let $field = $crate::wire::declaration::wire!(
                    @from wire $crate::wire::declaration::wire!(@name $prefix $field $($($name)?)?),
                    $field: $layout $(= $codec)?
                );)*
                $(let $read = wire; $($from)*)?
                Ok($domain $shape)
            }
        }

        $crate::wire::declaration::wire!(
            @read $wire, $domain $(, $(#[doc = $how])+ $visible $function($cells: $payload))?
        );
    };

    // The name of a field in refusals.
    (@name $prefix:literal $field:ident) => { concat!($prefix, ".", stringify!($field)) };
    (@name $prefix:literal $field:ident $name:literal) => { $name };

    // The codec that describes a field.
    (@codec) => { $crate::codec::by_hand("written as 0, not read") };
    (@codec $codec:expr) => { $codec };

    // What is written to a field.
    (@to reserved: u32) => { 0 };
    (@to $field:ident: $layout:ty = $codec:expr) => {
        $crate::codec::Codec::<$layout>::to_wire(&$codec, $field)
    };

    // What is read from a field.
    (@from $wire:ident $name:expr, reserved: u32) => { () };
    (@from $wire:ident $name:expr, $field:ident: $layout:ty = $codec:expr) => {
        $crate::codec::Codec::<$layout>::from_wire(&$codec, $name, $wire.$field)?
    };

    // How the domain type is read: alone, or as a header with its cells.
    (@read $wire:ident, $domain:ident) => {
        impl TryFrom<&$wire> for $domain {
            type Error = $crate::Refusal;

            #[inline]
            fn try_from(wire: &$wire) -> Result<Self, $crate::Refusal> {
                wire.read()
            }
        }
    };
    (
        @read $wire:ident, $domain:ident,
        $(#[doc = $how:literal])* $visible:vis $function:ident($cells:ident: $payload:ty)
    ) => {
        $(#[doc = $how])*
        $visible fn $function(wire: &$wire, $cells: $payload) -> Result<$domain, $crate::Refusal> {
            wire.read($cells)
        }
    };
}

pub(crate) use wire;
