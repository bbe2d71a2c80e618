//! Which of many large messages are kept, so that a bag stays within a size.

/// Keeps every so many messages of a series, and the last.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Thinning {
    stride: usize,
    last: usize,
}

impl Thinning {
    /// Keeps as many of messages with these sizes as fit into `bytes_max`, evenly; always the last. A size is that of the message
    /// wherever it is kept.
    pub fn of(sizes: &[u64], bytes_max: u64) -> Self {
        let last = sizes.len().saturating_sub(1);
        let bytes = |thinning: &Self| {
            let kept = sizes.iter().enumerate().filter(|(number, _)| thinning.keeps(*number));
            kept.fold(0_u64, |sum, (_, size)| sum.saturating_add(*size))
        };
        let strides = 1..sizes.len();
        let fitting =
            strides.map(|stride| Self { stride, last }).find(|thinning| bytes(thinning) <= bytes_max);
        fitting.unwrap_or(Self { stride: usize::MAX, last })
    }

    /// Whether the message of that number is kept, counted from 0.
    pub fn keeps(&self, number: usize) -> bool {
        // Counted from the end, since there the map is largest and is looked at most.
        number <= self.last && (self.last - number).is_multiple_of(self.stride)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn as_many_are_kept_as_fit_and_the_last_always() {
        let kept = |sizes: &[u64], bytes_max| -> Vec<usize> {
            let thinning = Thinning::of(sizes, bytes_max);
            (0..sizes.len()).filter(|number| thinning.keeps(*number)).collect()
        };
        assert_eq!(kept(&[4; 5], 20), [0, 1, 2, 3, 4]);
        assert_eq!(kept(&[4; 5], 19), [0, 2, 4]);
        assert_eq!(kept(&[4; 5], 11), [1, 4]);
        assert_eq!(kept(&[4; 5], 7), [4]);
        assert_eq!(kept(&[4; 5], 0), [4], "one at least");
        assert_eq!(kept(&[9], 0), [0]);
        assert_eq!(kept(&[], 0), [0; 0]);
    }
}
