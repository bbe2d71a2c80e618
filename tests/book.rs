//! The README and the book in docs/ agree with themselves and with the program.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

use crate::harness::{Mission, hopper, stderr};
use crate::tools::is_served;
use contract::message::Visitor;
use contract::{Message, Request};
use serde_json::Value;

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

fn read(path: impl AsRef<Path>) -> String {
    let path = root().join(path);
    std::fs::read_to_string(&path).unwrap_or_else(|error| panic!("{}: {error}", path.display()))
}

/// Every Markdown file below docs/, relative to the repository.
fn pages() -> Vec<PathBuf> {
    let mut folders = vec![PathBuf::from("docs")];
    let mut pages = Vec::new();
    while let Some(folder) = folders.pop() {
        for entry in std::fs::read_dir(root().join(&folder)).unwrap() {
            let path = folder.join(entry.unwrap().file_name());
            if root().join(&path).is_dir() {
                folders.push(path);
            } else if path.extension().is_some_and(|extension| extension == "md") {
                pages.push(path);
            }
        }
    }
    assert!(pages.len() > 10, "the book has {} pages", pages.len());
    pages.sort();
    pages
}

/// The text of a page without fenced blocks, line by line.
fn outside_fences(text: &str) -> impl Iterator<Item = &str> {
    let mut fenced = false;
    text.lines().filter(move |line| {
        let fence = line.trim_start().starts_with("```");
        fenced ^= fence;
        !fenced && !fence
    })
}

/// The lines outside fenced blocks, without code in backticks.
fn prose(text: &str) -> String {
    let lines = outside_fences(text).map(|line| line.split('`').step_by(2).collect::<Vec<_>>().join(" "));
    lines.collect::<Vec<_>>().join("\n")
}

/// Code in backticks outside fenced blocks.
fn quoted(text: &str) -> Vec<String> {
    let code = |line: &str| line.split('`').skip(1).step_by(2).map(str::to_owned).collect::<Vec<_>>();
    outside_fences(text).flat_map(code).collect()
}

/// The targets of links and images.
fn links(text: &str) -> Vec<String> {
    let prose = prose(text);
    prose.split("](").skip(1).map(|rest| rest.split(')').next().unwrap().to_owned()).collect()
}

/// The anchors of a page's headings, by the rule that GitHub and mdBook share.
fn anchors(text: &str) -> BTreeSet<String> {
    let mut counts: BTreeMap<String, usize> = BTreeMap::new();
    let headings = outside_fences(text).filter_map(|line| {
        let title = line.trim_start_matches('#');
        (title.len() < line.len() && title.starts_with(' ')).then(|| title.trim())
    });
    let slugs = headings.map(|title| {
        let slug: String = title
            .chars()
            .filter(|c| c.is_alphanumeric() || [' ', '-', '_'].contains(c))
            .map(|c| if c == ' ' { '-' } else { c })
            .flat_map(char::to_lowercase)
            .collect();
        let count = counts.entry(slug.clone()).or_default();
        *count += 1;
        if *count == 1 { slug } else { format!("{slug}-{}", *count - 1) }
    });
    slugs.collect()
}

/// The sections of a page: what each heading of the second or third level quotes, with the text below it.
fn sections(text: &str) -> BTreeMap<String, String> {
    let mut sections = BTreeMap::new();
    let mut here: Vec<String> = Vec::new();
    for line in text.lines() {
        if line.starts_with("## ") || line.starts_with("### ") {
            here = line.split('`').skip(1).step_by(2).map(str::to_owned).collect();
            for name in &here {
                assert!(sections.insert(name.clone(), String::new()).is_none(), "{name} has two sections");
            }
        }
        for name in &here {
            *sections.get_mut(name).unwrap() += &format!("{line}\n");
        }
    }
    sections
}

/// The first cell of each row of a section's tables that is code, without its backticks.
fn rows(section: &str) -> BTreeSet<String> {
    let first = |line: &str| Some(line.strip_prefix("| `")?.split('`').next().unwrap().to_owned());
    section.lines().filter_map(first).collect()
}

