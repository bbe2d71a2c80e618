//! `hopper bag export --ros2`: writes the last mission of a recording as a bag of ROS 2.

use std::fs::Permissions;
use std::io::{self, BufWriter, Write};
use std::os::unix::fs::PermissionsExt;
use std::path::Path;

use contract::{Brief, PriorCell};
use node::{Exit, Failure};
use recording::Recording;
use ros2::{Conversion, Converted, Mission, Ros2Error, convert};

use super::{at_fault, folder_for, open, scenario_of, unwritten, warn_of_skipped};

/// Bytes of a MiB.
const MIB: u64 = 1 << 20;

/// The name of the file in a bag whose folder has a name that YAML cannot hold.
const UNNAMED: &str = "mission";

/// Writes the bag into the new folder `out`, for its owner only: whole, or not at all.
///
/// # Errors
/// Exit code 2 if the recording is none of Hopper's, is cut off, or has no map, or if the folder is there already or cannot be
/// made; 1 if the bag cannot be written.
pub fn write(path: &Path, bytes: &[u8], out: &Path, maps_mib: u32) -> Result<Exit, Failure> {
    let parent = folder_for(out, "folder")?;
    let recording = Recording::read(bytes).map_err(|error| at_fault(path, &error))?;
    if let Some(fault) = &recording.fault {
        return Err(Failure::usage(format!(
            "{path} is not whole: {fault}; a bag needs a whole recording, which hopper bag recover {path} whole.mcap makes of what is there",
            path = path.display()
        )));
    }
    let recording = open(path, bytes)?;
    let mission = Mission::of(&recording).map_err(|error| failure(path, out, error))?;
    warn_of_skipped(path, &mission.skipped);
    let prior = prior(&recording, &mission.brief)?;
    let conversion = Conversion { prior: &prior, maps_bytes_max: u64::from(maps_mib) * MIB };
    // Under another name until it is whole; dropping it removes it.
    let owner_only = Permissions::from_mode(0o700);
    let folder = tempfile::Builder::new().prefix(".hopper-").permissions(owner_only).tempdir_in(parent);
    let folder = folder.map_err(|error| unwritten(out, Exit::Usage, &error.kind().into()))?;
    let name = out.file_name().and_then(|name| name.to_str()).unwrap_or(UNNAMED);
    let file_name = format!("{name}_0.mcap");
    let cannot = |error: io::Error| unwritten(out, Exit::Failed, &error);
    let mut file = BufWriter::new(std::fs::File::create(folder.path().join(&file_name)).map_err(cannot)?);
    let Converted { summary, maps: [written, changes] } =
        convert(&recording, &mission, &conversion, &mut file, &file_name)
            .map_err(|error| failure(path, out, error))?;
    file.flush().map_err(cannot)?;
    std::fs::write(folder.path().join("metadata.yaml"), &summary.metadata).map_err(cannot)?;
    // Over no folder but an empty one that was made meanwhile.
    std::fs::rename(folder.path(), out).map_err(cannot)?;
    let _ = folder.keep();
    let messages: u64 = summary.messages.values().sum();
    let topics = summary.messages.len();
    let thinned = if written < changes { "; --maps-mib keeps more of them" } else { "" };
    tracing::info!(
        "{}: wrote {messages} messages on {topics} topics, with {written} of {changes} maps{thinned}",
        out.display()
    );
    Ok(Exit::Done)
}

/// The expected speeds of uncertain ground, if the mission has such ground and the recording its scenario.
fn prior(recording: &Recording<'_>, brief: &Brief) -> Result<Vec<PriorCell>, Failure> {
    if brief.sampling.is_none() {
        return Ok(Vec::new());
    }
    let Some((_, world)) = scenario_of(recording, brief)? else { return Ok(Vec::new()) };
    let cells = world.terrain.prior.iter().zip(&world.terrain.cells);
    Ok(cells.map(|(speeds, ground)| PriorCell { speeds: *speeds, height_m: ground.height_m }).collect())
}

/// A failure that names the file at fault.
fn failure(path: &Path, out: &Path, error: Ros2Error) -> Failure {
    match error {
        Ros2Error::Recording(_) | Ros2Error::NoMap { .. } => {
            Failure::usage(format!("{}: {error}", path.display()))
        }
        Ros2Error::Write(_) | Ros2Error::Encode { .. } => {
            Failure::new(Exit::Failed, format!("{} cannot be written: {error}", out.display()))
        }
    }
}
