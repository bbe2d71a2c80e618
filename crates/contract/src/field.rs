//! What is declared of each field of a message, down to the numbers that its bytes are.

/// A field of a wire type as its declaration has it.
#[derive(Clone, Debug, PartialEq)]
pub struct Field {
    /// Its name in the wire type.
    pub name: &'static str,
    /// Its name in refusals.
    pub refused_as: &'static str,
    /// Its type.
    pub layout: String,
    /// What its type is made of.
    pub shape: Shape,
    /// What its bytes stand for.
    pub meaning: Meaning,
    /// Where it begins, bytes.
    pub offset: usize,
    /// What is accepted, in words.
    pub range: String,
    /// What it is, and why it is there.
    pub reason: &'static str,
    /// Its bytes just inside of its range; none where everything is accepted, or others say what is.
    pub inside: Vec<Vec<u8>>,
    /// Its bytes just outside of its range.
    pub outside: Vec<Vec<u8>>,
}

impl Field {
    /// A field of type `W` in a wire type that is declared outside of this crate, where it crosses no shared memory. `range` is
    /// what is accepted, in words.
    #[must_use]
    pub fn of<W: Shaped>(
        name: &'static str,
        offset: usize,
        range: impl Into<String>,
        reason: &'static str,
    ) -> Self {
        Self {
            name,
            refused_as: name,
            layout: layout_name::<W>(),
            shape: W::shape(),
            meaning: Meaning::Plain,
            offset,
            range: range.into(),
            reason,
            inside: Vec::new(),
            outside: Vec::new(),
        }
    }

    /// The same with what its bytes stand for.
    #[must_use]
    pub fn meaning(self, meaning: Meaning) -> Self {
        Self { meaning, ..self }
    }
}

/// The name of a type without its path: `[u64; 2]`.
pub(crate) fn layout_name<W>() -> String {
    let layout = std::any::type_name::<W>();
    let (brackets, path) = layout.split_at(layout.len() - layout.trim_start_matches('[').len());
    brackets.to_owned() + path.rsplit("::").next().unwrap_or(path)
}

/// A number of a wire type, in the byte order of the machine.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[allow(missing_docs, reason = "the names are those of the types")]
pub enum Number {
    U8,
    U16,
    U32,
    U64,
    I32,
    F64,
}

impl Number {
    /// How many bytes it takes.
    #[must_use]
    pub fn bytes(self) -> usize {
        match self {
            Number::U8 => 1,
            Number::U16 => 2,
            Number::U32 | Number::I32 => 4,
            Number::U64 | Number::F64 => 8,
        }
    }
}

/// What a field is made of.
#[derive(Clone, Debug, PartialEq)]
pub enum Shape {
    /// A number.
    Number(Number),
    /// So many of the same, one after another.
    Array(Box<Shape>, usize),
    /// A wire type inside another.
    Parts(Vec<Field>),
}

/// A type that a field of a wire type may have.
pub trait Shaped {
    /// What it is made of.
    fn shape() -> Shape;
}

impl<T: Shaped, const N: usize> Shaped for [T; N] {
    fn shape() -> Shape {
        Shape::Array(Box::new(T::shape()), N)
    }
}

/// The numbers that wire types are made of.
macro_rules! numbers {
    ($($number:ident = $layout:ty),*) => {
        $(impl Shaped for $layout {
            fn shape() -> Shape {
                Shape::Number(Number::$number)
            }
        })*
    };
}

numbers!(U8 = u8, U16 = u16, U32 = u32, U64 = u64, I32 = i32, F64 = f64);

/// What the bytes of a field stand for, for whoever shows them to people.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub enum Meaning {
    /// Numbers, or bytes without a meaning of their own.
    #[default]
    Plain,
    /// A code, and what each code stands for.
    Codes(Vec<(u32, String)>),
    /// Text, padded with zeros.
    Text,
}
