//! Converts wire layouts to protobuf messages and back: the same fields under the same names.
//!
//! The conversion is lossless. Decoded messages are validated where all messages are: by the `TryFrom` of the wire
//! layout.

use bytemuck::Zeroable;
use contract::wire::{
    BriefV10, CommandV3, ControlV1, HeartbeatV2, LeaderV1, MapPageV2, MapPatchV2, OutcomeV1, PastHeaderV1,
    PolicyCellV1, PolicyHeaderV1, PoseV1, RecordV5, RobotV1, SeenCellV4, StateV4, TempoV1, seen_soil,
    soil_of_seen,
};
use contract::{Name, Refusal};

use crate::proto::hopper as proto;

/// Converts one field of a wire layout to its protobuf type `P` and back.
pub trait Field<P>: Sized {
    /// The value in a protobuf message.
    fn to_proto(&self) -> P;

    /// The value from a protobuf message; `field` names it in errors.
    ///
    /// # Errors
    /// If the wire layout cannot represent it.
    fn from_proto(proto_value: &P, field: &str) -> Result<Self, Refusal>;
}

macro_rules! same_type {
    ($($number:ident),*) => { $(
        impl Field<$number> for $number {
            fn to_proto(&self) -> $number {
                *self
            }

            fn from_proto(proto_value: &$number, _: &str) -> Result<Self, Refusal> {
                Ok(*proto_value)
            }
        }
    )* };
}

same_type!(u32, u64, f64);

/// A tag, which is an enumeration in protobuf.
impl Field<i32> for u32 {
    fn to_proto(&self) -> i32 {
        *self as i32
    }

    fn from_proto(proto_value: &i32, field: &str) -> Result<Self, Refusal> {
        u32::try_from(*proto_value).map_err(|_| Refusal::malformed(field, "a known tag", proto_value))
    }
}

/// A flag, which is a bool in protobuf.
impl Field<bool> for u32 {
    fn to_proto(&self) -> bool {
        *self != 0
    }

    fn from_proto(proto_value: &bool, _: &str) -> Result<Self, Refusal> {
        Ok(u32::from(*proto_value))
    }
}

/// A run id, which is 32 hexadecimal digits in protobuf.
impl Field<String> for [u64; 2] {
    fn to_proto(&self) -> String {
        format!("{:016x}{:016x}", self[0], self[1])
    }

    fn from_proto(proto_value: &String, field: &str) -> Result<Self, Refusal> {
        let run =
            Some(proto_value).filter(|text| text.len() == 32 && text.bytes().all(|b| b.is_ascii_hexdigit()));
        let run = run.and_then(|text| u128::from_str_radix(text, 16).ok());
        let run =
            run.ok_or_else(|| Refusal::malformed(field, "32 hexadecimal digits", short(proto_value)))?;
        Ok([(run >> 64) as u64, run as u64])
    }
}

/// A name, which is a string in protobuf.
impl Field<String> for [u8; Name::BYTES] {
    fn to_proto(&self) -> String {
        let end = self.iter().position(|&byte| byte == 0).unwrap_or(self.len());
        String::from_utf8_lossy(&self[..end]).into_owned()
    }

    fn from_proto(proto_value: &String, field: &str) -> Result<Self, Refusal> {
        let length = proto_value.len();
        if length >= Name::BYTES {
            return Err(Refusal::malformed(field, "at most 31 bytes", short(proto_value)));
        }
        let mut bytes = [0; Name::BYTES];
        bytes[..length].copy_from_slice(proto_value.as_bytes());
        Ok(bytes)
    }
}

/// A digest, which is a byte string in protobuf. One that is absent is zero, as an absent number is: recordings of before
/// have no digest in commands and maps.
impl Field<Vec<u8>> for [u8; 32] {
    fn to_proto(&self) -> Vec<u8> {
        self.to_vec()
    }

    fn from_proto(proto_value: &Vec<u8>, field: &str) -> Result<Self, Refusal> {
        if proto_value.is_empty() {
            return Ok([0; 32]);
        }
        proto_value
            .as_slice()
            .try_into()
            .map_err(|_| Refusal::malformed(field, "32 bytes", proto_value.len()))
    }
}

