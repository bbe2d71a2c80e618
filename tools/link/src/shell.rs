//! The command line of `hopper link`, and its life in shared memory.

use std::cell::RefCell;
use std::io::Write as _;
use std::net::SocketAddr;
use std::rc::Rc;
use std::time::Duration;

use contract::{MonotonicNs, Role};
use link::{Downlink, Passes, Settings, Tally};
use monitor::process::{Display, Monitor, Observer};
use monitor::{Progress, Watcher};
use node::peer::PeerArgs;
use node::{Exit, Failure, Instance, Node};
use process::block_on;
use telemetry::{Kind, MissionTime, xtce};

use crate::observer::{LinkObserver, Sender};
use crate::transport::Transport;

/// Where packets go unless an address is given: the port of telemetry in the examples of Yamcs.
const ADDRESS: &str = "127.0.0.1:10015";

/// Pause between two looks after the mission, while packets wait.
const LOOK: Duration = Duration::from_millis(2);

/// Arguments of `hopper link`.
#[derive(clap::Args, Debug)]
pub struct Args {
    #[command(subcommand)]
    command: Option<Command>,
    #[command(flatten)]
    send: SendArgs,
}

#[derive(clap::Subcommand, Debug)]
enum Command {
    /// Write what the packets consist of as XTCE, on standard output.
    Xtce,
}

#[derive(clap::Args, Debug)]
struct SendArgs {
    #[command(flatten)]
    peer: PeerArgs,
    /// Send each packet as a datagram to this address, or to this port of this machine [default: 127.0.0.1:10015].
    #[arg(long, value_name = "ADDR", value_parser = address, conflicts_with = "tcp")]
    udp: Option<SocketAddr>,
    /// Send packets one after another to whoever connects to this address, or to this port of this machine; port 0 picks a
    /// free one, which the log names. Without a client packets wait.
    #[arg(long, value_name = "ADDR", value_parser = address)]
    tcp: Option<SocketAddr>,
    /// Send at most so many bits in a second of mission time [default: any number].
    #[arg(long, value_name = "BITS", value_parser = clap::value_parser!(u64).range(1..=1_000_000_000_000))]
    rate: Option<u64>,
    /// Send only during passes, in mission time: LENGTH/PERIOD, so long at the beginning of each period, e.g. 10m/90m.
    #[arg(long, value_name = "PASSES")]
    passes: Option<Passes>,
    /// Mission time that a decision takes: observing, planning and hopping, e.g. 60s, 2m, 1h.
    #[arg(long, value_name = "TIME", value_parser = step, default_value = "60s")]
    step: MissionTime,
}

/// An address with its port, or a port of this machine's loopback.
fn address(text: &str) -> Result<SocketAddr, String> {
    let port = text.parse().ok().map(|port: u16| SocketAddr::from(([127, 0, 0, 1], port)));
    let need = || format!("an address is e.g. {ADDRESS}, [::1]:10015, or a port alone; got {text:?}");
    port.or_else(|| text.parse().ok()).ok_or_else(need)
}

/// From a millisecond to a hundred days.
fn step(text: &str) -> Result<MissionTime, String> {
    let is_within = |time: &MissionTime| (0.001..=8.64e6).contains(&time.seconds());
    let need = || format!("a decision takes from 1ms to 100d, e.g. 60s, 2m, 1h; got {text:?}");
    link::duration(text).filter(is_within).ok_or_else(need)
}

/// Runs the process until the mission has ended and everything is sent.
///
/// # Errors
/// If shared memory or the address cannot be had, or a peer was waited for longer than `--wait`.
pub fn run(args: &Args) -> Result<Exit, Failure> {
    if let Some(Command::Xtce) = &args.command {
        let text = xtce::document(hopper::VERSION);
        std::io::stdout().write_all(text.as_bytes()).map_err(Failure::run)?;
        return Ok(Exit::Done);
    }
    let SendArgs { peer, udp, tcp, rate, passes, step } = &args.send;
    let transport = match tcp {
        Some(address) => Transport::tcp(*address)?,
        None => Transport::udp(udp.unwrap_or_else(|| address(ADDRESS).expect("an address")))?,
    };
    let address = transport.address().map_err(Failure::run)?;
    let way = if tcp.is_some() { "to whoever connects to TCP" } else { "to UDP" };
    tracing::info!("telemetry goes {way} {address}; hopper link xtce says what it consists of");
    if !address.ip().is_loopback() {
        tracing::warn!(
            "telemetry is neither encrypted nor signed: anyone on the way to {address} can read it"
        );
    }
    let downlink = Downlink::new(&Settings { rate: *rate, passes: *passes, step: *step });
    let sender = Rc::new(RefCell::new(Sender { downlink, transport }));
    let instance = Instance::new(&peer.instance)?;
    let mut node = Node::join_with(&instance, Role::Monitor, peer.joining())?;
    let observer: Box<dyn Observer<Node>> = Box::new(LinkObserver::open(&mut node, Rc::clone(&sender))?);
    let exit = block_on(async {
        let mut monitor = Monitor::join(&mut node, Quiet, None, vec![observer], peer.terms()).await?;
        tracing::info!("joined instance {:?}", peer.instance);
        let watched = process::run(&mut monitor, &mut node).await;
        let finished = monitor.finish(&mut node);
        watched.and_then(|exit| finished.map(|()| exit))
    })?;
    let shutdown = node.shutdown();
    // The instance is free for the next mission while the rest goes down.
    drop(node);
    let mut sender = sender.borrow_mut();
    if exit != Exit::Interrupted && !is_done(&sender) {
        let Tally { cells_waiting, decisions_waiting, .. } = sender.downlink.tally();
        let nobody = if sender.transport.is_open() { "" } else { ", to whoever connects; Ctrl-C ends it" };
        tracing::info!(
            "the mission is over; {cells_waiting} cells and {decisions_waiting} decisions are still to be sent{nobody}"
        );
        while !is_done(&sender) && shutdown.stop_reason().is_none() {
            sender.downlink.advance(Node::now());
            sender.send();
            shutdown.wait(LOOK);
        }
    }
    report(&sender.downlink.tally());
    Ok(if is_done(&sender) { exit } else { Exit::Interrupted })
}

/// Whether everything has been sent.
fn is_done(sender: &Sender) -> bool {
    sender.downlink.is_idle() && sender.transport.is_flushed()
}

/// Says what was sent.
fn report(tally: &Tally) {
    let (packets, bytes): (u64, u64) = (tally.packets.iter().sum(), tally.bytes.iter().sum());
    let kinds = Kind::ALL.iter().zip(tally.packets).filter(|(_, count)| *count > 0);
    let kinds: Vec<String> = kinds.map(|(kind, count)| format!("{count} {kind}")).collect();
    tracing::info!(
        "sent {packets} packets of {bytes} bytes ({}); {} states were replaced by newer ones, {} events passed over",
        kinds.join(", "),
        tally.states_replaced,
        tally.events_passed_over
    );
}

/// The log says all there is to say.
struct Quiet;

impl Display for Quiet {
    fn show(&mut self, _progress: &Progress, _watcher: &Watcher, _now: MonotonicNs) {}

    fn finished(&mut self, _watcher: &Watcher, _now: MonotonicNs) -> Result<(), Failure> {
        Ok(())
    }
}
