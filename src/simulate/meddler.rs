//! Where a test may plant a bug: between each machine and its host.
//!
//! A bug in a protocol rule is a machine that hears something it should have refused, or wants something
//! it should not. So it can be planted from outside, by changing what the true machine hears or wants,
//! and the production code holds neither bugs nor switches for them. The house has [`Faithful`] alone,
//! which changes nothing; the planted ones live in the tests.

use contract::{Incarnation, MonotonicNs, ObservedMap, Record};
use hopper_sim::{Arbiter, Storage};
use monitor::Watcher;
use perception::Cartographer;
use planner::pilot::Pilot;
use terrain::Terrain;

use super::disk::Disk;

/// Stands between the machines and their host; by default it lets everything pass.
pub trait Meddler {
    /// What the journal takes for the disk.
    fn storage(&mut self, disk: &Disk) -> Box<dyn Storage> {
        Box::new(disk.clone())
    }

    /// What a process reads when it asks for the time.
    fn clock(&mut self, monotonic: MonotonicNs, _wall: MonotonicNs) -> MonotonicNs {
        monotonic
    }

    /// The arbiter is about to hear `event`, or not.
    fn arbiter_hears(&mut self, _arbiter: &Arbiter, event: hopper_sim::Event) -> Option<hopper_sim::Event> {
        Some(event)
    }

    /// The arbiter wants `effects`.
    fn arbiter_wants(&mut self, _arbiter: &Arbiter, _effects: &mut Vec<hopper_sim::Effect>) {}

    /// Whether the journal is really asked to append.
    fn commits(&mut self, _record: &Record) -> bool {
        true
    }

    /// The cartographer is about to hear `event`, or not.
    fn cartographer_hears(
        &mut self,
        _cartographer: &Cartographer,
        event: perception::Event,
    ) -> Option<perception::Event> {
        Some(event)
    }

    /// The cartographer wants `effects`.
    fn cartographer_wants(&mut self, _cartographer: &Cartographer, _effects: &mut Vec<perception::Effect>) {}

    /// The cartographer publishes `map` of `terrain`.
    fn cartographer_publishes(&mut self, _map: &mut ObservedMap, _terrain: &Terrain) {}

    /// The pilot of `life` is about to hear `event`, or not.
    fn pilot_hears(
        &mut self,
        _pilot: &Pilot,
        _life: Incarnation,
        event: planner::pilot::Event,
    ) -> Option<planner::pilot::Event> {
        Some(event)
    }

    /// The pilot of `life` wants `effects`.
    fn pilot_wants(
        &mut self,
        _pilot: &Pilot,
        _life: Incarnation,
        _effects: &mut Vec<planner::pilot::Effect>,
    ) {
    }

    /// The watcher is about to hear `event`, or not.
    fn watcher_hears(&mut self, _watcher: &Watcher, event: monitor::Event) -> Option<monitor::Event> {
        Some(event)
    }
}

/// Changes nothing.
#[derive(Clone, Copy, Debug, Default)]
pub struct Faithful;

impl Meddler for Faithful {}
