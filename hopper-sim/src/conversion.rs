//! Converts an elevation model of a format that is not read, by a command of GDAL that is printed.
//!
//! GDAL opens far more than files: virtual rasters, archives and addresses of the network. So it is told which drivers may
//! open the file, it gets an absolute path of a regular file, and its drivers and handlers of remote data are switched off for
//! what a file of a plain driver may refer to.

use std::ffi::{OsStr, OsString};
use std::io::ErrorKind;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use node::Failure;
use terrain::{CONVERTED, RasterFile, TerrainError};

/// Drivers of rasters that are files by themselves, or with a header beside them.
const DRIVERS: [&str; 44] = [
    "GTiff",
    "AAIGrid",
    "BT",
    "CTG",
    "DTED",
    "EHdr",
    "ENVI",
    "FIT",
    "FITS",
    "GRASSASCIIGrid",
    "GS7BG",
    "GSAG",
    "GSBG",
    "GXF",
    "HF2",
    "HFA",
    "IDA",
    "ILWIS",
    "ISG",
    "ISIS2",
    "ISIS3",
    "JP2OpenJPEG",
    "LCP",
    "Leveller",
    "NWT_GRD",
    "netCDF",
    "PAux",
    "PCIDSK",
    "PCRaster",
    "PDS",
    "PDS4",
    "PNG",
    "PNM",
    "RMF",
    "RRASTER",
    "RST",
    "SAGA",
    "SDTS",
    "SIGDEM",
    "SRTMHGT",
    "Terragen",
    "USGSDEM",
    "VICAR",
    "XYZ",
];

/// Drivers that a file beside the model, such as its mask, could bring in, and that open other things than files.
const SKIPPED: &str = "VRT,GTI,DERIVED,WMS,WCS,WMTS,HTTP,PLMOSAIC,PLSCENES,EEDAI,EEDA,OGCAPI,STACTA,STACIT,DAAS,RDA,NGW,\
                       Zarr,MBTiles,GPKG,Rasterlite,PostGISRaster,TileDB,CAD,ERS,MRF,TIL";

/// The name of the file that says what a GeoTIFF was converted from ends so, behind that of the GeoTIFF.
const RECORD: &str = ".source";

/// The file to read for `dem`: itself if it is read as it is, or a GeoTIFF that is made of it, beside it.
///
/// # Errors
/// Exit code 2 if it is no raster of a plain format, or GDAL is not installed.
pub fn converted(dem: &Path) -> Result<PathBuf, Failure> {
    let refused = match RasterFile::open(dem) {
        Ok(_) => return Ok(dem.into()),
        Err(error) => error,
    };
    if !can_help(&refused) {
        return Err(Failure::usage(refused));
    }
    let source = dem.canonicalize().map_err(|error| Failure::usage(format!("{}: {error}", dem.display())))?;
    let target = with_ending(dem, CONVERTED);
    let record = with_ending(&target, RECORD);
    let files = files_of(&source).map_err(|error| Failure::usage(format!("{}: {error}", dem.display())))?;
    if target.exists() && std::fs::read_to_string(&record).is_ok_and(|before| before == files) {
        tracing::info!("{} was converted before: reading {}", dem.display(), target.display());
        return Ok(target);
    }
    translate(&source, &target, &refused)?;
    std::fs::write(&record, files).map_err(|error| Failure::run(format!("{}: {error}", record.display())))?;
    Ok(target)
}

/// The file at `source` and those beside it that are called like it, with size and time of each: what a conversion of it
/// depends on.
fn files_of(source: &Path) -> std::io::Result<String> {
    let folder = source.parent().unwrap_or(Path::new("/"));
    let text =
        |name: Option<&OsStr>| name.map(|name| name.to_string_lossy().to_lowercase()).unwrap_or_default();
    let (name, stem) = (text(source.file_name()), text(source.file_stem()) + ".");
    let mut lines = Vec::new();
    for entry in std::fs::read_dir(folder)? {
        let path = entry?.path();
        let other = text(path.file_name());
        let is_result = other.contains(CONVERTED);
        if (other != name && !other.starts_with(&stem)) || is_result || !path.is_file() {
            continue;
        }
        let metadata = path.metadata()?;
        let time = metadata.modified()?.duration_since(std::time::UNIX_EPOCH).unwrap_or_default();
        lines.push(format!("{other}: {} bytes, {} ns\n", metadata.len(), time.as_nanos()));
    }
    lines.sort();
    Ok(lines.concat())
}

