//! Lists of kinds: the bodies, sensors and goals that a robot may have.
//!
//! A kind is a struct with its parameters, in a file of its own, and one line in the list of its family; what the file has public
//! is public in the crate. In messages a kind is its code with a block of numbers; both ways, the refusals and the reference follow
//! from [`Kind::parameters`].

use crate::block::{Block, InBlock};

/// One of several kinds of a family, with its parameters.
pub trait Kind: Copy + Default {
    /// Its name in words: in scenarios, recordings and refusals.
    const NAME: &'static str;

    /// Names its parameters one by one, in the order of the block. `block` writes, reads or describes them.
    fn parameters(&mut self, block: &mut Block<'_>);
}

/// A kind, and how a block holds its parameters.
#[derive(Clone, Debug, PartialEq)]
pub struct KindInBlock {
    /// Its code.
    pub code: u32,
    /// Its name.
    pub name: &'static str,
    /// What it is.
    pub what: &'static str,
    /// Its parameters in order.
    pub parameters: Vec<InBlock>,
}

impl KindInBlock {
    pub(crate) fn of<K: Kind>(code: u32, what: &'static str) -> Self {
        let mut block = Block::describe();
        K::default().parameters(&mut block);
        Self { code, name: K::NAME, what, parameters: block.described() }
    }
}

/// Declares a family of kinds, one line a kind: its module, its variant of the enum with its parameters, its code, and what it is.
/// What can be asked of any of them is a trait, which the file of each implements; the enum dereferences to it.
///
/// ```text
/// kinds! {
///     /// What a robot is.
///     pub enum Body, each BodyKind, block of 16, refused as "robot.body" {
///         hopper => Hopper(Hopper) = 1, "Hops.";
///     }
/// }
/// ```
macro_rules! kinds {
    (
        $(#[doc = $about:literal])+
        pub enum $family:ident, each $trait:ident, block of $values:literal, refused as $prefix:literal {
            $($module:ident => $kind:ident($parameters:ident) = $code:literal, $what:literal;)+
        }
    ) => {
        $(mod $module;)+
        $(pub use self::$module::*;)+

        $(#[doc = $about])+
        #[derive(Clone, Copy, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
        #[serde(rename_all = "snake_case")]
        pub enum $family {
            $(#[doc = $what] $kind($parameters),)+
        }

        impl std::ops::Deref for $family {
            type Target = dyn $trait;

            fn deref(&self) -> &Self::Target {
                match self {
                    $(Self::$kind(kind) => kind,)+
                }
            }
        }

        impl $family {
            /// Numbers of the block that holds the parameters.
            pub(crate) const BLOCK: usize = $values;

            /// Its name in words.
            #[must_use]
            pub fn name(&self) -> &'static str {
                match self {
                    $(Self::$kind(_) => <$parameters as $crate::mission::kind::Kind>::NAME,)+
                }
            }

            /// Its code and its parameters, the rest of the block zero.
            pub(crate) fn to_block(self) -> (u32, [f64; $values]) {
                let mut values = [0.0; $values];
                let mut block = $crate::block::Block::write(&mut values);
                match self {
                    $(Self::$kind(mut kind) => {
                        $crate::mission::kind::Kind::parameters(&mut kind, &mut block);
                        ($code, values)
                    })+
                }
            }

            /// The kind of that code with the parameters of a block.
            pub(crate) fn from_block(
                code: u32,
                values: &[f64; $values],
            ) -> Result<Self, $crate::Refusal> {
                match code {
                    $($code => {
                        let mut kind = $parameters::default();
                        let mut block = $crate::block::Block::read($prefix, values);
                        $crate::mission::kind::Kind::parameters(&mut kind, &mut block);
                        block.end()?;
                        Ok(Self::$kind(kind))
                    })+
                    other => {
                        let need = [$(concat!(stringify!($code), " ", stringify!($kind))),+].join(", ");
                        Err($crate::Refusal::malformed($prefix, &need, other))
                    }
                }
            }

            /// All kinds with their codes, what they are, and their parameters.
            #[must_use]
            pub fn described() -> Vec<$crate::mission::kind::KindInBlock> {
                vec![$($crate::mission::kind::KindInBlock::of::<$parameters>(
                    $code, $what,
                )),+]
            }
        }
    };
}

pub(crate) use kinds;

/// Declares where the rules for each kind of a family are, one line a kind: the module of the folder below, and the kinds whose
/// parameters implement the trait there. Makes the function `of`, which finds the rules of a kind.
///
/// ```text
/// contract::rules! {
///     /// What a body does.
///     pub fn of(Body) -> Actions;
///     hopper => Hopper,
///     wheels => Rover | Driver,
/// }
/// ```
#[macro_export]
macro_rules! rules {
    (
        $(#[doc = $about:literal])+
        $visible:vis fn of($family:ident) -> $rules:ident;
        $($module:ident => $($kind:ident)|+,)+
    ) => {
        $(mod $module;)+

        $(#[doc = $about])+
        #[must_use]
        $visible fn of(kind: &$crate::$family) -> &dyn $rules {
            match kind {
                $($($crate::$family::$kind(parameters) => parameters,)+)+
            }
        }
    };
}
