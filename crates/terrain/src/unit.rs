//! Units of length: the codes of EPSG (OGC 19-008, 7.4), and the names that files call them by.

use std::fmt;

/// Relative difference of two units that count as one: a foot and a US survey foot differ by 2e-6.
const SAME_WITHIN: f64 = 1e-4;

/// Each unit with its EPSG code (0 for none), its name, its length in metres and further names, in lower case without spaces,
/// underscores, hyphens and brackets.
const UNITS: &[(u64, &str, f64, &[&str])] = &[
    (9001, "metre", 1.0, &["m", "meter", "meters", "metres", "mtr"]),
    (
        9002,
        "foot",
        0.3048,
        &["ft", "feet", "internationalfoot", "internationalfeet", "footinternational", "intft"],
    ),
    (
        9003,
        "US survey foot",
        1200.0 / 3937.0,
        &[
            "usft",
            "ftus",
            "sft",
            "ussft",
            "usfoot",
            "usfeet",
            "footus",
            "feetus",
            "ussurveyfeet",
            "surveyfoot",
            "feetussurvey",
            "footussurvey",
            "surveyfeet",
        ],
    ),
    (9036, "kilometre", 1000.0, &["km", "kilometer", "kilometers", "kilometres"]),
    (0, "hectometre", 100.0, &["hm", "hectometer", "hectometers", "hectometres"]),
    (0, "decimetre", 0.1, &["dm", "decimeter", "decimeters", "decimetres"]),
    (1033, "centimetre", 0.01, &["cm", "centimeter", "centimeters", "centimetres"]),
    (1025, "millimetre", 0.001, &["mm", "millimeter", "millimeters", "millimetres"]),
    (0, "inch", 0.0254, &["in", "inches"]),
    (0, "US survey inch", 100.0 / 3937.0, &["usin"]),
    (9096, "yard", 0.9144, &["yd", "yards"]),
    (0, "US survey yard", 3600.0 / 3937.0, &["usyd"]),
    (9014, "fathom", 1.8288, &["fath", "fathoms", "fm"]),
    (9093, "statute mile", 1609.344, &["mi", "mile", "miles"]),
    (9035, "US survey mile", 6_336_000.0 / 3937.0, &["usmi"]),
    (9030, "nautical mile", 1852.0, &["kmi", "nmi", "nm", "nauticalmiles"]),
    (9097, "chain", 20.1168, &["ch"]),
    (9098, "link", 0.201_168, &["links"]),
    (9033, "US survey chain", 79_200.0 / 3937.0, &["usch"]),
    (9034, "US survey link", 792.0 / 3937.0, &[]),
    (9005, "Clarke's foot", 0.304_797_265_4, &["footclarke"]),
    (9037, "Clarke's yard", 0.914_391_796_2, &["yardclarke"]),
    (9038, "Clarke's chain", 20.116_619_516_4, &[]),
    (9039, "Clarke's link", 0.201_166_195_164, &[]),
    (9031, "German legal metre", 1.000_013_596_5, &["metergermanlegal"]),
    (9040, "British yard (Sears 1922)", 0.914_398_414_616_028_7, &[]),
    (9041, "British foot (Sears 1922)", 0.304_799_471_538_676_2, &[]),
    (9042, "British chain (Sears 1922)", 20.116_765_121_552_632, &[]),
    (9043, "British link (Sears 1922)", 0.201_167_651_215_526_3, &[]),
    (9050, "British yard (Benoit 1895 A)", 0.914_399_2, &[]),
    (9051, "British foot (Benoit 1895 A)", 0.304_799_733_333_333_3, &[]),
    (9052, "British chain (Benoit 1895 A)", 20.116_782_4, &[]),
    (9053, "British link (Benoit 1895 A)", 0.201_167_824, &[]),
    (9060, "British yard (Benoit 1895 B)", 0.914_399_204_289_812_4, &[]),
    (9061, "British foot (Benoit 1895 B)", 0.304_799_734_763_270_8, &[]),
    (9062, "British chain (Benoit 1895 B)", 20.116_782_494_375_872, &[]),
    (9063, "British link (Benoit 1895 B)", 0.201_167_824_943_758_7, &[]),
    (9070, "British foot (1865)", 0.304_800_833_333_333_35, &[]),
    (9080, "Indian foot", 0.304_799_510_248_146_94, &[]),
    (9081, "Indian foot (1937)", 0.304_798_41, &["indft"]),
    (9082, "Indian foot (1962)", 0.304_799_6, &[]),
    (9083, "Indian foot (1975)", 0.304_799_5, &[]),
    (9084, "Indian yard", 0.914_398_530_744_440_8, &[]),
    (9085, "Indian yard (1937)", 0.914_395_23, &["indyd"]),
    (9086, "Indian yard (1962)", 0.914_398_8, &[]),
    (9087, "Indian yard (1975)", 0.914_398_5, &[]),
    (9094, "Gold Coast foot", 0.304_799_710_181_508_8, &[]),
    (9095, "British foot (1936)", 0.304_800_749_1, &[]),
    (9099, "British yard (Sears 1922 truncated)", 0.914_398, &[]),
    (9300, "British foot (Sears 1922 truncated)", 0.304_799_333_333_333_3, &[]),
    (9301, "British chain (Sears 1922 truncated)", 20.116_756, &[]),
    (9302, "British link (Sears 1922 truncated)", 0.201_167_56, &[]),
];

/// A unit of length. Displayed, it is its name with its length in metres.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct LengthUnit {
    pub name: String,
    /// Its length, metres: above 0.
    pub metres: f64,
}