/// Whether another format, packing or type of number is all that is wrong.
fn can_help(error: &TerrainError) -> bool {
    match error {
        TerrainError::File { source, .. } => can_help(source),
        TerrainError::Format { .. } => true,
        TerrainError::Unsupported { what, .. } => ["compression", "sample type", "predictor"].contains(what),
        _ => false,
    }
}

/// Runs the command, into a file of another name until it is whole.
fn translate(source: &Path, target: &Path, refused: &TerrainError) -> Result<(), Failure> {
    let unfinished = with_ending(target, &format!(".{}", std::process::id()));
    let is_of_type = refused.to_string().contains("sample type");
    let mut arguments: Vec<OsString> =
        ["-q", "-of", "GTiff", "-co", "COMPRESS=DEFLATE"].map(OsString::from).into();
    if is_of_type {
        arguments.extend(["-ot", "Float64"].map(OsString::from));
    }
    let shown = shown(&arguments, source, target);
    arguments.extend(DRIVERS.iter().flat_map(|driver| ["-if", driver]).map(OsString::from));
    tracing::info!("converting: {shown}");
    let output = Command::new("gdal_translate")
        .args(&arguments)
        .args(["--config", "GDAL_TIFF_INTERNAL_MASK", "YES"])
        .args([source, &unfinished])
        .env("GDAL_SKIP", SKIPPED)
        .env("CPL_VSIL_CURL_ALLOWED_EXTENSIONS", ".none")
        .env("GDAL_PYTHON_DRIVER_PATH", "DISABLED")
        .env("GDAL_DRIVER_PATH", "disable")
        .stdin(Stdio::null())
        .output();
    let output = output.map_err(|error| match error.kind() {
        ErrorKind::NotFound => Failure::usage(format!(
            "--convert needs GDAL's program gdal_translate, found none: install gdal-bin, or run elsewhere: {shown}"
        )),
        _ => Failure::run(format!("gdal_translate cannot be run: {error}")),
    })?;
    let whole = if output.status.success() { std::fs::rename(&unfinished, target).is_ok() } else { false };
    if whole {
        let [beside, before] = [&unfinished, target].map(|path| with_ending(path, ".aux.xml"));
        // That of an earlier conversion says nothing of this one.
        let _ = std::fs::remove_file(&before);
        if beside.exists() {
            std::fs::rename(&beside, &before).map_err(Failure::run)?;
        }
        return Ok(());
    }
    let _ = std::fs::remove_file(&unfinished);
    let said = String::from_utf8_lossy(&output.stderr);
    // Warnings come first.
    let is_error = |line: &&str| line.starts_with("ERROR");
    let said =
        said.lines().find(is_error).or_else(|| said.lines().next()).unwrap_or("it wrote no file").trim();
    let label = ["lbl", "LBL", "Lbl"]
        .map(|extension| source.with_extension(extension))
        .into_iter()
        .find(|file| file.is_file());
    let label = label
        .filter(|label| label != source)
        .map_or_else(String::new, |label| format!("; its label may be what to convert: {}", label.display()));
    Err(Failure::usage(format!(
        "--convert: gdal_translate cannot convert {} with its drivers of plain rasters: {said}{label}",
        source.display()
    )))
}

/// The command as it may be typed.
fn shown(arguments: &[OsString], source: &Path, target: &Path) -> String {
    let words = arguments.iter().map(OsString::as_os_str).chain([source.as_os_str(), target.as_os_str()]);
    let quoted = |word: &OsStr| {
        let text = word.to_string_lossy();
        let is_plain = text.chars().all(|c| c.is_ascii_alphanumeric() || "/._-=+,:".contains(c));
        if is_plain { text.into_owned() } else { format!("'{}'", text.replace('\'', "'\\''")) }
    };
    format!("gdal_translate {}", words.map(quoted).collect::<Vec<_>>().join(" "))
}

fn with_ending(path: &Path, ending: &str) -> PathBuf {
    let mut name = path.as_os_str().to_owned();
    name.push(ending);
    name.into()
}
