//! A quantity over several maps beside each other, in one scale.

use contract::Range;

use super::field_map::{Place, TOP, bar, shades};
use super::scale::range;
use super::svg_writer::SvgWriter;

const LEFT: f64 = 24.0;
const SIDE: f64 = 250.0;
const GAP: f64 = 22.0;
/// Room for the bar of shades.
const RIGHT: f64 = 120.0;
const FOOT: f64 = 44.0;

/// One map of a grid.
#[derive(Clone, Debug, PartialEq)]
pub struct Field {
    /// What stands below it.
    pub heading: String,
    /// Row by row from the south-western corner; what is no number is drawn as blocked.
    pub values: Vec<f64>,
}

/// Square maps of one size in a row.
#[derive(Clone, Debug, PartialEq)]
pub struct FieldGrid {
    /// Title of the document.
    pub title: String,
    /// A smaller line below the title.
    pub caption: String,
    /// What the shades mean, with its unit.
    pub quantity: String,
    /// Columns of each map, as many as rows.
    pub columns: usize,
    /// The maps, left to right.
    pub fields: Vec<Field>,
}

impl FieldGrid {
    /// The SVG document; it depends only on the maps, to the byte.
    #[must_use]
    pub fn svg(&self) -> String {
        let width = (SIDE + GAP) * self.fields.len() as f64;
        let mut svg = SvgWriter::new(LEFT + width + RIGHT, TOP + SIDE + FOOT, &self.title);
        svg.heading(24.0, 34.0, 20.0, "font-weight=\"bold\"", &self.title);
        svg.heading(24.0, 58.0, 14.0, "fill=\"#555\"", &self.caption);
        let finite =
            self.fields.iter().flat_map(|field| &field.values).copied().filter(|value| value.is_finite());
        let values = range(finite).unwrap_or(Range { min: 0.0, max: 1.0 });
        for (n, Field { heading, values: cells }) in self.fields.iter().enumerate() {
            let left = LEFT + (SIDE + GAP) * n as f64;
            let place = Place { left, top: TOP, size: SIDE / self.columns as f64 };
            shades(&mut svg, cells, self.columns, values, place);
            svg.outline(left, TOP, SIDE, SIDE);
            svg.text(left + SIDE / 2.0, TOP + SIDE + 24.0, "text-anchor=\"middle\"", heading);
        }
        bar(&mut svg, values, LEFT + width, SIDE, &self.quantity);
        svg.finish()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn maps_stand_side_by_side_in_one_scale() {
        let field = |values: [f64; 4]| Field { heading: "h".into(), values: values.into() };
        let grid = FieldGrid {
            title: "t".into(),
            caption: "c".into(),
            quantity: "q".into(),
            columns: 2,
            fields: vec![field([0.0, 0.0, 0.0, 0.0]), field([1.0, f64::NAN, 1.0, 1.0])],
        };
        let svg = grid.svg();
        // Two runs of the first map; three and a blocked cell of the second, whose shade is another.
        let cells: Vec<_> = svg.lines().filter(|line| line.contains("stroke-width=\"0.3\"")).collect();
        assert_eq!(cells.iter().map(|line| line.matches('z').count()).sum::<usize>(), 2 + 3);
        assert_eq!(cells.len(), 3);
    }
}
