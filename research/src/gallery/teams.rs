//! The team papers' figures: P21 Figs 12 and 14 to 19, P19 Figs 5 to 8, from the built-in campaigns with the papers' numbers of
//! runs.

use ::campaign::StudyFile;
use hopper::commands::campaign::BUILT_IN;
use node::Failure;

use super::Figure;
use crate::claims::Claim;
use crate::report::Report;
use crate::reported::Reported;
use crate::scouting::scale;
use crate::studies::coverage::Coverage;
use crate::studies::large::Large;
use crate::studies::monte_carlo::MonteCarlo;
use crate::studies::single::Single;
use crate::studies::{fly_all, version};

/// Seed of the worlds of Figs 18 and 19.
const SEED: u64 = 1;

/// One figure of a study.
struct Shown {
    /// Name in the gallery.
    name: &'static str,
    /// Its file among those of the study.
    file: &'static str,
    title: &'static str,
    /// What the paper shows, what ours shows, what cannot be had.
    text: &'static str,
    /// Parts of the claims that it bears on.
    claims: &'static [&'static str],
}

/// P21's Monte Carlo simulation: Fig. 12.
///
/// # Errors
/// If the study cannot be flown.
pub fn monte_carlo() -> Result<Vec<Figure>, Failure> {
    let text = "P21, Fig. 12: box plots of the true travel time in its four scenarios, 100 runs each. Ours: the same number of \
                runs, with `scout_value` and the rover that knows the truth beside: how far a box lies above the last one is the \
                regret. The paper's own times cannot be had: it prints neither its worlds nor its numbers.";
    figures::<MonteCarlo>(
        "p21",
        &[Shown {
            name: "p21-fig-12",
            file: "fig-12.svg",
            title: "Rover and helicopter: travel times (P21, Fig. 12)",
            text,
            claims: &[""],
        }],
    )
}

/// P21's case study: Figs 16 and 17.
///
/// # Errors
/// If the study cannot be flown.
pub fn large() -> Result<Vec<Figure>, Failure> {
    let sixteen = "P21, Fig. 16: the reduction of the standard deviation along the flights of both helicopters on its map of \
                   Jezero. Ours: the sum over all cells seen, mean of 20 flights on a made map of 821 × 821 cells, with \
                   `scout_value` beside. The paper's map is not public, so its curve cannot be had.";
    let seventeen = "P21, Fig. 17: box plots of 20 runs on the map of Jezero with one start and goal. Ours: 20 truths of the \
                     made map. The paper's times cannot be had, for the same reason.";
    figures::<Large>(
        "p21-large",
        &[
            Shown {
                name: "p21-fig-16",
                file: "fig-16.svg",
                title: "Rover and helicopter: spread shown on the way (P21, Fig. 16)",
                text: sixteen,
                claims: &["(Fig. 16)"],
            },
            Shown {
                name: "p21-fig-17",
                file: "fig-17.svg",
                title: "Rover and helicopter: travel times on the large map (P21, Fig. 17)",
                text: seventeen,
                claims: &["(Fig. 17)", "with it the rover is faster"],
            },
        ],
    )
}

/// P21's single agent: Figs 14 and 15.
///
/// # Errors
/// If the study cannot be flown.
pub fn single() -> Result<Vec<Figure>, Failure> {
    let fourteen = "P21, Fig. 14: information gained over the distance along three paths across one grid. Ours: the mean of 400 \
                    random grids, since the paper does not define its own; its curve cannot be had.";
    let fifteen = "P21, Fig. 15: the same over the true travel time. Ours: the mean of the same 400 grids, whose times have no \
                   unit.";
    figures::<Single>(
        "p21-single",
        &[
            Shown {
                name: "p21-fig-14",
                file: "fig-14.svg",
                title: "A single agent: information over distance (P21, Fig. 14)",
                text: fourteen,
                claims: &["(Fig. 14)"],
            },
            Shown {
                name: "p21-fig-15",
                file: "fig-15.svg",
                title: "A single agent: information over time (P21, Fig. 15)",
                text: fifteen,
                claims: &["(Fig. 15)"],
            },
        ],
    )
}

/// P21's decision processes: Figs 18 and 19.
///
/// # Errors
/// None.
pub fn values() -> Result<Vec<Figure>, Failure> {
    Ok(vec![value(true), value(false)])
}