#[test]
fn every_page_is_in_the_summary_once() {
    let listed = links(&read("docs/SUMMARY.md"));
    let unique: BTreeSet<&String> = listed.iter().collect();
    assert_eq!(listed.len(), unique.len(), "a page is listed twice: {listed:?}");
    let listed: BTreeSet<PathBuf> = listed.iter().map(|page| Path::new("docs").join(page)).collect();
    let there = pages().into_iter().filter(|page| !page.ends_with("SUMMARY.md")).collect();
    assert_eq!(listed, there, "docs/SUMMARY.md and the files in docs/");
}

/// Links of the book stay within it, since mdBook copies nothing else.
#[test]
fn every_link_and_every_anchor_resolves() {
    let outside = ["README.md", "ARCHITECTURE.md", "PROMISES.md", "CHANGELOG.md", "fuzz/README.md"];
    let mut count = 0;
    for page in outside.iter().map(PathBuf::from).chain(pages()) {
        let text = read(&page);
        for link in links(&text) {
            if link.starts_with("https://") || link.starts_with("http://") {
                continue;
            }
            let (file, anchor) = link.split_once('#').unwrap_or((&link, ""));
            let folder = page.parent().unwrap();
            let target = if file.is_empty() { page.clone() } else { folder.join(file) };
            assert!(root().join(&target).exists(), "{}: {link} leads nowhere", page.display());
            let leaves = page.starts_with("docs") && target.components().any(|part| part.as_os_str() == "..");
            assert!(!leaves, "{}: {link} leaves the book: name the file instead", page.display());
            let known = anchor.is_empty() || anchors(&read(&target)).contains(anchor);
            assert!(known, "{}: {link} has no such heading", page.display());
            count += 1;
        }
    }
    assert!(count > 60, "only {count} links");
}

/// Files of the repository that the book names exist.
#[test]
fn every_path_that_the_book_names_exists() {
    let folders = std::fs::read_dir(root()).unwrap().map(|entry| entry.unwrap());
    let folders: BTreeSet<String> = folders
        .filter(|entry| entry.path().is_dir())
        .map(|entry| entry.file_name().into_string().unwrap())
        .filter(|name| !["out", "target"].contains(&name.as_str()))
        .collect();
    let mut count = 0;
    for page in pages().into_iter().chain([PathBuf::from("README.md"), PathBuf::from("fuzz/README.md")]) {
        for path in quoted(&read(&page)) {
            let first = path.split('/').next().unwrap();
            if path.contains([' ', '*', '<']) || !path.contains('/') || !folders.contains(first) {
                continue;
            }
            assert!(root().join(&path).exists(), "{} names {path}", page.display());
            count += 1;
        }
    }
    assert!(count > 30, "only {count} paths");
}

/// Numbers of a text with the unit that follows, if one does.
fn figures(text: &str) -> BTreeSet<String> {
    let units = ["%", "µs", "ms", "s", "Hz", "MB", "kB"];
    let in_number = |c: char| c.is_ascii_digit() || c == '.' || c == ',';
    let words: Vec<&str> = text.split([' ', '\n', '|', '(', ')']).filter(|word| !word.is_empty()).collect();
    let mut figures = BTreeSet::new();
    for (at, word) in words.iter().enumerate() {
        let number = word.trim_end_matches(['.', ',', ';', ':']);
        if number.is_empty()
            || !number.starts_with(|c: char| c.is_ascii_digit())
            || !number.chars().all(in_number)
        {
            continue;
        }
        let unit = if number == *word { words.get(at + 1).copied().unwrap_or("") } else { "" };
        let unit = unit.trim_end_matches(['.', ',', ';', ':']);
        figures.insert(if units.contains(&unit) { format!("{number} {unit}") } else { number.to_owned() });
    }
    figures
}

#[test]
fn figures_are_read_with_their_units() {
    let read = figures("It takes 0.13 to 0.14 ms (81 %), or 1,000 hops; in 2023, 20 × 20, P23.");
    let expected = ["0.13", "0.14 ms", "1,000", "20", "2023", "81 %"].map(String::from);
    assert_eq!(read, BTreeSet::from(expected));
}