impl LengthUnit {
    pub fn metre() -> Self {
        Self { name: "metre".into(), metres: 1.0 }
    }

    /// The unit of an EPSG code.
    pub fn of_epsg(code: u64) -> Option<Self> {
        let (_, name, metres, _) = UNITS.iter().find(|unit| unit.0 == code && code != 0)?;
        Some(Self { name: (*name).into(), metres: *metres })
    }

    /// The unit of a name or an abbreviation, whatever its case and spelling.
    pub fn of_name(name: &str) -> Option<Self> {
        let plain = plain(name);
        let is_named = |unit: &&(u64, &str, f64, &[&str])| {
            self::plain(unit.1) == plain || unit.3.contains(&plain.as_str())
        };
        let (_, name, metres, _) = UNITS.iter().find(is_named)?;
        Some(Self { name: (*name).into(), metres: *metres })
    }

    /// The unit of a name in any words around it: `[m]`, `meter (m)`, `feet (US survey)`, `m above sea level`. `None` if there is
    /// none, or another one.
    pub fn of_words(text: &str) -> Option<Self> {
        if let Some(unit) =
            Self::of_name(text.trim_matches(|c: char| "[](){}<>".contains(c) || c.is_whitespace()))
        {
            return Some(unit);
        }
        let lower = text.to_lowercase();
        let before = ["above ", "over ", "a.s.l", "asl", "amsl", "relative to "]
            .iter()
            .filter_map(|word| lower.find(word))
            .min()
            .unwrap_or(lower.len());
        let named = lower[..before].trim_end_matches(|c: char| !c.is_alphanumeric() && c != ')');
        if let Some(unit) = Self::of_name(named) {
            return Some(unit);
        }
        // A name with its abbreviation behind it: both have to be the same unit.
        let (name, rest) = named.split_once(['(', '['])?;
        let behind = Self::of_name(rest.trim_matches(|c: char| "])".contains(c) || c.is_whitespace()))?;
        Self::of_name(name).filter(|unit| unit.is_same_as(&behind))
    }

    /// A unit of `metres` each, called `name`, if that is a length.
    pub fn of_length(name: &str, metres: f64) -> Option<Self> {
        if !(metres.is_finite() && metres > 0.0) {
            return None;
        }
        let name = if name.trim().is_empty() { "unit" } else { name.trim() };
        Some(Self { name: name.chars().take(40).collect(), metres })
    }

    /// Whether both are the same length, but for what different definitions of one unit differ by.
    pub fn is_same_as(&self, other: &Self) -> bool {
        (self.metres - other.metres).abs() <= SAME_WITHIN * self.metres
    }

    /// Whether it is a metre to the last digit that matters.
    pub fn is_metre(&self) -> bool {
        (self.metres - 1.0).abs() <= 1e-12
    }
}

impl fmt::Display for LengthUnit {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if self.is_metre() {
            return f.write_str("metre");
        }
        // Twelve digits hide the rounding of binary fractions.
        let metres: f64 = format!("{:.11e}", self.metres).parse().unwrap_or(self.metres);
        write!(f, "{} of {metres} m", self.name)
    }
}

fn plain(name: &str) -> String {
    let kept = |c: &char| !(c.is_whitespace() || "_-.()'".contains(*c));
    name.chars().filter(kept).flat_map(char::to_lowercase).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_unit_is_known_by_its_code_and_by_its_names() {
        for (names, code, metres) in [
            (&["m", "Metre", "METERS"][..], 9001, 1.0),
            (&["ft", "Foot", "feet", "International Foot"], 9002, 0.3048),
            (
                &["us-ft", "US survey foot", "Foot_US", "ftUS", "US_Survey_Foot"],
                9003,
                0.304_800_609_601_219_2,
            ),
            (&["KM", "kilometer"], 9036, 1000.0),
            (&["cm", "Centimeter"], 1033, 0.01),
            (&["yd"], 9096, 0.9144),
        ] {
            let by_code = LengthUnit::of_epsg(code).unwrap();
            assert!((by_code.metres - metres).abs() < 1e-15, "{by_code}");
            for name in names {
                assert_eq!(LengthUnit::of_name(name), Some(by_code.clone()), "{name}");
            }
        }
        for (words, metres) in [
            ("[m]", 1.0),
            ("[ft]", 0.3048),
            ("meter (m)", 1.0),
            ("feet (US survey)", 1200.0 / 3937.0),
            ("m above sea level", 1.0),
            ("Metres (above geoid)", 1.0),
            ("ft a.s.l.", 0.3048),
        ] {
            assert_eq!(LengthUnit::of_words(words).map(|unit| unit.metres), Some(metres), "{words}");
        }
        for words in ["degC", "meter (ft)", "counts (m)", "above sea level", ""] {
            assert_eq!(LengthUnit::of_words(words), None, "{words}");
        }
        for (code, name) in [(0, ""), (9102, "degree"), (32767, "parsec")] {
            assert_eq!((LengthUnit::of_epsg(code), LengthUnit::of_name(name)), (None, None));
        }
    }

    #[test]
    fn feet_of_two_definitions_are_one_unit_and_metres_another() {
        let [foot, us_foot] = ["ft", "us-ft"].map(|name| LengthUnit::of_name(name).unwrap());
        assert!(foot.is_same_as(&us_foot) && !foot.is_same_as(&LengthUnit::metre()));
        assert_eq!(us_foot.to_string(), "US survey foot of 0.304800609601 m");
    }
}
