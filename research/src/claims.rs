//! Claims of papers: [`p23::claim`].

pub use p23::claim::{Claim, Verdict, not_borne_out};
