//! A writer that takes its share of shared memory only once somebody is to be told something.

use std::rc::Rc;

use contract::Policy;
use contract::service::Topic;

use crate::base::Base;
use crate::port::{Slices, count_readers, open_slices};
use crate::{NodeError, Sheet, SheetWriter};

/// Writes `hop/rN/policy`, for whoever listens.
pub type PolicyPort = OnDemand<Policy>;

/// A writer of a topic whose messages are a header and cells, made when the first message is published, for
/// messages of as many cells. It is made anew for messages of another size, once the old one is gone: at no
/// time does shared memory hold both.
#[derive(Debug)]
pub struct OnDemand<S: Sheet> {
    base: Rc<Base>,
    topic: Topic,
    factory: Slices<S>,
    writer: Option<(usize, SheetWriter<S>)>,
}

impl<S: Sheet> OnDemand<S> {
    pub(crate) fn new(base: &Rc<Base>, topic: Topic) -> Result<Self, NodeError> {
        let factory = open_slices::<S>(base, &topic)?;
        Ok(Self { base: Rc::clone(base), topic, factory, writer: None })
    }

    /// How many read at present, those not yet freed after death included.
    #[must_use]
    pub fn readers(&self) -> usize {
        count_readers(&self.factory)
    }

    /// Publishes a message.
    ///
    /// # Errors
    /// [`NodeError::NoRoom`] if shared memory cannot hold messages of this size; otherwise as
    /// [`SheetWriter::publish`].
    pub fn publish(&mut self, message: &S) -> Result<(), NodeError> {
        let cells = message.cells();
        if self.writer.as_ref().is_some_and(|(most, _)| *most != cells) {
            self.writer = None;
        }
        if self.writer.is_none() {
            self.writer = Some((cells, SheetWriter::new(&self.base, &self.topic, cells)?));
        }
        self.writer.as_ref().map_or(Ok(()), |(_, writer)| writer.publish(message))
    }
}
