//! Well-known text of coordinate systems, of both editions (OGC 01-009, OGC 18-010) and in ESRI's dialect.

use super::{CoordinateSystem, Heights, Kind, NESTING_MAX, beginning, body_radius, epsg};
use crate::unit::LengthUnit;

/// Most keywords within each other.
const DEPTH_MAX: u32 = 32;

/// A keyword with what its brackets hold.
#[derive(Debug)]
struct Node {
    /// In capitals.
    keyword: String,
    values: Vec<Value>,
}

#[derive(Debug)]
enum Value {
    Node(Node),
    /// A text in quotes.
    Text(String),
    /// A number, or a word without quotes.
    Word(String),
}

pub(super) fn is_like(text: &str) -> bool {
    let keyword: String = text.chars().take_while(|c| !"[(".contains(*c)).collect();
    let is_word = |c: char| c.is_ascii_alphanumeric() || c == '_' || c.is_whitespace();
    keyword.len() < text.len() && !keyword.trim().is_empty() && keyword.chars().all(is_word)
}

pub(super) fn read(text: &str) -> Result<CoordinateSystem, String> {
    let mut reader = Reader { rest: text };
    let (mut place, mut vertical) = (None, None);
    // ESRI writes the heights before or behind the projected system: PROJCS[...],VERTCS[...].
    loop {
        let node = reader.node(0)?;
        let target = if node.is_vertical() { &mut vertical } else { &mut place };
        if target.is_some() {
            return Err(format!("one coordinate system, got another: {}[...]", node.keyword));
        }
        *target = Some(node);
        reader.take(',');
        reader.skip();
        if reader.rest.is_empty() {
            break;
        }
    }
    let mut system = match (&place, &vertical) {
        (Some(node), _) | (None, Some(node)) => system(node, 0)?,
        (None, None) => return Err("well-known text, got none".into()),
    };
    if let Some(vertical) = vertical {
        system.heights = heights(&vertical);
    }
    Ok(system)
}

fn system(node: &Node, depth: u32) -> Result<CoordinateSystem, String> {
    if depth > NESTING_MAX {
        return Err(format!("at most {NESTING_MAX} coordinate systems within each other, got more"));
    }
    let degrees = || Kind::Degrees { radius_m: node.radius_m() };
    let mut system = match node.keyword.as_str() {
        "PROJCS" | "PROJCRS" | "PROJECTEDCRS" | "DERIVEDPROJCRS" => plane(node),
        "LOCAL_CS" | "ENGCRS" | "ENGINEERINGCRS" => {
            let mut local = plane(node);
            if node.has_angles() {
                local.kind = Some(Kind::Degrees { radius_m: None });
            }
            local
        }
        "GEOGCS" | "GEOGCRS" | "GEOGRAPHICCRS" => CoordinateSystem::new(node.name(), Some(degrees())),
        "GEODCRS" | "GEODETICCRS" => {
            let kind = if node.is_cartesian() { Kind::Geocentric } else { degrees() };
            CoordinateSystem::new(node.name(), Some(kind))
        }
        "GEOCCS" => CoordinateSystem::new(node.name(), Some(Kind::Geocentric)),
        "COMPD_CS" | "COMPOUNDCRS" => compound(node, depth)?,
        "BOUNDCRS" => match node.child(&["SOURCECRS"]).and_then(|source| source.nodes().next()) {
            Some(source) => self::system(source, depth + 1)?,
            None => return Err("the source of a BOUNDCRS, got none".into()),
        },
        _ if node.is_vertical() => {
            let mut vertical = CoordinateSystem::new(node.name(), None);
            vertical.heights = heights(node);
            vertical
        }
        keyword => return Err(format!("well-known text of a coordinate system, got {keyword}[...]")),
    };
    // ESRI's strings in GeoTIFFs hold the heights within the projected system.
    if let Some(vertical) = node.nodes().find(|inner| inner.is_vertical() && depth == 0) {
        system.heights = heights(vertical);
    }
    Ok(system)
}

