//! What a body consists of, number by number, as the declarations of its wire types have it.

use contract::Payload;
use contract::field::{Meaning, Number, Shape};
use contract::message::Wire;
use contract::wire::Field;

/// The body of a kind of message.
#[derive(Clone, Debug, PartialEq)]
pub struct Body {
    /// What precedes the cells.
    pub header: Vec<Item>,
    /// What each cell consists of.
    pub cell: Vec<Item>,
    /// Whether a body has any number of cells, which stands before them in 16 bits; else it has one.
    pub is_counted: bool,
    /// Names and versions of the wire types of header and cell; the first is empty where there is no header.
    pub wire: [&'static str; 2],
}

/// A number, or a run of bytes, in a body.
#[derive(Clone, Debug, PartialEq)]
pub struct Item {
    /// Names from the field to the number: `leader_term`, `pose_cell_0`.
    pub name: String,
    /// Its type; `U8` for a run of bytes.
    pub number: Number,
    /// Bytes of a run; 1 for a number.
    pub count: usize,
    /// Where it begins in the wire type, bytes.
    pub offset: usize,
    /// What it stands for.
    pub meaning: Meaning,
    /// What is accepted, in words.
    pub range: String,
    /// What it is.
    pub reason: &'static str,
}

impl Body {
    /// The body of messages of type `P`.
    #[must_use]
    pub fn of<P: Payload>() -> Self {
        let is_counted = size_of::<P::Header>() > 0;
        Self {
            header: items(&P::Header::fields()),
            cell: items(&P::Cell::fields()),
            is_counted,
            wire: [if is_counted { P::Header::NAME } else { "" }, P::Cell::NAME],
        }
    }

    /// Bytes before the cells, their number included.
    #[must_use]
    pub fn head_bytes(&self) -> usize {
        length(&self.header) + if self.is_counted { 2 } else { 0 }
    }

    /// Bytes of a cell.
    #[must_use]
    pub fn cell_bytes(&self) -> usize {
        length(&self.cell)
    }
}

impl Item {
    /// How many bytes it takes.
    #[must_use]
    pub fn bytes(&self) -> usize {
        self.number.bytes() * self.count
    }
}

fn length(items: &[Item]) -> usize {
    items.iter().map(Item::bytes).sum()
}

/// What fields consist of; those that are reserved are left out.
fn items(fields: &[Field]) -> Vec<Item> {
    let mut items = Vec::new();
    for field in fields.iter().filter(|field| field.name != "reserved") {
        append(&mut items, field.name, field.offset, &field.shape, field);
    }
    items
}

/// Adds what `shape` at `offset` consists of, and says how many bytes of the wire type it takes.
fn append(items: &mut Vec<Item>, name: &str, offset: usize, shape: &Shape, field: &Field) -> usize {
    let item = |number, count| Item {
        name: name.to_owned(),
        number,
        count,
        offset,
        meaning: field.meaning.clone(),
        range: field.range.clone(),
        reason: field.reason,
    };
    match shape {
        Shape::Number(number) => {
            items.push(item(*number, 1));
            number.bytes()
        }
        Shape::Array(of, count) if **of == Shape::Number(Number::U8) => {
            items.push(item(Number::U8, *count));
            *count
        }
        Shape::Array(of, count) => {
            let mut end = offset;
            for place in 0..*count {
                end += append(items, &format!("{name}_{place}"), end, of, field);
            }
            end - offset
        }
        Shape::Parts(fields) => {
            let mut bytes = 0;
            for part in fields {
                let end = if part.name == "reserved" {
                    part.offset + append(&mut Vec::new(), "", 0, &part.shape, part)
                } else {
                    let name = format!("{name}_{}", part.name);
                    part.offset + append(items, &name, offset + part.offset, &part.shape, part)
                };
                bytes = bytes.max(end);
            }
            bytes
        }
    }
}
