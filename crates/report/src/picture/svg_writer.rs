//! Writes an SVG document element by element.

use std::fmt::{self, Write as _};

/// A coordinate: two decimals at most, no trailing zeros, no negative zero.
#[derive(Clone, Copy, Debug)]
pub struct Number(pub f64);

impl fmt::Display for Number {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        // Four decimals below 1: strokes in units of a tile are thin.
        let text = if self.0.abs() < 1.0 { format!("{:.4}", self.0) } else { format!("{:.2}", self.0) };
        let text = text.trim_end_matches('0').trim_end_matches('.');
        f.write_str(if text == "-0" { "0" } else { text })
    }
}

/// An SVG document under construction. Every opened element must be closed by the caller.
#[derive(Debug)]
pub struct SvgWriter {
    text: String,
    width: f64,
}

impl SvgWriter {
    /// A white document of `width` × `height` units; screen readers announce `title`.
    pub fn new(width: f64, height: f64, title: &str) -> Self {
        let size = [width, height].map(|side| Number(side.ceil()).to_string());
        Self::sized(width, height, title, &size, 12.5)
    }

    /// As [`SvgWriter::new`], `width_mm` millimetres wide on paper.
    pub fn column(width: f64, height: f64, width_mm: f64, title: &str) -> Self {
        let scale = width_mm / width.ceil();
        let size = [width, height].map(|side| format!("{}mm", Number(side.ceil() * scale)));
        Self::sized(width, height, title, &size, 15.0)
    }

    fn sized(width: f64, height: f64, title: &str, size: &[String; 2], font_size: f64) -> Self {
        let sheet_width = width.ceil();
        let [shown_width, shown_height] = size;
        let (width, height) = (Number(sheet_width), Number(height.ceil()));
        let mut text = format!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{shown_width}\" height=\"{shown_height}\" \
             viewBox=\"0 0 {width} {height}\" role=\"img\" font-family=\"DejaVu Sans, Verdana, Helvetica, sans-serif\" \
             font-size=\"{}\" fill=\"#222\">\n",
            Number(font_size)
        );
        let _ = writeln!(text, "<title>{}</title>", escaped(title));
        let _ = writeln!(text, "<rect width=\"{width}\" height=\"{height}\" fill=\"#fff\"/>");
        Self { text, width: sheet_width }
    }

    /// `attributes` may be empty.
    pub fn open(&mut self, name: &str, attributes: &str) {
        let space = if attributes.is_empty() { "" } else { " " };
        let _ = writeln!(self.text, "<{name}{space}{attributes}>");
    }

    /// Nothing checks that it is the element opened last.
    pub fn close(&mut self, name: &str) {
        let _ = writeln!(self.text, "</{name}>");
    }

    /// Adds a complete element, which must be well-formed.
    pub fn raw(&mut self, element: &str) {
        self.text.push_str(element);
        self.text.push('\n');
    }

    /// Adds the outline of a rectangle.
    pub fn outline(&mut self, left: f64, top: f64, width: f64, height: f64) {
        let (x, y, width, height) = (Number(left), Number(top), Number(width), Number(height));
        let rect = format!("<rect x=\"{x}\" y=\"{y}\" width=\"{width}\" height=\"{height}\"");
        self.raw(&format!("{rect} fill=\"none\" stroke=\"#333\"/>"));
    }

    /// Adds a path unless it is empty.
    pub fn path(&mut self, path: &str, attributes: &str) {
        if !path.is_empty() {
            let _ = writeln!(self.text, "<path {attributes} d=\"{path}\"/>");
        }
    }

    /// Adds a line of text with its baseline at (x, y).
    pub fn text(&mut self, x: f64, y: f64, attributes: &str, words: &str) {
        let space = if attributes.is_empty() { "" } else { " " };
        let _ = writeln!(
            self.text,
            "<text x=\"{}\" y=\"{}\"{space}{attributes}>{}</text>",
            Number(x),
            Number(y),
            escaped(words)
        );
    }

    /// Adds a line of text from (x, y) in font size `size`, or smaller if the document is too narrow.
    pub fn heading(&mut self, x: f64, y: f64, size: f64, attributes: &str, words: &str) {
        // Bold letters of the fonts in use are on average two thirds as wide as high.
        let fitting = (self.width - x) * 1.45 / words.chars().count().max(1) as f64;
        self.text(x, y, &format!("font-size=\"{}\" {attributes}", Number(size.min(fitting))), words);
    }

    /// Adds a line of text that runs upwards, centred at (x, y).
    pub fn text_upwards(&mut self, x: f64, y: f64, words: &str) {
        let (x, y) = (Number(x), Number(y));
        let _ = writeln!(
            self.text,
            "<text x=\"{x}\" y=\"{y}\" text-anchor=\"middle\" font-size=\"14\" transform=\"rotate(-90 {x} {y})\">{}</text>",
            escaped(words)
        );
    }

    /// Closes the document and returns its text.
    pub fn finish(mut self) -> String {
        self.text.push_str("</svg>\n");
        self.text
    }
}

/// Escapes text for XML; characters that XML forbids are left out.
pub(crate) fn escaped(words: &str) -> String {
    let mut text = String::with_capacity(words.len());
    for character in words.chars().filter(|c| !c.is_control() && !matches!(c, '\u{fffe}' | '\u{ffff}')) {
        match character {
            '&' => text.push_str("&amp;"),
            '<' => text.push_str("&lt;"),
            '>' => text.push_str("&gt;"),
            '"' => text.push_str("&quot;"),
            _ => text.push(character),
        }
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_as_short_as_they_can_be() {
        for (value, need) in [
            (0.0, "0"),
            (-0.00001, "0"),
            (38.0, "38"),
            (1.5, "1.5"),
            (-2.345_6, "-2.35"),
            (0.031_28, "0.0313"),
            (100.0, "100"),
        ] {
            assert_eq!(Number(value).to_string(), need);
        }
    }
}
