//! The committed code and descriptors of the schemas are those of their `.proto` files.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

use std::path::Path;

use prost::Message as _;

const FOLDER: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../../crates/recording/proto");

/// P-BAG-SCHEMAS: The committed schemas match the `.proto` files.
///
/// Run with `HOPPER_BLESS=1` to write them anew.
#[test]
fn the_committed_schemas_are_those_of_the_proto_files() {
    let made = tempfile::tempdir().unwrap();
    for name in ["hopper", "foxglove"] {
        let file = format!("{name}.proto");
        let compile = |with_comments| {
            let mut compiler = protox::Compiler::new([FOLDER]).unwrap();
            compiler.include_source_info(with_comments).include_imports(true).open_file(&file).unwrap();
            compiler.file_descriptor_set()
        };
        let descriptors = compile(false).encode_to_vec();
        prost_build::Config::new().out_dir(made.path()).compile_fds(compile(true)).unwrap();
        let code = std::fs::read(made.path().join(format!("{name}.rs"))).unwrap();
        for (file, bytes) in [(format!("{name}.rs"), code), (format!("{name}.bin"), descriptors)] {
            let path = Path::new(FOLDER).join(file);
            if std::env::var_os("HOPPER_BLESS").is_some() {
                std::fs::write(&path, &bytes).unwrap();
            }
            assert!(std::fs::read(&path).unwrap() == bytes, "{} is out of date", path.display());
        }
    }
}
