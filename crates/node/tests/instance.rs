//! Instances keep apart, name who holds what, and leave nothing behind.

use std::sync::Barrier;
use std::time::Duration;

use crate::samples::{Own, ROBOT, brief, eventually, state};
use contract::{Brief, Command, Name, Role, State};
use iceoryx2::prelude::{Config, FileName, NodeBuilder, Path, SemanticString, ipc};
use node::inspect::{NodeHealth, inspect};
use node::{Cleaned, Exit, Instance, Node, NodeError};
use process::{Membership, Ports, Reader as _, Terms, Writer as _};

#[test]
fn a_name_that_cannot_be_one_is_refused() {
    for bad in ["", "two words", "ünder", &"x".repeat(65)] {
        let error = Instance::new(bad).unwrap_err();
        assert_eq!(error.exit(), Exit::Usage);
        assert!(error.to_string().contains(&format!("{bad:?}")), "{error}");
    }
}

#[test]
fn two_instances_never_meet() {
    let (one, other) = (Own::new(), Own::new());
    {
        let mut here = Node::join(&one.0, Role::HopperSim).unwrap();
        let mut there = Node::join(&other.0, Role::HopperSim).unwrap();
        let (mut writer, mut reader) =
            (here.writer::<State>(ROBOT).unwrap(), there.reader::<State>(ROBOT, false).unwrap());
        writer.publish(state(1)).unwrap();
        writer.idle();
        assert_eq!(reader.newest(), None);
        assert_eq!(writer.readers(), 0);
        there.writer::<State>(ROBOT).unwrap();
    }
    one.assert_gone();
    other.assert_gone();
}

/// P-LEAVE: The last process to leave leaves nothing in shared memory; cleaning never touches a
/// live instance.
#[test]
fn whoever_leaves_last_leaves_nothing_in_whatever_order_ports_and_nodes_go() {
    let own = Own::new();
    let mut a = Node::join(&own.0, Role::HopperSim).unwrap();
    let mut b = Node::join(&own.0, Role::Planner).unwrap();
    let (mut writer, mut reader) =
        (a.writer::<State>(ROBOT).unwrap(), b.reader::<State>(ROBOT, false).unwrap());
    drop(a);
    writer.publish(state(3)).unwrap();
    assert_eq!(reader.newest(), Some(Ok(state(3))), "a port outlives its node");
    drop((b, writer));
    assert!(own.0.exists());
    drop(reader);
    own.assert_gone();
}

#[test]
fn a_claim_names_its_holder_and_ends_with_it() {
    let own = Own::new();
    {
        let claim = own.0.claim(Role::HopperSim).unwrap();
        let error = own.0.claim(Role::HopperSim).unwrap_err();
        assert_eq!(error.exit(), Exit::Peer);
        let need = format!(
            "instance {:?} needs one hopper-sim, and process {} is it",
            own.0.name(),
            std::process::id()
        );
        assert_eq!(error.to_string(), need);
        drop(claim);
        own.0.claim(Role::HopperSim).unwrap();
    }
    own.assert_gone();
}

/// P-LEAVE.
#[test]
fn cleaning_never_touches_a_live_instance() {
    let own = Own::new();
    assert_eq!(own.0.clean().unwrap(), Cleaned::Nothing);
    {
        let mut node = Node::join(&own.0, Role::HopperSim).unwrap();
        let mut writer = node.writer::<State>(ROBOT).unwrap();
        let before = own.files();
        assert_eq!(own.0.clean().unwrap(), Cleaned::Alive);
        assert_eq!(own.files(), before);
        drop(node);
        assert_eq!(own.0.clean().unwrap(), Cleaned::Alive, "a port alone keeps it alive");
        writer.publish(state(1)).unwrap();
    }
    {
        let _claim = own.0.claim(Role::HopperSim).unwrap();
        assert_eq!(own.0.clean().unwrap(), Cleaned::Alive, "a claim keeps it alive");
    }
    own.assert_gone();
}

#[test]
fn comings_and_goings_at_the_same_moment_leave_nothing() {
    let own = Own::new();
    let barrier = Barrier::new(4);
    std::thread::scope(|scope| {
        for _ in 0..4 {
            scope.spawn(|| {
                for _ in 0..12 {
                    barrier.wait();
                    let mut node = Node::join(&own.0, Role::Monitor).unwrap();
                    let mut reader = node.reader::<State>(ROBOT, false).unwrap();
                    assert_eq!(reader.newest(), None);
                }
            });
        }
    });
    own.assert_gone();
}

