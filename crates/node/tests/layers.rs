//! No module of this crate imports in a circle.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

use std::fs;
use std::path::{Path, PathBuf};

/// Files and folders of `src`, each importing only from those before it.
const ORDER: [&str; 20] = [
    "shared_memory",
    "error",
    "clock",
    "crash",
    "host",
    "log",
    "nonce",
    "exit",
    "file_lock",
    "middleware",
    "signature",
    "membership",
    "memory_budget",
    "cleanup",
    "session",
    "ports",
    "node",
    "peer",
    "inspect",
    "relay",
];

fn files(folder: &Path) -> Vec<PathBuf> {
    let paths = fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path());
    paths.flat_map(|path| if path.is_dir() { files(&path) } else { vec![path] }).collect()
}

#[test]
fn modules_import_only_from_those_before_them() {
    let src = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
    let place = |module: &str| ORDER.iter().position(|known| *known == module);
    for path in files(&src) {
        let within = path.strip_prefix(&src).unwrap().with_extension("");
        let module = within.iter().next().unwrap().to_str().unwrap();
        if module == "lib" {
            continue;
        }
        let own = place(module).unwrap_or_else(|| panic!("{module} has no place in the order"));
        let text = fs::read_to_string(&path).unwrap();
        for import in text.split("crate::").skip(1) {
            let names = match import.strip_prefix('{') {
                Some(list) => list.split('}').next().unwrap(),
                None => import,
            };
            let names = if import.starts_with('{') { names.split(", ").collect() } else { vec![names] };
            for name in names {
                let end = name.find(|c: char| !c.is_alphanumeric() && c != '_').unwrap_or(name.len());
                let imported = &name[..end];
                let place = place(imported).unwrap_or_else(|| panic!("{module} imports {imported}"));
                assert!(place <= own, "{} imports {imported}, which comes later", path.display());
            }
        }
    }
}
