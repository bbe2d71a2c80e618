//! Serves a mission live to viewers that speak Foxglove's WebSocket protocol.
//!
//! The channels are those of a recording ([`recording::Transcript`]). A viewer that comes late gets the newest message of
//! each channel that it subscribes to. Messages wait in a bounded queue for each viewer and are sent by a thread of the server,
//! so a slow viewer loses messages and delays nobody. Requests are read as those for the page ([`monitor::web::Reception`]).
//!
//! Not Foxglove's own server: it admits the pages of any origin, keeps sockets that say nothing, and does not speak the
//! protocol under its older name, which Lichtblick uses.

mod channels;
mod gate;
mod protocol;
mod server;
mod viewer;

use contract::{Decision, RunId};
use monitor::process::Observer;
use monitor::shell::FoxgloveArgs;
use node::{Exit, Failure, Node};
use recorder::RecorderPorts;
use recording::Transcript;
use std::sync::Arc;

use channels::Channels;
use server::{Admission, ViewerServer};
use viewer::Patience;

/// Publishes the messages of the mission.
struct FoxgloveServer {
    ports: RecorderPorts<Node>,
    transcript: Transcript,
    channels: Arc<Channels>,
    /// `None` once the mission is over.
    server: Option<ViewerServer>,
}

/// Opens the ports and begins to serve.
///
/// # Errors
/// If a port or the address cannot be had.
pub fn open(args: &FoxgloveArgs, node: &mut Node) -> Result<Box<dyn Observer<Node>>, Failure> {
    let ports = RecorderPorts::open(node, false)?;
    let (channels, woken) = Channels::new(node.instance().name()).map_err(Failure::run)?;
    let FoxgloveArgs { address, hosts, origins } = args.clone();
    let admission = Admission { hosts, origins };
    let server = ViewerServer::open(address, admission, Arc::clone(&channels), woken, Patience::default());
    let server = server.map_err(|error| {
        Failure::new(Exit::Usage, format!("--foxglove cannot listen on {address}: {error}"))
    })?;
    tracing::info!("viewers connect to ws://{}", server.address);
    if !server.address.ip().is_loopback() {
        tracing::warn!("anyone who can reach {} can see the mission: nothing is encrypted", server.address);
    }
    let transcript = Transcript::default();
    Ok(Box::new(FoxgloveServer { ports, transcript, channels, server: Some(server) }))
}

impl FoxgloveServer {
    fn publish(&mut self) {
        for message in self.transcript.take() {
            self.channels.publish(message);
        }
    }
}

impl Observer<Node> for FoxgloveServer {
    fn period_ns(&self) -> u64 {
        self.ports.period_ns()
    }

    fn turn(&mut self, node: &mut Node) -> Result<(), Failure> {
        let now = Node::now();
        self.ports.want_policies(node, self.channels.wants_policies());
        let wanted = self.ports.receive(node).tell(&mut self.transcript, now);
        let wanted = wanted.or(self.transcript.tick(now));
        self.publish();
        self.ports.ask(node, wanted).map_err(Into::into)
    }

    fn is_whole_until(&self, _run: RunId, _decision: Decision) -> bool {
        true
    }

    fn finish(&mut self, node: &mut Node) -> Result<(), Failure> {
        let turned = self.turn(node);
        self.transcript.finish(Node::now());
        self.publish();
        self.server = None;
        turned
    }
}
