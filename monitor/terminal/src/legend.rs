//! What the symbols on the map stand for.

use contract::{Account, Brief};

use crate::map::has_ways;

/// Each symbol that the map of a mission may have, with its meaning, the most common first.
pub(crate) fn legend(brief: &Brief) -> Vec<(&'static str, &'static str)> {
    let is_hoppers = brief.account == Account::Hopper;
    let mut symbols = match brief.robots.count() {
        1 => vec![("@", if is_hoppers { "hopper" } else { "robot" })],
        _ => vec![("0 1 …", "robots")],
    };
    symbols.extend([("★", "goal"), ("S", "start"), ("•", "way"), ("·", "not seen")]);
    if is_hoppers {
        symbols.extend([("×", "slipped"), ("o", "stayed"), ("→", "policy")]);
    }
    if has_ways(brief) {
        symbols.extend([("+", "route"), ("∘", "rim of what is seen")]);
    }
    symbols.extend([("##", "impassable"), ("░░", "sand")]);
    if is_hoppers {
        symbols.extend([("✦", "treasure"), ("☆", "later goal"), ("◇", "impact")]);
    }
    symbols
}

/// As many of them as fit in a line of that many columns.
pub(crate) fn fitted(symbols: &[(&str, &str)], columns: usize) -> String {
    let mut line = String::from(" ");
    for (symbol, meaning) in symbols {
        let entry = format!("{symbol} {meaning}  ");
        if line.chars().count() + entry.chars().count() > columns {
            break;
        }
        line += &entry;
    }
    line.trim_end().to_owned() + " "
}
