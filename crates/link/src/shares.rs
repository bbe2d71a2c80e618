//! Who may send next, if several have something to send.

/// Shares of the budget. Whoever has had least for its weight is next, so each of those that wait gets its share, and
/// what one does not use the others get.
#[derive(Clone, Debug)]
pub struct Shares<const N: usize> {
    weights: [u64; N],
    /// Bits that each has had, divided by its weight.
    had: [u64; N],
}

impl<const N: usize> Shares<N> {
    /// Shares in the proportion of `weights`, none of which is 0.
    pub fn new(weights: [u64; N]) -> Self {
        Self { weights, had: [0; N] }
    }

    /// Who of those that have something is next; the first of equals.
    pub fn next(&self, has: [bool; N]) -> Option<usize> {
        (0..N).filter(|place| has[*place]).min_by_key(|place| self.had[*place])
    }

    /// `place` has sent so many bits. Those that had nothing to send do not save up.
    pub fn sent(&mut self, place: usize, bits: u64, has: [bool; N]) {
        let least = self.next(has).map_or(0, |next| self.had[next]);
        for (other, had) in self.had.iter_mut().enumerate() {
            if !has[other] {
                *had = (*had).max(least);
            }
        }
        self.had[place] = self.had[place].saturating_add(bits * 1024 / self.weights[place]);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_gets_its_share_and_what_one_leaves_the_others_get() {
        let mut shares = Shares::new([1, 3]);
        let mut bits = [0_u64; 2];
        for _ in 0..4000 {
            let next = shares.next([true, true]).unwrap();
            bits[next] += 100;
            shares.sent(next, 100, [true, true]);
        }
        assert_eq!(bits, [100_000, 300_000]);
        for _ in 0..1000 {
            shares.sent(1, 100, [false, true]);
        }
        // The first has saved nothing up.
        let next = (0..8).map(|_| {
            let next = shares.next([true, true]).unwrap();
            shares.sent(next, 100, [true, true]);
            next
        });
        assert!(next.filter(|next| *next == 0).count() <= 3);
        assert_eq!(shares.next([false, false]), None);
    }
}
