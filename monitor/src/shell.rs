//! The command line of the monitor, and its life in shared memory.

use std::net::SocketAddr;
use std::sync::{Arc, Mutex};
use std::time::Duration;

use contract::{MonotonicNs, Role};
use node::peer::PeerArgs;
use node::{Exit, Failure, Instance, Node, ShutdownSignal};
use process::{Ports as _, block_on};

use crate::bar::Bar;
use crate::process::{Display, Monitor, Observer};
use crate::record_args::{RecordArgs, RecordNotes};
use crate::web::Page;
use crate::web::hosts::host_name;
use crate::{History, Progress, Screen, View, Watcher};

/// Where the page is served unless an address is given.
pub const PAGE_ADDRESS: &str = "127.0.0.1:8427";

/// Where viewers connect unless an address is given: the port that Foxglove proposes.
pub const FOXGLOVE_ADDRESS: &str = "127.0.0.1:8765";

/// Pause between two looks for a reason to end, while a page is all that is left.
const LOOK: Duration = Duration::from_secs(1);

/// What there is to see, beside a line a second.
#[derive(clap::Args, Clone, Debug)]
pub struct ViewArgs {
    /// Serve the mission as a page at this address or port; port 0 picks a free one, which the log names.
    #[arg(long, value_name = "ADDR", num_args = 0..=1, default_missing_value = PAGE_ADDRESS, value_parser = address)]
    pub web: Option<SocketAddr>,
    /// End with the mission instead of serving the page until Ctrl-C.
    #[arg(long, requires = "web")]
    pub web_exit: bool,
    /// Open the page in the browser of this desktop.
    #[arg(long, requires = "web")]
    pub open: bool,
    /// Serve the page, and what `--foxglove` serves, under this name too: that of a proxy, or of this machine in its network.
    /// May be repeated; localhost, loopback and the address that is served need not be named.
    #[arg(long, value_name = "NAME", value_parser = host_name)]
    pub web_host: Vec<String>,
    /// Let page or terminal pause, step, change the pace, and hand over to a stand-by planner.
    #[arg(long)]
    pub control: bool,
}

/// Arguments of `monitor` and of `hopper monitor`.
#[derive(clap::Args, Clone, Debug)]
pub struct Args {
    #[command(flatten)]
    peer: PeerArgs,
    #[command(flatten)]
    view: ViewArgs,
    /// Show the mission on this terminal, of at least 80 columns by 24 rows, over ssh too.
    #[arg(long)]
    tui: bool,
    /// Serve the mission live to Foxglove and Lichtblick by WebSocket at this address or port; port 0 picks a free one,
    /// which the log names.
    #[arg(long, value_name = "ADDR", num_args = 0..=1, default_missing_value = FOXGLOVE_ADDRESS, value_parser = address)]
    foxglove: Option<SocketAddr>,
    /// Let viewers in a browser connect whose pages are of this origin, e.g. `https://app.foxglove.dev`; may be repeated.
    /// Programs, which send no Origin, and pages of this machine need not be named.
    #[arg(long, requires = "foxglove", value_name = "ORIGIN", value_parser = origin)]
    foxglove_origin: Vec<String>,
    /// Print the last progress as one JSON object on standard output when the mission ends.
    #[arg(long, default_value = "text")]
    format: report::Format,
    #[command(flatten)]
    record: RecordArgs,
    #[command(flatten)]
    notes: RecordNotes,
}

/// What an executable may link beside the page: crates of their own, so that the default build leaves them out.
#[derive(Clone, Copy, Default)]
pub struct Extensions {
    /// Takes over the terminal; the argument is whether orders are allowed.
    #[allow(clippy::type_complexity, reason = "one signature, used once")]
    pub terminal: Option<fn(bool) -> Result<Box<dyn Screen>, Failure>>,
    /// Opens a recording and its ports; the last argument is whether the process may have been restarted.
    #[allow(clippy::type_complexity, reason = "one signature, used once")]
    pub recorder:
        Option<fn(&RecordArgs, &RecordNotes, &mut Node, bool) -> Result<Box<dyn Observer<Node>>, Failure>>,
    /// Serves viewers.
    #[allow(clippy::type_complexity, reason = "one signature, used once")]
    pub foxglove: Option<fn(&FoxgloveArgs, &mut Node) -> Result<Box<dyn Observer<Node>>, Failure>>,
}

