//! Wire layouts beside their protobuf messages: the same fields under the same names.
//!
//! Nothing is lost on the way, and a message that comes back is validated where every message is: by the
//! `TryFrom` of the wire layout.

use bytemuck::Zeroable;
use contract::wire::{
    BriefV3, CommandV1, ControlV1, HeartbeatV1, LeaderV1, MapPageV1, MapPatchV1, OutcomeV1, PastHeaderV1,
    PolicyCellV1, PolicyHeaderV1, PoseV1, RecordV3, SeenCellV1, SoilMotionV1, StateV3, TempoV1,
};
use contract::{Name, Refusal};

use crate::proto::hopper as proto;

/// One field: as shown in a message, and taken back from one.
pub trait Field<P>: Sized {
    /// As it stands in a message.
    fn show(&self) -> P;

    /// From a message.
    ///
    /// # Errors
    /// If the layout has no such value.
    fn take(shown: &P, field: &str) -> Result<Self, Refusal>;
}

macro_rules! plain {
    ($($number:ident),*) => { $(
        impl Field<$number> for $number {
            fn show(&self) -> $number {
                *self
            }

            fn take(shown: &$number, _: &str) -> Result<Self, Refusal> {
                Ok(*shown)
            }
        }
    )* };
}

plain!(u32, u64, f64);

/// A tag: an enumeration in the message.
impl Field<i32> for u32 {
    fn show(&self) -> i32 {
        *self as i32
    }

    fn take(shown: &i32, field: &str) -> Result<Self, Refusal> {
        u32::try_from(*shown).map_err(|_| Refusal::malformed(field, "a known tag", shown))
    }
}

/// A flag.
impl Field<bool> for u32 {
    fn show(&self) -> bool {
        *self != 0
    }

    fn take(shown: &bool, _: &str) -> Result<Self, Refusal> {
        Ok(u32::from(*shown))
    }
}

/// The run.
impl Field<String> for [u64; 2] {
    fn show(&self) -> String {
        format!("{:016x}{:016x}", self[0], self[1])
    }

    fn take(shown: &String, field: &str) -> Result<Self, Refusal> {
        let run = Some(shown).filter(|text| text.len() == 32 && text.bytes().all(|b| b.is_ascii_hexdigit()));
        let run = run.and_then(|text| u128::from_str_radix(text, 16).ok());
        let run = run.ok_or_else(|| Refusal::malformed(field, "32 hexadecimal digits", short(shown)))?;
        Ok([(run >> 64) as u64, run as u64])
    }
}

/// A name.
impl Field<String> for [u8; Name::BYTES] {
    fn show(&self) -> String {
        let end = self.iter().position(|&byte| byte == 0).unwrap_or(self.len());
        String::from_utf8_lossy(&self[..end]).into_owned()
    }

    fn take(shown: &String, field: &str) -> Result<Self, Refusal> {
        let mut bytes = [0; Name::BYTES];
        let room = bytes.get_mut(..shown.len()).filter(|_| shown.len() < Name::BYTES);
        let room = room.ok_or_else(|| Refusal::malformed(field, "at most 31 bytes", short(shown)))?;
        room.copy_from_slice(shown.as_bytes());
        Ok(bytes)
    }
}

/// A digest.
impl Field<Vec<u8>> for [u8; 32] {
    fn show(&self) -> Vec<u8> {
        self.to_vec()
    }

    fn take(shown: &Vec<u8>, field: &str) -> Result<Self, Refusal> {
        shown.as_slice().try_into().map_err(|_| Refusal::malformed(field, "32 bytes", shown.len()))
    }
}

macro_rules! row {
    ($($number:ident),*) => { $(
        impl<const N: usize> Field<Vec<$number>> for [$number; N] {
            fn show(&self) -> Vec<$number> {
                self.to_vec()
            }

            fn take(shown: &Vec<$number>, field: &str) -> Result<Self, Refusal> {
                let need = || Refusal::malformed(field, &format!("{N} numbers"), shown.len());
                shown.as_slice().try_into().map_err(|_| need())
            }
        }
    )* };
}

row!(u64, f64);

impl Field<Option<proto::Cell>> for [i32; 2] {
    fn show(&self) -> Option<proto::Cell> {
        Some(proto::Cell { x: self[0], y: self[1] })
    }

    fn take(shown: &Option<proto::Cell>, _: &str) -> Result<Self, Refusal> {
        Ok(shown.map_or([0; 2], |cell| [cell.x, cell.y]))
    }
}

/// A list of fixed length; zeros at its end are left out.
impl<const N: usize> Field<Vec<proto::Cell>> for [[i32; 2]; N] {
    fn show(&self) -> Vec<proto::Cell> {
        let length = self.iter().rposition(|cell| *cell != [0; 2]).map_or(0, |last| last + 1);
        self[..length].iter().map(|&[x, y]| proto::Cell { x, y }).collect()
    }