fn plane(node: &Node) -> CoordinateSystem {
    let mut system = CoordinateSystem::new(node.name(), Some(Kind::Plane));
    let of_code = || node.epsg().and_then(epsg::of_code).and_then(|system| system.unit);
    system.unit = node.unit().or_else(of_code);
    if let Some(third) = node.axes().nth(2) {
        let unit = third.unit().or(node.own_unit());
        system.heights = Heights { unit, downwards: third.is_down(), ..Heights::default() };
    }
    system.radius_m = node.radius_m();
    system.identity.code = node.epsg().map(|code| format!("EPSG:{code}"));
    system
}

fn compound(node: &Node, depth: u32) -> Result<CoordinateSystem, String> {
    let mut compound = CoordinateSystem::new(node.name(), None);
    for part in
        node.nodes().filter(|part| !["AUTHORITY", "ID", "USAGE", "REMARK"].contains(&part.keyword.as_str()))
    {
        let part = system(part, depth + 1)?;
        if part.kind.is_some() {
            (compound.kind, compound.unit) = (part.kind, part.unit);
            (compound.radius_m, compound.identity) = (part.radius_m, part.identity);
        }
        if part.heights != Heights::default() {
            compound.heights = part.heights;
        }
    }
    Ok(compound)
}

fn heights(node: &Node) -> Heights {
    // ESRI counts upwards with the direction 1, downwards with -1.
    let direction = node
        .nodes()
        .find(|inner| inner.keyword == "PARAMETER" && inner.name().eq_ignore_ascii_case("Direction"));
    let downwards = node.axes().any(Node::is_down)
        || direction.and_then(|inner| inner.number(0)).is_some_and(|sign| sign < 0.0);
    let of_code = node.epsg().map(epsg::vertical);
    let unit = node.unit().or_else(|| of_code.as_ref().and_then(|heights| heights.unit.clone()));
    let downwards = downwards || of_code.is_some_and(|heights| heights.downwards);
    Heights { unit, downwards, ..Heights::default() }
}

impl Node {
    fn nodes(&self) -> impl Iterator<Item = &Node> {
        self.values.iter().filter_map(|value| match value {
            Value::Node(node) => Some(node),
            _ => None,
        })
    }

    fn child(&self, keywords: &[&str]) -> Option<&Node> {
        self.nodes().find(|node| keywords.contains(&node.keyword.as_str()))
    }

    /// The first text in quotes.
    fn name(&self) -> &str {
        let text = self.values.iter().find_map(|value| match value {
            Value::Text(text) => Some(text.as_str()),
            _ => None,
        });
        text.unwrap_or_default()
    }

    /// The number at `index` among those of this node.
    fn number(&self, index: usize) -> Option<f64> {
        let numbers = self.values.iter().filter_map(|value| match value {
            Value::Word(word) | Value::Text(word) => word.trim().parse::<f64>().ok(),
            Value::Node(_) => None,
        });
        numbers.filter(|number| number.is_finite()).nth(index)
    }

    fn is_vertical(&self) -> bool {
        ["VERT_CS", "VERTCS", "VERTCRS", "VERTICALCRS"].contains(&self.keyword.as_str())
    }

    fn axes(&self) -> impl Iterator<Item = &Node> {
        self.nodes().filter(|node| node.keyword == "AXIS")
    }

    fn is_down(&self) -> bool {
        self.values
            .iter()
            .any(|value| matches!(value, Value::Word(word) if word.eq_ignore_ascii_case("down")))
    }

    fn is_cartesian(&self) -> bool {
        let system = self.child(&["CS"]);
        system.is_some_and(|cs| {
            cs.values
                .iter()
                .any(|value| matches!(value, Value::Word(word) if word.eq_ignore_ascii_case("cartesian")))
        })
    }

