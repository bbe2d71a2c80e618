//! No modules of a crate import each other in a circle.
//!
//! Sibling modules are compared: an import of anything below `a` from anywhere below `b` is an arrow from `b` to `a`. Names that
//! a parent re-exports count as their module's. What a parent module imports from its own children is not an arrow.

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

use super::{code, packages, root, sources};

/// A module by its names from the crate's root, which has none.
type Module = Vec<String>;

/// Arrows between the children of each module.
type Arrows = BTreeMap<Module, BTreeMap<String, BTreeSet<String>>>;

#[test]
fn no_modules_import_each_other_in_a_circle() {
    let mut circles = Vec::new();
    for package in packages() {
        for (parent, arrows) in arrows(&root().join(&package).join("src")) {
            let circle = |module: &&String| reaches(&arrows, module, module);
            for module in arrows.keys().filter(circle) {
                let next: Vec<_> = arrows[module]
                    .iter()
                    .filter(|next| *next == module || reaches(&arrows, next, module))
                    .collect();
                circles.push(format!("{package}, {}::{module} imports {next:?}", parent.join("::")));
            }
        }
    }
    assert!(circles.is_empty(), "these modules import each other in a circle:\n{}", circles.join("\n"));
}

fn reaches(arrows: &BTreeMap<String, BTreeSet<String>>, from: &str, to: &str) -> bool {
    let mut open = vec![from];
    let mut seen = BTreeSet::new();
    while let Some(module) = open.pop() {
        let next = arrows.get(module).into_iter().flatten().map(String::as_str);
        open.extend(next.filter(|module| seen.insert(*module)));
    }
    seen.contains(to)
}

fn arrows(src: &Path) -> Arrows {
    let files: Vec<(Module, String)> = sources(src)
        .into_iter()
        .map(|file| {
            let text = code(&file);
            let product = text.split("#[cfg(test)]\nmod tests").next().unwrap_or_default().to_owned();
            (module(file.strip_prefix(src).unwrap()), product)
        })
        .collect();
    let modules: BTreeSet<&Module> = files.iter().map(|(module, _)| module).collect();
    let mut re_exports: BTreeMap<Module, Module> = BTreeMap::new();
    for (module, text) in &files {
        for list in text.split("pub use ").skip(1).chain(text.split("pub(crate) use ").skip(1)) {
            for path in paths(list.split(';').next().unwrap()) {
                let target = absolute(module, &modules, &path);
                let name = path.last().unwrap().clone();
                re_exports.insert([module.as_slice(), &[name]].concat(), target);
            }
        }
    }
    let mut arrows = Arrows::new();
    for (module, text) in &files {
        for path in references(text) {
            let mut target = absolute(module, &modules, &path);
            while let Some(end) =
                (1..=target.len()).rev().find(|end| re_exports.contains_key(&target[..*end]))
            {
                let meant = &re_exports[&target[..end]];
                if target.starts_with(meant) {
                    break;
                }
                target = [meant, &target[end..]].concat();
            }
            let common = module.iter().zip(&target).take_while(|(own, other)| own == other).count();
            if common < module.len()
                && common < target.len()
                && modules.iter().any(|known| known.starts_with(&target[..=common]))
            {
                let siblings = arrows.entry(module[..common].to_vec()).or_default();
                siblings.entry(module[common].clone()).or_default().insert(target[common].clone());
            }
        }
    }
    arrows
}

/// The module that a file below `src` holds.
fn module(file: &Path) -> Module {
    let mut names: Module =
        file.with_extension("").iter().map(|name| name.to_string_lossy().into_owned()).collect();
    if names.last().is_some_and(|last| last == "mod") || names == ["lib"] || names == ["main"] {
        names.pop();
    }
    names
}

/// All paths in `text` that begin with `crate`, `super` or `self`.
fn references(text: &str) -> Vec<Module> {
    ["crate::", "super::", "self::"]
        .iter()
        .flat_map(|start| text.match_indices(start))
        .filter(|(at, _)| {
            !text[..*at].ends_with(|before: char| before.is_alphanumeric() || "_:".contains(before))
        })
        .flat_map(|(at, _)| paths(&text[at..]))
        .collect()
}

/// The paths that `text` begins with: one, or as many as its braces hold.
fn paths(text: &str) -> Vec<Module> {
    let text = text.trim_start();
    if let Some(list) = text.strip_prefix('{') {
        let (mut depth, mut begin, mut all) = (0, 0, Vec::new());
        for (at, letter) in list.char_indices() {
            match letter {
                '{' => depth += 1,
                '}' if depth > 0 => depth -= 1,
                ',' | '}' if depth == 0 => {
                    all.extend(paths(&list[begin..at]));
                    begin = at + 1;
                    if letter == '}' {
                        break;
                    }
                }
                _ => {}
            }
        }
        return all;
    }
    let end = text.find(|letter: char| !letter.is_alphanumeric() && letter != '_').unwrap_or(text.len());
    let name = text[..end].to_owned();
    match text[end..].strip_prefix("::") {
        _ if name.is_empty() => Vec::new(),
        Some(rest) => {
            let below = paths(rest);
            if below.is_empty() {
                return vec![vec![name]];
            }
            below.into_iter().map(|path| [vec![name.clone()], path].concat()).collect()
        }
        None => vec![vec![name]],
    }
}

/// A path as it is written in `module`, from the crate's root.
fn absolute(module: &Module, modules: &BTreeSet<&Module>, path: &[String]) -> Module {
    let mut base = module.clone();
    let mut rest = path;
    match path.first().map(String::as_str) {
        Some("crate") => {
            base.clear();
            rest = &path[1..];
        }
        Some("self") => rest = &path[1..],
        Some("super") => {
            while rest.first().is_some_and(|name| name == "super") {
                base.pop();
                rest = &rest[1..];
            }
        }
        // A child, or else another crate.
        Some(first) => {
            let child = [module.as_slice(), &[first.to_owned()]].concat();
            if !modules.contains(&child) {
                return vec!["another crate".to_owned()];
            }
        }
        None => {}
    }
    base.extend(rest.iter().cloned());
    base
}
