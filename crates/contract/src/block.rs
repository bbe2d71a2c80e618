//! Blocks of numbers: the parameters of a body, a sensor or a goal in the message that has room for any of them.

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
    /// Its name; of a list, of its first item.
    pub name: String,
    /// The number of the block, from 0, that holds it, or its first item.
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
        let at = self.next();
        match &mut self.task {
            Task::Write(values) => values[at] = *value,
            Task::Read { prefix, values, refusal } if refusal.is_none() => {
                match range.from_wire(&format!("{prefix}.{name}"), values[at]) {
                    Ok(read) => *value = read,
                    Err(refused) => *refusal = Some(refused),
                }
            }
            Task::Read { .. } => {}
            Task::Describe(parameters) => {
                parameters.push(InBlock {
                    name: name.into(),
                    at,
                    reason,
                    range: Codec::<f64>::range(&range),
                });
            }
        }
    }

    /// A whole number within a range, small enough that a float holds it.
    pub(crate) fn whole<W>(&mut self, name: &str, reason: &'static str, range: Whole, value: &mut W)
    where
        W: Copy + Display + Into<u64> + TryFrom<u64>,
    {
        let at = self.next();
        match &mut self.task {
            Task::Write(values) => values[at] = (*value).into() as f64,
            Task::Read { prefix, values, refusal } if refusal.is_none() => {
                let read = values[at] as u64;
                let field = format!("{prefix}.{name}");
                if (read as f64).to_bits() != values[at].to_bits() {
                    *refusal = Some(Refusal::malformed(&field, &Codec::<u64>::range(&range), values[at]));
                    return;
                }
                let narrow = Codec::<u64>::from_wire(&range, &field, read).and_then(|read| {
                    W::try_from(read).map_err(|_| Refusal::malformed(&field, "a smaller number", read))
                });
                match narrow {
                    Ok(read) => *value = read,
                    Err(refused) => *refusal = Some(refused),
                }
            }
            Task::Read { .. } => {}
            Task::Describe(parameters) => {
                parameters.push(InBlock {
                    name: name.into(),
                    at,
                    reason,
                    range: Codec::<u64>::range(&range),
                });
            }
        }
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
        if let Task::Describe(parameters) = &mut self.task {
            parameters.push(InBlock { name: name.into(), at: self.at, reason, range: CELL.range() });
        }
        self.further_cell(name, value);
    }

    /// Another cell of a list, which is described by its first one.
    pub(crate) fn further_cell(&mut self, name: &str, value: &mut Cell) {
        let at = self.next();
        self.next();
        match &mut self.task {
            Task::Write(values) => [values[at], values[at + 1]] = CELL.to_wire(value).map(f64::from),
            Task::Read { prefix, values, refusal } if refusal.is_none() => {
                let read = [values[at], values[at + 1]];
                let cell = read.map(|coordinate| coordinate as i32);
                let field = format!("{prefix}.{name}");
                match CELL.from_wire(&field, cell) {
                    Ok(cell) if [f64::from(cell.x), f64::from(cell.y)] == read => *value = cell,
                    Ok(_) => {
                        let got = format!("({}, {})", read[0], read[1]);
                        *refusal = Some(Refusal::malformed(&field, "whole numbers", got));
                    }
                    Err(refused) => *refusal = Some(refused),
                }
            }
            Task::Read { .. } | Task::Describe(_) => {}
        }
    }

    /// A point (x, y), metres.
    pub(crate) fn point(&mut self, name: &str, reason: &'static str, value: &mut Waypoint) {
        self.float(name, reason, LENGTH, &mut value.x_m);
        self.float(&format!("{name}.y"), "Its second coordinate.", LENGTH, &mut value.y_m);
    }

    /// Refuses what follows from parameters that were read, unless it is within a range.
    pub(crate) fn holds(&mut self, name: &str, range: Float, value: f64) {
        let is_so = range.from_wire(name, value).is_ok();
        self.check(name, is_so, &Codec::<f64>::range(&range), value);
    }

    /// Refuses parameters that were read and do not go together.
    pub(crate) fn check(&mut self, name: &str, is_so: bool, need: &str, got: impl Display) {
        if let Task::Read { prefix, refusal, .. } = &mut self.task
            && refusal.is_none()
            && !is_so
        {
            *refusal = Some(Refusal::malformed(&format!("{prefix}.{name}"), need, got));
        }
    }

    fn next(&mut self) -> usize {
        let at = self.at;
        self.at += 1;
        at
    }
}
