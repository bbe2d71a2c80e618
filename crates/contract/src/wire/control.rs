//! `hop/control` with `hop/tempo`.

use crate::Role;
use crate::fixed_payload;

use super::declaration::wire;
use crate::codec::{Codec, FLAG, Float, NOT_ZERO, ROBOT, RUN, float, joint, unknown_tag, whole};
use crate::message::{Message, PublishSubscribe};
use crate::mission::pace::{HERTZ_MAX, HERTZ_MIN, TIMES_MAX, TIMES_MIN};
use crate::{Control, Incarnation, Order, Pace, Pacing, Refusal};

/// Landings a second.
const HERTZ: Float = float(HERTZ_MIN, HERTZ_MAX);

/// Times real time.
const TIMES: Float = float(TIMES_MIN, TIMES_MAX);

wire! {
    /// An order from the ground.
    pub struct ControlV1 = "hop.Control.v1", 48 bytes, refused as "control" {
        /// Run that is meant.
        run: [u64; 2] = RUN,
        /// Life of the planner that shall take over.
        incarnation: u64 = joint(NOT_ZERO, "read with `order` 5"),
        /// Landings a second, or times real time, if that is the pace asked for; zero otherwise.
        pace_hz: f64 = joint(HERTZ, "read with `order` 4 and `pace` 3; with `pace` 4 up to 10^9") => "control.pace",
        /// 1 pause, 2 resume, 3 step, 4 pace, 5 hand over.
        order: u32 = joint(whole(1, 5), "says which other fields are read"),
        /// Pace asked for: 0 none, 1 max, 2 real, 3 as many hertz, 4 as many times real time.
        pace: u32 = joint(whole(1, 4), "read with `order` 4"),
        /// Robot that is meant.
        robot: u32 = ROBOT,
        reserved: u32,
    }
    of Control { run, robot, order }
    to_wire {
        let (order, pace, incarnation) = match *order {
            Order::Pause => (&1, None, 0),
            Order::Resume => (&2, None, 0),
            Order::Step => (&3, None, 0),
            Order::Pace(pace) => (&4, Some(pace), 0),
            Order::HandOver(incarnation) => (&5, None, incarnation.0),
        };
        let incarnation = &incarnation;
        let (pace, pace_hz) = &pace.map_or((0, 0.0), pace_to_wire);
    }
    from_wire(wire) {
        let order = match order {
            1 => Order::Pause,
            2 => Order::Resume,
            3 => Order::Step,
            4 => Order::Pace(pace_from_wire("control.pace", pace, pace_hz)?),
            5 if incarnation != 0 => Order::HandOver(Incarnation(incarnation)),
            5 => return Err(Refusal::malformed("control.incarnation", "not zero", 0)),
            code => return Err(unknown_tag("control.order", code)),
        };
    }
}

wire! {
    /// The pace in force.
    pub struct TempoV1 = "hop.Tempo.v1", 40 bytes, refused as "tempo" {
        /// Run that is paced.
        run: [u64; 2] = RUN,
        /// Landings a second, or times real time, if that is the pace; zero otherwise.
        pace_hz: f64 = joint(HERTZ, "read with `pace` 3; with `pace` 4 up to 10^9") => "tempo.pace",
        /// 1 max, 2 real, 3 as many hertz, 4 as many times real time.
        pace: u32 = joint(whole(1, 4), "says what `pace_hz` is"),
        /// 1 while landings are held back.
        paused: u32 = FLAG,
        /// 1 if orders are obeyed.
        heeds: u32 = FLAG,
        /// Robot that is paced.
        robot: u32 = ROBOT,
    }
    of Pacing { run, robot, pace, paused, obeys: heeds }
    to_wire {
        let (pace, pace_hz) = &pace_to_wire(*pace);
    }
    from_wire(wire) {
        let pace = pace_from_wire("tempo.pace", pace, pace_hz)?;
    }
}

fn pace_to_wire(pace: Pace) -> (u32, f64) {
    match pace {
        Pace::Max => (1, 0.0),
        Pace::Real => (2, 0.0),
        Pace::Hertz(pace_hz) => (3, pace_hz),
        Pace::Times(times) => (4, times),
    }
}

fn pace_from_wire(field: &str, code: u32, pace_hz: f64) -> Result<Pace, Refusal> {
    match code {
        1 => Ok(Pace::Max),
        2 => Ok(Pace::Real),
        3 => Ok(Pace::Hertz(HERTZ.from_wire(field, pace_hz)?)),
        4 => Ok(Pace::Times(TIMES.from_wire(field, pace_hz)?)),
        _ => Err(unknown_tag(field, code)),
    }
}

fixed_payload!(Control => ControlV1);

/// Written by monitors that were started with `--control`; read by hopper-sim and planners.
impl Message for Control {
    const SERVICE: PublishSubscribe = PublishSubscribe {
        max_publishers: 4,
        max_subscribers: 24,
        history: 0,
        buffer: 16,
        ..PublishSubscribe::new("hop/control", &[Role::Monitor])
    };
}

fixed_payload!(Pacing => TempoV1);

/// Published when it changes, and again every second.
impl Message for Pacing {
    const SERVICE: PublishSubscribe = PublishSubscribe::new("hop/tempo", &[Role::HopperSim]);
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{RobotId, RunId};

    const RUN: RunId = RunId(7 << 64 | 9);

    #[test]
    fn every_order_survives_the_wire() {
        let orders = [
            Order::Pause,
            Order::Resume,
            Order::Step,
            Order::Pace(Pace::Max),
            Order::Pace(Pace::Real),
            Order::Pace(Pace::Hertz(2.5)),
            Order::Pace(Pace::Times(3600.0)),
            Order::HandOver(Incarnation(3)),
        ];
        for order in orders {
            let control = Control { run: RUN, robot: RobotId(1), order };
            assert_eq!(Control::try_from(&ControlV1::from(&control)), Ok(control));
        }
    }

    #[test]
    fn the_pacing_survives_the_wire() {
        for (pace, paused) in [(Pace::Max, false), (Pace::Real, true), (Pace::Hertz(0.5), true)] {
            let pacing = Pacing { run: RUN, robot: RobotId(0), pace, paused, obeys: !paused };
            assert_eq!(Pacing::try_from(&TempoV1::from(&pacing)), Ok(pacing));
        }
    }

    #[test]
    fn an_order_out_of_range_is_refused() {
        let order = Order::Pace(Pace::Hertz(1.0));
        let wire = ControlV1::from(&Control { run: RUN, robot: RobotId(0), order });
        for bad in [
            ControlV1 { order: 0, ..wire },
            ControlV1 { order: 6, ..wire },
            ControlV1 { order: 5, ..wire },
            ControlV1 { pace: 0, ..wire },
            ControlV1 { pace: 5, ..wire },
            ControlV1 { pace_hz: f64::NAN, ..wire },
            ControlV1 { pace_hz: -1.0, ..wire },
            ControlV1 { pace_hz: 1e9, ..wire },
            ControlV1 { robot: 70_000, ..wire },
        ] {
            assert!(Control::try_from(&bad).is_err(), "{bad:?}");
        }
    }
}
