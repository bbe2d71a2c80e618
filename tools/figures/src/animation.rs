//! `hopper gif`: a mission as an animation that any page or chat shows.

use std::path::PathBuf;

use gif::{Encoder, Frame, Repeat};
use hopper::commands::journal::folder;
use hopper::files::write;
use hopper::mission::Flown;
use node::{Exit, Failure};
use report::PictureStyle;

use crate::drawing::{fonts, rendered};

/// Most bytes of the file: what chats and issue trackers take.
pub const BYTES_MAX: usize = 5_000_000;

/// Most frames; of a longer mission every so many hops are one.
const FRAMES_MAX: usize = 90;

/// Time of a frame, and of the last one, hundredths of a second.
const FRAME_CS: u16 = 14;
const LAST_FRAME_CS: u16 = 250;

/// Arguments of `hopper gif`.
#[derive(clap::Args, Clone, Debug)]
pub struct Args {
    /// Folder of the journal, or the output folder of the run.
    #[arg(value_name = "RUN")]
    run: PathBuf,
    /// File to write; an old one is replaced.
    #[arg(long, value_name = "FILE", default_value = "mission.gif", value_parser = node::output_file_of(&["gif"]))]
    out: PathBuf,
    /// Width in pixels, 120 to 1600.
    #[arg(long, default_value_t = 640, value_parser = clap::value_parser!(u16).range(120..=1600))]
    width: u16,
}

/// Writes the animation, with fewer frames if it would be too large otherwise.
///
/// # Errors
/// If the journal cannot be read, or the file not be written.
pub fn run(args: &Args) -> Result<Exit, Failure> {
    let flown = Flown::read(&folder(&args.run)?)?;
    let mut frames = FRAMES_MAX;
    loop {
        let bytes = animation(&flown, frames, args.width)?;
        if bytes.len() <= BYTES_MAX {
            write(&args.out, &bytes)?;
            return Ok(Exit::Done);
        }
        if frames <= 2 {
            let message = format!(
                "an animation needs at most {BYTES_MAX} bytes, got {} with two frames: give a smaller --width",
                bytes.len()
            );
            return Err(Failure::usage(message));
        }
        frames /= 2;
    }
}

/// The decisions that are shown of `count`: from 0 to the last, evenly, at most `frames`.
#[must_use]
pub fn shown(count: usize, frames: usize) -> Vec<usize> {
    let steps = count.min(frames.saturating_sub(1)).max(1);
    let mut at: Vec<usize> = (0..=steps).map(|step| step * count / steps).collect();
    at.dedup();
    at
}

/// The mission as GIF.
///
/// # Errors
/// If a picture cannot be drawn.
pub fn animation(flown: &Flown, frames: usize, width: u16) -> Result<Vec<u8>, Failure> {
    let fonts = fonts();
    let pictures = flown.pictures(&shown(flown.records.len(), frames), PictureStyle::Screen)?;
    let mut encoder: Option<Encoder<Vec<u8>>> = None;
    // The title may be longer or the legend have more lines later: all frames are as high as the last.
    let Some(last) = pictures.last() else { return Err(Failure::usage("a mission without a picture")) };
    let (height, _) = rendered(last, &fonts, width)?;
    let unwritten =
        |error: gif::EncodingError| Failure::run(format!("the animation cannot be written: {error}"));
    for (number, picture) in pictures.iter().enumerate() {
        let (_, mut pixels) = rendered(picture, &fonts, width)?;
        let row = usize::from(width) * 4;
        pixels.resize(row * usize::from(height), 0xff);
        let mut frame = Frame::from_rgba_speed(width, height, &mut pixels, 10);
        frame.delay = if number + 1 == pictures.len() { LAST_FRAME_CS } else { FRAME_CS };
        let encoder = match &mut encoder {
            Some(encoder) => encoder,
            none => {
                let mut begun = Encoder::new(Vec::new(), width, height, &[]).map_err(unwritten)?;
                begun.set_repeat(Repeat::Infinite).map_err(unwritten)?;
                none.insert(begun)
            }
        };
        encoder.write_frame(&frame).map_err(unwritten)?;
    }
    let encoder = encoder.ok_or_else(|| Failure::usage("a mission without a picture"))?;
    encoder.into_inner().map_err(|error| Failure::run(format!("the animation cannot be written: {error}")))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_frames_run_from_the_start_to_the_end_and_are_few_enough() {
        assert_eq!(shown(0, 90), [0]);
        assert_eq!(shown(3, 90), [0, 1, 2, 3]);
        let long = shown(100_000, 90);
        assert_eq!((long[0], long[long.len() - 1], long.len()), (0, 100_000, 90));
    }
}
