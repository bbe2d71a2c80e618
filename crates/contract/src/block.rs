//! Blocks of numbers: the parameters of a body, a sensor or a goal in a message.

use std::fmt::Display;

use crate::codec::{CELL, Codec, Float, LENGTH, Whole, at_most};
use crate::{Cell, Refusal, Waypoint};

/// The parameters of a kind, one after another: written to a block, read from one, or described.
pub struct Block<'a> {
    task: Task<'a>,
    at: usize,
}

enum Task<'a> {
    Write(&'a mut [f64]),
    Read { prefix: &'a str, values: &'a [f64], refusal: Option<Refusal> },
    Describe(Vec<InBlock>),
}

/// A parameter in a block.
#[derive(Clone, Debug, PartialEq)]
pub struct InBlock {
    /// Its name; for a list, that of its items.
    pub name: String,
    /// Its index in the block, from 0; for a list, that of the first item.
    pub at: usize,
    /// What it is.
    pub reason: &'static str,
    /// What is accepted, in words.
    pub range: String,
}

impl<'a> Block<'a> {
    pub(crate) fn write(values: &'a mut [f64]) -> Self {
        Self { task: Task::Write(values), at: 0 }
    }

    pub(crate) fn read(prefix: &'a str, values: &'a [f64]) -> Self {
        Self { task: Task::Read { prefix, values, refusal: None }, at: 0 }
    }

    pub(crate) fn describe() -> Self {
        Self { task: Task::Describe(Vec::new()), at: 0 }
    }

    /// What was described; nothing where a block was written or read.
    pub(crate) fn described(self) -> Vec<InBlock> {
        match self.task {
            Task::Describe(parameters) => parameters,
            Task::Write(_) | Task::Read { .. } => Vec::new(),
        }
    }

    /// The first refusal, if one of the parameters is out of range, or a number after them is not 0.
    pub(crate) fn end(self) -> Result<(), Refusal> {
        let Task::Read { prefix, values, refusal } = self.task else { return Ok(()) };
        if let Some(refusal) = refusal {
            return Err(refusal);
        }
        match values[self.at..].iter().find(|value| value.to_bits() != 0) {
            None => Ok(()),
            Some(value) => Err(Refusal::malformed(prefix, "0 after the last parameter", value)),
        }
    }

    /// A number within a range.
    pub(crate) fn float(&mut self, name: &str, reason: &'static str, range: Float, value: &mut f64) {
        self.describe_as(name, reason, || Codec::<f64>::range(&range));
        self.next(name, value, |value| [*value], |field, [read]| range.from_wire(field, read));
    }

    /// A whole number within a range, small enough that a float holds it.
    pub(crate) fn whole<W>(&mut self, name: &str, reason: &'static str, range: Whole, value: &mut W)
    where
        W: Copy + Display + Into<u64> + TryFrom<u64>,
    {
        self.describe_as(name, reason, || Codec::<u64>::range(&range));
        let to_block = |value: &W| [(*value).into() as f64];
        self.next(name, value, to_block, |field, [got]| {
            let read = got as u64;
            if (read as f64).to_bits() != got.to_bits() {
                return Err(Refusal::malformed(field, &Codec::<u64>::range(&range), got));
            }
            let read = Codec::<u64>::from_wire(&range, field, read)?;
            W::try_from(read).map_err(|_| Refusal::malformed(field, "a smaller number", read))
        });
    }

    /// One of several things by its place in `all`.
    pub(crate) fn choice<T: Copy + PartialEq>(
        &mut self,
        name: &str,
        reason: &'static str,
        all: &[T],
        value: &mut T,
    ) {
        let mut place = all.iter().position(|one| one == value).unwrap_or(0) as u32;
        self.whole(name, reason, at_most(all.len() as u64 - 1), &mut place);
        *value = all[place as usize];
    }

    /// A cell (x, y).
    pub(crate) fn cell(&mut self, name: &str, reason: &'static str, value: &mut Cell) {
        self.describe_as(name, reason, || CELL.range());
        self.further_cell(name, value);
    }

    /// Another cell of a list, which is described by its first one.
    pub(crate) fn further_cell(&mut self, name: &str, value: &mut Cell) {
        let to_block = |cell: &Cell| CELL.to_wire(cell).map(f64::from);
        self.next(name, value, to_block, |field, read| {
            let cell = CELL.from_wire(field, read.map(|coordinate| coordinate as i32))?;
            if to_block(&cell) == read {
                Ok(cell)
            } else {
                Err(Refusal::malformed(field, "whole numbers", format!("({}, {})", read[0], read[1])))
            }
        });
    }

    /// A point (x, y), metres.
    pub(crate) fn point(&mut self, name: &str, reason: &'static str, value: &mut Waypoint) {
        self.float(name, reason, LENGTH, &mut value.x_m);
        self.float(&format!("{name}.y"), "Its second coordinate.", LENGTH, &mut value.y_m);
    }

    /// Refuses what follows from parameters that were read, unless it is within a range.
    pub(crate) fn holds(&mut self, name: &str, range: Float, value: f64) {
        self.accept(name, |field, _| range.from_wire(field, value).map(drop));
    }

    /// Refuses parameters that were read and do not go together.
    pub(crate) fn check(&mut self, name: &str, is_so: bool, need: &str, got: impl Display) {
        self.accept(name, |field, _| if is_so { Ok(()) } else { Err(Refusal::malformed(field, need, got)) });
    }

    fn describe_as(&mut self, name: &str, reason: &'static str, range: impl FnOnce() -> String) {
        if let Task::Describe(parameters) = &mut self.task {
            parameters.push(InBlock { name: name.into(), at: self.at, reason, range: range() });
        }
    }

    /// Writes or reads the parameter that takes the next `N` numbers.
    fn next<T, const N: usize>(
        &mut self,
        name: &str,
        value: &mut T,
        to_block: impl FnOnce(&T) -> [f64; N],
        from_block: impl FnOnce(&str, [f64; N]) -> Result<T, Refusal>,
    ) {
        let numbers = self.at..self.at + N;
        self.at = numbers.end;
        if let Task::Write(values) = &mut self.task {
            values[numbers].copy_from_slice(&to_block(value));
            return;
        }
        let read = self.accept(name, |field, values| {
            from_block(field, std::array::from_fn(|item| values[numbers.start + item]))
        });
        if let Some(read) = read {
            *value = read;
        }
    }

    /// What `read` makes of the block that is read; its refusal is kept, and then nothing more is read.
    fn accept<T>(&mut self, name: &str, read: impl FnOnce(&str, &[f64]) -> Result<T, Refusal>) -> Option<T> {
        let Task::Read { prefix, values, refusal } = &mut self.task else { return None };
        if refusal.is_some() {
            return None;
        }
        match read(&format!("{prefix}.{name}"), values) {
            Ok(read) => Some(read),
            Err(refused) => {
                *refusal = Some(refused);
                None
            }
        }
    }
}
