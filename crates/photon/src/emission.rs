//! Which lamp a photon leaves, and in which direction.
//!
//! Dmitriev et al. 2002, §4.1: Φ₂ chooses the lamp, is remapped, and with Φ₃ chooses the direction. The chance of a lamp follows its
//! *rated* flux, the one in the scene file, so that dimming moves no photon; it is snapped to multiples of a power of two, so that
//! no group of photons straddles two lamps, and every lamp keeps at least one step.

use lightmend_scene::{Scene, luminance};

/// Chances of at least 1/32: the groups of N_g = 2⁵·3² photons each keep to one lamp.
const LEAST_BITS: u32 = 5;

/// The chance of each lamp.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct LampChoice {
    /// First step of each lamp; one more entry than lamps.
    first: Vec<u32>,
    /// The lamp of each step; a power of two of them.
    lamp_of: Vec<u16>,
}

impl LampChoice {
    /// Chances in proportion to the lamps' rated luminous flux.
    pub fn new(scene: &Scene) -> LampChoice {
        let fluxes: Vec<f64> = scene.lamps.iter().map(|l| luminance(l.flux())).collect();
        LampChoice::from_fluxes(&fluxes)
    }

    fn from_fluxes(fluxes: &[f64]) -> LampChoice {
        let lamps = fluxes.len();
        if lamps == 0 {
            return LampChoice { first: vec![0], lamp_of: Vec::new() };
        }
        // Twice as many steps as lamps, so that the brightest still differ.
        let bits = LEAST_BITS.max(lamps.next_power_of_two().ilog2() + 1);
        let steps = 1u32 << bits;
        let total: f64 = fluxes.iter().sum();
        let mut share: Vec<u32> = vec![1; lamps];
        // The largest remainder method (Hamilton): each next step to the lamp that is furthest below its share.
        for _ in lamps as u32..steps {
            let behind = |l: usize| fluxes[l] / total * f64::from(steps) - f64::from(share[l]);
            let next = (0..lamps).fold(0, |best, l| if behind(l) > behind(best) { l } else { best });
            share[next] += 1;
        }
        let mut choice = LampChoice { first: vec![0], lamp_of: Vec::new() };
        for (lamp, share) in share.into_iter().enumerate() {
            choice.lamp_of.extend(std::iter::repeat_n(lamp as u16, share as usize));
            choice.first.push(choice.lamp_of.len() as u32);
        }
        choice
    }

    /// The chance that a photon leaves lamp `lamp`.
    pub fn chance(&self, lamp: usize) -> f64 {
        f64::from(self.first[lamp + 1] - self.first[lamp]) / self.lamp_of.len() as f64
    }

    /// The lamp for a random number, and the number remapped to [0, 1) (Shirley, Wang, Zimmerman 1996, Fig. 8).
    #[inline]
    pub fn choose(&self, u: f64) -> (usize, f64) {
        let steps = self.lamp_of.len() as f64;
        let scaled = u * steps;
        let lamp = usize::from(self.lamp_of[scaled as usize]);
        let (first, end) = (f64::from(self.first[lamp]), f64::from(self.first[lamp + 1]));
        (lamp, ((scaled - first) / (end - first)).min(1.0f64.next_down()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn chances_follow_flux_in_steps() {
        let choice = LampChoice::from_fluxes(&[300.0, 100.0, 0.0, 1.0]);
        let chances: Vec<f64> = (0..4).map(|l| choice.chance(l) * 32.0).collect();
        assert_eq!(chances.iter().sum::<f64>(), 32.0);
        assert_eq!((chances[2], chances[3]), (1.0, 1.0), "every lamp keeps a step");
        assert!((chances[0] - 22.5).abs() <= 0.5 && (chances[1] - 7.5).abs() <= 0.5, "{chances:?}");
        let hundred = LampChoice::from_fluxes(&[1.0; 100]);
        assert!((0..100).all(|l| hundred.chance(l) > 0.0));
    }

    #[test]
    fn remapping_covers_each_lamp_evenly() {
        let choice = LampChoice::from_fluxes(&[3.0, 1.0]);
        assert_eq!(choice.choose(0.0), (0, 0.0));
        assert_eq!(choice.choose(0.375), (0, 0.5));
        assert_eq!(choice.choose(0.75), (1, 0.0));
        let (lamp, u) = choice.choose(1.0f64.next_down());
        assert!(lamp == 1 && u < 1.0);
    }
}
