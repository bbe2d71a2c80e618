//! The bodies of all fuzz targets, over the committed corpus and mutations of valid input.

use std::any::type_name;
use std::collections::BTreeSet;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::{Path, PathBuf};

use contract::message::Visitor;
use contract::{Message, Payload, Request};
use hostile::mutation::Mutator;
use hostile::{TARGETS, Target};

/// Mutations of each target.
const MUTATIONS: usize = 4000;

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..")
}

/// The committed inputs of a target by name, those that once broke it among them.
fn corpus(target: &Target) -> Vec<(String, Vec<u8>)> {
    let Ok(folder) = std::fs::read_dir(root().join("fuzz/corpus").join(target.name)) else {
        return Vec::new();
    };
    let mut paths: Vec<PathBuf> = folder.map(|entry| entry.unwrap().path()).collect();
    paths.sort();
    paths.iter().map(|path| (path.display().to_string(), std::fs::read(path).unwrap())).collect()
}

/// Has a target read `bytes`; if a claim does not hold, they are kept, and told of.
fn read(target: &Target, what: &str, bytes: &[u8]) -> Result<(), String> {
    catch_unwind(AssertUnwindSafe(|| (target.read)(bytes))).map_err(|_| {
        let kept = std::env::temp_dir().join(format!("hostile-{}", target.name));
        let _ = std::fs::write(&kept, bytes);
        format!("{}: {what}, kept in {}", target.name, kept.display())
    })
}

/// Its corpus, then mutations of that and of valid input, until one does not hold.
fn read_all(target: &Target) -> Result<(), String> {
    let kept = corpus(target);
    kept.iter().try_for_each(|(name, bytes)| read(target, name, bytes))?;
    let seeds: Vec<Vec<u8>> =
        (target.seeds)().into_iter().chain(kept.into_iter().map(|(_, bytes)| bytes)).collect();
    assert!(!seeds.is_empty(), "{} has nothing to begin from", target.name);
    let mut mutator = Mutator::new(2023);
    (0..MUTATIONS).try_for_each(|round| {
        let (seed, other) = (&seeds[round % seeds.len()], &seeds[(round / 3) % seeds.len()]);
        read(target, &format!("mutation {round}"), &mutator.mutate(seed, other))
    })
}

/// P-FUZZED: No reader panics on any input: the bodies of all fuzz targets run over their corpus
/// and 4,000 mutations of valid input each. `fuzz/README.md` has the figures under libFuzzer.
#[test]
fn no_reader_panics_whatever_it_reads() {
    let fallen: Vec<String> = TARGETS.iter().filter_map(|target| read_all(target).err()).collect();
    assert!(fallen.is_empty(), "claims do not hold:\n{}", fallen.join("\n"));
}

/// Every wire type of a message, by its path.
struct WireTypes(BTreeSet<&'static str>);

impl WireTypes {
    fn payload<P: Payload>(&mut self) {
        self.0.extend([type_name::<P::Header>(), type_name::<P::Cell>()]);
    }
}

impl Visitor for WireTypes {
    fn message<M: Message>(&mut self) {
        self.payload::<M>();
    }

    fn request<Q: Request>(&mut self) {
        self.payload::<Q>();
        self.payload::<Q::Response>();
    }
}

/// P-FUZZED-ALL: Every wire type is read by a fuzz target, and every target is a binary of `fuzz/`.
#[test]
fn every_wire_type_and_every_target_has_its_place() {
    let read = |path: PathBuf| std::fs::read_to_string(&path).unwrap();
    let body = read(root().join("qa/hostile/src/wire.rs"));
    let mut types = WireTypes(BTreeSet::new());
    contract::wire::visit(&mut types);
    assert!(types.0.len() > 14, "{:?}", types.0);
    for path in types.0 {
        let name = path.rsplit("::").next().unwrap();
        assert!(body.contains(name), "no target reads {name}");
    }
    let manifest = read(root().join("fuzz/Cargo.toml"));
    for Target { name, .. } in TARGETS {
        assert!(manifest.contains(&format!("name = \"{name}\"")), "{name} is no binary of fuzz/");
        let main = read(root().join(format!("fuzz/fuzz_targets/{name}.rs")));
        assert!(main.contains("fuzz_target!") && main.contains("hostile::"), "{name}");
    }
}
