//! The way of a hop as displays draw it: what flew, what rolled, where it hit.

use contract::{Detail, MotionModel, PathPoint};

/// How far the end of a flight may be from where its launch leads, as a share of its length, before the stretch counts as rolled.
const FLIGHT_TOLERANCE: f64 = 1e-6;

/// A stretch of the way, from the launch or an impact to the next one or to rest. Places are (east, north, up), metres; times are
/// since the launch, seconds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stretch {
    /// Where it begins.
    pub from_m: [f64; 3],
    /// Where it ends.
    pub to_m: [f64; 3],
    /// When it begins.
    pub begins_s: f64,
    /// When it ends.
    pub ends_s: f64,
    /// Velocity at its beginning if the body flies, m/s; `None` if it rolls.
    pub launch_mps: Option<[f64; 3]>,
    /// Whether the body comes to rest at its end.
    pub is_last: bool,
}

impl Stretch {
    /// Where the body is at `share` of the time, 0 to 1. A flight is the parabola that begins with the launch velocity and ends where
    /// the stretch ends; the last roll slows down evenly, any other is at constant speed.
    #[must_use]
    pub fn at(&self, share: f64) -> [f64; 3] {
        let Self { from_m, to_m, begins_s, ends_s, launch_mps, is_last } = *self;
        let along = if launch_mps.is_none() && is_last { share * (2.0 - share) } else { share };
        let mut at = [0, 1, 2].map(|axis| from_m[axis] + (to_m[axis] - from_m[axis]) * along);
        if let Some([_, _, climb_mps]) = launch_mps {
            let fall_m = climb_mps * (ends_s - begins_s) - (to_m[2] - from_m[2]);
            at[2] += fall_m * share * (1.0 - share);
        }
        at
    }
}

/// The stretches of the way of a hop, in order; none where the body did not move.
#[must_use]
pub fn stretches(detail: &Detail) -> Vec<Stretch> {
    let ends = detail.path.iter().skip(1).map(|next| (next.at_m, Some(next.seconds)));
    let ends = ends.chain([(detail.rest_m, detail.figure("seconds"))]);
    let count = detail.path.len();
    let stretches = detail.path.iter().zip(ends).enumerate();
    let stretches = stretches.filter(|(_, (point, (to_m, _)))| point.at_m != *to_m);
    stretches
        .map(|(place, (point, (to_m, ends_s)))| stretch(point, to_m, ends_s, place + 1 == count))
        .collect()
}

/// Where the body hit the ground, of the impacts that are told.
pub fn impacts(detail: &Detail) -> impl Iterator<Item = [f64; 3]> + '_ {
    detail.path.iter().skip(1).map(|point| point.at_m)
}

/// How long the hop took from the launch to rest, seconds; where the model does not say so, what its launch velocity makes of the way.
#[must_use]
pub fn seconds(detail: &Detail) -> f64 {
    stretches(detail).last().map_or(0.0, |last| last.ends_s)
}

/// How the hop ended, as the second half of a sentence about the hopper.
#[must_use]
pub fn ending(detail: &Detail) -> &'static str {
    let is_displaced = detail.figure("displaced").is_some_and(|displaced| displaced > 0.0);
    if is_displaced {
        return "it ended on the last free cell of its way, since another robot was where it came to rest";
    }
    match (detail.model, detail.path.is_empty()) {
        (MotionModel::Contact, _) => match detail.figure("end").map_or(0, |end| end as u8) {
            1 => "it came to rest",
            2 => "it was caught (crease, pit or wall)",
            3 => "it did not get off the ground",
            4 => "it left the map",
            5 => "it rolled away",
            6 => "it bounced on",
            _ => "it stood still",
        },
        (MotionModel::Collision, false) if detail.figure("collided") == Some(1.0) => {
            "its arc met the ground, and it stayed"
        }
        (_, false) => "it came to rest",
        (_, true) => "it stood still",
    }
}

/// What of the energy of the launch is left neither in height nor in motion at the end, J/kg.
#[must_use]
pub fn lost_j_per_kg(detail: &Detail, gravity_mps2: f64) -> Option<f64> {
    let launched = detail.path.first()?;
    let energy = detail.figure("energy_j_per_kg")?;
    Some(energy - gravity_mps2 * (detail.rest_m[2] - launched.at_m[2]))
}

