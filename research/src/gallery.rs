//! `hopper gallery`: the papers' figures in our own hand, the same bytes each time.
//!
//! A figure is a function of nothing but its name: built-in scenarios, one seed, the reading
//! `paper-2023`; or built-in campaigns of studies; or measurements that are kept with the sources. `docs/gallery.md` shows
//! them all.

pub mod anytime;
mod flight;
mod known;
mod missions;
mod page;
mod steps;
mod teams;

use std::path::{Path, PathBuf};

use hopper_sim::private_file::{self, FileError};
use node::{Exit, Failure};
use rayon::prelude::*;

/// Seed of every mission that is drawn; the first there is.
pub const SEED: u64 = 1;

/// Arguments of `hopper gallery`.
#[derive(clap::Args, Clone, Debug)]
pub struct Args {
    /// Folder for the figures; the page that shows them lies beside it, under the same name and `.md`.
    #[arg(long, value_name = "DIR", default_value = "docs/gallery", value_parser = node::output_path())]
    out: PathBuf,
}

/// A figure with what the page says about it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Figure {
    /// Name of its file, without `.svg`.
    pub name: String,
    /// What it shows, in a line; the page's heading over it.
    pub title: String,
    /// What it shows and where the paper has it, in Markdown.
    pub text: String,
    /// The figure itself, an SVG document.
    pub svg: String,
}

/// Draws some of the figures.
type Draw = Box<dyn Fn() -> Result<Vec<Figure>, Failure> + Send + Sync>;

/// Draws all figures and writes them with the page that shows them.
///
/// # Errors
/// If the folder cannot be written.
pub fn run(args: &Args) -> Result<Exit, Failure> {
    let figures: Vec<Vec<Figure>> = all().into_par_iter().map(|draw| draw()).collect::<Result<_, _>>()?;
    let figures: Vec<Figure> = figures.into_iter().flatten().collect();
    let at = |path: &Path, error: std::io::Error| {
        Failure::usage(format!("--out: {} cannot be written: {error}", path.display()))
    };
    std::fs::create_dir_all(&args.out).map_err(|error| at(&args.out, error))?;
    let folder = args.out.file_name().unwrap_or_default().to_string_lossy();
    let page = (args.out.with_extension("md"), page::page(&figures, &folder));
    let files =
        figures.iter().map(|figure| (args.out.join(&figure.name).with_extension("svg"), figure.svg.clone()));
    for (path, text) in files.chain([page]) {
        private_file::write_shared(&path, &text).map_err(|error| match error {
            FileError::Io { path, source, .. } => at(&path, source),
            refused => Failure::usage(refused),
        })?;
    }
    let (folder, page) = (args.out.display(), args.out.with_extension("md"));
    tracing::info!(
        "wrote {} figures to {folder}, and the page that shows them to {}",
        figures.len(),
        page.display()
    );
    Ok(Exit::Done)
}

/// Every figure, in the order of the page.
fn all() -> Vec<Draw> {
    let mut draws: Vec<Draw> = Vec::new();
    for world in missions::WORLDS {
        draws.push(Box::new(move || Ok(vec![missions::states(world)?, missions::weights(world)?])));
    }
    draws.push(Box::new(|| Ok(vec![steps::small()?, steps::large()?])));
    draws.push(Box::new(known::figures));
    draws.push(Box::new(teams::monte_carlo));
    draws.push(Box::new(teams::single));
    draws.push(Box::new(teams::large));
    draws.push(Box::new(teams::values));
    draws.push(Box::new(|| Ok(vec![anytime::figure()?])));
    draws.push(Box::new(teams::coverage));
    draws
}

/// The figure `name` alone, if there is one whose drawing takes no more than seconds.
///
/// # Errors
/// If it cannot be drawn.
pub fn figure(name: &str) -> Option<Result<Figure, Failure>> {
    match name {
        "anytime" => return Some(anytime::figure()),
        "p21-fig-18" => return Some(Ok(teams::value(true))),
        "p21-fig-19" => return Some(Ok(teams::value(false))),
        "p21-fig-14" | "p21-fig-15" => {
            let wanted = |figures: Vec<Figure>| figures.into_iter().find(|figure| figure.name == name);
            return teams::single().map(wanted).transpose();
        }
        _ => {}
    }
    let (kind, world) = name.split_once('-')?;
    let world = missions::WORLDS.iter().find(|known| known.scenario == world)?;
    match kind {
        "states" => Some(missions::states(world)),
        "weights" => Some(missions::weights(world)),
        _ => None,
    }
}
