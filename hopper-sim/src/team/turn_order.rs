//! Which robot of a team acts next: simulated clocks, and the order that follows from them.
//!
//! Every robot has a clock, in nanoseconds of simulated time from the beginning of the mission: the moment from which it
//! is ready for its next action. A decision is the turn of one robot. The robot that is due is the one with the least
//! (clock, number) among those that are neither parked nor done, so a robot that acts in short steps has more turns than
//! one whose actions last long, and equal steps make the robots act in the order of their numbers.
//!
//! Outcomes are public when they are committed. A robot may therefore know what another one does up to one action
//! early in simulated time.

use contract::RobotId;

/// The shortest action, nanoseconds of simulated time. A robot without end of turns at one moment would keep all others
/// from theirs.
pub const ACTION_MIN_NS: u64 = 1_000_000_000;

/// How long an action of `seconds` lasts, nanoseconds: rounded to the nearest, halves away from zero, and at least
/// [`ACTION_MIN_NS`]. The one place where simulated time is rounded.
#[must_use]
pub fn duration_ns(seconds: f64) -> u64 {
    // The cast saturates, and takes NaN for 0.
    ((seconds * 1.0e9).round() as u64).max(ACTION_MIN_NS)
}

/// Whether a robot takes turns.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Readiness {
    /// It acts once its clock is the least.
    Ready,
    /// It waits for another robot to act.
    Parked,
    /// It acts no more.
    Done,
}

/// How the turns stand.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Due {
    /// This robot acts next.
    Robot(RobotId),
    /// Nobody can act, and at least one robot is parked: nothing will wake it.
    Deadlock,
    /// All robots are done.
    AllDone,
}

/// The clocks of all robots of a mission.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct TurnOrder {
    /// In the order of the robots' numbers.
    clocks: Vec<Clock>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Clock {
    ready_at_ns: u64,
    readiness: Readiness,
}

impl TurnOrder {
    /// All of `robots` robots ready at time 0.
    ///
    /// # Panics
    /// If there is none.
    #[must_use]
    pub fn new(robots: u16) -> Self {
        assert!(robots > 0, "a mission has at least one robot");
        let clock = Clock { ready_at_ns: 0, readiness: Readiness::Ready };
        Self { clocks: vec![clock; robots.into()] }
    }

    /// The robot whose clock is least among those that are ready; of equals the lowest number.
    #[must_use]
    pub fn due(&self) -> Due {
        let robots = (0..).map(RobotId).zip(&self.clocks);
        let ready = robots.filter(|(_, clock)| clock.readiness == Readiness::Ready);
        match ready.min_by_key(|(robot, clock)| (clock.ready_at_ns, *robot)) {
            Some((robot, _)) => Due::Robot(robot),
            None if self.clocks.iter().any(|clock| clock.readiness == Readiness::Parked) => Due::Deadlock,
            None => Due::AllDone,
        }
    }

    /// The clock of `robot`, nanoseconds.
    ///
    /// # Panics
    /// If the mission has no such robot; so for all robots named here.
    #[must_use]
    pub fn ready_at_ns(&self, robot: RobotId) -> u64 {
        self.clocks[usize::from(robot.0)].ready_at_ns
    }

    /// Whether `robot` takes turns.
    #[must_use]
    pub fn readiness(&self, robot: RobotId) -> Readiness {
        self.clocks[usize::from(robot.0)].readiness
    }

    /// `robot`, whose turn it is, has acted for `duration_ns`. Whoever is parked wakes when that action ends, or when its
    /// own clock comes if that is later.
    ///
    /// # Panics
    /// If it is another robot's turn, or the action was shorter than [`ACTION_MIN_NS`].
    pub fn act(&mut self, robot: RobotId, duration_ns: u64) {
        assert!(
            duration_ns >= ACTION_MIN_NS,
            "an action lasts {ACTION_MIN_NS} ns at least, not {duration_ns}"
        );
        let clock = self.turn_of(robot);
        clock.ready_at_ns = clock.ready_at_ns.saturating_add(duration_ns);
        let end_ns = clock.ready_at_ns;
        for clock in self.clocks.iter_mut().filter(|clock| clock.readiness == Readiness::Parked) {
            *clock = Clock { ready_at_ns: clock.ready_at_ns.max(end_ns), readiness: Readiness::Ready };
        }
    }

