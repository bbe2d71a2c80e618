//! Several robots in one picture: the cells they visited, their routes, and each robot with its colour and number.

use std::collections::BTreeMap;
use std::fmt::Write as _;

use contract::{Branch, Cell};

use super::colour;
use super::frame::Frame;
use super::mission::Picture;
use super::svg_writer::{Number, SvgWriter};
use super::symbols;

/// Opacity of a cell that was visited once, and what each further visit adds.
const ONCE: f64 = 0.22;
const AGAIN: f64 = 0.14;

impl Picture<'_> {
    /// Draws visits, routes and robots; in a hopper's mission the routes of its helicopters only. A robot is shown where its
    /// last decision left it; one that has not decided yet is not on the route.
    pub(super) fn team(&self, svg: &mut SvgWriter, frame: &Frame) {
        let mut visits: BTreeMap<Cell, u32> = BTreeMap::new();
        let mut routes: BTreeMap<u16, Vec<Cell>> = BTreeMap::new();
        let mut stranded = Vec::new();
        let is_of_hopper = self.brief.is_of_hopper();
        for record in self.route.iter().filter(|record| !is_of_hopper || record.robot.0 > 0) {
            let (outcome, robot) = (record.outcome, record.robot.0);
            let route = routes.entry(robot).or_insert_with(|| {
                *visits.entry(outcome.from).or_default() += 1;
                vec![outcome.from]
            });
            if route.last() != Some(&outcome.from) {
                // A helicopter that is with its rover again.
                route.push(outcome.from);
            }
            if outcome.from != outcome.to {
                *visits.entry(outcome.to).or_default() += 1;
                route.push(outcome.to);
            }
            if outcome.branch == Branch::Stranded {
                stranded.push(robot);
            }
        }
        let side = Number(frame.pitch * 0.8);
        for (&cell, &count) in visits.iter().filter(|_| !is_of_hopper) {
            let (x, y) = frame.centre(cell);
            svg.raw(&format!(
                "<rect x=\"{}\" y=\"{}\" width=\"{side}\" height=\"{side}\" fill=\"{}\" fill-opacity=\"{}\"/>",
                Number(x - frame.pitch * 0.4),
                Number(y - frame.pitch * 0.4),
                colour::ROUTE,
                Number((ONCE + AGAIN * f64::from(count - 1)).min(0.85))
            ));
        }
        for (&robot, cells) in &routes {
            let mut path = String::new();
            for (number, &cell) in cells.iter().enumerate() {
                let (x, y) = frame.centre(cell);
                let _ = write!(path, "{}{} {}", if number == 0 { "M" } else { "L" }, Number(x), Number(y));
            }
            let line = "fill=\"none\" stroke-linejoin=\"round\" stroke-linecap=\"round\"";
            svg.path(&path, &format!("{line} stroke=\"#111\" stroke-width=\"3.4\" stroke-opacity=\".6\""));
            svg.path(&path, &format!("{line} stroke=\"{}\" stroke-width=\"2\"", colour::robot(robot)));
        }
        let size = (frame.pitch * 0.34).clamp(8.0, 12.0);
        for (&robot, cells) in &routes {
            let Some(&cell) = cells.last() else { continue };
            let (x, y) = frame.centre(cell);
            svg.raw(&symbols::dot(x, y, size, &colour::robot(robot), "#111"));
            let mark = if stranded.contains(&robot) { "×".to_owned() } else { robot.to_string() };
            svg.text(
                x,
                y + 4.2,
                "text-anchor=\"middle\" font-size=\"12\" font-weight=\"bold\" fill=\"#111\"",
                &mark,
            );
        }
    }
}
