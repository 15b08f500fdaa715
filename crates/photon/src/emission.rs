//! Which lamp a photon leaves, and in which direction.
//!
//! Dmitriev et al. 2002, §4.1: Φ₂ chooses the lamp, is remapped, and with Φ₃ chooses the direction. The chance of a lamp follows its
//! *rated* flux, the one in the scene file, so that dimming moves no photon; it is snapped to multiples of a power of two, so that
//! no group of photons straddles two lamps, and every lamp keeps at least one step.

use lightmend_scene::{Configuration, luminance};

/// Chances are multiples of 1/8 for one lamp, and twice as fine for twice the lamps: as fine as the groups of the seed's N_g, which is
/// 2⁵·3² for four lamps (§7), so that each group keeps to one lamp.
const BITS_FOR_ONE: u32 = 3;

/// The chance of each lamp.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct LampChoice {
    /// First step and one past the last of each lamp, by its number; empty where there is no lamp.
    steps: Vec<[u32; 2]>,
    /// The lamp of each step; a power of two of them.
    lamp_of: Vec<u16>,
}

impl LampChoice {
    /// Chances in proportion to the lamps' rated luminous flux.
    pub fn new(configuration: &Configuration) -> LampChoice {
        // In order of names, so that a lamp's photons do not depend on its number.
        let mut lamps: Vec<_> = configuration.lamps().collect();
        lamps.sort_by(|a, b| a.1.name.cmp(&b.1.name));
        let rated: Vec<(usize, f64)> = lamps.iter().map(|(id, lamp)| (*id, luminance(lamp.rated_flux()))).collect();
        LampChoice::from_rated(&rated, configuration.lamp_slots())
    }

    /// Lamps by number with their flux, among `slots` numbers.
    fn from_rated(rated: &[(usize, f64)], slots: usize) -> LampChoice {
        let lamps = rated.len();
        let mut choice = LampChoice { steps: vec![[0; 2]; slots], lamp_of: Vec::new() };
        if lamps == 0 {
            return choice;
        }
        let bits = BITS_FOR_ONE + lamps.next_power_of_two().ilog2();
        let steps = 1u32 << bits;
        let total: f64 = rated.iter().map(|(_, flux)| flux).sum();
        let mut share: Vec<u32> = vec![1; lamps];
        // The largest remainder method (Hamilton): each next step to the lamp that is furthest below its share.
        for _ in lamps as u32..steps {
            let behind = |l: usize| rated[l].1 / total * f64::from(steps) - f64::from(share[l]);
            let next = (0..lamps).fold(0, |best, l| if behind(l) > behind(best) { l } else { best });
            share[next] += 1;
        }
        for ((number, _), share) in rated.iter().zip(share) {
            let first = choice.lamp_of.len() as u32;
            choice.lamp_of.extend(std::iter::repeat_n(*number as u16, share as usize));
            choice.steps[*number] = [first, first + share];
        }
        choice
    }

    /// The chance that a photon leaves lamp number `lamp`.
    pub fn chance(&self, lamp: usize) -> f64 {
        let [first, end] = self.steps.get(lamp).copied().unwrap_or_default();
        f64::from(end - first) / self.lamp_of.len().max(1) as f64
    }

    /// The lamp for a random number, and the number remapped to [0, 1) (Shirley, Wang, Zimmerman 1996, Fig. 8). `None` in the dark.
    #[inline(always)]
    pub fn choose(&self, u: f64) -> Option<(usize, f64)> {
        let scaled = u * self.lamp_of.len() as f64;
        let lamp = usize::from(*self.lamp_of.get(scaled as usize)?);
        let [first, end] = self.steps[lamp].map(f64::from);
        Some((lamp, ((scaled - first) / (end - first)).min(1.0f64.next_down())))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn chances_follow_flux_in_steps() {
        let choice = LampChoice::from_rated(&[(0, 300.0), (1, 100.0), (2, 0.0), (3, 1.0)], 4);
        let chances: Vec<f64> = (0..4).map(|l| choice.chance(l) * 32.0).collect();
        assert_eq!(chances.iter().sum::<f64>(), 32.0);
        assert_eq!((chances[2], chances[3]), (1.0, 1.0), "every lamp keeps a step");
        assert!((chances[0] - 22.5).abs() <= 0.5 && (chances[1] - 7.5).abs() <= 0.5, "{chances:?}");
        let hundred = LampChoice::from_rated(&(0..100).map(|l| (l, 1.0)).collect::<Vec<_>>(), 100);
        assert!((0..100).all(|l| hundred.chance(l) > 0.0));
    }

    #[test]
    fn remapping_covers_each_lamp_evenly() {
        let choice = LampChoice::from_rated(&[(0, 3.0), (1, 1.0)], 2);
        assert_eq!(choice.choose(0.0), Some((0, 0.0)));
        assert_eq!(choice.choose(0.375), Some((0, 0.5)));
        assert_eq!(choice.choose(0.75), Some((1, 0.0)));
        let (lamp, u) = choice.choose(1.0f64.next_down()).unwrap();
        assert!(lamp == 1 && u < 1.0);
    }
}