macro_rules! array {
    ($($number:ident),*) => { $(
        impl<const N: usize> Field<Vec<$number>> for [$number; N] {
            fn to_proto(&self) -> Vec<$number> {
                self.to_vec()
            }

            fn from_proto(proto_value: &Vec<$number>, field: &str) -> Result<Self, Refusal> {
                let need = || Refusal::malformed(field, &format!("{N} numbers"), proto_value.len());
                proto_value.as_slice().try_into().map_err(|_| need())
            }
        }
    )* };
}

array!(u64, f64);

impl Field<Option<proto::Cell>> for [i32; 2] {
    fn to_proto(&self) -> Option<proto::Cell> {
        Some(proto::Cell { x: self[0], y: self[1] })
    }

    fn from_proto(proto_value: &Option<proto::Cell>, _: &str) -> Result<Self, Refusal> {
        Ok(proto_value.map_or([0; 2], |cell| [cell.x, cell.y]))
    }
}

/// Cells of fixed number, which are a list in protobuf; trailing zeros are left out.
impl<const N: usize> Field<Vec<proto::Cell>> for [[i32; 2]; N] {
    fn to_proto(&self) -> Vec<proto::Cell> {
        let length = self.iter().rposition(|cell| *cell != [0; 2]).map_or(0, |last| last + 1);
        self[..length].iter().map(|&[x, y]| proto::Cell { x, y }).collect()
    }

    fn from_proto(proto_value: &Vec<proto::Cell>, field: &str) -> Result<Self, Refusal> {
        if proto_value.len() > N {
            return Err(Refusal::malformed(field, &format!("at most {N} cells"), proto_value.len()));
        }
        let mut cells = [[0; 2]; N];
        for (cell, proto_value) in cells.iter_mut().zip(proto_value) {
            *cell = [proto_value.x, proto_value.y];
        }
        Ok(cells)
    }
}

const fn size_of_field<W, F>(_: fn(W) -> F) -> usize {
    size_of::<F>()
}

/// Implements the conversion between a wire layout and its message. The fields in braces exist in both, and are all of the
/// layout but so many bytes of `padding`, which are zero; those after `extra` exist in the message only, for the caller to fill in.
macro_rules! convert {
    ($($message:ident = $wire:ident { $($field:ident),* } $(padding $padding:literal)? $(extra { $($own:ident),* })?;)*) => { $(
        // A field of the layout that is missing above would be lost.
        const _: () =
            assert!(0 $(+ size_of_field(|wire: $wire| wire.$field))* $(+ $padding)? == size_of::<$wire>());

        impl From<&$wire> for proto::$message {
            fn from(wire: &$wire) -> Self {
                Self { $($field: wire.$field.to_proto(),)* $($($own: Default::default(),)*)? }
            }
        }

        impl TryFrom<&proto::$message> for $wire {
            type Error = Refusal;

            fn try_from(message: &proto::$message) -> Result<Self, Refusal> {
                let mut wire = $wire::zeroed();
                $(wire.$field = Field::from_proto(
                    &message.$field,
                    concat!(stringify!($message), ".", stringify!($field)),
                )?;)*
                Ok(wire)
            }
        }

        impl Field<Option<proto::$message>> for $wire {
            fn to_proto(&self) -> Option<proto::$message> {
                Some(self.into())
            }

            fn from_proto(proto_value: &Option<proto::$message>, _: &str) -> Result<Self, Refusal> {
                proto_value.as_ref().map_or_else(|| Ok($wire::zeroed()), TryInto::try_into)
            }
        }
    )* };
}

