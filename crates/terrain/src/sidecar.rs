//! Small files beside a raster: `.prj`, `.aux.xml`, `.msk`.

use std::fs::File;
use std::io::Read;
use std::path::{Path, PathBuf};

use crate::TerrainError;

/// Most bytes read of a file of text.
const TEXT_BYTES_MAX: u64 = 1 << 20;

/// The file beside `path` that is called as `path` with `suffix` behind, whatever the case of its letters.
pub(crate) fn appended(path: &Path, suffix: &str) -> Option<PathBuf> {
    let mut name = path.file_name()?.to_owned();
    name.push(suffix);
    found(path, &path.with_file_name(name))
}

/// The file beside `path` that is called as `path` with another `extension`, whatever the case of its letters.
pub(crate) fn with_extension(path: &Path, extension: &str) -> Option<PathBuf> {
    let other = path.with_extension(extension);
    if other == path { None } else { found(path, &other) }
}

/// The name of a GeoTIFF that was converted from another file is the name of that with this behind.
pub const CONVERTED: &str = ".converted.tif";

/// The file that the one at `path` was converted from, if it is still there.
pub(crate) fn converted_from(path: &Path) -> Option<PathBuf> {
    let name = path.file_name()?.to_str()?.strip_suffix(CONVERTED)?;
    let source = path.with_file_name(name);
    if !name.is_empty() && source.is_file() { Some(source) } else { None }
}

fn found(path: &Path, wanted: &Path) -> Option<PathBuf> {
    if wanted.is_file() {
        return Some(wanted.into());
    }
    let folder = match path.parent() {
        Some(folder) if !folder.as_os_str().is_empty() => folder,
        _ => Path::new("."),
    };
    let name = wanted.file_name()?;
    let mut entries: Vec<PathBuf> =
        std::fs::read_dir(folder).ok()?.flatten().map(|entry| entry.path()).collect();
    // The order of a folder is that of the file system.
    entries.sort();
    entries.into_iter().find(|entry| {
        let is_called_so = entry.file_name().is_some_and(|other| other.eq_ignore_ascii_case(name));
        is_called_so && entry != path && entry.is_file()
    })
}

/// The text of the file at `path`.
pub(crate) fn text(path: &Path) -> Result<String, TerrainError> {
    let mut bytes = Vec::new();
    File::open(path)?.take(TEXT_BYTES_MAX).read_to_end(&mut bytes)?;
    Ok(decoded(&bytes))
}

/// Bytes as text: UTF-16 where its byte order mark stands in front, otherwise UTF-8 without its mark.
pub(crate) fn decoded(bytes: &[u8]) -> String {
    let utf16 = |unit: fn([u8; 2]) -> u16| {
        let units: Vec<u16> = bytes[2..].chunks_exact(2).map(|pair| unit([pair[0], pair[1]])).collect();
        String::from_utf16_lossy(&units)
    };
    match bytes {
        [0xff, 0xfe, ..] => utf16(u16::from_le_bytes),
        [0xfe, 0xff, ..] => utf16(u16::from_be_bytes),
        _ => String::from_utf8_lossy(bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes)).into_owned(),
    }
}
