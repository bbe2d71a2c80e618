//! Tests of the whole: programs, live missions, files, documents and the tree itself, one module for each.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

#[path = "harness/chromium.rs"]
mod chromium;
mod harness;
#[allow(dead_code, reason = "the reader's own tests use every layout")]
#[path = "../crates/terrain/tests/raster/tiff_writer.rs"]
mod tiff_writer;

mod accompanied;
mod arguments;
mod batch;
mod book;
mod campaign;
mod chaos;
mod clairvoyant;
mod compatibility;
mod detached;
mod elevation;
mod exhaustion;
mod first_day;
mod foreign;
mod foreign_ground;
mod golden;
mod guard;
mod guides;
mod input;
mod journal;
mod limits;
mod looking_in;
mod manned;
mod mixed;
mod neighbours;
mod non_interference;
mod own_planner;
mod packages;
mod page;
mod physics;
mod python;
mod readiness;
mod rogue;
mod rovers;
mod scouts;
mod stopped;
mod structure;
mod table;

mod system;
mod takeover;
mod tampering;
mod tools;
mod tutorial;
mod web;
mod wide;
