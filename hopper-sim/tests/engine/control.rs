//! Orders move landings in time, never an outcome.

use contract::{Control, Guard, Incarnation, MonotonicNs, Order, Origin, Pace, RobotId, RunId};
use hopper_sim::throttle::{ORDERS_MAX, WINDOW_NS};
use hopper_sim::{Arbiter, Event, Mission, ROBOT};
use proptest::prelude::*;

use crate::fixture::{EAST, Host, LINGER_NS, RUN, command, mission, steer, undisturbed};

const SECOND_NS: u64 = 1_000_000_000;

/// A host that obeys orders.
fn heeding(pace: Pace) -> Host {
    heeding_on(mission(), pace)
}

fn heeding_on(mission: Mission, pace: Pace) -> Host {
    let mut host = Host::new(mission.clone(), Vec::new(), pace);
    host.arbiter = Arbiter::new(mission, None, pace, LINGER_NS, host.now).obeying_orders();
    host.on(Event::Tick);
    host
}

fn give(host: &mut Host, order: Order) {
    host.on(Event::Control(Ok(Control { run: RUN, robot: ROBOT, order })));
}

fn hop(host: &mut Host) {
    let state = host.state();
    host.send(command(&state, EAST));
}

#[test]
fn a_pause_holds_the_landing_and_costs_no_decision_time() {
    let mut host = heeding(Pace::Hertz(10.0));
    give(&mut host, Order::Pause);
    assert!(host.arbiter.pacing().paused);
    hop(&mut host);
    host.tick_after(60 * SECOND_NS);
    assert_eq!(host.state().decision.0, 0, "it is still in the air");
    assert!(host.arbiter.wake_at().is_some_and(|at| at > host.now), "nobody waits awake for it");
    give(&mut host, Order::Resume);
    assert_eq!(host.state().decision.0, 1);
    assert_eq!(host.state().landed, host.now, "the pause belongs to the flight");
}

/// P-CONTROL. A pause counts for no decision's time, so no deadline expires in it.
#[test]
fn no_fallback_acts_in_a_pause() {
    let mut mission = mission();
    mission.brief.guard = Guard { deadline_ns: SECOND_NS, ..Guard::OFF };
    let mut host = heeding_on(mission, Pace::Hertz(10.0));
    give(&mut host, Order::Pause);
    hop(&mut host);
    for _ in 0..60 {
        host.tick_after(SECOND_NS);
    }
    assert_eq!(host.records.len(), 1, "the hop in the air, and no other");
    give(&mut host, Order::Resume);
    hop(&mut host);
    assert_eq!(
        host.records.last().map(|record| record.origin),
        Some(Origin::Planner),
        "the planner is in time"
    );
    host.tick_after(SECOND_NS);
    host.tick_after(2 * SECOND_NS);
    assert_eq!(host.records.last().map(|record| record.origin), Some(Origin::Greedy), "later it is not");
}

#[test]
fn a_step_lets_one_landing_come() {
    let mut host = heeding(Pace::Hertz(0.001));
    give(&mut host, Order::Pause);
    for landings in 1..4 {
        hop(&mut host);
        host.tick_after(SECOND_NS);
        give(&mut host, Order::Step);
        assert_eq!(host.state().decision.0, landings);
    }
    give(&mut host, Order::Step);
    hop(&mut host);
    assert_eq!(host.state().decision.0, 3, "a step given at rest is for the hop that comes, at its pace");
    host.tick_after(2_000 * SECOND_NS);
    assert_eq!(host.state().decision.0, 4);
    hop(&mut host);
    host.tick_after(2_000 * SECOND_NS);
    assert_eq!(host.state().decision.0, 4, "and for no other");
    give(&mut host, Order::Resume);
    give(&mut host, Order::Step);
    assert!(!host.arbiter.pacing().paused, "a step means nothing where there is no pause");
}

#[test]
fn a_new_pace_counts_for_the_hop_in_the_air() {
    let mut host = heeding(Pace::Hertz(0.001));
    hop(&mut host);
    host.tick_after(SECOND_NS);
    assert_eq!(host.state().decision.0, 0);
    give(&mut host, Order::Pace(Pace::Max));
    assert_eq!((host.state().decision.0, host.state().landed), (1, host.now));
    assert_eq!(host.arbiter.pacing().pace, Pace::Max);
}

/// P-WEB-LEAVE. Whatever a page tells it, hopper-sim started without `--control` obeys no order.
#[test]
fn without_leave_or_for_another_run_or_robot_or_in_a_flood_orders_are_refused_and_counted() {
    let mut deaf = Host::new(mission(), Vec::new(), Pace::Max);
    give(&mut deaf, Order::Pause);
    assert!(!deaf.arbiter.pacing().paused && !deaf.arbiter.pacing().obeys);
    assert_eq!(deaf.refused, ["malformed"]);

    let mut host = heeding(Pace::Max);
    let order = Order::Pause;
    host.on(Event::Control(Ok(Control { run: RunId(1), robot: ROBOT, order })));
    host.on(Event::Control(Ok(Control { run: RUN, robot: RobotId(3), order })));
    assert!(!host.arbiter.pacing().paused);
    assert_eq!(host.refused, ["wrong_run", "wrong_robot"]);
    for _ in 0..ORDERS_MAX {
        give(&mut host, Order::HandOver(Incarnation(9)));
    }
    give(&mut host, order);
    assert!(!host.arbiter.pacing().paused, "a flood is not heard to its end");
    host.now = host.now.plus_ns(WINDOW_NS);
    give(&mut host, order);
    assert!(host.arbiter.pacing().paused);
}

proptest! {
    /// P-CONTROL: No digest depends on pause, step, pace or hand-over, whatever their timing, and
    /// no deadline expires during a pause.
    #[test]
    fn no_order_changes_an_outcome(
        orders in prop::collection::vec((0u8..6, 0u64..2 * SECOND_NS), 1..60),
        hertz in 0.5f64..1e4,
    ) {
        let mut host = heeding(Pace::Hertz(50.0));
        let mut orders = orders.into_iter();
        while !host.state().status.is_over() {
            let state = host.state();
            match orders.next() {
                Some((kind, wait_ns)) => {
                    let order = [
                        Order::Pause, Order::Resume, Order::Step, Order::Pace(Pace::Max),
                        Order::Pace(Pace::Hertz(hertz)), Order::HandOver(Incarnation(2)),
                    ][usize::from(kind)];
                    give(&mut host, order);
                    host.send(command(&state, steer(&mission().brief, &state)));
                    host.tick_after(wait_ns);
                }
                None => {
                    host.now = host.now.max(MonotonicNs(1)).plus_ns(2 * SECOND_NS);
                    give(&mut host, Order::Resume);
                    let state = host.state();
                    host.send(command(&state, steer(&mission().brief, &state)));
                    host.tick_after(2 * SECOND_NS);
                }
            }
        }
        let digests = |records: &[contract::Record]| records.iter().map(|r| r.digest).collect::<Vec<_>>();
        prop_assert_eq!(digests(&host.records), digests(&undisturbed()));
    }
}