    fn take(shown: &Vec<proto::Cell>, field: &str) -> Result<Self, Refusal> {
        if shown.len() > N {
            return Err(Refusal::malformed(field, &format!("at most {N} cells"), shown.len()));
        }
        let mut cells = [[0; 2]; N];
        for (cell, shown) in cells.iter_mut().zip(shown) {
            *cell = [shown.x, shown.y];
        }
        Ok(cells)
    }
}

/// A layout and its message, with the fields that both have; what the layout has besides is zero.
macro_rules! mirror {
    ($($message:ident = $wire:ident { $($field:ident),* } $(besides { $($own:ident),* })?;)*) => { $(
        impl From<&$wire> for proto::$message {
            fn from(wire: &$wire) -> Self {
                Self { $($field: wire.$field.show(),)* $($($own: Default::default(),)*)? }
            }
        }

        impl TryFrom<&proto::$message> for $wire {
            type Error = Refusal;

            fn try_from(message: &proto::$message) -> Result<Self, Refusal> {
                let mut wire = $wire::zeroed();
                $(wire.$field = Field::take(
                    &message.$field,
                    concat!(stringify!($message), ".", stringify!($field)),
                )?;)*
                Ok(wire)
            }
        }

        impl Field<Option<proto::$message>> for $wire {
            fn show(&self) -> Option<proto::$message> {
                Some(self.into())
            }

            fn take(shown: &Option<proto::$message>, _: &str) -> Result<Self, Refusal> {
                shown.as_ref().map_or_else(|| Ok($wire::zeroed()), TryInto::try_into)
            }
        }
    )* };
}

mirror! {
    SoilMotion = SoilMotionV1 { intended, stuck, sideways, flights };
    Brief = BriefV3 {
        run, scenario, scenario_hash, profile, robots, width, height, hop_cells, gradient_source, cell_size_m,
        datum_m, start, goal, weights, payoff_goal, payoff_treasure, discount, sand_term, safety_range,
        height_range_m, hard, sand, slope_limit_rad, launch_angle_rad, gravity_mps2, sensor_gain,
        sensor_offset_m, sensor_radius_m, steps_max, decision_budget_ns, hazard_max, deadline_ns, hops_max,
        goal_count, goals
    };
    Leader = LeaderV1 { term, incarnation, pid, planner };
    Pose = PoseV1 { cell, height_m };
    Outcome = OutcomeV1 {
        branch, flights, from, to, launch_speed_mps, launch_angle_rad, range_m, rise_m, apex_height_m,
        flight_time_s
    };
    State = StateV3 {
        run, decision, steps, visits, landed_ns, published_ns, robot, status, collected, vetoed, last_origin,
        last_vetoed, leader, pose, last, digest, last_timing_ns
    };
    MapPatch = MapPatchV1 {
        run, through, sequence, before, after, sensed_ns, published_ns, cell_size_m, width, height, hop_cells,
        robot, seen_cells, more, treasure_count, treasures
    } besides { cells };
    MapPage = MapPageV1 {
        run, through, sequence, observation, sensed_ns, published_ns, cell_size_m, width, height, hop_cells,
        robot, from, next, treasure_count, treasures
    } besides { cells };
    Command = CommandV1 {
        run, decision, term, incarnation, observation, work, sensed_ns, map_published_ns, planning_started_ns,
        planning_ended_ns, robot, action, pid, cut, planner
    };
    Policy = PolicyHeaderV1 { run, decision, error_bound, robot, planner } besides { cells };
    PolicyCell = PolicyCellV1 { value, action };
    Control = ControlV1 { run, incarnation, pace_hz, order, pace, robot };
    Tempo = TempoV1 { run, pace_hz, pace, paused, heeds, robot };
    Heartbeat = HeartbeatV1 { run, incarnation, counter, decision, role, status, pid, version, planner };
    Record = RecordV3 {
        decision, observation, work, steps, visits, robot, action, cut, status, collected, origin, vetoed,
        leader, outcome, pose, timing_ns, previous, digest
    };
    Past = PastHeaderV1 { run, from, robot } besides { records };
}

/// A seen cell is written by hand: there are many, and a list for two gradients would be as many allocations.
impl From<&SeenCellV1> for proto::SeenCell {
    fn from(wire: &SeenCellV1) -> Self {
        Self {
            index: wire.index,
            height_m: wire.height_m,
            gradient_x: wire.gradient[0],
            gradient_y: wire.gradient[1],
            soil: i32::from(wire.soil),
            passable: wire.passable != 0,
        }
    }
}

impl TryFrom<&proto::SeenCell> for SeenCellV1 {
    type Error = Refusal;

    fn try_from(shown: &proto::SeenCell) -> Result<Self, Refusal> {
        let soil = u16::try_from(shown.soil);
        Ok(Self {
            height_m: shown.height_m,
            gradient: [shown.gradient_x, shown.gradient_y],
            index: shown.index,
            soil: soil.map_err(|_| Refusal::malformed("SeenCell.soil", "a known tag", shown.soil))?,
            passable: u16::from(shown.passable),
        })
    }
}

/// The head of a text that may be long.
fn short(text: &str) -> String {
    text.chars().take(40).collect()
}
