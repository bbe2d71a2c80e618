//! Cells beside nodata whose heights a resampling has interpolated between ground and the value of nodata.

/// How far from a cell of nodata such cells are looked for, cells.
const REACH: u8 = 4;

/// They differ from all ground by more than this share of the way to the value of nodata: the weight of one cell of that in
/// a mean of a hundred.
const SHARE_MIN: f64 = 0.01;

/// Takes such cells out of `values`, rows of `width`: NaN stands in their place. How many there are.
///
/// `was_number` says which cells held a number before nodata was taken out, `nodata` which numbers were. A cell goes that lies
/// outside of the heights further away from nodata by more than their range.
pub(crate) fn remove(values: &mut [f64], width: usize, was_number: &[bool], nodata: &[f64]) -> u64 {
    if nodata.is_empty() {
        return 0;
    }
    let near = near(values, width, was_number);
    let (mut min, mut max) = (f64::INFINITY, f64::NEG_INFINITY);
    for (value, _) in values.iter().zip(&near).filter(|(value, near)| !**near && !value.is_nan()) {
        (min, max) = (min.min(*value), max.max(*value));
    }
    // Without differences there is nothing to measure by.
    if min >= max {
        return 0;
    }
    let is_between = |value: f64| {
        let gap = (min - value).max(value - max);
        let is_on_the_way = |nodata: f64| {
            let is_same_side = nodata < value && value < min || nodata > value && value > max;
            is_same_side && gap > SHARE_MIN * (nodata - value).abs()
        };
        gap > max - min && nodata.iter().copied().any(is_on_the_way)
    };
    let mut cells = 0;
    for (value, _) in values.iter_mut().zip(&near).filter(|(_, near)| **near) {
        if is_between(*value) {
            *value = f64::NAN;
            cells += 1;
        }
    }
    cells
}

/// Which cells lie within [`REACH`] of a cell that held a number and holds none any more.
fn near(values: &[f64], width: usize, was_number: &[bool]) -> Vec<bool> {
    let mut near: Vec<bool> =
        values.iter().zip(was_number).map(|(value, was_number)| *was_number && value.is_nan()).collect();
    let height = near.len() / width;
    let mut edge: Vec<usize> = (0..near.len()).filter(|index| near[*index]).collect();
    for _ in 0..REACH {
        let mut next = Vec::new();
        for index in edge {
            let (x, y) = (index % width, index / width);
            for row in y.saturating_sub(1)..(y + 2).min(height) {
                for column in x.saturating_sub(1)..(x + 2).min(width) {
                    let neighbour = row * width + column;
                    if !near[neighbour] {
                        near[neighbour] = true;
                        next.push(neighbour);
                    }
                }
            }
        }
        edge = next;
    }
    near
}

#[cfg(test)]
mod tests {
    use super::*;

    const SIDE: usize = 30;

    /// Ground from 100 to 103 m, a third of which is `fill`, as means of so many cells a side.
    fn averaged(fill: f64, side: usize) -> Vec<f64> {
        let at = |x: usize, y: usize| if x < 10 { fill } else { 100.0 + ((x + y) % 4) as f64 };
        let mean = |x: usize, y: usize| {
            let half = side / 2;
            let columns = x.saturating_sub(half)..=(x + half).min(SIDE - 1);
            let cells: Vec<f64> = columns
                .flat_map(|x| (y.saturating_sub(half)..=(y + half).min(SIDE - 1)).map(move |y| at(x, y)))
                .collect();
            cells.iter().sum::<f64>() / cells.len() as f64
        };
        (0..SIDE * SIDE).map(|index| mean(index % SIDE, index / SIDE)).collect()
    }

    fn removed(mut values: Vec<f64>, fill: f64) -> u64 {
        let was_number = vec![true; values.len()];
        for value in values.iter_mut().filter(|value| **value == fill) {
            *value = f64::NAN;
        }
        remove(&mut values, SIDE, &was_number, &[fill])
    }

    #[test]
    fn cells_between_ground_and_nodata_are_taken_out_beside_it() {
        for fill in [-9999.0, -32768.0, 1e5] {
            for side in [3, 5] {
                let expected = (side - 1) * SIDE;
                assert_eq!(removed(averaged(fill, side), fill), expected as u64, "{fill} {side}");
            }
            assert_eq!(removed(averaged(fill, 1), fill), 0);
        }
        // A cliff beside a gap is no such cell, and neither is a spike on the other side.
        let mut cliff = averaged(-9999.0, 1);
        cliff[SIDE + 10] = 60.0;
        cliff[SIDE + 11] = 900.0;
        assert_eq!(removed(cliff, -9999.0), 0);
        assert_eq!(removed(averaged(-9999.0, 3), 7.0), 0);
    }
}