#[test]
fn every_figure_of_the_readme_is_in_the_measurements() {
    let text = prose(&read("README.md"));
    // What a link leads to is no prose.
    let mut parts = text.split("](");
    let first = parts.next().unwrap();
    let text: Vec<&str> =
        [first].into_iter().chain(parts.map(|part| part.split_once(')').unwrap().1)).collect();
    let text = text.join(" ");
    let measured = read("docs/measurements.md");
    let measured = figures(&measured.replace('`', " "));
    // A figure without its unit may stand there with one, as the lower end of a range does.
    let numbers: BTreeSet<&str> = measured.iter().map(|figure| figure.split(' ').next().unwrap()).collect();
    let quoted = figures(&text);
    assert!(quoted.len() > 20, "the README quotes {quoted:?}");
    for figure in quoted {
        let known =
            if figure.contains(' ') { measured.contains(&figure) } else { numbers.contains(&*figure) };
        assert!(known, "docs/measurements.md has no {figure}");
    }
}

/// The lines of all `sh` blocks of a page, comments and redirections left out.
fn shell_lines(text: &str) -> Vec<String> {
    let blocks = text.split("```sh\n").skip(1).map(|rest| rest.split("\n```").next().unwrap());
    let lines = blocks.flat_map(str::lines).map(|line| {
        let line = line.split(" #").next().unwrap().split([';', '|', '>']).next().unwrap();
        line.trim().trim_end_matches('&').trim().to_owned()
    });
    lines.filter(|line| !line.is_empty() && !line.starts_with('#')).collect()
}

/// Commands are parsed by the program itself: `--help` at their end makes it stop there.
#[test]
fn every_command_shown_is_one_that_exists() {
    let mut count = 0;
    for page in pages().into_iter().chain([PathBuf::from("README.md")]) {
        for line in shell_lines(&read(&page)) {
            let words: Vec<&str> = line.split_whitespace().collect();
            match words[..] {
                ["hopper", ref rest @ ..] if is_served(rest) => {
                    let output = hopper(rest).arg("--help").output().unwrap();
                    let why = stderr(&output);
                    assert_eq!(output.status.code(), Some(0), "{}: {line}: {why}", page.display());
                    for file in rest.iter().filter(|word| word.starts_with("campaigns/")) {
                        assert!(root().join(file).exists(), "{}: {line}: no {file}", page.display());
                    }
                    count += 1;
                }
                ["cargo", "bench", "--bench", name, ..] => {
                    let found = root().join("benches").join(name).with_extension("rs").exists();
                    assert!(found, "{}: {line}: no such benchmark", page.display());
                }
                _ => {}
            }
        }
    }
    assert!(count > 30, "only {count} commands");
}

/// Every command of `hopper` with its help, the ones below commands included.
fn commands() -> Vec<(String, String)> {
    let mut waiting = vec![Vec::<String>::new()];
    let mut commands = Vec::new();
    while let Some(command) = waiting.pop() {
        let words: Vec<&str> = command.iter().map(String::as_str).chain(["--help"]).collect();
        if !is_served(&words) {
            continue;
        }
        let output = hopper(&words).output().unwrap();
        assert_eq!(output.status.code(), Some(0), "{words:?}: {}", stderr(&output));
        let help = String::from_utf8(output.stdout).unwrap();
        let list = help.split("Commands:\n").nth(1).and_then(|rest| rest.split("\n\n").next()).unwrap_or("");
        let names = list.lines().filter_map(|line| line.strip_prefix("  ")?.split_whitespace().next());
        for name in names.filter(|name| *name != "help") {
            waiting.push(command.iter().cloned().chain([name.to_owned()]).collect());
        }
        if !command.is_empty() {
            commands.push((format!("hopper {}", command.join(" ")), help));
        }
    }
    commands
}

#[test]
fn the_reference_has_every_command_with_every_flag_and_no_other() {
    let mut sections = sections(&read("docs/cli.md"));
    let commands = commands();
    sections.retain(|name, _| is_served(&name.split(' ').skip(1).collect::<Vec<_>>()));
    let known: BTreeSet<&String> = commands.iter().map(|(name, _)| name).collect();
    assert_eq!(sections.keys().collect::<BTreeSet<_>>(), known, "sections of docs/cli.md and commands");
    for (name, help) in &commands {
        let options = help.lines().map(str::trim_start).filter(|line| line.starts_with('-'));
        let flags = options.filter_map(|line| line.split([' ', ',']).find(|word| word.starts_with("--")));
        let flags: BTreeSet<String> =
            flags.filter(|flag| !["--help", "--version"].contains(flag)).map(Into::into).collect();
        let rows = rows(&sections[name]);
        let told = rows.iter().map(|row| row.split(' ').next().unwrap().to_owned()).collect();
        assert_eq!(flags, told, "flags of {name} and rows of docs/cli.md");
    }
}

