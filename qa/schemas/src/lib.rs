//! Nothing but tests: what compiles schemas, and the viewers' own messages, are built for them alone.

#![warn(clippy::disallowed_methods)]
