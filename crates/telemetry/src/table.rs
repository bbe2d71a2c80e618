//! The table of packets in `docs/ground.md`.

use std::fmt::Write as _;

use contract::field::Number;

use crate::{Body, Item, Kind};

/// All packets, and then what each body consists of.
#[must_use]
pub fn markdown() -> String {
    let mut text = String::from(
        "| packet | APID | service | body | bytes | what it says |\n| --- | --- | --- | --- | --- | --- |\n",
    );
    for kind in Kind::ALL {
        let (service, subtypes) = kind.service();
        let subtypes: Vec<String> = subtypes.iter().map(u8::to_string).collect();
        let body = kind.body();
        let [header, cell] = body.wire;
        let head = 21 + kind.structure().map_or(0, |_| 1) + body.head_bytes();
        let (wire, bytes) = if body.is_counted {
            (format!("`{header}`, then `{cell}` each"), format!("{head}, and {} a cell", body.cell_bytes()))
        } else {
            (format!("`{cell}`"), (head + body.cell_bytes()).to_string())
        };
        writeln!(
            text,
            "| {kind} | {} | {service}/{} | {wire} | {bytes} | {} |",
            kind.apid(),
            subtypes.join(", "),
            kind.what()
        )
        .expect("a string grows");
    }
    for kind in Kind::ALL {
        let Body { header, cell, is_counted, .. } = kind.body();
        write!(
            text,
            "\n### {kind}\n\n| at | name | type | accepted | what it is |\n| --- | --- | --- | --- | --- |\n"
        )
        .expect("a string grows");
        let mut at = 19;
        if let Some(structure) = kind.structure() {
            writeln!(
                text,
                "| {at} | `structure` | `u8` | {structure} | Structure of the housekeeping report. |"
            )
            .expect("a string grows");
            at += 1;
        }
        at = rows(&mut text, at, header);
        if *is_counted {
            writeln!(text, "| {at} | `count` | `u16` | any | Cells that follow. |").expect("a string grows");
            text.push_str("| | | | | *Of each cell, counted from its first byte:* |\n");
            rows(&mut text, 0, cell);
        } else {
            rows(&mut text, at, cell);
        }
    }
    text
}

/// A row an item; where the next one begins.
fn rows(text: &mut String, mut at: usize, items: &[Item]) -> usize {
    for item in items {
        let reason = item.reason.replace('|', "\\|").replace("[`", "`").replace("`]", "`");
        let reason = without_targets(&reason);
        writeln!(text, "| {at} | `{}` | `{}` | {} | {reason} |", item.name, type_of(item), item.range)
            .expect("a string grows");
        at += item.bytes();
    }
    at
}

/// Text without what links of doc comments point to.
fn without_targets(text: &str) -> String {
    let mut plain = String::new();
    for (at, part) in text.split("`(crate::").enumerate() {
        match part.split_once(')') {
            Some((_, rest)) if at > 0 => {
                plain.push('`');
                plain.push_str(rest);
            }
            _ => plain.push_str(part),
        }
    }
    plain
}

fn type_of(item: &Item) -> String {
    let name = match item.number {
        Number::U8 => "u8",
        Number::U16 => "u16",
        Number::U32 => "u32",
        Number::U64 => "u64",
        Number::I32 => "i32",
        Number::F64 => "f64",
    };
    if item.count == 1 { name.into() } else { format!("[{name}; {}]", item.count) }
}
