//! Formats text tables.

/// Lines of a table with `headings` over `rows`, columns two spaces apart, each line ended.
///
/// Columns of numbers (cells that begin with a digit, a sign or a point, with or without unit) are aligned right,
/// others left. Empty cells do not affect the alignment.
///
/// ```
/// let rows = [["plan", "12.5"], ["commit", "3.0"]].map(|row| row.map(String::from));
/// assert_eq!(report::table(["stage", "ms"], &rows), "stage     ms\nplan    12.5\ncommit   3.0\n");
/// ```
#[must_use]
pub fn table<const COLUMNS: usize>(headings: [&str; COLUMNS], rows: &[[String; COLUMNS]]) -> String {
    let columns: [Column; COLUMNS] =
        std::array::from_fn(|c| Column::of(headings[c], rows.iter().map(|row| &row[c])));
    let mut lines = String::new();
    let mut line = |cells: [&str; COLUMNS]| {
        let set: Vec<String> = cells.iter().zip(&columns).map(|(cell, column)| column.set(cell)).collect();
        lines.push_str(set.join("  ").trim_end());
        lines.push('\n');
    };
    line(headings);
    for row in rows {
        line(std::array::from_fn(|c| row[c].as_str()));
    }
    lines
}

struct Column {
    width: usize,
    right: bool,
}

impl Column {
    fn of<'a>(heading: &str, cells: impl Iterator<Item = &'a String> + Clone) -> Self {
        let width = cells.clone().map(|cell| cell.chars().count()).chain([heading.chars().count()]).max();
        let mut filled = cells.filter(|cell| !cell.is_empty()).peekable();
        Self {
            width: width.unwrap_or(0),
            right: filled.peek().is_some() && filled.all(|cell| is_number(cell)),
        }
    }

    fn set(&self, cell: &str) -> String {
        let width = self.width;
        if self.right { format!("{cell:>width$}") } else { format!("{cell:<width$}") }
    }
}

fn is_number(cell: &str) -> bool {
    cell.trim_start_matches(['+', '-', '−', '.', '<']).starts_with(|first: char| first.is_ascii_digit())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_stand_right_and_words_left() {
        let rows =
            [["a", "1.0", "x"], ["long", "-10.25", ""], ["b", "", "yy"]].map(|row| row.map(String::from));
        assert_eq!(
            table(["name", "value", "note"], &rows),
            "name   value  note\na        1.0  x\nlong  -10.25\nb             yy\n"
        );
    }

    #[test]
    fn a_table_without_rows_is_its_headings() {
        assert_eq!(table(["one", "two"], &[]), "one  two\n");
    }
}
