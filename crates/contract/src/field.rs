//! What is declared of each field of a message.

/// A field of a wire type as its declaration has it.
#[derive(Clone, Debug, PartialEq)]
pub struct Field {
    /// Its name in the wire type.
    pub name: &'static str,
    /// Its name in refusals.
    pub refused_as: &'static str,
    /// Its type.
    pub layout: String,
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
