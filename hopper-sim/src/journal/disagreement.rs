//! Where a journal's header is not what it must be.

use std::fmt::Debug;

use super::JournalError;

/// The first field that differs.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Disagreement {
    /// Path of the field, such as `brief.motion.gravity_mps2`.
    pub field: String,
    /// What it needs to be.
    pub need: String,
    /// What it is.
    pub got: String,
}

impl From<Disagreement> for JournalError {
    fn from(Disagreement { field, need, got }: Disagreement) -> Self {
        JournalError::Mismatch { field: field.into(), need, got }
    }
}

/// Compares what is called `field` of two headers. The error names the first field in it that differs.
pub(super) fn agree<T: Debug>(field: &str, need: &T, got: &T) -> Result<(), Disagreement> {
    // The bits of a number show in its text, and each line of the text is a field.
    let (need, got) = (format!("{need:#?}"), format!("{got:#?}"));
    let mut path = Path::default();
    for (need, got) in need.lines().zip(got.lines()) {
        path.enter(need);
        if need != got {
            return Err(Disagreement { field: path.below(field), need: value(need), got: value(got) });
        }
    }
    Ok(())
}

/// Where a line of a pretty-printed value stands.
#[derive(Default)]
struct Path {
    /// One for each depth, from the value itself on.
    fields: Vec<Field>,
}

#[derive(Default)]
struct Field {
    /// Name, or number in a list; empty of what has none, such as what `Some` holds.
    name: String,
    is_list: bool,
    /// Elements so far.
    elements: usize,
}

impl Path {
    fn enter(&mut self, line: &str) {
        let text = line.trim_start();
        let depth = (line.len() - text.len()) / 4;
        if text.starts_with(['}', ')', ']']) {
            return self.fields.truncate(depth + 1);
        }
        self.fields.truncate(depth);
        let name = match (text.split_once(": "), self.fields.last_mut()) {
            (Some((name, _)), _) => name.to_owned(),
            (None, Some(list)) if list.is_list => {
                list.elements += 1;
                (list.elements - 1).to_string()
            }
            (None, _) => String::new(),
        };
        self.fields.push(Field { name, is_list: text.ends_with('['), elements: 0 });
    }

    /// The path of the line below `field`.
    fn below(&self, field: &str) -> String {
        let names = self.fields.iter().map(|field| field.name.as_str());
        let path = std::iter::once(field).chain(names).filter(|name| !name.is_empty());
        path.collect::<Vec<_>>().join(".")
    }
}

/// The value in a line of a pretty-printed one.
fn value(line: &str) -> String {
    let text = line.trim().split_once(": ").map_or(line.trim(), |(_, value)| value);
    match text.trim_end_matches(['{', '(', '[', '}', ')', ']', ',', ' ']) {
        "" if text.starts_with("[]") => "none".into(),
        "" if text == "[" => "some".into(),
        "" => "no more".into(),
        text => text.to_owned(),
    }
}

#[cfg(test)]
mod tests {
    use contract::{Cell, Range};

    use super::*;

    #[derive(Debug)]
    #[allow(dead_code, reason = "compared by its text")]
    struct Compared {
        cells: Vec<Cell>,
        range: Option<Range>,
        scale: f64,
    }

    #[test]
    fn the_first_field_that_differs_is_named_with_both_values() {
        let compared = |x, max, scale| Compared {
            cells: vec![Cell::new(1, 2), Cell::new(x, 4)],
            range: Some(Range { min: 0.0, max }),
            scale,
        };
        let base = compared(3, 1.0, 2.0);
        for (other, told) in [
            (compared(3, 1.0, 2.0), None),
            (compared(5, 1.0, 2.0), Some(("brief.cells.1.x", "3", "5"))),
            (compared(3, 1.5, 7.0), Some(("brief.range.max", "1.0", "1.5"))),
            (compared(3, 1.0, -2.0), Some(("brief.scale", "2.0", "-2.0"))),
            (Compared { range: None, ..compared(3, 1.0, 2.0) }, Some(("brief.range", "Some", "None"))),
        ] {
            let got = agree("brief", &base, &other).err();
            let got = got.as_ref().map(|got| (got.field.as_str(), got.need.as_str(), got.got.as_str()));
            assert_eq!(got, told);
        }
        let longer = Compared { cells: vec![Cell::new(1, 2)], ..compared(3, 1.0, 2.0) };
        let got = agree("brief", &longer, &base).unwrap_err();
        assert_eq!(
            (got.field.as_str(), got.need.as_str(), got.got.as_str()),
            ("brief.cells", "no more", "Cell")
        );
        assert_eq!(agree("faults", &Some(1), &None).unwrap_err().field, "faults");
    }
}
