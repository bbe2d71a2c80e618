//! The rover mobility model: terrain class, slope and rock abundance give the speed.
//!
//! Folsom et al. 2021, Fig. 3, after Ono et al. 2018, "Mars 2020 site-specific mission performance analysis: Part 2".

use crate::speed::{Speed, SpeedDistribution, SpeedError};

/// What the ground is made of, in the eleven classes of the SPOC classifier (Rothrock et al. 2016).
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
#[repr(u8)]
#[expect(missing_docs, reason = "the classes are only names")]
pub enum TerrainClass {
    SmoothRegolith,
    SmoothOutcrop,
    FracturedOutcrop,
    SparseLinearRipples,
    RoughOutcrop,
    Crater,
    RockField,
    DenseLinearRipples,
    DeepSand,
    PolygonalRipples,
    Scarp,
}

impl TerrainClass {
    /// All classes, in the order that [`speed_distribution`] takes their probabilities.
    pub const ALL: [Self; 11] = [
        Self::SmoothRegolith,
        Self::SmoothOutcrop,
        Self::FracturedOutcrop,
        Self::SparseLinearRipples,
        Self::RoughOutcrop,
        Self::Crater,
        Self::RockField,
        Self::DenseLinearRipples,
        Self::DeepSand,
        Self::PolygonalRipples,
        Self::Scarp,
    ];
}

/// Rock abundance up to which the first column of the table holds.
const FEW_ROCKS: f64 = 0.07;
/// Rock abundance up to which the second column holds; nothing drives beyond.
const SOME_ROCKS: f64 = 0.15;

/// The speed on ground of a class, with its slope in degrees and the share of it that rocks cover (CFA, 0 to 1).
#[must_use]
pub fn speed(class: TerrainClass, slope_deg: f64, cfa: f64) -> Speed {
    use TerrainClass as Class;
    // Steepest slopes for each speed, gentle first.
    let limits: &[(f64, Speed)] = match class {
        Class::SmoothRegolith | Class::SmoothOutcrop | Class::FracturedOutcrop if cfa <= FEW_ROCKS => {
            &[(15.0, Speed::Fast), (20.0, Speed::Medium), (25.0, Speed::Slow)]
        }
        Class::SmoothRegolith | Class::SmoothOutcrop | Class::FracturedOutcrop if cfa <= SOME_ROCKS => {
            &[(25.0, Speed::Slow)]
        }
        Class::SparseLinearRipples if cfa <= FEW_ROCKS => &[(10.0, Speed::Medium)],
        Class::SparseLinearRipples if cfa <= SOME_ROCKS => &[(10.0, Speed::Slow)],
        Class::RoughOutcrop if cfa <= FEW_ROCKS => &[(15.0, Speed::Medium), (25.0, Speed::Slow)],
        Class::RoughOutcrop if cfa <= SOME_ROCKS => &[(20.0, Speed::Slow)],
        _ => &[],
    };
    limits.iter().find(|(steepest_deg, _)| slope_deg <= *steepest_deg).map_or(Speed::Zero, |limit| limit.1)
}

/// Why a cell's properties give no distribution of speeds.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum MobilityError {
    /// Not a slope of ground.
    #[error("a slope needs 0 to 90 degrees, got {got}")]
    Slope {
        /// The slope given, in degrees.
        got: f64,
    },
    /// Not a share.
    #[error("a rock abundance (CFA) needs 0 to 1, got {got}; divide percentages by 100")]
    Cfa {
        /// The number given.
        got: f64,
    },
    /// The classes' probabilities do not add up.
    #[error("the probabilities of the terrain classes are none: {0}")]
    Classes(SpeedError),
}

