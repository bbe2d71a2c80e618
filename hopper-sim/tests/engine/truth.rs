//! The truth is told in pages, to whoever asks about this run.

use contract::{RunId, Truth, TruthRequest};
use terrain::Terrain;

use crate::fixture::{RUN, mission};

#[test]
fn pages_of_any_size_add_up_to_the_truth_and_another_runs_is_not_told() {
    let mission = mission();
    let whole = mission.brief.grid.cells();
    for cells_max in [1, 7, whole, 10 * whole] {
        let mut follower = follow::TruthFollower::default();
        follower.begin(RUN);
        let mut now = contract::MonotonicNs(0);
        let mut truth = None;
        while truth.is_none() {
            let request = follower.ask(now).expect("what is missing is asked for");
            let page = mission.truth_page(&request, cells_max).expect("it is answered");
            assert!((1..=cells_max).contains(&page.cells.len()), "{cells_max}");
            truth = follower.page(page).unwrap();
            now = now.plus_ns(1);
        }
        let terrain = Terrain::clone(&mission.terrain);
        let (grid, cells, treasures) = (terrain.grid, terrain.cells, terrain.treasures);
        assert_eq!(truth, Some(Truth { run: RUN, grid, cells, treasures }), "{cells_max}");
    }
    let beyond = mission.truth_page(&TruthRequest { run: RUN, from: u32::MAX }, 7).unwrap();
    assert_eq!((beyond.from as usize, beyond.cells.len()), (whole, 0));
    assert_eq!(mission.truth_page(&TruthRequest { run: RunId(1), from: 0 }, 7), None);
}
