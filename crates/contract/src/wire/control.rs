//! `hop/rN/control` with `hop/rN/tempo`.

use bytemuck::{Pod, Zeroable};

use crate::Role;
use crate::fixed_payload;

use super::{Wire, flag, float, robot_from_wire, run_from_wire, run_to_wire};
use crate::message::{Message, PublishSubscribe};
use crate::mission::pace::{HERTZ_MAX, HERTZ_MIN, TIMES_MAX, TIMES_MIN};
use crate::{Control, Incarnation, Order, Pace, Pacing, Refusal};

#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct ControlV1 {
    /// Run that is meant, high half first.
    pub run: [u64; 2],
    /// Planner that shall take over; zero for other orders.
    pub incarnation: u64,
    /// Landings a second, or times real time, if that is the pace asked for; zero otherwise.
    pub pace_hz: f64,
    /// 1 pause, 2 resume, 3 step, 4 pace, 5 hand over.
    pub order: u32,
    /// Pace asked for: 0 none, 1 max, 2 real, 3 as many hertz, 4 as many times real time.
    pub pace: u32,
    pub robot: u32,
    pub reserved: u32,
}

#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct TempoV1 {
    pub run: [u64; 2],
    /// Landings a second, or times real time, if that is the pace; zero otherwise.
    pub pace_hz: f64,
    /// 1 max, 2 real, 3 as many hertz, 4 as many times real time.
    pub pace: u32,
    /// 1 while landings are held back.
    pub paused: u32,
    /// 1 if orders are heeded.
    pub heeds: u32,
    pub robot: u32,
}

const _: () = assert!(size_of::<ControlV1>() == 48);
const _: () = assert!(size_of::<TempoV1>() == 40);

impl Wire for ControlV1 {
    const NAME: &'static str = "hop.Control.v1";
}

impl Wire for TempoV1 {
    const NAME: &'static str = "hop.Tempo.v1";
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
        3 => Ok(Pace::Hertz(float(field, pace_hz, HERTZ_MIN, HERTZ_MAX)?)),
        4 => Ok(Pace::Times(float(field, pace_hz, TIMES_MIN, TIMES_MAX)?)),
        _ => Err(Refusal::malformed(field, "a known tag", code)),
    }
}

impl From<&Control> for ControlV1 {
    fn from(control: &Control) -> Self {
        let (order, pace, incarnation) = match control.order {
            Order::Pause => (1, None, Incarnation(0)),
            Order::Resume => (2, None, Incarnation(0)),
            Order::Step => (3, None, Incarnation(0)),
            Order::Pace(pace) => (4, Some(pace), Incarnation(0)),
            Order::HandOver(incarnation) => (5, None, incarnation),
        };
        let (pace, pace_hz) = pace.map_or((0, 0.0), pace_to_wire);
        Self {
            run: run_to_wire(control.run),
            incarnation: incarnation.0,
            pace_hz,
            order,
            pace,
            robot: u32::from(control.robot.0),
            reserved: 0,
        }
    }
}

impl TryFrom<&ControlV1> for Control {
    type Error = Refusal;

    fn try_from(wire: &ControlV1) -> Result<Self, Refusal> {
        let order = match wire.order {
            1 => Order::Pause,
            2 => Order::Resume,
            3 => Order::Step,
            4 => Order::Pace(pace_from_wire("control.pace", wire.pace, wire.pace_hz)?),
            5 if wire.incarnation != 0 => Order::HandOver(Incarnation(wire.incarnation)),
            5 => return Err(Refusal::malformed("control.incarnation", "not zero", 0)),
            code => return Err(Refusal::malformed("control.order", "a known tag", code)),
        };
        Ok(Self { run: run_from_wire(wire.run), robot: robot_from_wire(wire.robot)?, order })
    }
}

impl From<&Pacing> for TempoV1 {
    fn from(pacing: &Pacing) -> Self {
        let (pace, pace_hz) = pace_to_wire(pacing.pace);
        Self {
            run: run_to_wire(pacing.run),
            pace_hz,
            pace,
            paused: u32::from(pacing.paused),
            heeds: u32::from(pacing.obeys),
            robot: u32::from(pacing.robot.0),
        }
    }
}

impl TryFrom<&TempoV1> for Pacing {
    type Error = Refusal;

    fn try_from(wire: &TempoV1) -> Result<Self, Refusal> {
        Ok(Self {
            run: run_from_wire(wire.run),
            robot: robot_from_wire(wire.robot)?,
            pace: pace_from_wire("tempo.pace", wire.pace, wire.pace_hz)?,
            paused: flag("tempo.paused", wire.paused)?,
            obeys: flag("tempo.heeds", wire.heeds)?,
        })
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
        ..PublishSubscribe::new("hop/rN/control", &[Role::Monitor])
    };
}

fixed_payload!(Pacing => TempoV1);

/// Published when it changes, and again every second.
impl Message for Pacing {
    const SERVICE: PublishSubscribe = PublishSubscribe::new("hop/rN/tempo", &[Role::HopperSim]);
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
