//! Parses command lines: what is wrong in plain words, with the commands that a mistyped one resembles.

use std::io::IsTerminal as _;

use clap::error::{ContextKind, ContextValue, ErrorKind};
use clap::{Command, Error, Parser};

/// Most edits between a mistyped command and one that is suggested: `rnu` for `run` is one exchange of neighbours.
const EDITS_MAX: usize = 2;

/// Reasons of Rust's number parsers and of the duration parser, and what they mean to whoever typed the value.
const REASONS: [(&str, &str); 7] = [
    ("invalid digit found in string", "need a whole number without sign or fraction"),
    ("cannot parse integer from empty string", "need a whole number, got nothing"),
    ("number too large to fit in target type", "the number is too large"),
    ("invalid float literal", "need a number"),
    ("cannot parse float from empty string", "need a number, got nothing"),
    ("expected number at 0", "need a duration such as 30s or 500ms"),
    ("value was empty", "need a duration such as 30s or 500ms"),
];

/// The command line of this process as `C`. If it is none, or asks for help, this prints so and ends the process.
#[must_use]
pub fn parse<C: Parser>() -> C {
    let words: Vec<String> = std::env::args_os().skip(1).map(|word| word.to_string_lossy().into()).collect();
    C::try_parse().unwrap_or_else(|error| {
        let error = with_suggestions(error, &C::command(), &words);
        match error.kind() {
            ErrorKind::ValueValidation => {
                let text = error.render();
                let colourful = std::io::stderr().is_terminal() && std::env::var_os("NO_COLOR").is_none();
                let text = if colourful { text.ansi().to_string() } else { text.to_string() };
                // Fails only if nobody reads.
                let _ = std::io::Write::write_all(&mut std::io::stderr(), in_plain_words(&text).as_bytes());
                std::process::exit(error.exit_code())
            }
            _ => error.exit(),
        }
    })
}

/// The text of an error about a value with its reason in plain words.
fn in_plain_words(text: &str) -> String {
    REASONS.iter().fold(text.to_owned(), |text, (reason, words)| text.replace(reason, words))
}

/// `error` with the commands that resemble an unknown one, where clap finds none: it compares letters at the same place
/// only, so a short word with two letters exchanged resembles nothing.
fn with_suggestions(mut error: Error, command: &Command, words: &[String]) -> Error {
    let (ErrorKind::InvalidSubcommand, None) = (error.kind(), error.get(ContextKind::SuggestedSubcommand))
    else {
        return error;
    };
    let Some(ContextValue::String(got)) = error.get(ContextKind::InvalidSubcommand) else { return error };
    let got = got.clone();
    // The command whose subcommand is unknown.
    let parent = words
        .iter()
        .take_while(|word| **word != got)
        .try_fold(command, |parent, word| parent.find_subcommand(word))
        .unwrap_or(command);
    let mut near: Vec<(usize, String)> = parent
        .get_subcommands()
        .map(|command| (edits(&got, command.get_name()), command.get_name().to_owned()))
        .filter(|(edits, name)| *edits <= EDITS_MAX && *edits < name.len().min(got.chars().count()))
        .collect();
    near.sort();
    let least = near.first().map(|(edits, _)| *edits);
    let names: Vec<_> =
        near.into_iter().filter(|(edits, _)| Some(*edits) == least).map(|(_, name)| name).collect();
    if !names.is_empty() {
        error.insert(ContextKind::SuggestedSubcommand, ContextValue::Strings(names));
    }
    error
}

/// Fewest insertions, deletions, substitutions and exchanges of neighbours that turn `a` into `b` (optimal string
/// alignment).
fn edits(a: &str, b: &str) -> usize {
    let (a, b): (Vec<char>, Vec<char>) = (a.chars().collect(), b.chars().collect());
    let mut rows = vec![vec![0; b.len() + 1]; a.len() + 1];
    for i in 0..=a.len() {
        for j in 0..=b.len() {
            if i == 0 || j == 0 {
                rows[i][j] = i + j;
                continue;
            }
            let substituted = rows[i - 1][j - 1] + usize::from(a[i - 1] != b[j - 1]);
            let mut least = substituted.min(rows[i - 1][j] + 1).min(rows[i][j - 1] + 1);
            if i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1] {
                least = least.min(rows[i - 2][j - 2] + 1);
            }
            rows[i][j] = least;
        }
    }
    rows[a.len()][b.len()]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn edits_count_an_exchange_of_neighbours_once() {
        for (a, b, need) in
            [("rnu", "run", 1), ("run", "run", 0), ("", "run", 3), ("simm", "sim", 1), ("bag", "run", 3)]
        {
            assert_eq!((edits(a, b), edits(b, a)), (need, need), "{a} {b}");
        }
    }
}