/// The definition that a property of a JSON Schema refers to, through an alternative of null too.
fn definition<'a>(schema: &'a Value, property: &'a Value) -> &'a Value {
    let alternatives = property["anyOf"].as_array().map_or(&[][..], Vec::as_slice);
    let mut references =
        [property].into_iter().chain(alternatives).filter_map(|value| value["$ref"].as_str());
    let found = references.next().and_then(|reference| schema.pointer(&reference[1..]));
    found.unwrap_or(property)
}

/// The tables of a scenario with their fields, by dotted path.
fn tables(schema: &Value, path: &str, object: &Value, tables: &mut BTreeMap<String, BTreeSet<String>>) {
    let properties = object["properties"].as_object().unwrap();
    tables.insert(path.to_owned(), properties.keys().cloned().collect());
    for (name, property) in properties {
        let path = if path.is_empty() { name.clone() } else { format!("{path}.{name}") };
        let target = definition(schema, definition(schema, property));
        let element = definition(schema, &property["items"]);
        let kinds = target["oneOf"].as_array().map_or(&[][..], Vec::as_slice);
        if target["properties"].is_object() {
            self::tables(schema, &path, target, tables);
        } else if element["properties"].is_object() {
            self::tables(schema, &path, element, tables);
        }
        // Of a list whose elements name their kind, each kind is a table of its own.
        let bodies = element["oneOf"].as_array().map_or(&[][..], Vec::as_slice);
        for body in bodies {
            let mut body = body.clone();
            let fields = body["properties"].as_object_mut().unwrap();
            let name = fields.remove("body").unwrap()["const"].as_str().unwrap().to_owned();
            tables.insert(path.clone(), BTreeSet::from(["body".to_owned()]));
            self::tables(schema, &format!("{path}.{name}"), &body, tables);
        }
        for kind in kinds.iter().filter_map(|kind| kind["properties"].as_object()) {
            if let Some(model) = kind.get("model") {
                tables.insert(path.clone(), BTreeSet::from(["model".to_owned()]));
                let mut fields = kind.clone();
                fields.remove("model");
                if !fields.is_empty() {
                    let table = serde_json::json!({ "properties": fields });
                    let name = model["const"].as_str().unwrap();
                    self::tables(schema, &format!("{path}.{name}"), &table, tables);
                }
                continue;
            }
            for (name, property) in kind {
                self::tables(schema, &format!("{path}.{name}"), definition(schema, property), tables);
            }
        }
    }
}

#[test]
fn the_reference_has_every_field_of_a_scenario_and_no_other() {
    let output = hopper(&["scenario", "schema"]).output().unwrap();
    let schema: Value = serde_json::from_slice(&output.stdout).unwrap();
    let mut known = BTreeMap::new();
    tables(&schema, "", &schema, &mut known);
    assert!(known.len() > 15, "{known:?}");
    let page = read("docs/scenario.md");
    let top = page.split("\n## ").find(|section| section.starts_with("Top level")).unwrap();
    assert_eq!(rows(top), known.remove("").unwrap(), "the top level");
    let sections = sections(&page);
    let told: BTreeMap<String, BTreeSet<String>> =
        sections.iter().map(|(path, section)| (path.clone(), rows(section))).collect();
    assert_eq!(told, known, "docs/scenario.md and `hopper scenario schema`");
}

/// The numbers and type names of a service as `hopper topic list` prints them, each with the word before it.
fn qualities(kind: &str) -> Vec<String> {
    let words: Vec<&str> = kind.split([' ', ',']).filter(|word| !word.is_empty()).collect();
    let counted = |name: &str, back: bool| {
        let at = words.iter().position(|word| *word == name)?;
        Some(format!("| {} ", words[if back { at - 1 } else { at + 1 }]))
    };
    let numbers = [
        ("publishers", true),
        ("subscribers", true),
        ("clients", true),
        ("history", false),
        ("buffer", false),
    ];
    let mut qualities: Vec<String> = numbers.iter().filter_map(|(name, back)| counted(name, *back)).collect();
    for (at, word) in words.iter().enumerate().filter(|(_, word)| word.starts_with("hop.")) {
        qualities.push(format!("`{word}` {} bytes)", words[at + 1]));
    }
    qualities
}

