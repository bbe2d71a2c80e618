//! Claims of papers, each judged by the whole interval of what came out.

use serde::Serialize;

/// Whether a claim holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Verdict {
    /// Our number, or all of its interval, agrees with it.
    Holds,
    /// Our number, or all of its interval, contradicts it.
    Fails,
    /// The interval has values of both kinds: more runs would decide.
    Open,
    /// The paper does not say enough, or its data is not public.
    NotToBeHad,
}

impl Verdict {
    /// The verdict on a statement that is true or false of our runs.
    #[must_use]
    pub fn of(holds: bool) -> Self {
        if holds { Self::Holds } else { Self::Fails }
    }

    /// The verdict on what never happens, and happened `count` times in `runs`: once is enough against it, and `runs_min` without
    /// it, the paper's number, for it.
    #[must_use]
    pub fn never(count: usize, runs: u64, runs_min: u64) -> Self {
        match count {
            0 if runs < runs_min => Self::Open,
            count => Self::of(count == 0),
        }
    }

    /// Whether all of the interval `ours` is above `limit`; an end at exactly that decides nothing.
    #[must_use]
    pub fn above(ours: impl Into<(f64, f64)>, limit: f64) -> Self {
        match ours.into() {
            (low, _) if low > limit => Self::Holds,
            (_, high) if high < limit => Self::Fails,
            _ => Self::Open,
        }
    }

    /// Whether all of the interval `ours` is below `limit`.
    #[must_use]
    pub fn below(ours: impl Into<(f64, f64)>, limit: f64) -> Self {
        let (low, high) = ours.into();
        Self::above((-high, -low), -limit)
    }

    /// Whether all of the interval `ours` lies within `low` to `high`, the ends included.
    #[must_use]
    pub fn within(ours: impl Into<(f64, f64)>, low: f64, high: f64) -> Self {
        let ours = ours.into();
        if ours.0 >= low && ours.1 <= high {
            Self::Holds
        } else if ours.1 < low || ours.0 > high {
            Self::Fails
        } else {
            Self::Open
        }
    }

    /// The verdict on a claim that needs all of `verdicts`.
    #[must_use]
    pub fn all(verdicts: impl IntoIterator<Item = Self>) -> Self {
        verdicts.into_iter().fold(Self::Holds, |all, verdict| match (all, verdict) {
            (Self::Fails, _) | (_, Self::Fails) => Self::Fails,
            (Self::Open, _) | (_, Self::Open) => Self::Open,
            _ => Self::Holds,
        })
    }

    /// As reports have it.
    #[must_use]
    pub fn words(self) -> &'static str {
        match self {
            Self::Holds => "holds",
            Self::Fails => "does not hold",
            Self::Open => "open (too few runs)",
            Self::NotToBeHad => "cannot be had",
        }
    }
}

/// A claim beside what came out; field names are those of the JSON.
#[derive(Clone, Debug, Serialize)]
pub struct Claim {
    /// The claim, in words.
    pub claim: String,
    /// The paper's number, or yes.
    pub paper: String,
    /// What would make it hold here; why it cannot be had.
    pub holds_if: String,
    /// What we got, with its 95 % interval.
    pub ours: String,
    /// Whether it holds.
    pub verdict: Verdict,
}

impl Claim {
    /// A claim with its verdict.
    #[must_use]
    pub fn new(claim: &str, paper: &str, holds_if: &str, ours: String, verdict: Verdict) -> Self {
        Self { claim: claim.into(), paper: paper.into(), holds_if: holds_if.into(), ours, verdict }
    }

    /// Headings of its row.
    pub const HEADINGS: [&'static str; 5] = ["claim", "paper", "holds if", "ours", "verdict"];

    /// The cells of its row.
    #[must_use]
    pub fn cells(&self) -> [String; 5] {
        [&self.claim, &self.paper, &self.holds_if, &self.ours, self.verdict.words()].map(ToString::to_string)
    }
}

/// The claims that were not borne out, in groups: those that do not hold, those that are open, those that cannot be had.
#[must_use]
pub fn not_borne_out(claims: &[Claim]) -> Vec<(Verdict, Vec<&Claim>)> {
    let of = |verdict| claims.iter().filter(|claim| claim.verdict == verdict).collect::<Vec<_>>();
    let groups = [Verdict::Fails, Verdict::Open, Verdict::NotToBeHad].map(|verdict| (verdict, of(verdict)));
    groups.into_iter().filter(|(_, claims)| !claims.is_empty()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_touches_the_limit_is_no_verdict() {
        let cases = [
            ((0.0, 0.0), Verdict::Open, Verdict::Open),
            ((0.0, 0.1), Verdict::Open, Verdict::Open),
            ((-0.1, 0.0), Verdict::Open, Verdict::Open),
            ((-0.1, 0.1), Verdict::Open, Verdict::Open),
            ((0.01, 0.1), Verdict::Holds, Verdict::Fails),
            ((-0.1, -0.01), Verdict::Fails, Verdict::Holds),
        ];
        for (ours, above, below) in cases {
            assert_eq!((Verdict::above(ours, 0.0), Verdict::below(ours, 0.0)), (above, below), "{ours:?}");
        }
    }
}
