//! What the marks mean.

use contract::{Branch, Direction};

use super::raster::Raster;
use super::sheet::{Number, Sheet};
use super::{Find, Picture, arrow, colour, is_slip};

const ENTRY_WIDTH: f64 = 228.0;
const ENTRY_HEIGHT: f64 = 25.0;
const LEFT: f64 = 36.0;

/// A swatch, drawn around a point, with its words.
pub struct Entry {
    swatch: Box<dyn Fn(f64, f64) -> String>,
    words: String,
    /// What it says where several pictures share the legend.
    shared: Option<&'static str>,
}

fn entry(words: impl Into<String>, swatch: impl Fn(f64, f64) -> String + 'static) -> Entry {
    Entry { swatch: Box::new(swatch), words: words.into(), shared: None }
}

/// The start: a blue dot, as in P23.
pub fn start(x: f64, y: f64, size: f64) -> String {
    dot(x, y, size, "#1f6fe0", "#fff")
}

/// The hopper: a yellow dot, as in P23.
pub fn hopper(x: f64, y: f64, size: f64) -> String {
    dot(x, y, size, "#ffd400", "#111")
}

fn dot(x: f64, y: f64, size: f64, fill: &str, stroke: &str) -> String {
    format!(
        "<circle cx=\"{}\" cy=\"{}\" r=\"{}\" fill=\"{fill}\" stroke=\"{stroke}\" stroke-width=\"1.8\"/>",
        Number(x),
        Number(y),
        Number(size)
    )
}

/// The goal: a red star, P23's red point with a form of its own.
pub fn goal(x: f64, y: f64, size: f64) -> String {
    star(x, y, size, "fill=\"#e3000f\" stroke=\"#fff\"")
}

/// A treasure: a black star, as in P23, golden once it is collected, faint while nobody knows of it.
pub fn treasure(x: f64, y: f64, size: f64, find: Find) -> String {
    let ink = match find {
        Find::Collected => "fill=\"#ffc400\" stroke=\"#111\"",
        Find::Seen => "fill=\"#111\" stroke=\"#fff\"",
        Find::Unseen => "fill=\"#111\" stroke=\"#fff\" opacity=\".45\"",
    };
    star(x, y, size, ink)
}

fn star(x: f64, y: f64, size: f64, ink: &str) -> String {
    let points: Vec<String> = (0..10)
        .map(|n| {
            let radius = size * if n % 2 == 0 { 1.45 } else { 0.62 };
            let angle = std::f64::consts::PI * f64::from(n) / 5.0;
            format!("{} {}", Number(x + radius * angle.sin()), Number(y - radius * angle.cos()))
        })
        .collect();
    format!(
        "<polygon points=\"{}\" {ink} stroke-width=\"1.8\" stroke-linejoin=\"round\" paint-order=\"stroke\"/>",
        points.join(" ")
    )
}

/// The entries for what `picture` shows.
pub fn entries(picture: &Picture<'_>, raster: &Raster) -> Vec<Entry> {
    let mut entries = vec![
        entry("start", |x, y| start(x, y, 7.0)),
        entry("goal", |x, y| goal(x, y, 7.0)),
        match picture.sensing_radius_m {
            Some(radius_m) => {
                let entry = entry(format!("hopper, sensing {radius_m:.1} m"), hopper_sensing);
                Entry { shared: Some("hopper, disc it senses"), ..entry }
            }
            None => entry("hopper", |x, y| hopper(x, y, 6.0)),
        },
    ];
    for (find, words) in [
        (Find::Collected, "treasure, collected"),
        (Find::Seen, "treasure, seen"),
        (Find::Unseen, "treasure, not seen"),
    ] {
        if picture.treasures.iter().any(|&cell| picture.find(cell) == find) {
            entries.push(entry(words, move |x, y| treasure(x, y, 6.0, find)));
        }
    }
    let took = |wanted: fn(Branch) -> bool| picture.route.iter().any(|record| wanted(record.outcome.branch));
    if took(|branch| branch == Branch::Intended) {
        entries.push(entry("hop as intended", |x, y| stroke(x, y, colour::ROUTE, "")));
    }
    if took(is_slip) {
        entries.push(entry("stray hop", |x, y| stroke(x, y, colour::STRAY, " stroke-dasharray=\"5 8\"")));
    }
    if took(|branch| branch == Branch::Stayed) {
        entries.push(entry("stray hop, got nowhere", |x, y| dot(x, y, 6.0, "#fff", colour::STRAY)));
    }
    let any = |wanted: fn(&super::raster::Tile) -> bool| raster.tiles().iter().any(wanted);
    if any(|tile| !tile.seen) {
        entries.push(entry("not seen", unseen));
    }
    if any(|tile| tile.sand) {
        entries.push(entry("sand", |x, y| {
            patch(x, y, &colour::height(0.5), "") + &patch(x, y, colour::SAND, " fill-opacity=\".5\"")
        }));
    }
    if any(|tile| tile.blocked) {
        entries.push(entry("impassable", |x, y| {
            patch(x, y, &colour::height(0.5), "") + &patch(x, y, colour::BLOCKED, " fill-opacity=\".75\"")
        }));
    }
    if picture.policy.is_some() {
        entries.push(entry("policy N, S, E, W", compass));
    }
    entries
}

