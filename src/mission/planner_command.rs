//! A command of the user's that is started as the planner process.

use std::fmt;
use std::os::unix::fs::PermissionsExt as _;
use std::path::{Path, PathBuf};
use std::str::FromStr;

/// A program with its arguments, as one line: words separated by blanks. Quotes and backslashes work as in a shell, and
/// nothing else does: no variables, no patterns, no pipes.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct PlannerCommand {
    line: String,
    program: PathBuf,
    arguments: Vec<String>,
}

impl PlannerCommand {
    /// The program, as given.
    #[must_use]
    pub fn program(&self) -> &Path {
        &self.program
    }

    /// Its arguments.
    #[must_use]
    pub fn arguments(&self) -> &[String] {
        &self.arguments
    }

    /// Says so if the program is not there, or is no program. One without a folder is looked for as a shell does.
    ///
    /// # Errors
    /// What is needed and what is there.
    pub fn check(&self) -> Result<(), String> {
        let named = self.program.components().count() > 1;
        let candidates: Vec<PathBuf> = match std::env::var_os("PATH") {
            Some(path) if !named => {
                std::env::split_paths(&path).map(|folder| folder.join(&self.program)).collect()
            }
            _ => vec![self.program.clone()],
        };
        if candidates.iter().any(|file| is_program(file)) {
            return Ok(());
        }
        let found = if candidates.iter().any(|file| file.exists()) {
            "is no program (make it executable, or name its interpreter first)"
        } else if named {
            "does not exist"
        } else {
            "is in no folder of PATH"
        };
        Err(format!(
            "--planner-command needs a program, got {:?}: {} {found}",
            self.line,
            self.program.display()
        ))
    }
}

fn is_program(file: &Path) -> bool {
    file.metadata().is_ok_and(|metadata| metadata.is_file() && metadata.permissions().mode() & 0o111 != 0)
}

impl fmt::Display for PlannerCommand {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(&self.line)
    }
}

impl FromStr for PlannerCommand {
    type Err = String;

    fn from_str(line: &str) -> Result<Self, String> {
        let mut words = words(line)?.into_iter();
        let program = words.next().filter(|program| !program.is_empty());
        let program = program.ok_or_else(|| format!("a planner command needs a program, got {line:?}"))?;
        Ok(Self { line: line.into(), program: program.into(), arguments: words.collect() })
    }
}

/// Splits a line as a shell does.
fn words(line: &str) -> Result<Vec<String>, String> {
    let mut words = Vec::new();
    let mut word: Option<String> = None;
    let mut quote = None;
    let mut letters = line.chars();
    while let Some(letter) = letters.next() {
        match (quote, letter) {
            (Some(open), _) if letter == open => quote = None,
            (None, '\'' | '"') => {
                quote = Some(letter);
                word.get_or_insert_default();
            }
            (None | Some('"'), '\\') => {
                let next = letters.next().ok_or_else(|| format!("{line:?} ends with a backslash"))?;
                word.get_or_insert_default().push(next);
            }
            (None, _) if letter.is_whitespace() => words.extend(word.take()),
            _ => word.get_or_insert_default().push(letter),
        }
    }
    if let Some(quote) = quote {
        return Err(format!("{line:?} needs another {quote} at its end"));
    }
    words.extend(word);
    Ok(words)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_line_is_split_as_a_shell_does() {
        let split = |line: &str| {
            let command: PlannerCommand = line.parse().unwrap();
            let program = command.program().to_string_lossy().into_owned();
            [&[program], command.arguments()].concat()
        };
        assert_eq!(split("python my_planner.py"), ["python", "my_planner.py"]);
        assert_eq!(split(" ./a  b\tc "), ["./a", "b", "c"]);
        assert_eq!(split(r#"'a b' "c 'd'" e\ f "" g"h""#), ["a b", "c 'd'", "e f", "", "gh"]);
        for (line, need) in
            [("", "a program"), ("  ", "a program"), ("'' a", "a program"), ("a 'b", "another '")]
        {
            let error = line.parse::<PlannerCommand>().unwrap_err();
            assert!(error.contains(need), "{error}");
        }
    }

    #[test]
    fn a_program_that_is_not_there_is_told_from_one_that_is_none() {
        let check = |line: &str| line.parse::<PlannerCommand>().unwrap().check();
        assert_eq!(check("sh -c true"), Ok(()));
        assert!(check("no-such-program-at-all x").unwrap_err().ends_with("is in no folder of PATH"));
        assert!(check("/no/such/program").unwrap_err().ends_with("does not exist"));
        assert!(check("/etc/passwd").unwrap_err().contains("is no program"));
    }
}
