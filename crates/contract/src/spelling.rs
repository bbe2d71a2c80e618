//! The known name that a mistyped one resembles.

/// Letters up to which a name is short: one edit between it and what was typed, and it is suggested; of a longer one two.
/// `rnu` for `run` is one exchange of neighbours.
const SHORT_LETTERS: usize = 5;

/// Letters from which on what was typed may be a part of a name.
const PART_LETTERS: usize = 4;

/// The names of `known` that `got` resembles most, in their order; none if it resembles nothing. A name that begins with it, or
/// has it as one of its words, comes before those that differ by a few letters. Capitals, and `-` instead of `_`, make no
/// difference.
#[must_use]
pub fn nearest<'a>(got: &str, known: impl IntoIterator<Item = &'a str>) -> Vec<&'a str> {
    let got = folded(got);
    let known: Vec<&str> = known.into_iter().collect();
    let is_part = |name: &&&str| {
        let name = folded(name);
        name != got && (name.starts_with(&got) || name.split('_').any(|word| word == got))
    };
    let is_exact = known.iter().any(|name| folded(name) == got);
    if !is_exact && got.chars().count() >= PART_LETTERS {
        let mut parts: Vec<&str> = known.iter().filter(is_part).copied().collect();
        let edits = |name: &&str| strsim::osa_distance(&got, &folded(name));
        if let Some(least) = parts.iter().map(edits).min() {
            parts.retain(|name| edits(name) == least);
            return parts;
        }
    }
    let (mut nearest, mut least) = (Vec::new(), usize::MAX);
    for name in known {
        let folded = folded(name);
        let edits = strsim::osa_distance(&got, &folded);
        // A short name that has to be typed anew resembles nothing.
        let length = got.chars().count().min(folded.chars().count());
        let edits_max = if length <= SHORT_LETTERS { 1 } else { 2 };
        if edits > edits_max || edits > 0 && edits >= length || edits > least {
            continue;
        }
        if edits < least {
            (nearest, least) = (Vec::new(), edits);
        }
        nearest.push(name);
    }
    nearest
}

/// The end of a sentence that names what `got` resembles: empty, or `; did you mean mdp?`.
#[must_use]
pub fn did_you_mean<'a>(got: &str, known: impl IntoIterator<Item = &'a str>) -> String {
    match nearest(got, known).as_slice() {
        [] => String::new(),
        names => format!("; did you mean {}?", names.join(" or ")),
    }
}

/// In lower case, words separated by `_`; `A*` is written `astar`.
fn folded(name: &str) -> String {
    name.trim().to_lowercase().replace(['-', ' '], "_").replace('*', "star")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_name_is_found_by_its_letters_whatever_their_case() {
        let known = ["mdp", "greedy", "astar", "dstar_lite", "hold"];
        for (got, meant) in [
            ("MDP", &["mdp"][..]),
            ("mpd", &["mdp"]),
            ("gredy", &["greedy"]),
            ("DStar-Lite", &["dstar_lite"]),
            ("dstar lite", &["dstar_lite"]),
            ("dstar", &["dstar_lite"]),
            ("D* Lite", &["dstar_lite"]),
            ("d*lite", &["dstar_lite"]),
            ("A*", &["astar"]),
            ("lite", &["dstar_lite"]),
            ("a", &[]),
            ("", &[]),
            ("teleport", &[]),
        ] {
            assert_eq!(nearest(got, known), meant, "{got}");
        }
        assert_eq!(did_you_mean("MDP", known), "; did you mean mdp?");
        assert_eq!(did_you_mean("rat", ["run", "cat", "bat"]), "; did you mean cat or bat?");
        assert_eq!(did_you_mean("teleport", known), "");
    }

    #[test]
    fn what_begins_a_name_or_is_a_word_of_it_means_it() {
        let known = ["rover-helicopter", "hopper-scout", "coverage", "coverage-8", "hard"];
        assert_eq!(nearest("helicopter", known), ["rover-helicopter"]);
        assert_eq!(nearest("rover", known), ["rover-helicopter"]);
        assert_eq!(nearest("cover", known), ["coverage"]);
        assert_eq!(nearest("coverage", known), ["coverage"]);
        assert!(nearest("he", known).is_empty());
    }

    #[test]
    fn an_exchange_of_neighbours_is_one_edit() {
        assert_eq!(nearest("rnu", ["run", "ran"]), ["run"]);
        assert_eq!(nearest("simm", ["sim"]), ["sim"]);
        assert!(nearest("bag", ["run"]).is_empty());
    }
}
