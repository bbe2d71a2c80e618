//! Formats Markdown tables.

/// A table with `headings` over `rows`, followed by an empty line.
#[must_use]
pub fn table<const COLUMNS: usize>(headings: [&str; COLUMNS], rows: &[[String; COLUMNS]]) -> String {
    let line = |cells: &[String]| format!("| {} |\n", cells.join(" | ").replace('\n', " "));
    let mut text = line(&headings.map(String::from));
    text += &format!("|{}\n", "---|".repeat(COLUMNS));
    for row in rows {
        text += &line(&row.clone().map(|cell| cell.replace('|', "\\|")));
    }
    text + "\n"
}