impl ViewArgs {
    /// Whether there is a page that outlives the mission.
    #[must_use]
    pub fn serves_on(&self) -> bool {
        self.web.is_some() && !self.web_exit
    }
}

impl Args {
    /// Whether the arguments ask for more than the page and the log.
    #[must_use]
    pub fn need_extensions(&self) -> bool {
        self.tui || self.record.record.is_some() || self.foxglove.is_some()
    }
}

/// Where viewers are served, and which.
#[derive(Clone, Debug)]
pub struct FoxgloveArgs {
    /// Address of the server.
    pub address: SocketAddr,
    /// Names of the server besides loopback names and its addresses.
    pub hosts: Vec<String>,
    /// Origins of pages that may connect.
    pub origins: Vec<String>,
}

/// An origin: what a browser sends of a page, scheme and host with the port if it is not the usual one.
///
/// # Errors
/// What was needed and what was got, in a sentence.
pub fn origin(text: &str) -> Result<String, String> {
    let need = || {
        format!(
            "an origin is scheme://host, e.g. https://app.foxglove.dev, or file:// for some desktop viewers; got {text:?}"
        )
    };
    let (scheme, host) = text.split_once("://").ok_or_else(need)?;
    let is_scheme = !scheme.is_empty()
        && scheme.bytes().all(|byte| byte.is_ascii_alphanumeric() || b"+-.".contains(&byte));
    let is_host = host.bytes().all(|byte| byte.is_ascii_graphic() && !b"/*?#@\\".contains(&byte));
    if is_scheme && is_host && (scheme == "file" || !host.is_empty()) {
        Ok(text.to_ascii_lowercase())
    } else {
        Err(need())
    }
}

/// An address with its port, or a port of this machine's loopback.
///
/// # Errors
/// What was needed and what was got, in a sentence.
pub fn address(text: &str) -> Result<SocketAddr, String> {
    let port = text.parse().ok().map(|port: u16| SocketAddr::from(([127, 0, 0, 1], port)));
    let need = || format!("an address is e.g. {PAGE_ADDRESS}, [::1]:8427, or a port alone; got {text:?}");
    port.or_else(|| text.parse().ok()).ok_or_else(need)
}

/// Runs the process until the mission ends.
///
/// # Errors
/// If shared memory or the page's address cannot be had, a peer was waited for longer than `--wait`, or the arguments
/// need an extension that this executable was built without.
pub fn run(args: &Args, extensions: &Extensions) -> Result<Exit, Failure> {
    let instance = Instance::new(&args.peer.instance)?;
    let mut node = Node::join_with(&instance, Role::Monitor, args.peer.joining())?;
    let (view, page) = view(args, extensions, &mut node)?;
    let observers = observers(args, extensions, &mut node)?;
    let show = Show { bar: if args.tui { Bar::default() } else { Bar::on_stderr() }, format: args.format };
    let exit = block_on(async {
        let mut monitor = Monitor::join(&mut node, show, view, observers, args.peer.terms()).await?;
        tracing::info!("joined instance {:?}", args.peer.instance);
        let watched = process::run(&mut monitor, &mut node).await;
        // Whatever ended the watch, what was recorded has an end.
        let recorded = monitor.finish(&mut node);
        watched.and_then(|exit| recorded.map(|()| exit))
    })?;
    // Whoever looks at the page needs no port: the instance is free for the next mission.
    let shutdown = node.shutdown();
    drop(node);
    if let Some(page) = page
        && args.view.serves_on()
        && !args.tui
        && exit != Exit::Interrupted
    {
        serve_on(&page, &shutdown, args.peer.lifeline, "; --web-exit ends it with the mission")?;
    }
    Ok(exit)
}

