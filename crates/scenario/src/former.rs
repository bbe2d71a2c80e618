//! Fields that scenarios had before a mission followed from its robots, and what to write instead.

use toml::Spanned;
use toml::de::{DeTable, DeValue};

use crate::ScenarioError;

/// What takes the place of section `[mission]`, by its kind.
const MISSION: [(&str, &str); 5] = [
    (
        "reach",
        "brief.start and brief.goal alone, or [[robots]] with body = \"hopper\" first and body = \"helicopter\" after it",
    ),
    ("patrol", "brief.goals with all goals, the first of them that of brief.goal, and brief.hops_max"),
    ("cover", "[[robots]] with body = \"rover\" and goal = { cover = 100, mode = \"overlap\" }"),
    (
        "scout",
        "[[robots]] with body = \"driver\" and body = \"helicopter\"; rover_samples, helicopter_samples and stages in [sampling]",
    ),
    (
        "mixed",
        "[[robots]] with body = \"hopper\", \"rover\", \"driver\" (to a goal) or \"helicopter\", and goal = { cover = 100 } of each rover",
    ),
];

/// Refuses `[mission]` and `vehicle` in a scenario that was read from `text`.
pub fn check(table: &DeTable<'_>, text: &str, origin: &str) -> Result<(), ScenarioError> {
    let refuse = |at: &Spanned<DeValue<'_>>, field, instead| {
        let line = 1 + text.as_bytes()[..at.span().start].iter().filter(|byte| **byte == b'\n').count();
        Err(ScenarioError::Former { origin: origin.into(), line, field, instead })
    };
    if let Some(mission) = table.get("mission") {
        let kind = mission.get_ref().get("kind").and_then(|kind| kind.get_ref().as_str()).unwrap_or("reach");
        let (_, instead) = MISSION.into_iter().find(|(known, _)| *known == kind).unwrap_or(MISSION[4]);
        return refuse(mission, "[mission]", instead);
    }
    let robots = table.get("robots").and_then(|robots| robots.get_ref().as_array());
    match robots.into_iter().flat_map(|robots| robots.iter()).find_map(|robot| robot.get_ref().get("vehicle"))
    {
        None => Ok(()),
        Some(vehicle) => {
            let instead = match vehicle.get_ref().as_str() {
                Some("hopper") => "body = \"hopper\"",
                Some("helicopter") => "body = \"helicopter\"",
                _ => {
                    "body = \"rover\" for one that covers ground, body = \"driver\" for one that drives to a goal"
                }
            };
            refuse(vehicle, "vehicle", instead)
        }
    }
}
