//! Functions fit a screen, or say why not.

use super::{EVERYWHERE, read, root, sources};

/// Lines of a function, from `fn` to its closing brace, that need no reason.
const LINES_MAX: usize = 70;

/// What a comment above a longer function begins with.
const REASON: &str = "// Long: ";

#[test]
fn no_function_is_longer_than_a_screen_without_a_reason() {
    let mut long = Vec::new();
    for file in EVERYWHERE.iter().flat_map(sources) {
        let generated = file.starts_with(root().join("crates/recording/proto"));
        let text = if generated { String::new() } else { read(&file) };
        let lines: Vec<&str> = text.lines().collect();
        for (at, line) in lines.iter().enumerate() {
            if !is_function(line) {
                continue;
            }
            // As it is formatted, only the closing brace stands as far left as the function itself.
            let indent = &line[..line.len() - line.trim_start().len()];
            let close = format!("{indent}}}");
            let body = lines[at..].iter().position(|line| line.ends_with(['{', ';', '}'])).unwrap_or(0);
            if !lines[at + body].ends_with('{') {
                continue;
            }
            let count = 1 + lines[at..].iter().position(|line| *line == close).unwrap_or(0);
            let above = lines[..at].iter().rev().take_while(|line| {
                line.trim_start().starts_with("//") || line.trim_start().starts_with("#[")
            });
            if count > LINES_MAX && !above.into_iter().any(|line| line.trim_start().starts_with(REASON)) {
                long.push(format!("{}:{}: {count} lines", file.display(), at + 1));
            }
        }
    }
    assert!(
        long.is_empty(),
        "more than {LINES_MAX} lines; split it, or give the reason in a comment `{REASON}…` above:\n{}",
        long.join("\n")
    );
}

fn is_function(line: &str) -> bool {
    let mut words = line.split_whitespace().skip_while(|word| {
        word.starts_with("pub") || ["const", "async", "unsafe", "extern", "\"C\"", "in"].contains(word)
    });
    words.next() == Some("fn")
}
