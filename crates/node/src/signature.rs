//! Services in words: types with their sizes, and quality of service.
//!
//! A service is described in the same words as it is asked for and as it was created, so that a mismatch can be
//! reported with both, and so that the descriptions of all services identify a build's messages.

use contract::limits::NODES_MAX;
use contract::message::Visitor;
use contract::wire::Wire;
use contract::{Message, Payload, Request, RobotId};
use iceoryx2::service::static_config::StaticConfig;
use iceoryx2::service::static_config::message_type_details::{TypeDetail, TypeVariant};
use iceoryx2::service::static_config::messaging_pattern::MessagingPattern;

/// Most listeners, and most notifiers, of one event service: a place for every process of an instance.
pub(crate) const EVENT_PORTS_MAX: usize = NODES_MAX;

/// A publish-subscribe service as it is asked for.
pub(crate) fn of_message<M: Message>() -> String {
    let service = M::SERVICE;
    format!(
        "{}, {} publishers, {} subscribers, history {}, buffer {}, borrowed {}, {NODES_MAX} nodes",
        payload::<M>(),
        service.max_publishers,
        service.max_subscribers,
        service.history,
        service.buffer,
        service.borrowed
    )
}

/// A request-response service as it is asked for.
pub(crate) fn of_request<Q: Request>() -> String {
    let clients = Q::SERVICE.max_clients;
    format!("{} answered by {}, {clients} clients", payload::<Q>(), payload::<Q::Response>())
}

/// An event service as it is asked for.
pub(crate) fn of_event() -> String {
    format!("events, {EVENT_PORTS_MAX} notifiers, {EVENT_PORTS_MAX} listeners")
}

/// Every service of a robot as it is asked for, under its name.
pub(crate) fn all() -> Vec<String> {
    struct Signatures(Vec<String>);
    impl Visitor for Signatures {
        fn message<M: Message>(&mut self) {
            let name = M::SERVICE.name_of(RobotId(0));
            self.0.push(format!("{name}: {}, {:?}", of_message::<M>(), M::SERVICE.capacity));
        }

        fn request<Q: Request>(&mut self) {
            let name = Q::SERVICE.name_of(RobotId(0));
            self.0.push(format!("{name}: {}, pages of {}", of_request::<Q>(), Q::SERVICE.page));
        }
    }
    let mut signatures = Signatures(Vec::new());
    contract::wire::visit(&mut signatures);
    signatures.0
}

/// A service as it was created.
pub(crate) fn of_existing(service: &StaticConfig) -> String {
    match service.messaging_pattern() {
        MessagingPattern::PublishSubscribe(config) => {
            let types = config.message_type_details();
            format!(
                "{}, {} publishers, {} subscribers, history {}, buffer {}, borrowed {}, {} nodes",
                types_of(&types.user_header, &types.payload),
                config.max_publishers(),
                config.max_subscribers(),
                config.history_size(),
                config.subscriber_max_buffer_size(),
                config.subscriber_max_borrowed_samples(),
                config.max_nodes()
            )
        }
        MessagingPattern::Event(config) => {
            format!("events, {} notifiers, {} listeners", config.max_notifiers(), config.max_listeners())
        }
        MessagingPattern::RequestResponse(config) => {
            let (request, response) =
                (config.request_message_type_details(), config.response_message_type_details());
            format!(
                "{} answered by {}, {} clients",
                types_of(&request.user_header, &request.payload),
                types_of(&response.user_header, &response.payload),
                config.max_clients()
            )
        }
        other => format!("{other:?}"),
    }
}

fn payload<P: Payload>() -> String {
    let (header_bytes, cell_bytes) = (size_of::<P::Header>(), size_of::<P::Cell>());
    types((P::Header::NAME, header_bytes), (P::Cell::NAME, cell_bytes))
}

fn types_of(header: &TypeDetail, payload: &TypeDetail) -> String {
    let one = |detail: &TypeDetail| (detail.type_name().to_string(), detail.size());
    let ((header, header_bytes), (cell, cell_bytes)) = (one(header), one(payload));
    match payload.variant() {
        TypeVariant::FixedSize => types(("", 0), (&cell, cell_bytes)),
        TypeVariant::Dynamic => types((&header, header_bytes), (&cell, cell_bytes)),
    }
}

/// A header and its cells, each by name and size in bytes. A message of one fixed size has no header.
fn types((header, header_bytes): (&str, usize), (cell, cell_bytes): (&str, usize)) -> String {
    match header_bytes {
        0 => format!("{cell} ({cell_bytes} bytes)"),
        _ => format!("{header} ({header_bytes} bytes) with cells of {cell} ({cell_bytes} bytes)"),
    }
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use super::*;

    /// Which there are is checked against docs/messages.md, in tests/book.rs.
    #[test]
    fn every_service_of_the_contract_is_described_once() {
        let signatures = all();
        let names: BTreeSet<_> =
            signatures.iter().filter_map(|text| Some(text.split_once(": ")?.0)).collect();
        assert_eq!(names.len(), signatures.len(), "{signatures:#?}");
        assert!(names.len() >= 11, "{signatures:#?}");
    }
}
