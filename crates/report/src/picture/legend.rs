//! The legend of a picture.

use contract::{Branch, Detail, Direction};

use super::mission::{Picture, is_slip};
use super::quiver::arrow;
use super::svg_writer::{Number, SvgWriter};
use super::symbols::{TreasureState, dot, goal, hopper, impact, start, treasure};
use super::tile_map::{Tile, TileMap};
use crate::colour;
use crate::way;

const ENTRY_WIDTH: f64 = 228.0;
const ENTRY_HEIGHT: f64 = 25.0;
const LEFT: f64 = 36.0;

/// A legend entry: a sample drawn around a point, and its text.
pub struct Entry {
    swatch: Box<dyn Fn(f64, f64) -> String>,
    words: String,
    /// Text to use instead if several pictures share the legend.
    shared: Option<&'static str>,
}

fn entry(words: impl Into<String>, swatch: impl Fn(f64, f64) -> String + 'static) -> Entry {
    Entry { swatch: Box::new(swatch), words: words.into(), shared: None }
}

/// The entries for the elements that `picture` shows.
pub fn entries(picture: &Picture<'_>, tiles: &TileMap) -> Vec<Entry> {
    if !picture.is_of_hopper() {
        return team_entries(picture, tiles);
    }
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
    for (treasure_state, words) in [
        (TreasureState::Collected, "treasure, collected"),
        (TreasureState::Seen, "treasure, seen"),
        (TreasureState::Unseen, "treasure, not seen"),
    ] {
        if picture.treasures.iter().any(|&cell| picture.treasure_state(cell) == treasure_state) {
            entries.push(entry(words, move |x, y| treasure(x, y, 6.0, treasure_state)));
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
    let ways = picture.route.iter().filter_map(|record| picture.detail(record));
    let ways: Vec<&Detail> = ways.collect();
    if ways.iter().any(|detail| way::impacts(detail).next().is_some()) {
        entries.push(entry("impact", |x, y| {
            let (diamond, rim) = (impact(x, y, 5.0), colour::DARK);
            format!("<path fill=\"{}\" stroke=\"{rim}\" d=\"{diamond}\"/>", colour::IMPACT)
        }));
    }
    if ways.iter().any(|detail| way::stretches(detail).iter().any(|way| way.launch_mps.is_none())) {
        entries.push(entry("rolled", |x, y| stroke(x, y, colour::ROLLED, "")));
    }
    entries.extend(robot_entries(picture).skip(1));
    entries.extend(ground_entries(tiles));
    if picture.policy.is_some() {
        entries.push(entry("policy N, S, E, W", compass));
    }
    entries
}

/// The entries of a picture of several robots.
fn team_entries(picture: &Picture<'_>, tiles: &TileMap) -> Vec<Entry> {
    if !picture.speeds.is_empty() {
        return entries_on_uncertain_ground(picture, tiles);
    }
    let robots = (0..picture.brief.robots.count()).map(|robot| robot_entry(robot, "robot"));
    let visited = entry("visited, darker the more often", |x, y| {
        patch(x, y, &colour::height(0.5), "") + &patch(x, y, colour::ROUTE, " fill-opacity=\".4\"")
    });
    robots.chain([visited]).chain(ground_entries(tiles)).collect()
}

/// The entries where the ground is uncertain.
fn entries_on_uncertain_ground(picture: &Picture<'_>, tiles: &TileMap) -> Vec<Entry> {
    let mut entries = vec![entry("start", |x, y| start(x, y, 7.0)), entry("goal", |x, y| goal(x, y, 7.0))];
    entries.extend(robot_entries(picture));
    entries.push(entry("travelled", |x, y| stroke(x, y, "#111", "")));
    entries.push(entry("announced", |x, y| stroke(x, y, "#111", " stroke-dasharray=\"5 7\"")));
    if picture.brief.robots.iter().any(|robot| robot.sensor.view_m().is_some()) {
        entries.push(entry("field of view", |x, y| dot(x, y, 8.0, "none", &colour::robot(1))));
    }
    if tiles.tiles().iter().any(|tile| !tile.seen) {
        entries.push(entry("not seen, as expected before", unseen));
    }
    entries
}

/// An entry a robot, in the order of their numbers.
fn robot_entries(picture: &Picture<'_>) -> impl Iterator<Item = Entry> {
    let robots = picture.brief.robots.numbered();
    robots.map(|(number, robot)| robot_entry(number.0, robot.body.word()))
}

fn robot_entry(robot: u16, noun: &str) -> Entry {
    entry(format!("{noun} {robot}"), move |x, y| dot(x, y, 7.0, &colour::robot(robot), "#111"))
}

/// The entries for the ground that is shown.
fn ground_entries(tiles: &TileMap) -> Vec<Entry> {
    let any = |wanted: fn(&Tile) -> bool| tiles.tiles().iter().any(wanted);
    let mut entries = Vec::new();
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

/// The entries of several pictures without repetition, in an order that fits all of them.
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

/// Height of `count` entries in a document of `width`.
pub fn height(count: usize, width: f64) -> f64 {
    count.div_ceil(columns(width)) as f64 * ENTRY_HEIGHT + 14.0
}

fn columns(width: f64) -> usize {
    (((width - LEFT) / ENTRY_WIDTH) as usize).max(1)
}

/// Draws `entries` from `top` downwards.
pub fn draw(svg: &mut SvgWriter, entries: &[Entry], top: f64, width: f64) {
    let rows = entries.len().div_ceil(columns(width));
    for (n, Entry { swatch, words, .. }) in entries.iter().enumerate() {
        let (column, row) = (n / rows, n % rows);
        let x = LEFT + column as f64 * ENTRY_WIDTH + 24.0;
        let y = top + row as f64 * ENTRY_HEIGHT + 12.0;
        svg.raw(&swatch(x, y));
        svg.text(x + 30.0, y + 4.5, "", words);
    }
}
