//! The figure of a landing table beside the law of the papers.

use contract::Soil;
use report::picture::{Chart, Curves, Line};
use scatter::{FlatScatter, slope_in_limits};
use scenario::{Robot, Scatter};

use crate::landing_table::{BIN_DEG, LandingTable};

/// The law of P23 on a soil.
fn law(soil: Soil) -> FlatScatter {
    let Scatter { intended, stuck, sideways, .. } = match soil {
        Soil::Hard => Scatter::default(),
        Soil::Sand => Scatter::on_sand(),
    };
    FlatScatter { intended, stuck, sideways }
}

/// Shares of hops that rest where they aim, by the slope towards the target, on both soils, by physics and by the law.
#[must_use]
pub fn figure(table: &LandingTable) -> String {
    let at: Vec<f64> = (-12..=12).map(|bin| f64::from(bin) * BIN_DEG).collect();
    let derived = |soil, offset| {
        let share = |&along: &f64| table.straight(soil, along).map(|class| class.share(offset));
        at.iter().map(share).collect::<Vec<_>>()
    };
    let slope_limit_rad = Robot::default().slope_limit_deg.to_radians();
    let of_law = |soil, stays: bool| {
        let share = |&along: &f64| {
            let ahead = slope_in_limits(libm::tan(along.to_radians()), slope_limit_rad);
            let scatter = law(soil).on_slope(ahead, 0.0);
            Some(if stays { scatter.stayed } else { scatter.intended })
        };
        at.iter().map(share).collect::<Vec<_>>()
    };
    let chart = |quantity: &str, offset, stays| Chart {
        quantity: quantity.into(),
        lines: vec![
            Line { name: "physics, hard".into(), values: derived(Soil::Hard, offset) },
            Line { name: "physics, sand".into(), values: derived(Soil::Sand, offset) },
            Line { name: "law, hard".into(), values: of_law(Soil::Hard, stays) },
            Line { name: "law, sand".into(), values: of_law(Soil::Sand, stays) },
        ],
    };
    Curves {
        title: format!("Hops of {} m on {}: physics beside the law of P23", table.hop_m, table.preset),
        caption: format!("{} hops a class, level ground across", table.classes[0].samples),
        axis: "slope towards the target, degrees".into(),
        charts: vec![
            chart("share that rests where it aims", [1, 0], false),
            chart("share that stays", [0, 0], true),
        ],
        at,
    }
    .svg()
}
