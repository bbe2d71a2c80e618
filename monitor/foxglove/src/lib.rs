//! Serves a mission live to viewers that speak Foxglove's WebSocket protocol.
//!
//! The channels are those of a recording ([`recording::Transcript`]). A viewer that comes late gets the newest message of
//! each channel that it subscribes to. Messages wait in a bounded queue for each viewer, on threads of the server, so a
//! slow viewer loses messages and delays nobody.

mod channels;

use std::net::SocketAddr;
use std::sync::Arc;
use std::time::Duration;

use contract::{Decision, RunId};
use foxglove::{Context, WebSocketServer, WebSocketServerHandle};
use monitor::process::Observer;
use node::{Exit, Failure, Node};
use recorder::RecorderPorts;
use recording::Transcript;

use channels::Channels;

/// Time for viewers to take the last messages.
const GRACE: Duration = Duration::from_millis(300);

/// Publishes the messages of the mission.
struct FoxgloveServer {
    ports: RecorderPorts<Node>,
    transcript: Transcript,
    channels: Arc<Channels>,
    server: Option<WebSocketServerHandle>,
}

/// Opens the ports and begins to serve at `address`.
///
/// # Errors
/// If a port or the address cannot be had.
pub fn open(address: SocketAddr, node: &mut Node) -> Result<Box<dyn Observer<Node>>, Failure> {
    let ports = RecorderPorts::open(node, false)?;
    let context = Context::new();
    let channels = Arc::new(Channels::new(&context));
    // The server puts host and port together as text.
    let host = match address {
        SocketAddr::V4(address) => address.ip().to_string(),
        SocketAddr::V6(address) => format!("[{}]", address.ip()),
    };
    let server = WebSocketServer::new()
        .name(format!("hopper {}", node.instance().name()))
        .context(&context)
        .listener(Arc::clone(&channels) as _)
        .bind(host, address.port())
        .start_blocking()
        .map_err(|error| {
            Failure::new(Exit::Usage, format!("--foxglove cannot listen on {address}: {error}"))
        })?;
    tracing::info!("viewers connect to ws://{}", SocketAddr::new(address.ip(), server.port()));
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
        if let Some(server) = self.server.take() {
            // Its threads send meanwhile; a viewer that does not read is not waited for.
            if server.client_count() > 0 {
                std::thread::sleep(GRACE);
            }
            drop(server.stop());
        }
        turned
    }
}