/// Fig. 18, or Fig. 19 without a goal.
pub fn value(has_goal: bool) -> Figure {
    let (number, with, defined) =
        if has_goal { (18, "with", "a defined") } else { (19, "without", "an undefined") };
    Figure {
        name: format!("p21-fig-{number}"),
        title: format!("Value of entropy as a reward, {with} a goal (P21, Fig. {number})"),
        text: format!(
            "P21, Fig. {number}: values found by value iteration for a stochastic policy with entropy as a reward and {defined} \
             goal state. Ours: the same on the Monte Carlo world in 50 × 50 cells, with the process of \
             [scouting.md](scouting.md#what-the-paper-left-open). The paper describes neither its process nor its map, so its \
             values cannot be had; [Scalability](scouting.md#scalability) has the table and how often a policy is trapped."
        ),
        svg: scale::values(SEED, has_goal),
    }
}

/// P19's figures.
///
/// # Errors
/// If the study cannot be flown.
pub fn coverage() -> Result<Vec<Figure>, Failure> {
    let five = "P19, Fig. 5: a typical mission from its start to full coverage at a path ratio of 1.75, as maps of visits. Ours: of \
                3,000 missions with `spiral` the one that ends nearest to 1.75. The paper's world cannot be had: it prints no size \
                and no obstacles.";
    let six = "P19, Fig. 6: path ratio over the share covered, 3,000 runs for each planner and share. Ours: as many. The paper \
               draws its values and prints none.";
    let seven = "P19, Fig. 7: one pair of missions, four rovers to 99 %, 444 steps in `overlap` and 449 in `voronoi`. Ours: of \
                 3,000 pairs on 30 × 30 cells the one that comes nearest. The paper's \
                 own world cannot be had.";
    let spread = "The distributions that such a pair comes from, on three sizes of worlds, since the paper does not print its own.";
    let eight = "P19, Fig. 8: path ratio of teams of several sizes to 95 % in both modes. Ours: teams of 2 to 8 with `spiral` on \
                 four sizes of worlds, 3,000 runs a point. The paper prints neither sizes nor values.";
    let shown = |name, file, title, text, claims| Shown { name, file, title, text, claims };
    figures::<Coverage>(
        "p19",
        &[
            shown("p19-fig-5", "fig-5.svg", "Coverage: a typical mission (P19, Fig. 5)", five, &["(Fig. 5)"]),
            shown(
                "p19-fig-6",
                "fig-6.svg",
                "Coverage: path ratio of one rover (P19, Fig. 6)",
                six,
                &["(Fig. 6)"],
            ),
            shown(
                "p19-fig-7",
                "fig-7-missions.svg",
                "Coverage: a pair of missions (P19, Fig. 7)",
                seven,
                &["(Fig. 7)"],
            ),
            shown(
                "p19-fig-7-all",
                "fig-7.svg",
                "Coverage: where the pair comes from (P19, Fig. 7)",
                spread,
                &[],
            ),
            shown(
                "p19-fig-8",
                "fig-8.svg",
                "Coverage: teams in both modes (P19, Fig. 8)",
                eight,
                &["(Fig. 8)"],
            ),
        ],
    )
}

/// Flies a built-in campaign, and takes some of its figures.
fn figures<S: Reported>(campaign: &'static str, all: &[Shown]) -> Result<Vec<Figure>, Failure> {
    let built_in = BUILT_IN.into_iter().find(|(name, _)| *name == campaign).expect("a built-in campaign");
    let plan = StudyFile::<S>::parse(built_in.1, campaign).map_err(Failure::usage)?.plan(&version());
    let report = plan.settings.report(plan.seed, &fly_all(&plan)?);
    let drawn = report.figures()?;
    let figure = |shown: &Shown| {
        let (_, svg) = drawn.iter().find(|(file, _)| file == shown.file).expect("a figure of the study");
        let judged =
            report.claims().iter().filter(|claim| shown.claims.iter().any(|part| claim.claim.contains(part)));
        let judged: Vec<String> = judged.map(line).collect();
        let claims = if judged.is_empty() { String::new() } else { format!("\n\n{}", judged.join("\n")) };
        Figure {
            name: shown.name.into(),
            title: shown.title.into(),
            text: format!("{} Campaign `{campaign}`.{claims}", shown.text),
            svg: svg.clone(),
        }
    };
    Ok(all.iter().map(figure).collect())
}

/// A claim in a line of a list.
fn line(claim: &Claim) -> String {
    let Claim { claim, ours, verdict, .. } = claim;
    let ours = if ours.is_empty() { String::new() } else { format!(" ({ours})") };
    format!("- {}: {claim}{ours}", verdict.words())
}
