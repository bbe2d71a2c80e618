//! PROMISES.md has the headlines, docs/promises.md the details, and the comments of the tests both.
//!
//! The comment of one test says what a promise is: `/// P-ID: sentence`, up to an empty line or the
//! next id. Other tests that hold it have the id with a full stop, `/// P-ID.`, and may go on with
//! what they add. A headline names ids, or all that begin alike: `P-BAG-*` are those that no other
//! headline names.

use std::collections::BTreeMap;
use std::fmt::Write;

use super::{EVERYWHERE, read, root, sources};

const PAGE: &str = "docs/promises.md";
const HEAD: &str = "# Promises in detail

Every promise with the tests that hold it, below the headlines of `PROMISES.md`. This page is written from the comments
of the tests; `HOPPER_BLESS=1 cargo test --test tests -- promises` writes it anew.
";

/// A detail of a promise, with the tests that hold it as (file, function).
#[derive(Default)]
struct Promise {
    sentences: Vec<String>,
    tests: Vec<(String, String)>,
}

/// All promises by id, from the comments of all tests.
fn promises() -> BTreeMap<String, Promise> {
    let mut files: Vec<_> = EVERYWHERE.iter().flat_map(sources).collect();
    files.sort();
    let mut promises: BTreeMap<String, Promise> = BTreeMap::new();
    for file in files {
        let text = read(&file);
        let path = file.strip_prefix(root()).unwrap().to_string_lossy().into_owned();
        let lines: Vec<&str> = text.lines().map(str::trim).collect();
        for (at, line) in lines.iter().enumerate() {
            let Some(named) = line.strip_prefix("/// ").filter(|named| named.starts_with("P-")) else {
                continue;
            };
            let place = format!("{path}:{}", at + 1);
            let end = named.find([':', '.']).unwrap_or_else(|| panic!("{place}: needs `P-ID:` or `P-ID.`"));
            let (id, rest) = named.split_at(end);
            let is_id = |c: char| c.is_ascii_uppercase() || c.is_ascii_digit() || c == '-';
            assert!(id.chars().all(is_id), "{place}: {id:?} is no id");
            let promise = promises.entry(id.to_owned()).or_default();
            if let Some(begin) = rest.strip_prefix(':') {
                promise.sentences.push(sentence(begin.trim(), &lines[at + 1..]));
            }
            promise
                .tests
                .push((path.clone(), test_below(&lines[at..]).unwrap_or_else(|| panic!("{place}: no test"))));
        }
    }
    promises
}

/// A sentence that begins with `begin` and goes on in the lines of its paragraph.
fn sentence(begin: &str, below: &[&str]) -> String {
    let mut sentence = begin.to_owned();
    for line in below {
        match line.strip_prefix("/// ") {
            Some(more) if !more.starts_with("P-") => sentence += &format!(" {more}"),
            _ => break,
        }
    }
    sentence
}

/// The test that a comment is of.
fn test_below(lines: &[&str]) -> Option<String> {
    let above = lines.iter().take_while(|line| line.starts_with("//") || line.starts_with("#["));
    let is_test = above.clone().any(|line| line.contains("test"));
    let function = lines.get(above.count())?.strip_prefix("fn ")?;
    is_test.then(|| function.split('(').next().unwrap().to_owned())
}

/// A promise as PROMISES.md has it.
struct Headline {
    group: String,
    text: String,
    /// Ids, and beginnings of ids with a `*` behind.
    names: Vec<String>,
}

fn headlines() -> Vec<Headline> {
    let text = read("PROMISES.md");
    let mut group = "";
    let mut headlines: Vec<Headline> = Vec::new();
    for line in text.lines() {
        if let Some(title) = line.strip_prefix("## ") {
            group = title;
        } else if let Some(text) = line.strip_prefix("- ") {
            headlines.push(Headline { group: group.into(), text: text.into(), names: Vec::new() });
        } else if let Some(more) = line.strip_prefix("  ") {
            let headline = headlines.last_mut().expect("a headline comes before its ids");
            if more.starts_with("`P-") {
                headline.names.extend(more.split('`').skip(1).step_by(2).map(Into::into));
            } else {
                headline.text += &format!(" {more}");
            }
        }
    }
    headlines
}

/// The headlines that name `id`: by itself if any does, else by how it begins.
fn places(id: &str, headlines: &[Headline]) -> Vec<usize> {
    let naming = |is_named: &dyn Fn(&str) -> bool| -> Vec<usize> {
        let names = headlines
            .iter()
            .enumerate()
            .flat_map(|(at, headline)| headline.names.iter().map(move |name| (at, name)));
        names.filter(|(_, name)| is_named(name)).map(|(at, _)| at).collect()
    };
    let by_itself = naming(&|name| name == id);
    if by_itself.is_empty() {
        naming(&|name| name.strip_suffix('*').is_some_and(|begin| id.starts_with(begin)))
    } else {
        by_itself
    }
}

#[test]
fn every_promise_has_one_sentence_and_one_headline() {
    let (promises, headlines) = (promises(), headlines());
    assert!((40..=60).contains(&headlines.len()), "{} headlines are no list to read", headlines.len());
    let mut held = vec![0; headlines.len()];
    for (id, promise) in &promises {
        let [sentence] = &promise.sentences[..] else {
            panic!("{id} has {} sentences in {:?}", promise.sentences.len(), promise.tests);
        };
        assert!(sentence.ends_with('.'), "{id}: {sentence}");
        let [at] = places(id, &headlines)[..] else {
            panic!("{id} needs one headline, got {:?}", places(id, &headlines));
        };
        held[at] += 1;
    }
    for (headline, held) in headlines.iter().zip(held) {
        assert!(held > 0, "no test holds: {}", headline.text);
        for name in &headline.names {
            let begin = name.strip_suffix('*');
            let is_held = promises.keys().any(|id| begin.map_or(id == name, |begin| id.starts_with(begin)));
            assert!(is_held, "{name} is no promise of any test: {}", headline.text);
        }
    }
}

/// What docs/promises.md has to be.
fn page() -> String {
    let (promises, headlines) = (promises(), headlines());
    let mut page = HEAD.to_owned();
    let mut group = "";
    for (at, headline) in headlines.iter().enumerate() {
        if headline.group != group {
            group = &headline.group;
            write!(page, "\n## {group}\n").unwrap();
        }
        write!(page, "\n{}\n\n", headline.text).unwrap();
        for (id, promise) in promises.iter().filter(|(id, _)| places(id, &headlines) == [at]) {
            let mut tests: BTreeMap<&str, Vec<String>> = BTreeMap::new();
            for (file, test) in &promise.tests {
                tests.entry(file).or_default().push(format!("`{test}`"));
            }
            let tests: Vec<String> =
                tests.iter().map(|(file, tests)| format!("`{file}`: {}", tests.join(", "))).collect();
            let sentence = promise.sentences.join(" ");
            write!(page, "- **{id}**: {sentence}\n  ({})\n", tests.join("; ")).unwrap();
        }
    }
    page
}

#[test]
fn the_page_of_promises_is_that_of_the_comments() {
    let page = page();
    if std::env::var_os("HOPPER_BLESS").is_some() {
        std::fs::write(root().join(PAGE), &page).unwrap();
    }
    let written = read(PAGE);
    let differs = page.lines().zip(written.lines()).find(|(made, found)| made != found);
    assert!(page == written, "HOPPER_BLESS=1 writes {PAGE} anew; the first difference: {differs:?}");
}