    /// `robot`, whose turn it is, waits for another one to act.
    ///
    /// # Panics
    /// If it is another robot's turn.
    pub fn park(&mut self, robot: RobotId) {
        self.turn_of(robot).readiness = Readiness::Parked;
    }

    /// `robot` does not act before that moment, nanoseconds of simulated time.
    pub fn put_off(&mut self, robot: RobotId, ready_at_ns: u64) {
        let clock = &mut self.clocks[usize::from(robot.0)];
        clock.ready_at_ns = clock.ready_at_ns.max(ready_at_ns);
    }

    /// `robot` acts no more, whoever's turn it is.
    pub fn finish(&mut self, robot: RobotId) {
        self.clocks[usize::from(robot.0)].readiness = Readiness::Done;
    }

    fn turn_of(&mut self, robot: RobotId) -> &mut Clock {
        let due = self.due();
        assert!(due == Due::Robot(robot), "robot {robot} acts out of turn: {due:?}");
        &mut self.clocks[usize::from(robot.0)]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    const S: u64 = 1_000_000_000;

    fn due(order: &TurnOrder) -> u16 {
        match order.due() {
            Due::Robot(robot) => robot.0,
            none => panic!("somebody is ready: {none:?}"),
        }
    }

    #[test]
    fn equal_steps_make_the_robots_act_in_the_order_of_their_numbers() {
        let mut order = TurnOrder::new(3);
        for turn in 0..9 {
            assert_eq!(due(&order), turn % 3);
            order.act(RobotId(turn % 3), S);
        }
        assert_eq!(order.ready_at_ns(RobotId(1)), 3 * S);
    }

    #[test]
    fn who_acts_briefly_has_more_turns() {
        let mut order = TurnOrder::new(2);
        let turns: Vec<u16> = (0..8)
            .map(|_| {
                let robot = due(&order);
                order.act(RobotId(robot), if robot == 0 { S } else { 3 * S });
                robot
            })
            .collect();
        assert_eq!(turns, [0, 1, 0, 0, 0, 1, 0, 0]);
    }

    #[test]
    fn the_parked_wake_at_the_end_of_the_next_action_and_never_before_their_own_clock() {
        let mut order = TurnOrder::new(3);
        order.park(RobotId(0));
        order.act(RobotId(1), 5 * S);
        assert_eq!((order.readiness(RobotId(0)), order.ready_at_ns(RobotId(0))), (Readiness::Ready, 5 * S));
        order.act(RobotId(2), S);
        order.act(RobotId(2), 2 * S);
        assert_eq!(order.ready_at_ns(RobotId(0)), 5 * S, "who is ready is not woken");
        order.act(RobotId(2), 3 * S);
        order.park(RobotId(0));
        order.park(RobotId(1));
        order.act(RobotId(2), S);
        assert_eq!([0, 1, 2].map(|robot| order.ready_at_ns(RobotId(robot))), [7 * S; 3]);
        let mut late = TurnOrder::new(2);
        late.act(RobotId(0), 9 * S);
        late.act(RobotId(1), 10 * S);
        late.park(RobotId(0));
        assert_eq!(due(&late), 1);
        late.act(RobotId(1), S);
        assert_eq!(late.ready_at_ns(RobotId(0)), 11 * S);
    }

    #[test]
    fn to_wait_as_the_last_that_is_ready_is_a_deadlock_and_so_is_to_leave_only_parked_robots() {
        let mut order = TurnOrder::new(2);
        order.park(RobotId(0));
        let mut left_alone = order.clone();
        order.park(RobotId(1));
        assert_eq!(order.due(), Due::Deadlock);
        left_alone.finish(RobotId(1));
        assert_eq!(left_alone.due(), Due::Deadlock);
        left_alone.finish(RobotId(0));
        assert_eq!(left_alone.due(), Due::AllDone);
        let mut alone = TurnOrder::new(1);
        alone.park(RobotId(0));
        assert_eq!(alone.due(), Due::Deadlock);
    }

    #[test]
    fn a_robot_that_is_done_has_no_turn_and_wakes_nobody() {
        let mut order = TurnOrder::new(3);
        order.finish(RobotId(0));
        assert_eq!(due(&order), 1);
        order.park(RobotId(1));
        order.finish(RobotId(2));
        assert_eq!(order.readiness(RobotId(1)), Readiness::Parked);
        assert_eq!(order.due(), Due::Deadlock);
    }

    #[test]
    #[should_panic(expected = "robot 1 acts out of turn")]
    fn nobody_acts_out_of_turn() {
        TurnOrder::new(2).act(RobotId(1), S);
    }

    #[test]
    fn seconds_are_rounded_to_the_nearest_nanosecond_and_to_one_second_at_least() {
        let cases = [
            (1.0, S),
            (0.0, S),
            (-5.0, S),
            (f64::NAN, S),
            (1.000_000_000_4, S),
            (1.000_000_000_6, S + 1),
            (88_776.0, 88_776 * S),
            (f64::INFINITY, u64::MAX),
        ];
        for (seconds, ns) in cases {
            assert_eq!(duration_ns(seconds), ns, "{seconds} s");
        }
    }

    #[test]
    fn a_clock_at_its_end_stays_there() {
        let mut order = TurnOrder::new(1);
        order.act(RobotId(0), u64::MAX);
        order.act(RobotId(0), S);
        assert_eq!(order.ready_at_ns(RobotId(0)), u64::MAX);
    }

    /// What a robot does with its turn.
    #[derive(Clone, Copy, Debug)]
    enum Turn {
        Act(u64),
        Park,
        Finish,
    }

    fn turns() -> impl Strategy<Value = Vec<Turn>> {
        let turn = prop_oneof![
            12 => (1..4_u64).prop_map(|seconds| Turn::Act(seconds * S)),
            4 => Just(Turn::Park),
            1 => Just(Turn::Finish),
        ];
        prop::collection::vec(turn, 0..200)
    }

    proptest! {
        /// The order is that of a plain simulation: sort everyone who is ready, take the first.
        #[test]
        fn turns_are_those_of_a_sorted_list_and_time_never_runs_backwards(robots in 1..=16_u16, turns in turns()) {
            let mut order = TurnOrder::new(robots);
            let mut plain: Vec<(u64, u16)> = (0..robots).map(|robot| (0, robot)).collect();
            let mut parked: Vec<(u64, u16)> = Vec::new();
            let mut last_turn = 0;
            for turn in turns {
                plain.sort_unstable();
                let expected = plain.first().map(|&(_, robot)| Due::Robot(RobotId(robot)));
                let over = if parked.is_empty() { Due::AllDone } else { Due::Deadlock };
                prop_assert_eq!(order.due(), expected.unwrap_or(over));
                let Some(&(at, robot)) = plain.first() else { break };
                prop_assert!(at >= last_turn, "turns come in the order of simulated time");
                last_turn = at;
                match turn {
                    Turn::Act(ns) => {
                        order.act(RobotId(robot), ns);
                        plain[0].0 += ns;
                        plain.extend(parked.drain(..).map(|(own, robot)| (own.max(at + ns), robot)));
                    }
                    Turn::Park => {
                        order.park(RobotId(robot));
                        parked.push(plain.remove(0));
                    }
                    Turn::Finish => {
                        order.finish(RobotId(robot));
                        plain.remove(0);
                    }
                }
                for &(at, robot) in plain.iter().chain(&parked) {
                    prop_assert_eq!(order.ready_at_ns(RobotId(robot)), at);
                }
            }
        }

        /// Nobody starves: who is ready acts within as many turns as the others can fit into one longest action each.
        #[test]
        fn whoever_is_ready_gets_its_turn(robots in 2..=16_u16, seconds in prop::collection::vec(1..4_u64, 200)) {
            let mut order = TurnOrder::new(robots);
            let mut waited = vec![0; robots.into()];
            for seconds in seconds {
                let robot = due(&order);
                order.act(RobotId(robot), seconds * S);
                waited.iter_mut().for_each(|turns| *turns += 1);
                waited[usize::from(robot)] = 0;
                prop_assert!(waited.iter().all(|turns| *turns <= 4 * usize::from(robots)), "{:?}", waited);
            }
        }
    }
}
