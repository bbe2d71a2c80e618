//! One message of a recording, as it stands in the file.

use contract::{Announcement, DetailPage, DetailRequest, MonotonicNs, Route, Team};

use crate::{Channel, JsonMessage, MessageError, RecordedMessage, RecordingError};

/// One message of a recording.
#[derive(Clone, Debug)]
pub struct Entry<'a> {
    /// Number in the file, from 0.
    pub number: u64,
    /// Topic it was recorded on.
    pub topic: String,
    /// The channel, if it is one of Hopper's with the expected schema.
    pub known: Option<Channel>,
    /// When the recorder received it.
    pub logged: MonotonicNs,
    /// When it was published, or `logged` if the message has no such time.
    pub published: MonotonicNs,
    /// Number on its channel, from 0.
    pub sequence: u32,
    /// Its protobuf encoding.
    pub data: &'a [u8],
}

impl Entry<'_> {
    /// The decoded message; `None` on channels of other programs and on those made for viewers.
    ///
    /// # Errors
    /// If it is not protobuf of its schema, or a field is out of range.
    pub fn message(&self) -> Result<Option<RecordedMessage>, RecordingError> {
        let Some(topic) = self.known else { return Ok(None) };
        RecordedMessage::decode(topic, self.data).map_err(|cause| RecordingError::Message {
            topic: self.topic.clone(),
            number: self.number,
            cause,
        })
    }

    /// Why Hopper cannot decode the message; `None` if it can, or if the topic is another program's.
    #[must_use]
    pub fn undecodable(&self) -> Option<RecordingError> {
        let cause = match self.known {
            Some(_) => return self.message().err(),
            None if JsonMessage::is_topic_of::<Team>(&self.topic) => {
                serde_json::from_slice::<Team>(self.data).err().map(json)
            }
            None if JsonMessage::is_topic_of::<Announcement>(&self.topic) => {
                match serde_json::from_slice::<Announcement>(self.data) {
                    Ok(Announcement { route, .. }) => {
                        Route::new(route.waypoints().to_vec()).err().map(MessageError::from)
                    }
                    Err(error) => Some(json(error)),
                }
            }
            None if JsonMessage::is_topic_of_answers::<DetailRequest>(&self.topic) => {
                match serde_json::from_slice::<DetailPage>(self.data) {
                    Ok(DetailPage { detail, .. }) => detail.checked().err().map(MessageError::from),
                    Err(error) => Some(json(error)),
                }
            }
            None => None,
        };
        Some(RecordingError::Message { topic: self.topic.clone(), number: self.number, cause: cause? })
    }
}

fn json(error: serde_json::Error) -> MessageError {
    MessageError::Json(error.to_string())
}
