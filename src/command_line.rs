//! Parses command lines: what is wrong in plain words, with the commands that a mistyped one resembles.

use std::fmt::Write as _;
use std::path::Path;

use clap::builder::StyledStr;
use clap::error::{ContextKind, ContextValue, ErrorKind};
use clap::{Command, Error, Parser};
use contract::spelling::nearest;

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
                let text =
                    if node::stderr_has_colours() { text.ansi().to_string() } else { text.to_string() };
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

/// `error` with what was meant, where clap finds nothing.
fn with_suggestions(error: Error, command: &Command, words: &[String]) -> Error {
    let (kind, invalid) = match error.kind() {
        ErrorKind::InvalidSubcommand => (ErrorKind::InvalidSubcommand, ContextKind::InvalidSubcommand),
        ErrorKind::UnknownArgument => (ErrorKind::UnknownArgument, ContextKind::InvalidArg),
        _ => return error,
    };
    let Some(ContextValue::String(got)) = error.get(invalid) else { return error };
    let got = got.clone();
    // The command that does not know it.
    let parent = words
        .iter()
        .take_while(|word| **word != got)
        .try_fold(command, |parent, word| parent.find_subcommand(word))
        .unwrap_or(command);
    match kind {
        ErrorKind::InvalidSubcommand => with_commands(error, parent, &got),
        _ => with_flag(error, parent, &got),
    }
}

/// `error` with the commands that resemble an unknown one: clap compares letters at the same place only, so to it a short
/// word with two letters exchanged resembles nothing.
fn with_commands(mut error: Error, parent: &Command, got: &str) -> Error {
    if error.get(ContextKind::SuggestedSubcommand).is_some() {
        return error;
    }
    let near = nearest(got, parent.get_subcommands().map(Command::get_name));
    if near.is_empty() {
        return with_flag(error, parent, got);
    }
    let names = near.into_iter().map(str::to_owned).collect();
    error.insert(ContextKind::SuggestedSubcommand, ContextValue::Strings(names));
    error
}

/// `error` with the flag that a scenario, a planner or a file needs before it: `hopper run hard`.
fn with_flag(mut error: Error, parent: &Command, got: &str) -> Error {
    let knows = |flag: &str| parent.get_arguments().any(|argument| argument.get_long() == Some(flag));
    let ending = Path::new(got).extension().map(|ending| ending.to_ascii_lowercase());
    let is_any_of =
        |endings: &[&str]| ending.as_ref().is_some_and(|got| endings.iter().any(|ending| got == ending));
    let first = |names: Vec<&str>| names.first().map(|name| (*name).to_owned());
    let scenario = match is_any_of(&["toml"]) {
        true => Some(got.to_owned()),
        false => first(nearest(got, scenario::BUILT_IN.map(|(name, _)| name))),
    };
    let planner = first(nearest(got, planner::ALGORITHMS.iter().copied()));
    let dem = is_any_of(&["tif", "tiff", "asc"]).then(|| got.to_owned());
    let known = [("scenario", scenario), ("dem", dem), ("planner", planner.clone()), ("algorithm", planner)];
    let meant = known.into_iter().find_map(|(flag, value)| match value {
        Some(value) if knows(flag) => Some((flag, value)),
        _ => None,
    });
    if let Some((flag, value)) = meant
        && !got.starts_with('-')
    {
        let mut tip = StyledStr::new();
        let _ = write!(
            tip,
            "a {} is given by its flag: '--{flag} {value}'",
            if flag == "dem" { "model" } else { flag }
        );
        error.insert(ContextKind::Suggested, ContextValue::StyledStrs(vec![tip]));
    }
    error
}
