//! The variant of the middleware that is used.

use iceoryx2::prelude::{ServiceName, ipc};

/// iceoryx2's variant for processes that share memory.
pub(crate) type Ipc = ipc::Service;

/// A service name as the middleware wants it.
pub(crate) fn service_name(name: &str) -> ServiceName {
    ServiceName::new(name).expect("a service has a short name of ASCII")
}
