//! Briefs of earlier builds, which did not list their robots: those of a lone hopper are read, all others refused.

use contract::wire::{BriefV10, brief_from_wire};
use contract::{
    Account, Brief, Cell, Goal, GradientSource, Grid, MotionParameters, Refusal, Robot, SensorParameters,
    SoilMotion, Visit,
};

use crate::proto::hopper as proto;

/// The brief of a message without robots.
///
/// # Errors
/// If it is not that of a lone hopper, or a field is out of range.
pub(crate) fn read(message: &proto::Brief) -> Result<Brief, Refusal> {
    let proto::Brief { robot_count, cover_percent, rover_samples, required, .. } = *message;
    if (robot_count, cover_percent, rover_samples, required) != (1, 0, 0, 0) {
        let need = "a list of robots, or the brief of a lone hopper";
        return Err(Refusal::malformed("Brief.robots", need, format!("none for {robot_count} robots")));
    }
    let wire = BriefV10 { account: Account::Hopper.code(), ..message.try_into()? };
    brief_from_wire(&wire, &[(&hopper(message)?).into()])
}

fn hopper(message: &proto::Brief) -> Result<Robot, Refusal> {
    let proto::Brief { width, height, cell_size_m, hop_cells, .. } = *message;
    let grid = Grid::new(width, height, cell_size_m, hop_cells)
        .map_err(|error| Refusal::malformed("brief.grid", "a grid within bounds", error))?;
    let motion = MotionParameters {
        hard: soil(message.hard.as_ref()),
        sand: soil(message.sand.as_ref()),
        slope_limit_rad: message.slope_limit_rad,
        launch_angle_rad: message.launch_angle_rad,
        gravity_mps2: message.gravity_mps2,
        vertical: false,
        table: 0,
    };
    let [radius_min_m, radius_max_m] = message.sensor_radius_m[..] else {
        let got = message.sensor_radius_m.len();
        return Err(Refusal::malformed("Brief.sensor_radius_m", "2 numbers", got));
    };
    let gradient = match message.gradient_source() {
        proto::GradientSource::Measured => GradientSource::Measured,
        proto::GradientSource::SeenDifferences => GradientSource::SeenDifferences,
        proto::GradientSource::NoSource => {
            return Err(Refusal::malformed("Brief.gradient_source", "a known tag", message.gradient_source));
        }
    };
    let sensor = SensorParameters {
        gain: message.sensor_gain,
        offset_m: message.sensor_offset_m,
        radius_min_m,
        radius_max_m,
        gradient,
    };
    let cell = |cell: &proto::Cell| Cell { x: cell.x, y: cell.y };
    let ends = [message.start, message.goal].map(|end| cell(&end.unwrap_or_default()));
    let hopper = Robot::hopper(&grid, motion, sensor, ends);
    if message.goal_count == 0 && message.hops_max == 0 {
        return Ok(hopper);
    }
    let goals: Vec<Cell> = message.goals.iter().map(cell).collect();
    match Visit::new(&goals, message.hops_max) {
        Some(visit) if visit.goals().len() == message.goal_count as usize => {
            Ok(Robot { goal: Goal::Visit(visit), ..hopper })
        }
        _ => Err(Refusal::malformed("Brief.goals", "goals to be visited in turn, and hops", goals.len())),
    }
}

fn soil(message: Option<&proto::SoilMotion>) -> SoilMotion {
    let proto::SoilMotion { intended, stuck, sideways, flights } = message.copied().unwrap_or_default();
    SoilMotion { intended, stuck, sideways, flights }
}

#[cfg(test)]
mod tests {
    use prost::Message as _;

    use super::*;
    use crate::{Channel, Recording};

    /// The brief of a lone hopper, as an earlier build wrote it.
    fn earlier() -> proto::Brief {
        let recording = Recording::read(include_bytes!("../../../tests/golden/hard.mcap")).unwrap();
        let brief = recording.entries().find(|entry| entry.known == Some(Channel::Brief)).unwrap();
        proto::Brief::decode(brief.data).unwrap()
    }

    /// P-OLD-RECORDING.
    #[test]
    fn an_earlier_brief_is_read_if_it_is_of_a_lone_hopper_and_else_refused() {
        let brief = read(&earlier()).unwrap();
        assert_eq!((brief.account, brief.robots.count()), (Account::Hopper, 1));
        let leg = brief.leg(0);
        assert_eq!((leg.start, leg.goal), (Cell::new(1, 2), Cell::new(18, 18)));
        assert_eq!((leg.motion.sand.flights, leg.sensor.gain), (2, 2.0));
        let goals = vec![proto::Cell { x: 18, y: 18 }, proto::Cell { x: 1, y: 2 }];
        let visits = proto::Brief { goals, goal_count: 2, hops_max: 9, ..earlier() };
        assert_eq!(read(&visits).unwrap().visits().map(|visit| visit.hops_max), Some(9));
        for refused in [
            proto::Brief { robot_count: 2, ..earlier() },
            proto::Brief { robot_count: 0, ..earlier() },
            proto::Brief { cover_percent: 100, ..earlier() },
            proto::Brief { rover_samples: 9, ..earlier() },
            proto::Brief { required: 1, ..earlier() },
        ] {
            let refusal = read(&refused).unwrap_err().to_string();
            assert!(refusal.contains("Brief.robots"), "{refusal}");
        }
        let short = proto::Brief { goal_count: 3, ..visits };
        assert!(read(&short).unwrap_err().to_string().contains("Brief.goals"));
    }
}
