//! Why the middleware could not open a service.

use iceoryx2::service::builder::event::{EventOpenError, EventOpenOrCreateError};
use iceoryx2::service::builder::publish_subscribe::{
    PublishSubscribeOpenError, PublishSubscribeOpenOrCreateError,
};
use iceoryx2::service::builder::request_response::{
    RequestResponseOpenError, RequestResponseOpenOrCreateError,
};

/// Whether to try again.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Obstacle {
    /// Another process is making or removing the service, or died while it did.
    Temporary,
    /// The service exists with another type or quality of service.
    Mismatch,
}

impl From<&PublishSubscribeOpenOrCreateError> for Obstacle {
    fn from(error: &PublishSubscribeOpenOrCreateError) -> Self {
        use PublishSubscribeOpenError as E;
        let PublishSubscribeOpenOrCreateError::PublishSubscribeOpenError(error) = error else {
            return Obstacle::Temporary;
        };
        match error {
            E::IncompatibleTypes
            | E::IncompatibleMessagingPattern
            | E::IncompatibleAttributes
            | E::IncompatibleOverflowBehavior
            | E::DoesNotSupportRequestedMinBufferSize
            | E::DoesNotSupportRequestedMinHistorySize
            | E::DoesNotSupportRequestedMinSubscriberBorrowedSamples
            | E::DoesNotSupportRequestedAmountOfPublishers
            | E::DoesNotSupportRequestedAmountOfSubscribers
            | E::DoesNotSupportRequestedAmountOfNodes
            | E::VersionMismatch => Obstacle::Mismatch,
            _ => Obstacle::Temporary,
        }
    }
}

impl From<&EventOpenOrCreateError> for Obstacle {
    fn from(error: &EventOpenOrCreateError) -> Self {
        use EventOpenError as E;
        let EventOpenOrCreateError::EventOpenError(error) = error else { return Obstacle::Temporary };
        match error {
            E::IncompatibleMessagingPattern
            | E::IncompatibleAttributes
            | E::IncompatibleDeadline
            | E::IncompatibleNotifierCreatedEvent
            | E::IncompatibleNotifierDroppedEvent
            | E::IncompatibleNotifierDeadEvent
            | E::DoesNotSupportRequestedAmountOfNotifiers
            | E::DoesNotSupportRequestedAmountOfListeners
            | E::DoesNotSupportRequestedMaxEventId
            | E::DoesNotSupportRequestedAmountOfNodes
            | E::VersionMismatch => Obstacle::Mismatch,
            _ => Obstacle::Temporary,
        }
    }
}

impl From<&RequestResponseOpenOrCreateError> for Obstacle {
    fn from(error: &RequestResponseOpenOrCreateError) -> Self {
        use RequestResponseOpenError as E;
        let RequestResponseOpenOrCreateError::RequestResponseOpenError(error) = error else {
            return Obstacle::Temporary;
        };
        match error {
            E::IncompatibleRequestOrResponseType
            | E::IncompatibleAttributes
            | E::IncompatibleMessagingPattern
            | E::IncompatibleOverflowBehaviorForRequests
            | E::IncompatibleOverflowBehaviorForResponses
            | E::IncompatibleBehaviorForFireAndForgetRequests
            | E::DoesNotSupportRequestedAmountOfClientRequestLoans
            | E::DoesNotSupportRequestedAmountOfActiveRequestsPerClient
            | E::DoesNotSupportRequestedResponseBufferSize
            | E::DoesNotSupportRequestedAmountOfServers
            | E::DoesNotSupportRequestedAmountOfClients
            | E::DoesNotSupportRequestedAmountOfNodes
            | E::DoesNotSupportRequestedAmountOfBorrowedResponsesPerPendingResponse
            | E::VersionMismatch => Obstacle::Mismatch,
            _ => Obstacle::Temporary,
        }
    }
}
