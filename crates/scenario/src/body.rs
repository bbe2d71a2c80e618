//! Celestial bodies that elevation models are of.

/// A body whose gravity a fitted scenario takes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Body {
    Mercury,
    Venus,
    Earth,
    Moon,
    Mars,
}

/// First letters of the words by which names of coordinate systems tell their body.
const WORDS: [(Body, &[&str]); 5] = [
    (Body::Mercury, &["mercury"]),
    (Body::Venus, &["venus"]),
    (Body::Moon, &["moon", "lunar", "luna"]),
    (Body::Mars, &["mars", "martian"]),
    (Body::Earth, &["earth", "epsg", "wgs", "utm", "etrs", "nad27", "nad83", "osgb"]),
];

impl Body {
    /// The body that the name of a coordinate system tells, such as `Equirectangular MARS` or `WGS 84 / UTM zone 33N`.
    pub fn of_coordinate_system(name: &str) -> Option<Self> {
        let name = name.to_lowercase();
        let words: Vec<&str> = name.split(|letter: char| !letter.is_ascii_alphanumeric()).collect();
        // A year or a number may follow: Mars2000.
        let is_told = |known: &str| {
            words.iter().any(|word| {
                word.strip_prefix(known).is_some_and(|rest| rest.bytes().all(|byte| byte.is_ascii_digit()))
            })
        };
        WORDS.into_iter().find(|(_, words)| words.iter().any(|word| is_told(word))).map(|(body, _)| body)
    }

    /// Its name with an article where it has one.
    pub fn name(self) -> &'static str {
        match self {
            Body::Mercury => "Mercury",
            Body::Venus => "Venus",
            Body::Earth => "the Earth",
            Body::Moon => "the Moon",
            Body::Mars => "Mars",
        }
    }

    /// Gravity at its surface, m/s².
    pub fn gravity_mps2(self) -> f64 {
        match self {
            Body::Mercury => 3.70,
            Body::Venus => 8.87,
            Body::Earth => 9.81,
            Body::Moon => 1.62,
            Body::Mars => 3.72,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_body_is_told_by_the_name_of_the_coordinate_system() {
        for (name, body) in [
            ("Equirectangular MARS", Some(Body::Mars)),
            ("SimpleCylindrical_Mars2000", Some(Body::Mars)),
            ("Moon (2015) - Sphere / Ocentric / South Polar", Some(Body::Moon)),
            ("WGS 84 / UTM zone 33N", Some(Body::Earth)),
            ("EPSG:32633", Some(Body::Earth)),
            ("World_Mercator marsh", None),
            ("user-defined", None),
            ("", None),
        ] {
            assert_eq!(Body::of_coordinate_system(name), body, "{name}");
        }
    }
}