/// The speeds of a cell whose class is known only as a probability, in the order of [`TerrainClass::ALL`].
///
/// # Errors
/// If slope or rock abundance is out of range, or the probabilities do not add up.
pub fn speed_distribution(
    classes: &[f64; 11],
    slope_deg: f64,
    cfa: f64,
) -> Result<SpeedDistribution, MobilityError> {
    if !(0.0..=90.0).contains(&slope_deg) {
        return Err(MobilityError::Slope { got: slope_deg });
    }
    if !(0.0..=1.0).contains(&cfa) {
        return Err(MobilityError::Cfa { got: cfa });
    }
    let mut probabilities = [0.0; 4];
    for (class, probability) in TerrainClass::ALL.into_iter().zip(classes) {
        let speed = speed(class, slope_deg, cfa);
        if !(0.0..=1.0).contains(probability) {
            return Err(MobilityError::Classes(SpeedError::Probability { speed, got: *probability }));
        }
        probabilities[speed as usize] += probability;
    }
    SpeedDistribution::new(probabilities.map(|sum: f64| {
        // Eleven addends may round to just above 1.
        if sum > 1.0 && sum < 1.0 + SpeedDistribution::SUM_TOLERANCE { 1.0 } else { sum }
    }))
    .map_err(MobilityError::Classes)
}

#[cfg(test)]
mod tests {
    use super::*;
    use Speed::{Fast, Medium, Slow, Zero};

    #[test]
    fn the_papers_example_drives_at_50_m_per_sol() {
        assert_eq!(speed(TerrainClass::SmoothRegolith, 5.0, 0.10).m_per_sol(), 50.0);
    }

    /// P-MOBILITY: The rover's speed follows the published table at each of its thresholds.
    ///
    /// Each row of the table at its thresholds and just beyond, for CFA 7 %, 15 % and above.
    #[test]
    fn every_threshold_of_the_mobility_table_holds() {
        let check = |class, slope_deg, expected: [Speed; 3]| {
            let got = [0.07, 0.15, 0.151].map(|cfa| speed(class, slope_deg, cfa));
            assert_eq!(got, expected, "{class:?} at {slope_deg} degrees");
        };
        for class in
            [TerrainClass::SmoothRegolith, TerrainClass::SmoothOutcrop, TerrainClass::FracturedOutcrop]
        {
            check(class, 15.0, [Fast, Slow, Zero]);
            check(class, 15.1, [Medium, Slow, Zero]);
            check(class, 20.1, [Slow, Slow, Zero]);
            check(class, 25.1, [Zero, Zero, Zero]);
        }
        check(TerrainClass::SparseLinearRipples, 10.0, [Medium, Slow, Zero]);
        check(TerrainClass::SparseLinearRipples, 10.1, [Zero, Zero, Zero]);
        check(TerrainClass::RoughOutcrop, 15.0, [Medium, Slow, Zero]);
        check(TerrainClass::RoughOutcrop, 20.0, [Slow, Slow, Zero]);
        check(TerrainClass::RoughOutcrop, 20.1, [Slow, Zero, Zero]);
        check(TerrainClass::RoughOutcrop, 25.1, [Zero, Zero, Zero]);
        for class in &TerrainClass::ALL[5..] {
            check(*class, 0.0, [Zero, Zero, Zero]);
        }
    }

    #[test]
    fn uncertain_classes_give_the_sum_of_their_speeds() {
        let mut classes = [0.0; 11];
        classes[TerrainClass::SmoothRegolith as usize] = 0.6;
        classes[TerrainClass::RoughOutcrop as usize] = 0.3;
        classes[TerrainClass::Scarp as usize] = 0.1;
        let got = speed_distribution(&classes, 5.0, 0.05).unwrap();
        assert_eq!(got, SpeedDistribution::new([0.1, 0.0, 0.3, 0.6]).unwrap());
    }

    #[test]
    fn properties_out_of_range_are_refused() {
        let sure = [1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0];
        assert_eq!(speed_distribution(&sure, -1.0, 0.1), Err(MobilityError::Slope { got: -1.0 }));
        assert_eq!(speed_distribution(&sure, 5.0, 7.0), Err(MobilityError::Cfa { got: 7.0 }));
        assert!(matches!(speed_distribution(&[0.05; 11], 5.0, 0.1), Err(MobilityError::Classes(_))));
    }
}