    /// The unit that stands in this node itself.
    fn own_unit(&self) -> Option<LengthUnit> {
        let unit = self.child(&["UNIT", "LENGTHUNIT"])?;
        match unit.number(0) {
            Some(metres) => LengthUnit::of_length(unit.name(), metres),
            None => LengthUnit::of_name(unit.name()),
        }
    }

    /// Its own unit, or that of its first axis.
    fn unit(&self) -> Option<LengthUnit> {
        self.own_unit().or_else(|| self.axes().next()?.own_unit())
    }

    /// Whether its coordinates are angles.
    fn has_angles(&self) -> bool {
        let mut units = std::iter::once(self).chain(self.axes());
        units.any(|node| {
            let unit = node.child(&["UNIT"]).map(|unit| unit.name().to_ascii_lowercase());
            node.child(&["ANGLEUNIT"]).is_some()
                || unit.is_some_and(|name| name.starts_with("deg") || name == "radian")
        })
    }

    /// EPSG's code of this node.
    fn epsg(&self) -> Option<u64> {
        let id = self.child(&["AUTHORITY", "ID"])?;
        if !id.name().eq_ignore_ascii_case("EPSG") {
            return None;
        }
        id.number(0).map(|code| code as u64)
    }

    /// Equatorial radius of the body: the first number of the ellipsoid, wherever it stands.
    fn radius_m(&self) -> Option<f64> {
        if ["SPHEROID", "ELLIPSOID", "TRIAXIAL"].contains(&self.keyword.as_str()) {
            return self.number(0).and_then(body_radius);
        }
        self.nodes().find_map(Node::radius_m)
    }
}

/// Reads nodes from the front of a text.
struct Reader<'a> {
    rest: &'a str,
}

impl Reader<'_> {
    fn skip(&mut self) {
        self.rest = self.rest.trim_start();
    }

    /// Whether `wanted` came next; it is passed over then.
    fn take(&mut self, wanted: char) -> bool {
        self.skip();
        match self.rest.strip_prefix(wanted) {
            Some(rest) => {
                self.rest = rest;
                true
            }
            None => false,
        }
    }

    fn word(&mut self) -> String {
        self.skip();
        let end = self.rest.find(|c: char| "[](),\"".contains(c)).unwrap_or(self.rest.len());
        let (word, rest) = self.rest.split_at(end);
        self.rest = rest;
        word.trim().to_owned()
    }

    fn node(&mut self, depth: u32) -> Result<Node, String> {
        let start = self.rest;
        let keyword = self.word().to_ascii_uppercase();
        if keyword.is_empty() || !(self.take('[') || self.take('(')) {
            return Err(format!("well-known text, got {}", beginning(start)));
        }
        if depth > DEPTH_MAX {
            return Err(format!("at most {DEPTH_MAX} brackets within each other, got more"));
        }
        let mut values = Vec::new();
        loop {
            values.push(self.value(depth)?);
            if self.take(']') || self.take(')') {
                return Ok(Node { keyword, values });
            }
            if !self.take(',') {
                return Err(format!(
                    "a comma or a closing bracket in {keyword}, got {}",
                    beginning(self.rest)
                ));
            }
        }
    }

    fn value(&mut self, depth: u32) -> Result<Value, String> {
        if self.take('"') {
            return self.text().map(Value::Text);
        }
        let before = self.rest;
        let word = self.word();
        if self.rest.starts_with(['[', '(']) {
            self.rest = before;
            return self.node(depth + 1).map(Value::Node);
        }
        Ok(Value::Word(word))
    }

    /// The text up to the closing quote; two quotes in a row are one of the text.
    fn text(&mut self) -> Result<String, String> {
        let mut text = String::new();
        loop {
            let Some((part, rest)) = self.rest.split_once('"') else {
                return Err(format!("a closing quote, got the end after {}", beginning(&text)));
            };
            text.push_str(part);
            match rest.strip_prefix('"') {
                Some(after) => {
                    text.push('"');
                    self.rest = after;
                }
                None => {
                    self.rest = rest;
                    return Ok(text);
                }
            }
        }
    }
}
