//! Prints every message and request that the processes exchange: `cargo run --example services`.

#![allow(clippy::print_stdout, reason = "an example shows its result")]

use contract::message::Visitor;
use contract::{Message, Request};

struct Services;

impl Visitor for Services {
    fn message<M: Message>(&mut self) {
        println!("{:24} message", M::SERVICE.name);
    }

    fn request<R: Request>(&mut self) {
        println!("{:24} request", R::SERVICE.name);
    }
}

fn main() {
    contract::wire::visit(&mut Services);
}