/// What `docs/messages.md` says before the fields, which a test of the contract compares with their declarations.
fn services_of(page: &str) -> &str {
    page.split("\n## Fields").next().unwrap()
}

#[test]
fn the_reference_has_every_service_of_a_running_mission() {
    let mission = Mission::new("book");
    let mut processes = vec![mission.start_slow_sim("1")];
    processes.extend(mission.start_peers());
    mission.await_decisions(1);
    let mut list = mission.hopper(&["topic", "list", "--instance", &mission.name]);
    let output = list.args(["--format", "json", "--wait", "60s"]).output().unwrap();
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    let page = read("docs/messages.md");
    let mut told = rows(services_of(&page));
    for line in std::str::from_utf8(&output.stdout).unwrap().lines() {
        let service: Value = serde_json::from_str(line).unwrap();
        let kind = service["kind"].as_str().unwrap();
        if !kind.starts_with("hop.") {
            continue;
        }
        let name = service["name"].as_str().unwrap().replace("/r0/", "/rN/");
        let row = page.lines().find(|line| line.starts_with(&format!("| `{name}`")));
        let row = row.unwrap_or_else(|| panic!("docs/messages.md has no {name}"));
        for quality in qualities(kind) {
            assert!(row.contains(&quality), "{name}: docs/messages.md has no {quality:?}: {kind}");
        }
        told.remove(&name);
    }
    // Open only where robots have routes, planners believe a table, or a motion model tells more than outcomes; their rows are
    // compared with the registry.
    for service in ["hop/details", "hop/prior", "hop/rN/route", "hop/routes", "hop/table"] {
        assert!(told.remove(service), "{service} is open in the mission of a hopper");
    }
    assert!(told.is_empty(), "docs/messages.md has services that are not there: {told:?}");
}

#[test]
fn the_reference_has_every_exit_code() {
    let output = hopper(&["--help"]).output().unwrap();
    let help = String::from_utf8(output.stdout).unwrap();
    let codes = help.split("Exit codes:").nth(1).unwrap();
    let numbers = |text: &str| -> BTreeSet<u32> {
        text.split(|c: char| !c.is_ascii_digit()).filter_map(|number| number.parse().ok()).collect()
    };
    let page = read("docs/exit-codes.md");
    let first = page.lines().filter_map(|line| line.strip_prefix("| ")?.split(' ').next());
    assert_eq!(numbers(codes), first.filter_map(|code| code.parse().ok()).collect());
}

/// The guide's planner is the one that tests/guides.rs compiles and flies.
#[test]
fn the_planner_of_the_guide_is_the_one_that_is_flown() {
    let page = read("docs/own-planner.md");
    let shown = page.split("```rust\n").nth(1).unwrap().split("```").next().unwrap();
    let patch = read("tests/guides/add-a-planner.patch");
    let file =
        patch.split("+++ b/planner/src/beeline.rs\n").nth(1).unwrap().split("diff --git").next().unwrap();
    let lines = file.lines().filter_map(|line| line.strip_prefix('+'));
    assert_eq!(shown, lines.map(|line| format!("{line}\n")).collect::<String>());
}

/// Whether or not a process of a mission opens it.
#[test]
fn the_reference_has_every_message_and_request_of_the_registry() {
    struct Services(BTreeMap<String, usize>);
    impl Visitor for Services {
        fn message<M: Message>(&mut self) {
            self.0.insert(M::SERVICE.name.into(), M::SERVICE.max_publishers);
        }

        fn request<Q: Request>(&mut self) {
            self.0.insert(Q::SERVICE.name.into(), Q::SERVICE.max_clients);
        }
    }
    let mut services = Services(BTreeMap::new());
    contract::wire::visit(&mut services);
    let page = read("docs/messages.md");
    let told = rows(services_of(&page));
    assert_eq!(told, services.0.keys().cloned().collect(), "docs/messages.md and contract::wire::visit");
    for (name, ends) in services.0 {
        let row = page.lines().find(|line| line.starts_with(&format!("| `{name}`"))).unwrap();
        assert!(row.contains(&format!("| {ends} |")), "{row}: {ends} writers or clients");
    }
}
