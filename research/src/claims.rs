//! Claims of papers: [`campaign::claim`].

pub use ::campaign::claim::{Claim, Verdict, not_borne_out};
