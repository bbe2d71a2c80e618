//! The least probability of being lost on the way to a goal.

use super::Process;

/// Most sweeps.
const SWEEPS_MAX: u32 = 20_000;

/// The change of a sweep that ends the iteration.
const SETTLED: f64 = 1e-13;

/// Enclosure of the least risk: 1 − max P(goal) over all policies.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LeastRisk {
    /// No policy that arrives with all its remaining probability risks less.
    pub at_least: f64,
    /// Some policy risks no more.
    pub at_most: f64,
}

/// The least risk from a place, given that a policy risks at most `achieved` there.
///
/// Places between which the hopper can go to and fro for ever without risk are merged first (maximal end components): among them all have the best
/// exit of any. Iterating max P(goal) from 1 downwards then converges, and each iterate bounds it from above, so an iteration that is cut short
/// is sound as well.
#[must_use]
pub fn least_risk(process: &Process, place: usize, achieved: f64, pulse: &dyn Fn()) -> LeastRisk {
    let components = EndComponents::of(process, pulse);
    let mut best = vec![1.0_f64; components.count];
    for _ in 0..SWEEPS_MAX {
        let mut change: f64 = 0.0;
        for component in 0..components.count {
            let mut most: f64 = 0.0;
            for member in components.members(component) {
                for hop in 0..4 {
                    let arrives = arrives(process, &components, &best, *member as usize, hop);
                    most = most.max(arrives.unwrap_or(0.0));
                }
            }
            change = change.max(best[component] - most);
            best[component] = best[component].min(most);
        }
        pulse();
        if change <= SETTLED {
            break;
        }
    }
    let most = best[components.of[place] as usize];
    let at_least = (1.0 - most - SETTLED).clamp(0.0, achieved);
    LeastRisk { at_least, at_most: achieved }
}

/// The probability of a goal after a hop that can leave its component; `None` for any other.
fn arrives(
    process: &Process,
    components: &EndComponents,
    best: &[f64],
    place: usize,
    hop: usize,
) -> Option<f64> {
    let row = process.row(place, hop);
    if !row.is_useful() {
        return None;
    }
    let own = components.of[place];
    let (mut within, mut elsewhere, mut sum) = (row.stays, 0.0, 0.0);
    for (to, probability) in process.landings(place, hop) {
        let component = components.of[to];
        if component == own {
            within += probability;
        } else {
            elsewhere += probability;
            sum += probability * best[component as usize];
        }
    }
    let leaves = 1.0 - within;
    let is_internal = components.is_internal(process, place, hop);
    if is_internal || leaves <= 0.0 {
        return None;
    }
    // What is neither within, nor elsewhere, nor lost is at a goal.
    let goal = (leaves - elsewhere - row.lost).max(0.0);
    Some((sum + goal) / leaves)
}

/// A partition of the places into maximal end components, and single places that are in none.
struct EndComponents {
    /// Component of each place.
    of: Vec<u32>,
    count: usize,
    /// Places by component, and the first of each.
    places: Vec<u32>,
    first: Vec<u32>,
}

impl EndComponents {
    fn of(process: &Process, pulse: &dyn Fn()) -> Self {
        let places = process.places();
        // Hops that stay within their component, as bits. At first all that neither may be lost nor reach a goal.
        let mut kept: Vec<u8> = (0..places)
            .map(|place| (0..4).filter(|hop| is_closed(process, place, *hop)).map(|hop| 1 << hop).sum())
            .collect();
        let mut of = vec![0_u32; places];
        loop {
            let count = strongly_connected(process, &kept, &mut of);
            pulse();
            let mut is_same = true;
            for place in 0..places {
                for hop in 0..4 {
                    let leaves = || process.landings(place, hop).any(|(to, _)| of[to] != of[place]);
                    if kept[place] >> hop & 1 == 1 && leaves() {
                        kept[place] &= !(1 << hop);
                        is_same = false;
                    }
                }
            }
            if is_same {
                return Self::by(of, count);
            }
        }
    }

    fn by(of: Vec<u32>, count: usize) -> Self {
        let mut first = vec![0_u32; count + 1];
        for component in &of {
            first[*component as usize + 1] += 1;
        }
        for component in 0..count {
            first[component + 1] += first[component];
        }
        let mut next = first.clone();
        let mut places = vec![0_u32; of.len()];
        for (place, component) in of.iter().enumerate() {
            let at = &mut next[*component as usize];
            places[*at as usize] = place as u32;
            *at += 1;
        }
        Self { of, count, places, first }
    }

    fn members(&self, component: usize) -> &[u32] {
        &self.places[self.first[component] as usize..self.first[component + 1] as usize]
    }

    /// Whether a hop cannot leave the component of its place.
    fn is_internal(&self, process: &Process, place: usize, hop: usize) -> bool {
        is_closed(process, place, hop)
            && process.landings(place, hop).all(|(to, _)| self.of[to] == self.of[place])
    }
}

/// Whether a hop can neither be lost nor reach a goal. Probabilities that should sum to 1 may miss it by rounding.
fn is_closed(process: &Process, place: usize, hop: usize) -> bool {
    const ROUNDING: f64 = 1e-12;
    let row = process.row(place, hop);
    let within: f64 =
        row.stays + process.landings(place, hop).map(|(_, probability)| probability).sum::<f64>();
    row.is_useful() && row.lost == 0.0 && within > 1.0 - ROUNDING
}

/// The strongly connected components of the places under the kept hops, into `of`; how many there are (Tarjan 1972, without recursion).
fn strongly_connected(process: &Process, kept: &[u8], of: &mut [u32]) -> usize {
    const UNSEEN: u32 = u32::MAX;
    let places = process.places();
    let mut index = vec![UNSEEN; places];
    let mut low = vec![0_u32; places];
    let mut is_open = vec![false; places];
    let (mut open, mut path): (Vec<u32>, Vec<(u32, u8, u32)>) = (Vec::new(), Vec::new());
    let (mut next, mut count) = (0_u32, 0_usize);
    for root in 0..places {
        if index[root] != UNSEEN {
            continue;
        }
        path.push((root as u32, 0, 0));
        while let Some((place, hop, landing)) = path.pop() {
            let at = place as usize;
            if hop == 0 && landing == 0 {
                (index[at], low[at], is_open[at]) = (next, next, true);
                next += 1;
                open.push(place);
            }
            let (mut hop, mut landing) = (hop, landing);
            let mut below = None;
            while hop < 4 && below.is_none() {
                let is_kept = kept[at] >> hop & 1 == 1;
                let to =
                    if is_kept { process.landings(at, usize::from(hop)).nth(landing as usize) } else { None };
                let Some((to, _)) = to else {
                    (hop, landing) = (hop + 1, 0);
                    continue;
                };
                landing += 1;
                if index[to] == UNSEEN {
                    below = Some(to);
                } else if is_open[to] {
                    low[at] = low[at].min(index[to]);
                }
            }
            if let Some(to) = below {
                path.push((place, hop, landing));
                path.push((to as u32, 0, 0));
                continue;
            }
            if low[at] == index[at] {
                while let Some(member) = open.pop() {
                    is_open[member as usize] = false;
                    of[member as usize] = count as u32;
                    if member == place {
                        break;
                    }
                }
                count += 1;
            }
            if let Some((parent, _, _)) = path.last() {
                let parent = *parent as usize;
                low[parent] = low[parent].min(low[at]);
            }
        }
    }
    count
}