/// A service of the instance as somebody else's program would make it.
fn config(own: &Own) -> Config {
    let root = own.0.root().to_str().unwrap().to_owned();
    let mut config = Config::default();
    config.global.set_root_path(&Path::new(root.as_bytes()).unwrap());
    let prefix = format!("{}_", root.rsplit('/').next().unwrap());
    config.global.prefix = FileName::new(prefix.as_bytes()).unwrap();
    config
}

/// P-MISMATCH: A service of another type or quality of service is refused, and the error names what
/// was needed and what was found.
#[test]
fn a_service_of_another_type_or_quality_is_named_with_need_and_got() {
    let own = Own::new();
    {
        let mut node = Node::visit(&own.0).unwrap();
        let stranger = NodeBuilder::new().config(&config(&own)).create::<ipc::Service>().unwrap();
        let _wrong = stranger
            .service_builder(&"hop/state".try_into().unwrap())
            .publish_subscribe::<u64>()
            .open_or_create()
            .unwrap();
        let error = node.reader::<State>(ROBOT, false).unwrap_err();
        assert_eq!(error.exit(), Exit::Peer);
        let text = error.to_string();
        assert!(text.starts_with("service hop/state needs hop.State.v4 (352 bytes), 1 publishers"), "{text}");
        assert!(text.contains("got u64 (8 bytes), 2 publishers"), "{text}");

        let _narrow = stranger
            .service_builder(&"hop/r0/command".try_into().unwrap())
            .event()
            .max_listeners(1)
            .open_or_create()
            .unwrap();
        let error = node.writer::<Command>(ROBOT).unwrap_err();
        assert!(
            matches!(&error, NodeError::Mismatch { service, .. } if service == "hop/r0/command"),
            "{error}"
        );
    }
    own.assert_gone();
}

#[test]
fn inspection_tells_who_is_there_and_what_to_do_next() {
    let own = Own::new();
    let report = inspect(&own.0).unwrap();
    assert!(!report.alive && report.leftovers.is_empty());
    assert!(
        report.advice[0].starts_with("nothing runs: start `hopper sim --instance test-"),
        "{:?}",
        report.advice
    );
    std::thread::scope(|scope| {
        let (stop, stopped) = std::sync::mpsc::channel::<()>();
        let here = &own;
        scope.spawn(move || {
            let mut sim = Node::join(&here.0, Role::HopperSim).unwrap();
            let mut membership =
                Membership::join(&mut sim, Role::HopperSim, Name::NONE, Terms::default()).unwrap();
            let (mut briefs, mut states) =
                (sim.writer::<Brief>(ROBOT).unwrap(), sim.writer::<State>(ROBOT).unwrap());
            briefs.publish(brief()).unwrap();
            states.publish(state(2)).unwrap();
            while stopped.recv_timeout(Duration::from_millis(5)).is_err() {
                briefs.idle();
                states.idle();
                membership.beat((brief().run, state(2).decision, state(2).status), Node::now()).unwrap();
                if stopped.try_recv() == Err(std::sync::mpsc::TryRecvError::Disconnected) {
                    break;
                }
            }
        });
        eventually("a live instance", || inspect(&own.0).unwrap().mission);
        let report = inspect(&own.0).unwrap();
        assert!(report.alive);
        let sim = &report.processes[0];
        assert_eq!((sim.role, sim.pid, sim.decision), (Role::HopperSim, std::process::id(), 2));
        assert!(
            report.nodes.iter().any(|node| node.name == "hopper-sim" && node.health == NodeHealth::Alive)
        );
        let progress = report.mission.unwrap().progress.unwrap();
        assert_eq!((progress.decision, progress.steps), (2, 4));
        assert!(
            report
                .services
                .iter()
                .any(|service| service.name == "hop/state" && service.kind.starts_with("hop.State.v4"))
        );
        assert!(report.memory.used_bytes > 0 && report.memory.need_bytes.is_some());
        assert!(
            report.advice.iter().any(|line| line.contains("`hopper planner --instance")),
            "{:?}",
            report.advice
        );
        assert!(Instance::all().unwrap().contains(&own.0));
        drop(stop);
    });
    own.assert_gone();
}
