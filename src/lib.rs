//! Hopper.