fn stretch(point: &PathPoint, to_m: [f64; 3], ends_s: Option<f64>, is_last: bool) -> Stretch {
    let PathPoint { seconds: begins_s, at_m: from_m, leaves_mps } = *point;
    let way_m = [to_m[0] - from_m[0], to_m[1] - from_m[1]];
    let length_m = libm::hypot(way_m[0], way_m[1]);
    let level_mps = libm::hypot(leaves_mps[0], leaves_mps[1]);
    let lasts_s = match ends_s {
        Some(ends_s) => (ends_s - begins_s).max(0.0),
        None if level_mps > 0.0 => length_m / level_mps,
        None => 0.0,
    };
    // Nothing is told of a way on the ground where the model tells no time.
    let miss_m = [0, 1].map(|axis: usize| leaves_mps[axis] * lasts_s - way_m[axis]);
    let flies = ends_s.is_none() || libm::hypot(miss_m[0], miss_m[1]) <= FLIGHT_TOLERANCE * (1.0 + length_m);
    let launch_mps = flies.then_some(leaves_mps);
    Stretch { from_m, to_m, begins_s, ends_s: begins_s + lasts_s, launch_mps, is_last }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A hop east over level ground with g = 2 m/s²: 1 m in a second, a bounce of 0.5 m in half a second, then 0.1 m rolled in 0.4 s.
    fn detail() -> Detail {
        let point = |seconds, east_m, leaves_mps| PathPoint { seconds, at_m: [east_m, 0.5, 2.0], leaves_mps };
        Detail {
            model: MotionModel::Contact,
            rest_m: [2.1, 0.5, 2.0],
            figures: [1.0, 2.0, 0.1, 1.9, 1.0, 0.0],
            path: vec![
                point(0.0, 0.5, [1.0, 0.0, 1.0]),
                point(1.0, 1.5, [1.0, 0.0, 0.5]),
                point(1.5, 2.0, [0.5, 0.0, 0.0]),
            ],
        }
    }

    #[test]
    fn a_hop_flies_as_it_was_launched_and_rolls_from_its_last_impact_to_rest() {
        let ways = stretches(&detail());
        let flies: Vec<bool> = ways.iter().map(|way| way.launch_mps.is_some()).collect();
        assert_eq!(flies, [true, true, false]);
        // The apex of a launch at 1 m/s under 2 m/s² is 0.25 m high, half way.
        assert_eq!(ways[0].at(0.5), [1.0, 0.5, 2.25]);
        assert_eq!(ways[1].at(0.5), [1.75, 0.5, 2.0625]);
        // Half the time of an even braking is three quarters of the way.
        let rolled = ways[2].at(0.5);
        assert!((rolled[0] - 2.075).abs() < 1e-12 && rolled[2] == 2.0, "{rolled:?}");
        for way in &ways {
            assert_eq!((way.at(0.0), way.at(1.0)), (way.from_m, way.to_m));
        }
        assert_eq!(impacts(&detail()).collect::<Vec<_>>(), [[1.5, 0.5, 2.0], [2.0, 0.5, 2.0]]);
        assert_eq!((seconds(&detail()), ending(&detail())), (1.9, "it came to rest"));
    }

    #[test]
    fn a_hop_whose_time_is_not_told_takes_what_its_launch_makes_of_it_and_one_that_stays_takes_none() {
        let mut of_law = Detail { model: MotionModel::Collision, figures: [0.0; 6], ..detail() };
        of_law.path.truncate(1);
        of_law.rest_m = [1.5, 0.5, 2.2];
        let ways = stretches(&of_law);
        assert_eq!((ways.len(), ways[0].ends_s, ways[0].launch_mps), (1, 1.0, Some([1.0, 0.0, 1.0])));
        assert_eq!(ways[0].at(1.0), of_law.rest_m);
        let collided =
            Detail { rest_m: of_law.path[0].at_m, figures: [1.0, 0.0, 0.0, 0.0, 0.0, 0.0], ..of_law };
        assert!(stretches(&collided).is_empty() && seconds(&collided) == 0.0);
        assert!(ending(&collided).contains("met the ground"));
        assert_eq!(ending(&detail().at_rest()), "it stood still");
    }

    #[test]
    fn energy_is_lost_unless_it_is_left_in_height() {
        let flat = detail();
        assert_eq!(lost_j_per_kg(&flat, 2.0), Some(1.0));
        let higher = Detail { rest_m: [2.1, 0.5, 2.25], ..flat };
        assert_eq!(lost_j_per_kg(&higher, 2.0), Some(0.5));
        assert_eq!(lost_j_per_kg(&higher.at_rest(), 2.0), None, "it was not launched");
    }
}