fn hopper_sensing(x: f64, y: f64) -> String {
    let ring = format!(
        "<circle cx=\"{}\" cy=\"{}\" r=\"9.5\" fill=\"none\" stroke=\"#111\" stroke-width=\"1.2\" stroke-dasharray=\"4 3\"/>",
        Number(x),
        Number(y)
    );
    ring + &hopper(x, y, 5.0)
}

fn stroke(x: f64, y: f64, colour: &str, rest: &str) -> String {
    format!(
        "<path stroke=\"{colour}\" stroke-width=\"4\" stroke-linecap=\"round\"{rest} d=\"M{} {}h24\"/>",
        Number(x - 12.0),
        Number(y)
    )
}

fn patch(x: f64, y: f64, fill: &str, rest: &str) -> String {
    format!(
        "<rect x=\"{}\" y=\"{}\" width=\"26\" height=\"15\" fill=\"{fill}\"{rest}/>",
        Number(x - 13.0),
        Number(y - 7.5)
    )
}

fn unseen(x: f64, y: f64) -> String {
    let (left, bottom) = (Number(x - 13.0), Number(y + 7.5));
    patch(x, y, "#f4f2ee", "")
        + &format!(
            "<path stroke=\"{}\" stroke-width=\".9\" d=\"M{left} {bottom}l15 -15m-7 15l15 -15m-7 15l10 -10M{left} {}l7 -7\"/>",
            colour::HATCH,
            Number(y - 0.5)
        )
}

fn compass(x: f64, y: f64) -> String {
    let order = [Direction::North, Direction::South, Direction::East, Direction::West];
    let arrows = order.into_iter().zip([-15.0, -7.0, 4.0, 18.0]).map(|(direction, shift)| {
        let (path, ink) = (arrow(direction), colour::arrow(direction));
        let (x, y) = (Number(x + shift), Number(y));
        format!("<path fill=\"{ink}\" transform=\"translate({x} {y}) scale(.26)\" d=\"M0 0{path}\"/>")
    });
    arrows.collect()
}

/// The entries of several pictures, each but once, in the order of each.
pub fn shared(pictures: Vec<Vec<Entry>>) -> Vec<Entry> {
    let mut all: Vec<Entry> = Vec::new();
    for entries in pictures {
        let mut place = 0;
        for mut entry in entries {
            entry.words = entry.shared.map_or(entry.words, str::to_owned);
            match all.iter().position(|known| known.words == entry.words) {
                Some(known) => place = known + 1,
                None => {
                    all.insert(place, entry);
                    place += 1;
                }
            }
        }
    }
    all
}

/// Height of `count` entries on a sheet of `width`.
pub fn height(count: usize, width: f64) -> f64 {
    count.div_ceil(columns(width)) as f64 * ENTRY_HEIGHT + 14.0
}

fn columns(width: f64) -> usize {
    (((width - LEFT) / ENTRY_WIDTH) as usize).max(1)
}

/// Draws `entries` from `top` downwards.
pub fn draw(sheet: &mut Sheet, entries: &[Entry], top: f64, width: f64) {
    let rows = entries.len().div_ceil(columns(width));
    for (n, Entry { swatch, words, .. }) in entries.iter().enumerate() {
        let (column, row) = (n / rows, n % rows);
        let x = LEFT + column as f64 * ENTRY_WIDTH + 24.0;
        let y = top + row as f64 * ENTRY_HEIGHT + 12.0;
        sheet.raw(&swatch(x, y));
        sheet.text(x + 30.0, y + 4.5, "", words);
    }
}
