// A hash of sources, for build scripts.

use std::path::{Path, PathBuf};

use sha2::{Digest, Sha256};

/// The first `bytes` bytes of SHA-256 over names and contents of all files below `sources`, in order of names, hexadecimal.
/// Names count from `root`. The build script runs again when one of them changes.
pub fn hash(root: &Path, sources: &[PathBuf], bytes: usize) -> String {
    let mut files = Vec::new();
    for source in sources {
        let path = root.join(source);
        assert!(path.exists(), "the build script hashes {}, which does not exist", path.display());
        println!("cargo::rerun-if-changed={}", path.display());
        list(root, source, &mut files);
    }
    files.sort();
    let mut hasher = Sha256::new();
    for file in files {
        let contents = std::fs::read(root.join(&file)).unwrap_or_default();
        hasher.update(file.to_string_lossy().as_bytes());
        hasher.update((contents.len() as u64).to_le_bytes());
        hasher.update(contents);
    }
    hasher.finalize()[..bytes].iter().map(|byte| format!("{byte:02x}")).collect()
}

fn list(root: &Path, path: &Path, files: &mut Vec<PathBuf>) {
    let Ok(entries) = std::fs::read_dir(root.join(path)) else {
        files.push(path.into());
        return;
    };
    for entry in entries.flatten() {
        list(root, &path.join(entry.file_name()), files);
    }
}