/// Serves the page of a mission that is over until `shutdown`, of which the parent is told if there is one. `hint` is for the
/// log.
///
/// # Errors
/// If the parent cannot be informed.
pub fn serve_on(page: &Page, shutdown: &ShutdownSignal, has_parent: bool, hint: &str) -> Result<(), Failure> {
    use std::io::Write;
    if has_parent {
        // The parent takes any output for the word that everything else is done.
        writeln!(std::io::stdout(), "serving").map_err(Failure::run)?;
        std::io::stdout().flush().map_err(Failure::run)?;
    }
    // Without the key: nobody gives orders to a mission that is over.
    tracing::info!("the page stays at http://{}/ until Ctrl-C{hint}", page.address());
    while shutdown.stop_reason().is_none() {
        shutdown.wait(LOOK);
    }
    Ok(())
}

type Opened = (Option<View<Node>>, Option<Arc<Page>>);

fn view(args: &Args, extensions: &Extensions, node: &mut Node) -> Result<Opened, Failure> {
    let ViewArgs { web, web_host, control, open, .. } = &args.view;
    let (web, control, open) = (*web, *control, *open);
    if !web_host.is_empty() && web.is_none() && args.foxglove.is_none() {
        return Err(Failure::new(Exit::Usage, "--web-host needs --web or --foxglove: it names their server"));
    }
    if web.is_none() && !args.tui {
        let alone = || Failure::new(Exit::Usage, "--control needs --web or --tui to give orders from");
        return if control { Err(alone()) } else { Ok((None, None)) };
    }
    let account = Arc::new(Mutex::new(History::new(contract::RobotId(0)).in_instance(node.instance_name())));
    let mut screens: Vec<Box<dyn Screen>> = Vec::new();
    let page = web
        .map(|address| Page::open(address, web_host, control, Arc::clone(&account)).map(Arc::new))
        .transpose()?;
    if let Some(page) = &page {
        screens.push(Box::new(Arc::clone(page)));
        if open {
            page.open_in_browser();
        }
    }
    let mut view = View::open(node, account, screens, control)?;
    if args.tui {
        let open = extensions.terminal.ok_or_else(|| lacks("--tui"))?;
        view.add(open(control)?);
    }
    Ok((Some(view), page))
}

fn observers(
    args: &Args,
    extensions: &Extensions,
    node: &mut Node,
) -> Result<Vec<Box<dyn Observer<Node>>>, Failure> {
    let mut observers = Vec::new();
    if args.record.record.is_some() {
        let open = extensions.recorder.ok_or_else(|| lacks("--record"))?;
        observers.push(open(&args.record, &args.notes, node, args.peer.lifeline)?);
    }
    if let Some(address) = args.foxglove {
        let open = extensions.foxglove.ok_or_else(|| lacks("--foxglove"))?;
        let hosts = args.view.web_host.clone();
        observers.push(open(&FoxgloveArgs { address, hosts, origins: args.foxglove_origin.clone() }, node)?);
    }
    Ok(observers)
}

fn lacks(flag: &str) -> Failure {
    Failure::new(Exit::Usage, format!("{flag} is not part of this executable"))
}

/// Progress on standard error, the last of it on standard output for programs.
struct Show {
    bar: Bar,
    format: report::Format,
}

impl Display for Show {
    fn show(&mut self, progress: &Progress, _watcher: &Watcher, now: MonotonicNs) {
        self.bar.show(progress, now);
    }

    fn finished(&mut self, watcher: &Watcher, now: MonotonicNs) -> Result<(), Failure> {
        use std::io::Write;
        self.bar.finish();
        let Some(progress) = watcher.progress(now) else { return Ok(()) };
        if self.format == report::Format::Json {
            let text = serde_json::to_string(&progress).map_err(Failure::run)?;
            writeln!(std::io::stdout(), "{text}").map_err(Failure::run)?;
        }
        if progress.missing == 0 {
            return Ok(());
        }
        Err(Failure::new(
            Exit::Peer,
            format!(
                "hopper-sim left before this monitor had all of the mission: it lacks {} of {} decisions; \
                 the journal of hopper-sim has them: hopper journal show JOURNAL",
                progress.missing, progress.decision.0
            ),
        ))
    }
}

impl Drop for Show {
    fn drop(&mut self) {
        self.bar.finish();
    }
}
