//! Every stamp is the moment that it names, where each stage of each decision has a length of its own.

use simulation::fault::{Fault, Kind, Plan, points};
use simulation::setup::Missions;
use simulation::simulate;

/// Decisions at which processes are stopped: missions of these small worlds have fewer.
const DECISIONS: u64 = 130;

/// Nothing goes wrong, but every process stops for a while at every named point of every decision, each time for another while: so
/// no two moments of a decision are the same, and no two stages have one length.
fn unhurried(missions: Missions, seed: u64) -> Plan {
    let points: Vec<&'static str> =
        points().into_iter().filter(|point| !point.starts_with("monitor")).collect();
    let stop = |(decision, number): (u64, usize)| Fault {
        decision,
        after_ns: 0,
        kind: Kind::StopAt { point: points[number], ns: 83_000 * (number as u64 + 1) + 1_013 * decision },
    };
    let all = (0..DECISIONS).flat_map(|decision| (0..points.len()).map(move |number| (decision, number)));
    Plan { missions, seed, faults: all.map(stop).collect() }
}

/// P-STAMPS: Each stamp of states, patches, reminders, pages, commands, records and recordings is
/// the moment that it names, also when a message is sent again or a process restarts. Page,
/// monitor, summary, `timing.csv` and latency report have the times that follow from these stamps.
/// Every seed of the simulation checks it, with a different length for each stage and for robots of
/// every kind.
#[test]
fn every_stamp_is_the_moment_that_it_names() {
    let all = [
        Missions::Hopper,
        Missions::Rovers,
        Missions::Scouts,
        Missions::Accompanied,
        Missions::Mixed,
        Missions::Protocol,
    ];
    for missions in all {
        let (mut decisions, mut recordings) = (0, 0);
        for seed in 0..40 {
            let report = simulate(&unhurried(missions, seed), false);
            assert_eq!(report.violation, None, "{missions:?}, seed {seed}");
            decisions += report.decisions;
            recordings += report.coverage.of("recording", "acknowledged");
            let stopped = ["sim.appended", "perception.sensed", "planner.planned", "planner.map_received"]
                .map(|point| report.coverage.of("stopped_at", point));
            assert!(
                report.decisions == 0 || stopped.iter().all(|times| *times > 0),
                "{missions:?} {seed}: {stopped:?}"
            );
        }
        assert!(
            decisions > 200 && recordings > 3,
            "{missions:?}: {decisions} decisions, {recordings} recordings"
        );
    }
}
