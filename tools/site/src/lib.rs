//! The page without a server: a folder of static files that flies missions in the browser.
//!
//! The folder is the monitor's page (`monitor/src/web/page/`), in which the files of `crates/browser/page/` stand in for
//! the server: a WebAssembly module in a worker sends the frames.

mod check;
mod site;

pub use check::{differences, missions};
pub use site::{COMPRESSED_BYTES_MAX, Site, TARGET, build, has_target};
