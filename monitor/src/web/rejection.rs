//! Why a request is refused.

/// Why a request is refused: the HTTP status code and a sentence.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Rejection(pub u16, pub String);

impl Rejection {
    /// With its status code and reason.
    pub fn new(status: u16, reason: impl Into<String>) -> Self {
        Self(status, reason.into())
    }

    /// The reason phrase of the status code.
    #[must_use]
    pub fn phrase(&self) -> &'static str {
        match self.0 {
            400 => "Bad Request",
            403 => "Forbidden",
            404 => "Not Found",
            405 => "Method Not Allowed",
            408 => "Request Timeout",
            409 => "Conflict",
            411 => "Length Required",
            413 => "Content Too Large",
            415 => "Unsupported Media Type",
            421 => "Misdirected Request",
            426 => "Upgrade Required",
            431 => "Request Header Fields Too Large",
            503 => "Service Unavailable",
            _ => "Error",
        }
    }

    /// Whether whoever started the server can do something about it: the reason then says what.
    #[must_use]
    pub fn has_remedy(&self) -> bool {
        matches!(self.0, 403 | 421)
    }
}

/// Which refusals the log has shown: each is shown once, so that a flood of requests does not fill the log.
#[derive(Debug, Default)]
pub struct RefusalLog {
    shown: std::collections::BTreeSet<String>,
}

/// Most different refusals that the log shows.
const SHOWN_MAX: usize = 16;

impl RefusalLog {
    /// What to log about a refusal, if it is not shown yet.
    pub fn line(&mut self, rejection: &Rejection) -> Option<String> {
        if !rejection.has_remedy() || self.shown.len() > SHOWN_MAX || self.shown.contains(&rejection.1) {
            return None;
        }
        self.shown.insert(rejection.1.clone());
        if self.shown.len() > SHOWN_MAX {
            return Some("refused requests for many reasons: those to come are not logged".into());
        }
        Some(format!("refused a request: {}", rejection.1))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// P-WEB-REFUSALS: A request that is refused for its host, its origin or its key is logged
    /// once, with the remedy; a flood of them does not fill the log.
    #[test]
    fn each_refusal_is_shown_once_and_a_flood_of_different_ones_ends() {
        let mut log = RefusalLog::default();
        let mut line = |text: &str| log.line(&Rejection::new(421, text));
        assert_eq!(line("a").as_deref(), Some("refused a request: a"));
        assert_eq!((line("a"), line("a")), (None, None));
        let shown = (0..1000).filter_map(|number| line(&number.to_string())).count();
        assert_eq!(shown, SHOWN_MAX, "fifteen more, and that there are no more");
        let mut log = RefusalLog::default();
        assert_eq!(log.line(&Rejection::new(404, "there is no such path")), None, "nothing to be done");
    }
}
