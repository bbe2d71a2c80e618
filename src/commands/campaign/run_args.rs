//! What `hopper campaign run` is given, whatever it flies.

use std::path::PathBuf;

use ::campaign::Shard;
use report::Format;

/// Arguments of `hopper campaign run`.
#[derive(clap::Args, Clone, Debug)]
pub struct Args {
    /// The campaign: a TOML file, or the name of a built-in one; see `hopper campaign list`.
    #[arg(value_name = "NAME|FILE")]
    pub file: PathBuf,
    /// Threads to fly on [default: one per core].
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=4096))]
    pub(super) jobs: Option<u16>,
    /// Fly the I-th of N equal parts only, I from 1 to N.
    #[arg(long, value_name = "I/N", default_value = "1/1")]
    pub(super) shard: Shard,
    /// Continue where an earlier run into the same folder ended.
    #[arg(long)]
    pub(super) resume: bool,
    /// Folder for the rows [default: out/NAME, or out/NAME-I-of-N for a shard].
    #[arg(long, value_name = "DIR", value_parser = node::output_path())]
    pub(super) out: Option<PathBuf>,
    /// Format of the summary on standard output: text or json.
    #[arg(long, default_value_t)]
    pub(super) format: Format,
}
