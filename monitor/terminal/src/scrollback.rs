//! What stays on the terminal after the view is gone.

use std::io::{self, Write};

use ratatui::backend::IntoCrossterm;
use ratatui::buffer::Buffer;
use ratatui::crossterm::queue;
use ratatui::crossterm::style::{Color, Print, ResetColor, SetBackgroundColor, SetForegroundColor};

/// Writes a picture as lines, without its last one, which names keys.
///
/// # Errors
/// If the terminal is gone.
pub fn leave_behind(picture: &Buffer, out: &mut impl Write) -> io::Result<()> {
    let area = picture.area;
    for y in area.top()..area.bottom().saturating_sub(1) {
        let mut colours: Option<(Color, Color)> = None;
        for x in area.left()..area.right() {
            let cell = &picture[(x, y)];
            let own: (Color, Color) = (cell.fg.into_crossterm(), cell.bg.into_crossterm());
            if colours != Some(own) {
                queue!(out, SetForegroundColor(own.0), SetBackgroundColor(own.1))?;
                colours = Some(own);
            }
            queue!(out, Print(cell.symbol()))?;
        }
        queue!(out, ResetColor, Print("\n"))?;
    }
    out.flush()
}
