//! Waiting for a peer: which one, and for how long.

use std::borrow::Cow;
use std::time::Duration;

use contract::MonotonicNs;

use crate::{Exit, Failure, Ports};

/// A wait as long as this is logged: between two decisions everybody waits a little.
const WORTH_A_LINE_NS: u64 = 300_000_000;

/// Logs which peer a process waits for, and ends the wait after a limit.
#[derive(Clone, Debug)]
pub struct Patience {
    limit: Option<Duration>,
    /// Since when something has been waited for without a break.
    since: Option<MonotonicNs>,
    /// The peer that the log has named.
    logged: Option<Cow<'static, str>>,
}

impl Patience {
    /// Waits at most `limit` without a break; `None` waits forever.
    #[must_use]
    pub fn new(limit: Option<Duration>) -> Self {
        Self { limit, since: None, logged: None }
    }

    /// Notes what is waited for at present.
    ///
    /// # Errors
    /// Exit code 4 when something was waited for without a break for longer than the limit.
    pub fn check<P: Ports>(
        &mut self,
        waits_for: Option<impl Into<Cow<'static, str>>>,
        ports: &mut P,
    ) -> Result<(), Failure> {
        self.check_at(waits_for, ports.now(), || ports.absence_hint())
    }

    /// As [`Patience::check`], at `now`; `hint` is appended to what is logged.
    ///
    /// # Errors
    /// As [`Patience::check`].
    pub fn check_at(
        &mut self,
        waits_for: Option<impl Into<Cow<'static, str>>>,
        now: MonotonicNs,
        hint: impl Fn() -> String,
    ) -> Result<(), Failure> {
        let Some(what) = waits_for else {
            self.since = None;
            if let Some(what) = self.logged.take() {
                tracing::info!("no longer waiting for {what}");
            }
            return Ok(());
        };
        let what = what.into();
        let since = *self.since.get_or_insert(now);
        if self.logged.as_ref() != Some(&what) && now.since_ns(since) >= WORTH_A_LINE_NS {
            tracing::info!("waiting for {what}{}", hint());
            self.logged = Some(what.clone());
        }
        match self.limit {
            Some(limit) if u128::from(now.since_ns(since)) >= limit.as_nanos() => Err(Failure::new(
                Exit::Peer,
                format!(
                    "waited {limit:?} for {what}: start it in this instance, or allow more with --wait{}",
                    hint()
                ),
            )),
            _ => Ok(()),
        }
    }
}
