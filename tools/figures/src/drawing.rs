//! SVG turned into PDF and pixels.

use std::io::{self, Read as _, Write as _};
use std::sync::Arc;

use node::{Exit, Failure};
use resvg::tiny_skia::{Pixmap, Transform};
use resvg::usvg::{Options, Tree, fontdb};
use svg2pdf::{ConversionOptions, PageOptions};

/// Reads a picture as SVG from standard input and writes it as PDF to standard output.
///
/// # Errors
/// If it is no SVG, or a stream is gone.
pub fn pdf() -> Result<Exit, Failure> {
    let mut picture = String::new();
    io::stdin().read_to_string(&mut picture).map_err(Failure::run)?;
    let tree = parsed(&picture, &fonts())?;
    let pdf = svg2pdf::to_pdf(&tree, ConversionOptions::default(), PageOptions::default())
        .map_err(|error| Failure::run(format!("the picture cannot be written as PDF: {error}")))?;
    io::stdout().write_all(&pdf).map_err(Failure::run)?;
    Ok(Exit::Done)
}

/// The fonts of this system: pictures name DejaVu Sans and what resembles it.
#[must_use]
pub fn fonts() -> Arc<fontdb::Database> {
    let mut fonts = fontdb::Database::new();
    fonts.load_system_fonts();
    Arc::new(fonts)
}

/// The picture, parsed.
///
/// # Errors
/// If it is not SVG.
pub fn parsed(svg: &str, fonts: &Arc<fontdb::Database>) -> Result<Tree, Failure> {
    let options = Options { fontdb: Arc::clone(fonts), ..Options::default() };
    Tree::from_str(svg, &options).map_err(|error| Failure::run(format!("the picture is no SVG: {error}")))
}

/// The picture in `width` pixels, red, green, blue and alpha in turn, with its height.
///
/// # Errors
/// If it is not SVG, or the size is none.
pub fn rendered(svg: &str, fonts: &Arc<fontdb::Database>, width: u16) -> Result<(u16, Vec<u8>), Failure> {
    let tree = parsed(svg, fonts)?;
    let scale = f32::from(width) / tree.size().width();
    let height = (tree.size().height() * scale).ceil().clamp(1.0, f32::from(u16::MAX)) as u16;
    let mut pixels = Pixmap::new(u32::from(width), u32::from(height))
        .ok_or_else(|| Failure::run(format!("a picture of {width} x {height} pixels cannot be made")))?;
    resvg::render(&tree, Transform::from_scale(scale, scale), &mut pixels.as_mut());
    Ok((height, pixels.take()))
}
