//! What is still to come, as far as it can be told before it does.
//!
//! Photons that were repaired since the edit tell of those that are still marked: on every side of an element, so many deposits went
//! and so many came. If the others are like them, deposits that will still go and come there are counts of the same events in a stretch
//! `ratio` times as long: negative binomial variables (Gelman et al., Bayesian Data Analysis, §2.6). One light that may come of it is
//! drawn, and whoever sees no difference to it will not see the rest of the repair.

use super::{
    LedgerSolution,
    numbers::{Element, Numbers},
};
use crate::{bucket::Buckets, hash::mix, record::Outcome};

/// Deposits that went and came on each element side since the last edit, by number.
#[derive(Clone, Debug, Default)]
pub struct Exchange {
    gone: Vec<u32>,
    come: Vec<u32>,
    /// Photons that were marked and are right now.
    repaired: u64,
}

/// What is still to come.
#[derive(Debug, Clone)]
pub struct Pending {
    numbers: Numbers,
    exchange: Exchange,
    /// Photons that may be wrong for each that was repaired.
    ratio: f64,
}

/// Deposits that are thought to have gone and come in secret where none was seen. More: a change is expected everywhere; 0: only where there was
/// one already.
const UNSEEN: f64 = 0.25;

impl Exchange {
    /// Nothing yet.
    pub fn new(numbers: &Numbers) -> Exchange {
        let none = || vec![0; numbers.count()];
        Exchange { gone: none(), come: none(), repaired: 0 }
    }

    /// So many photons were repaired.
    pub fn count(&mut self, numbers: &Numbers, old: &Outcome, new: &Outcome, photons: u64) {
        for (counts, outcome) in [(&mut self.gone, old), (&mut self.come, new)] {
            for deposit in &outcome.deposits {
                let element = Element { object: deposit.to.object as usize, cell: deposit.to.cell, side: deposit.to.side };
                counts[numbers.of(element) as usize] += 1;
            }
        }
        self.repaired += photons;
    }
}

impl LedgerSolution {
    /// From now on it is counted what repairs bring.
    pub fn watch(&mut self) {
        self.exchange.get_or_insert_with(|| Exchange::new(&self.numbers));
    }

    /// What is still to come; `None` if it is not [watched](Self::watch).
    pub fn pending(&self) -> Option<Pending> {
        let exchange = self.exchange.clone()?;
        let ratio = self.outstanding as f64 / exchange.repaired.max(1) as f64;
        Some(Pending { numbers: self.numbers.clone(), exchange, ratio })
    }
}

impl Pending {
    /// Photons that may be wrong for each that was repaired since the edit.
    pub fn ratio(&self) -> f64 {
        self.ratio
    }

    /// Light that may come of `light` in the end, drawn from all that may: on `wanted` objects, the others stay as they are.
    pub fn draw(&self, light: &Buckets, wanted: impl Fn(usize) -> bool) -> Buckets {
        let mut drawn = light.clone();
        let counts = self.exchange.gone.iter().zip(&self.exchange.come);
        for (number, (gone, come)) in counts.enumerate() {
            let Element { object, cell, side } = self.numbers.element(number as u32);
            if !wanted(object) {
                continue;
            }
            let more = |count: u32, salt: u64| {
                let chance = (mix(2 * number as u64 + salt) >> 11) as f64 / (1u64 << 53) as f64;
                negative_binomial(f64::from(count) + UNSEEN, self.ratio, chance)
            };
            let change = more(*come, 1) - more(*gone, 0);
            if change != 0.0 {
                drawn.scale_side(object, cell, usize::from(side), change);
            }
        }
        drawn
    }
}

/// The value of a negative binomial variable that a share `chance` (0 to 1) of all do not exceed: events in a stretch `ratio` times as long as one in which there were
/// `shape`.
fn negative_binomial(shape: f64, ratio: f64, chance: f64) -> f64 {
    let mut probability = (-shape * ratio.ln_1p()).exp();
    if probability < 1e-250 {
        // So many are normally distributed.
        let deviation = (shape * ratio * (1.0 + ratio)).sqrt();
        return (shape * ratio + deviation * probit(chance)).round().max(0.0);
    }
    let (mut n, mut left) = (0.0, chance);
    while left > probability && probability > 1e-300 {
        left -= probability;
        probability *= (shape + n) / (n + 1.0) * ratio / (1.0 + ratio);
        n += 1.0;
    }
    n
}

/// The standard normal variable that a share of all do not exceed, by the logistic function, to 0.15.
fn probit(chance: f64) -> f64 {
    let chance = chance.clamp(1e-12, 1.0 - 1e-12);
    (chance / (1.0 - chance)).ln() * (std::f64::consts::PI / 8.0).sqrt()
}
