#![allow(clippy::all, missing_docs, clippy::unwrap_used, clippy::print_stdout, clippy::disallowed_methods)]
use scouting::*;
struct Instant(u64);
impl Instant {
    fn now() -> Self {
        Self(
            std::fs::read_to_string("/proc/thread-self/schedstat")
                .unwrap()
                .split(' ')
                .next()
                .unwrap()
                .parse()
                .unwrap(),
        )
    }
    fn elapsed(&self) -> std::time::Duration {
        std::time::Duration::from_nanos(Self::now().0 - self.0)
    }
}
fn main() {
    let args: Vec<String> = std::env::args().collect();
    let runs: u64 = args[1].parse().unwrap();
    let first: u64 = args.get(3).map_or(1, |s| s.parse().unwrap());
    let planner = if args.get(2).map(String::as_str) == Some("exact") {
        RoverPlanner::EttExact
    } else {
        RoverPlanner::RrtStarEtt
    };
    let s = Samples::MONTE_CARLO;
    let mut studies: Vec<Study> = Arm::ALL.iter().map(|_| Study { outcomes: vec![] }).collect();
    let mut spent = [0.0; 7];
    for seed in first..first + runs {
        let world = monte_carlo(seed);
        let t = Instant::now();
        let announced = announce(&world, planner, s, seed);
        spent[6] += t.elapsed().as_secs_f64();
        for (i, arm) in Arm::ALL.into_iter().enumerate() {
            let t = Instant::now();
            studies[i].outcomes.push(fly(&world, arm, planner, s, seed, announced.as_ref()));
            spent[i] += t.elapsed().as_secs_f64();
        }
    }
    for (i, arm) in Arm::ALL.into_iter().enumerate() {
        let (a, b) = (studies[i].mean_paired_saving(&studies[1]), studies[i].median_saving(&studies[1]));
        println!(
            "{:40} stuck {:5} none {:3} median {:.4} sd {:.4} paired {:6.3}% ({:.3}..{:.3}) median saving {:6.3}% ({:.2}..{:.2}) {:.2} ms",
            arm.name(),
            studies[i].stuck(),
            studies[i].without_route(),
            studies[i].median_sol(),
            studies[i].sd_sol(),
            a.value * 100.,
            a.low * 100.,
            a.high * 100.,
            b.value * 100.,
            b.low * 100.,
            b.high * 100.,
            1e3 * spent[i] / runs as f64
        );
    }
    println!("announce {:.2} ms", 1e3 * spent[6] / runs as f64);
}
