//! What stands behind a record in the journal.

use contract::{Action, Detail, DetailId, Record, Route};

/// What a record names by its fingerprint.
#[derive(Clone, Debug, PartialEq)]
pub enum Attachment {
    /// The points of the route that it announces.
    Route(Route),
    /// What the motion model tells beyond the outcome.
    Detail(Detail),
}

impl Attachment {
    /// Whether `record` names `attachment`, or needs none where there is none.
    #[must_use]
    pub fn fits(attachment: Option<&Self>, record: &Record) -> bool {
        let (route, detail) = match attachment {
            None => (None, DetailId::NONE),
            Some(Self::Route(route)) => (Some(route.id()), DetailId::NONE),
            Some(Self::Detail(detail)) => (None, detail.id()),
        };
        let announced = match record.action {
            Action::Announce(id) => Some(id),
            _ => None,
        };
        (announced, record.detail) == (route, detail)
    }

    /// The route, if it is one.
    #[must_use]
    pub fn route(&self) -> Option<&Route> {
        match self {
            Self::Route(route) => Some(route),
            Self::Detail(_) => None,
        }
    }

    /// The detail, if it is one.
    #[must_use]
    pub fn detail(&self) -> Option<&Detail> {
        match self {
            Self::Detail(detail) => Some(detail),
            Self::Route(_) => None,
        }
    }
}