convert! {
    Robot = RobotV1 {
        body, sensor, goal, required, start, heading, start_m, body_values, sensor_values, goal_values
    } padding 4;
    Brief = BriefV10 {
        run, scenario, scenario_hash, profile, account, width, height, hop_cells, treasures, cell_size_m, datum_m,
        weights, payoff_goal, payoff_treasure, discount, sand_term, safety_range, height_range_m, steps_max,
        decision_budget_ns, hazard_max, deadline_ns, leaving, distance_scale_cells, opening_steps, distance_norm,
        further_stages, sampling_seed, rover_samples, helicopter_samples
    } extra {
        robots, robot_count, gradient_source, start, goal, hard, sand, slope_limit_rad, launch_angle_rad,
        gravity_mps2, sensor_gain, sensor_offset_m, sensor_radius_m, hops_max, goal_count, goals, cover_percent,
        required
    };
    Leader = LeaderV1 { term, incarnation, pid, planner } padding 4;
    Pose = PoseV1 { cell, height_m };
    Outcome = OutcomeV1 {
        branch, flights, from, to, launch_speed_mps, launch_angle_rad, range_m, rise_m, apex_height_m,
        flight_time_s
    };
    State = StateV4 {
        run, decision, steps, visits, landed_ns, published_ns, robot, status, collected, vetoed, last_origin,
        last_vetoed, leader, pose, last, digest, previous, last_timing_ns
    };
    MapPatch = MapPatchV2 {
        run, through, sequence, before, after, sensed_ns, published_ns, cell_size_m, width, height, hop_cells,
        robot, seen_cells, more, treasure_count, treasures, digest
    } padding 4 extra { cells };
    MapPage = MapPageV2 {
        run, through, sequence, observation, sensed_ns, published_ns, cell_size_m, width, height, hop_cells,
        robot, from, next, treasure_count, treasures, digest
    } padding 4 extra { cells };
    Command = CommandV3 {
        run, decision, term, incarnation, observation, work, sensed_ns, map_published_ns, planning_started_ns,
        planning_ended_ns, robot, action, pid, cut, planner, digest, route
    };
    Policy = PolicyHeaderV1 { run, decision, error_bound, robot, planner } padding 4 extra { cells };
    PolicyCell = PolicyCellV1 { value, action } padding 4;
    Control = ControlV1 { run, incarnation, pace_hz, order, pace, robot } padding 4;
    Tempo = TempoV1 { run, pace_hz, pace, paused, heeds, robot };
    Heartbeat = HeartbeatV2 { run, incarnation, counter, decision, role, status, pid, robots, version, planner };
    Record = RecordV5 {
        decision, observation, work, steps, visits, robot, action, cut, status, collected, origin, vetoed,
        leader, outcome, pose, timing_ns, previous, digest, route, detail
    } padding 4;
    Past = PastHeaderV1 { run, from, robot } padding 4 extra { records };
}

/// Seen cells are converted by hand: there are many, and a list for the two gradients would allocate for each.
impl From<&SeenCellV4> for proto::SeenCell {
    fn from(wire: &SeenCellV4) -> Self {
        let (soil, passable) = soil_of_seen(wire.soil);
        Self {
            index: wire.index,
            height_m: wire.height_m,
            gradient_x: wire.gradient[0],
            gradient_y: wire.gradient[1],
            soil: soil.into(),
            passable,
            visits: wire.visits.into(),
            reported: wire.reported.into(),
        }
    }
}

impl TryFrom<&proto::SeenCell> for SeenCellV4 {
    type Error = Refusal;

    fn try_from(proto_value: &proto::SeenCell) -> Result<Self, Refusal> {
        let soil = u8::try_from(proto_value.soil);
        let soil = soil.map_err(|_| Refusal::malformed("SeenCell.soil", "a known tag", proto_value.soil))?;
        let visits = u16::try_from(proto_value.visits);
        let reported = u8::try_from(proto_value.reported);
        Ok(Self {
            height_m: proto_value.height_m,
            gradient: [proto_value.gradient_x, proto_value.gradient_y],
            index: proto_value.index,
            soil: seen_soil(soil, proto_value.passable),
            visits: visits
                .map_err(|_| Refusal::malformed("SeenCell.visits", "at most 65535", proto_value.visits))?,
            reported: reported
                .map_err(|_| Refusal::malformed("SeenCell.reported", "at most 255", proto_value.reported))?,
        })
    }
}

/// The first 40 characters of a text that may be long.
fn short(text: &str) -> String {
    text.chars().take(40).collect()
}
