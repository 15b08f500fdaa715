//! What a repair will still bring, as far as that can be told before it does.
//!
//! Photons that were repaired tell of those that are still marked: on each side of an element so many deposits went and so many came. If the
//! others are like them, what will yet go and come there are counts of the same events over a stretch `ratio` times as long: negative
//! binomial variables (Gelman et al., Bayesian Data Analysis, §2.6). One light that may come of it is drawn; who sees no difference
//! between that and the light of now will not see the rest of the repair either.
//!
//! What is marked last need not be like what was repaired first: what matters to a camera comes first. So only the last
//! photons count, as many as are left or up to three times as many.

use super::{
    LedgerSolution,
    numbers::{Element, Numbers},
};
use crate::{bucket::Buckets, hash::mix, record::Outcome};

/// What repairs brought since they are watched: of a stretch that is over, and of the one that goes on.
#[derive(Clone)]
pub struct Exchange {
    before: Stretch,
    now: Stretch,
    /// Photons repaired before both.
    earlier: u64,
}

#[derive(Clone)]
struct Stretch {
    /// Deposits that went and that came, by the number of the element side.
    deposits: Vec<[u32; 2]>,
    /// Photons that were marked and are right now.
    photons: u64,
}

/// What is still to come.
#[derive(Debug, Clone)]
pub struct Pending {
    numbers: Numbers,
    deposits: Vec<[u32; 2]>,
    /// Photons that may be wrong for each that was repaired.
    ratio: f64,
    /// Deposits that are thought to have gone or come unseen on every side.
    unseen: f64,
}

/// The same of all watched repairs and those to come. More: a change is expected everywhere; 0: only where there was one already.
const UNSEEN: f64 = 0.25;

impl Exchange {
    fn new(numbers: &Numbers) -> Exchange {
        let none = || Stretch { deposits: vec![[0; 2]; numbers.count()], photons: 0 };
        Exchange { before: none(), now: none(), earlier: 0 }
    }

    /// So many photons were repaired: what they had left, and what they left anew.
    pub fn count(&mut self, numbers: &Numbers, old: &Outcome, new: &Outcome, photons: u64) {
        for (which, outcome) in [old, new].into_iter().enumerate() {
            for to in outcome.deposits.iter().map(|deposit| deposit.to) {
                let number = numbers.of(Element { object: to.object as usize, cell: to.cell, side: to.side });
                self.now.deposits[number as usize][which] += 1;
            }
        }
        self.now.photons += photons;
    }

    /// So many are left: when no more of them than this stretch had, the next one begins.
    pub fn turn(&mut self, outstanding: u64) {
        if self.now.photons >= outstanding {
            self.earlier += self.before.photons;
            std::mem::swap(&mut self.before, &mut self.now);
            self.now.deposits.fill([0; 2]);
            self.now.photons = 0;
        }
    }
}

impl LedgerSolution {
    /// From now on, until the next edit, it is noted what repairs bring.
    pub fn watch(&mut self) {
        self.exchange.get_or_insert_with(|| Exchange::new(&self.numbers));
    }

    /// What is still to come; `None` if it is not [watched](Self::watch).
    pub fn pending(&self) -> Option<Pending> {
        let Exchange { before, now, earlier } = self.exchange.as_ref()?;
        let repaired = before.photons + now.photons;
        let all = (earlier + repaired + self.outstanding).max(1) as f64;
        let sum = |([a, b], [c, d]): (&[u32; 2], &[u32; 2])| [a + c, b + d];
        Some(Pending {
            numbers: self.numbers.clone(),
            deposits: before.deposits.iter().zip(&now.deposits).map(sum).collect(),
            ratio: self.outstanding as f64 / repaired.max(1) as f64,
            unseen: UNSEEN * (repaired + self.outstanding) as f64 / all,
        })
    }
}

impl Pending {
    /// Photons that may still be wrong for each that was repaired and tells of them. Above 1 little is known.
    pub fn ratio(&self) -> f64 {
        self.ratio
    }

    /// Light that may come of `light` in the end: drawn on the objects that are `wanted`, the others stay as they are. The same pending photons
    /// give the same light.
    pub fn draw(&self, light: &Buckets, wanted: impl Fn(usize) -> bool) -> Buckets {
        let mut drawn = light.clone();
        let usual = light.usual();
        for (number, counts) in self.deposits.iter().enumerate() {
            let Element { object, cell, side } = self.numbers.element(number as u32);
            if self.ratio == 0.0 || !wanted(object) {
                continue;
            }
            let more = |which: usize| {
                let chance = (mix((2 * number + which) as u64) >> 11) as f64 / (1u64 << 53) as f64;
                negative_binomial(f64::from(counts[which]) + self.unseen, self.ratio, chance)
            };
            let change = more(1) - more(0);
            if change != 0.0 {
                drawn.add_hits_alike(object, cell, usize::from(side), change, usual);
            }
        }
        drawn
    }
}

