//! Numbers in text, as programs of all kinds write them.

/// The number that `text` is; what the C runtime of Windows writes for one that is none is NaN or infinite, too.
pub(crate) fn number(text: &str) -> Option<f64> {
    let text = text.trim();
    if let Ok(number) = text.parse() {
        return Some(number);
    }
    let lower = text.to_ascii_lowercase();
    let (sign, rest) = match lower.strip_prefix('-') {
        Some(rest) => (-1.0, rest),
        None => (1.0, lower.as_str()),
    };
    let word = rest.strip_prefix("1.#").or(rest.strip_prefix("nan("))?;
    match word.trim_end_matches(|c: char| "0+-e)".contains(c)) {
        "qnan" | "snan" | "ind" | "nan" => Some(f64::NAN),
        "inf" => Some(sign * f64::INFINITY),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_no_number_in_words_is_nan() {
        for text in ["nan", "-NaN", "1.#QNAN", "-1.#IND", "-1.#QNAN000000000E+00", "-nan(ind)"] {
            assert!(number(text).unwrap().is_nan(), "{text}");
        }
        assert_eq!(number("-1.#INF"), Some(f64::NEG_INFINITY));
        assert_eq!(number(" -9999.0 "), Some(-9999.0));
        for text in ["", "1.#", "1.#x", "1,5", "-", "1.0D+02"] {
            assert_eq!(number(text), None, "{text}");
        }
    }
}
