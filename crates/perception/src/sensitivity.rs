//! What contrast of a grating an eye just sees (Daly 1993, contrast sensitivity), and what step of luminance (Ward Larson et al. 1997).
//!
//! S. Daly, "The Visible Differences Predictor", in Digital Images and Human Vision, MIT Press 1993, pp. 179–206: the formula without
//! its terms for accommodation, eccentricity and orientation, that is for foveal vision of upright gratings. G. Ward Larson, H.
//! Rushmeier, C. Piatko, "A Visibility Matching Tone Reproduction Operator", 1997, Table 1. Constants were compared with public
//! implementations of both.

/// Sensitivity at the best frequency in bright light: 1 ÷ threshold contrast.
const PEAK: f64 = 250.0;

/// Size of the picture that is looked at, square degrees. Smaller: less sensitive to coarse patterns.
const AREA: f64 = 100.0;

/// Sensitivity to a grating, 1 ÷ its threshold contrast; `frequency` in cycles per degree above 0, `luminance` in cd/m².
pub fn contrast_sensitivity(frequency: f64, luminance: f64) -> f64 {
    const EPSILON: f64 = 0.9;
    let a = 0.801 * (1.0 + 0.7 / luminance).powf(-0.2);
    let b = 0.3 * (1.0 + 100.0 / luminance).powf(0.15);
    let size = ((3.23 * (frequency * frequency * AREA).powf(-0.3)).powi(5) + 1.0).powf(-0.2);
    let rise = a * EPSILON * frequency * (-b * EPSILON * frequency).exp() * (1.0 + 0.06 * (b * EPSILON * frequency).exp()).sqrt();
    PEAK * size * rise
}

/// The step of luminance that is just seen where the eye is adapted to `luminance`; both cd/m². Rods and cones.
pub fn threshold_step(luminance: f64) -> f64 {
    let log = luminance.max(1e-30).log10();
    10f64.powf(match log {
        l if l < -3.94 => -2.86,
        l if l < -1.44 => (0.405 * l + 1.6).powf(2.18) - 2.86,
        l if l < -0.0184 => l - 0.395,
        l if l < 1.9 => (0.249 * l + 0.65).powf(2.7) - 0.72,
        l => l - 1.255,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sensitivity_is_that_of_an_eye() {
        // Between two and six cycles per degree it is best: some hundred and more in daylight, and finer than 50 nearly nothing is seen.
        let best = (1..600)
            .map(|f| f64::from(f) / 10.0)
            .max_by(|a, b| contrast_sensitivity(*a, 100.0).total_cmp(&contrast_sensitivity(*b, 100.0)));
        assert!((2.0..6.0).contains(&best.unwrap()), "{best:?}");
        assert!((100.0..250.0).contains(&contrast_sensitivity(4.0, 100.0)));
        assert!(contrast_sensitivity(50.0, 100.0) < 2.0);
        assert!(contrast_sensitivity(4.0, 1.0) < contrast_sensitivity(4.0, 100.0));
    }

    #[test]
    fn steps_follow_weber_in_daylight_and_grow_everywhere() {
        assert!((threshold_step(1000.0) / 1000.0 - 10f64.powf(-1.255)).abs() < 1e-12);
        let steps: Vec<f64> = (-60..60).map(|l| threshold_step(10f64.powf(f64::from(l) / 10.0))).collect();
        // The pieces of the table meet within its three digits.
        assert!(steps.windows(2).all(|w| w[1] > 0.98 * w[0]), "{steps:?}");
    }
}
