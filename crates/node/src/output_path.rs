//! Paths that a command is asked to write to, as its command line takes them.

use std::ffi::OsString;
use std::path::PathBuf;

use clap::builder::{OsStringValueParser, TypedValueParser};

/// Parses a file or a folder to write. It refuses an empty path, and `-`: what goes to standard output goes there
/// without being asked, and files do not.
#[must_use]
pub fn output_path() -> impl TypedValueParser<Value = PathBuf> {
    OsStringValueParser::new().try_map(path)
}

/// Parses a file to write in one of the formats that `endings` name; a name without an ending is taken as it is.
#[must_use]
pub fn output_file_of(endings: &'static [&'static str]) -> impl TypedValueParser<Value = PathBuf> {
    OsStringValueParser::new().try_map(move |text| file_of(text, endings))
}

fn path(text: OsString) -> Result<PathBuf, String> {
    if text.is_empty() {
        return Err("need a path, got nothing".into());
    }
    if text == "-" {
        return Err("need a path, got standard output; a file of that name is ./-".into());
    }
    Ok(text.into())
}

fn file_of(text: OsString, endings: &[&str]) -> Result<PathBuf, String> {
    let path = path(text)?;
    let Some(got) = path.extension().map(|ending| ending.to_string_lossy().to_lowercase()) else {
        return Ok(path);
    };
    if endings.contains(&got.as_str()) {
        return Ok(path);
    }
    let need = endings.iter().map(|ending| format!(".{ending}")).collect::<Vec<_>>().join(" or ");
    Err(format!("need a name that ends in {need}, the formats it is written in, got .{got}"))
}

#[cfg(test)]
mod tests {
    use std::os::unix::ffi::OsStringExt as _;

    use super::*;

    #[test]
    fn a_path_is_taken_whatever_its_bytes_and_standard_output_is_refused() {
        let odd = OsString::from_vec(b"out-\xff".to_vec());
        assert_eq!(path(odd.clone()), Ok(odd.into()));
        assert_eq!(path("./-".into()), Ok("./-".into()));
        for refused in ["", "-"] {
            assert!(path(refused.into()).unwrap_err().starts_with("need a path"), "{refused:?}");
        }
    }

    #[test]
    fn a_file_is_refused_whose_name_promises_another_format() {
        let file = |name: OsString| file_of(name, &["svg", "pdf"]);
        for taken in ["a.svg", "A.SVG", "a.Pdf", "a", "/dev/null", ".svg"] {
            assert_eq!(file(taken.into()), Ok(taken.into()));
        }
        for refused in ["a.png", "a.jpg", "a.svg.JPEG", "a.gif"] {
            assert!(file(refused.into()).unwrap_err().contains(".svg or .pdf"), "{refused}");
        }
        assert!(file("-".into()).is_err() && file("".into()).is_err());
    }
}
