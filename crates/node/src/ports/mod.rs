//! Typed ends of the services, one kind for every message: see [`contract::message`].
//!
//! A writer loans a slot, fills it and hands it over, then notifies the service's listeners. A reader copies a sample
//! first and validates the copy: its writer could still write to the slot.

mod client;
mod reader;
mod server;
pub(crate) mod service;
mod writer;
mod zero_copy;

pub use client::Client;
pub use reader::Reader;
pub use server::Server;
pub use writer::Writer;
pub(crate) use zero_copy::ZeroCopy;