/// Events in a stretch `ratio` times as long as one in which there were `shape`: the number that a share `chance` (0 to 1) of all such do not
/// exceed.
fn negative_binomial(shape: f64, ratio: f64, chance: f64) -> f64 {
    let (mean, deviation) = (shape * ratio, (shape * ratio * (1.0 + ratio)).sqrt());
    let mut probability = (-shape * ratio.ln_1p()).exp();
    if probability < 1e-250 {
        // So many are distributed normally; the logistic function comes near enough to that.
        let odds = (chance.clamp(1e-9, 1.0 - 1e-9) / (1.0 - chance.clamp(1e-9, 1.0 - 1e-9))).ln();
        return (mean + deviation * odds * 3f64.sqrt() / std::f64::consts::PI).round().max(0.0);
    }
    let (mut n, mut left) = (0.0, chance);
    while left > probability && n < mean + 40.0 * deviation {
        left -= probability;
        probability *= (shape + n) / (n + 1.0) * ratio / (1.0 + ratio);
        n += 1.0;
    }
    n
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{body::TreePreset, halton::Scrambling, path::FirstHits, pool::Pool, world::World};
    use glam::DVec3;
    use lightmend_scene::{Configuration, Edit, Scene};
    use std::{path::Path, sync::Arc};

    #[test]
    fn drawn_counts_have_their_mean_and_variance() {
        // Few, many, and so many that they are taken as normal.
        for (shape, ratio) in [(0.25, 0.5), (3.25, 2.0), (40.0, 0.3), (5000.0, 1.5)] {
            let drawn: Vec<f64> = (0..4000).map(|n| negative_binomial(shape, ratio, (f64::from(n) + 0.5) / 4000.0)).collect();
            let mean = drawn.iter().sum::<f64>() / 4000.0;
            let variance = drawn.iter().map(|n| (n - mean).powi(2)).sum::<f64>() / 4000.0;
            assert!((mean / (shape * ratio) - 1.0).abs() < 0.01, "{shape}, {ratio}: {mean}");
            assert!((variance / (shape * ratio * (1.0 + ratio)) - 1.0).abs() < 0.05, "{shape}, {ratio}: {variance}");
        }
    }

    #[test]
    fn what_is_to_come_is_told_before_it_comes() {
        let cornell = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenes/cornell/cornell.ron");
        let world = Arc::new(World::new(&Configuration::initial(&Scene::read(&cornell).unwrap().0), TreePreset::default()));
        let pool = Pool::new(240_000, 72, 16, Scrambling::Seed(1)).unwrap();
        let mut ledger = LedgerSolution::shoot(pool, world.clone(), FirstHits::Never, u64::MAX, &mut |_, _| true).unwrap();
        let edit = Edit::Move { object: "short box".into(), to: DVec3::new(1.5, 0.45, 0.0) };
        let after = Arc::new(world.moved_to(&world.configuration().apply(&edit).unwrap()));
        assert!(ledger.pending().is_none(), "nobody watches");
        ledger.watch();
        ledger.change(after).unwrap();
        assert!(ledger.pending().is_none(), "an edit ends it");
        ledger.watch();
        ledger.scan(usize::MAX);
        let marked = ledger.outstanding_photons();
        let mut told = Vec::new();
        while ledger.repair_next().unwrap().is_some() {
            let left = ledger.outstanding_photons();
            if told.is_empty() && left < marked * 2 / 3 || told.len() == 1 && left < marked / 4 {
                let now = ledger.buckets().clone();
                told.push((ledger.pending().unwrap().draw(&now, |_| true), now));
            }
        }
        let exact = ledger.buckets();
        assert_eq!(ledger.pending().unwrap().draw(exact, |_| true), *exact, "nothing is to come");
        // Sides whose hits change by more than a tenth and three: no fewer were told than there are, and not many times as many. (That what came
        // so far may be chance is part of what is drawn.)
        let many = |now: &Buckets, then: &Buckets| {
            let objects = 0..world.configuration().object_slots();
            let pages =
                objects.flat_map(|object| [0, 1].map(|side| Some((now.get(object, side, 0)?, then.get(object, side, 0)?))));
            let pairs = pages.flatten().flat_map(|(now, then)| now.iter().zip(then));
            pairs.filter(|(now, then)| (now.hits - then.hits).abs() as f64 > 3.0 + 0.1 * then.hits as f64).count() as f64
        };
        for (drawn, now) in &told {
            let (truth, told) = (many(now, exact), many(now, drawn));
            assert!(truth > 20.0 && (1.0..4.0).contains(&(told / truth)), "told {told} of {truth}");
        }
        assert_eq!(told.len(), 2);
    }
}
