//! What a repair will still bring, as far as that can be told before it does.
//!
//! Photons that were repaired tell of those that are still marked. **Expected** is that light goes on changing on each side of an element as
//! it has changed since the last edit, as far as that is more than chance: a difference of two lights of the same photons, of which a
//! sample is known (control variates: Owen, Monte Carlo Theory, Methods and Examples, §8.9). With nothing left it is exact.
//! **Possible** is more: so many deposits went and so many came, and if the others are like them, what will yet go and come are counts of
//! the same events over a stretch `ratio` times as long: negative
//! binomial variables (Gelman et al., Bayesian Data Analysis, §2.6). One light that may come of it is drawn; who sees no difference
//! between that and the light of now will not see the rest of the repair either.
//!
//! Of photons that several edits made wrong, those that were last right longer ago change more: by as much as there were edits since, as if all
//! edits were steps of a drag. What is marked last need not be like what was repaired first, if what matters to a camera comes first. Then nothing is
//! expected, and of what is possible only the last photons tell, as many as are left or up to three times as many.

use super::{
    LedgerSolution,
    held::{Held, WorldNumber},
    numbers::{Element, Numbers},
};
use crate::{bucket::Buckets, hash::mix, record::Outcome, world::World};
use rayon::prelude::*;
use std::ops::Range;

/// What repairs brought since they are watched: of a stretch that is over, and of the one that goes on.
#[derive(Clone)]
pub struct Exchange {
    before: Option<Stretch>,
    now: Stretch,
    /// Photons repaired before both.
    earlier: u64,
    /// Whether what was repaired is a sample of all: not if what a camera sees came first.
    is_sample: bool,
    /// Chunks that were scanned since the last edit, and photons that were marked in them.
    scanned: [u64; 2],
}

#[derive(Clone)]
struct Stretch {
    /// The light when it began.
    light: Buckets,
    /// Deposits that went and that came, by the number of the element side.
    deposits: Vec<[u32; 2]>,
    /// Photons that were marked and are right now.
    photons: u64,
    /// They, each as often as there were edits since it was last right.
    edits: u64,
}

/// What is still to come.
#[derive(Debug, Clone)]
pub struct Pending {
    numbers: Numbers,
    /// The light before `deposits`.
    light: Buckets,
    deposits: Vec<[u32; 2]>,
    /// Photons that may be wrong for each that was repaired.
    ratio: f64,
    /// Deposits that are thought to have gone or come unseen on every side.
    unseen: f64,
    /// Whether what was repaired is a sample of all.
    is_sample: bool,
}

/// The same of all watched repairs and those to come. More: a change is expected everywhere; 0: only where there was one already.
const UNSEEN: f64 = 0.25;

/// So many repaired photons tell enough to begin anew at the next edit. More: the light of a drag stays behind the hand; fewer: it is noise,
/// and not believed.
const ENOUGH: u64 = 32_768;

impl Stretch {
    fn new(numbers: &Numbers, light: &Buckets) -> Stretch {
        Stretch { light: light.clone(), deposits: vec![[0; 2]; numbers.count()], photons: 0, edits: 0 }
    }
}

impl Exchange {
    /// So many chunks were scanned, and so many photons marked in them.
    pub fn scan(&mut self, chunks: u64, marked: u64) {
        self.scanned[0] += chunks;
        self.scanned[1] += marked;
    }

    /// So many photons were repaired: what they had left, and what they left anew. `edits` is the sum of the edits since they were last right.
    pub fn count(&mut self, numbers: &Numbers, old: &Outcome, new: &Outcome, photons: u64, edits: u64) {
        for (which, outcome) in [old, new].into_iter().enumerate() {
            for to in outcome.deposits.iter().map(|deposit| deposit.to) {
                let number = numbers.of(Element { object: to.object as usize, cell: to.cell, side: to.side });
                self.now.deposits[number as usize][which] += 1;
            }
        }
        self.now.photons += photons;
        self.now.edits += edits;
    }

    /// So many are left. If what was repaired is no sample of them, and this stretch had as many, the next one begins.
    pub fn turn(&mut self, outstanding: u64, numbers: &Numbers) {
        if !self.is_sample && self.now.photons >= outstanding {
            // Its light is not asked for: to keep it would copy every page in which light arrives.
            let over = std::mem::replace(&mut self.now, Stretch::new(numbers, &Buckets::default()));
            self.earlier += self.before.replace(over).map_or(0, |before| before.photons);
        }
    }

    /// From now on, until the next edit, what is repaired is no sample.
    pub fn choose(&mut self) {
        self.is_sample = false;
    }

    /// What it tells after an edit, if anything: the stretch is over if it was long enough. One that is over is kept: light that were shown as it is until
    /// enough is known anew would flicker under a drag.
    pub fn after_edit(mut self, world: &World, numbers: &Numbers, light: &Buckets) -> Option<Exchange> {
        if !self.is_sample {
            return None;
        }
        if self.now.photons >= ENOUGH {
            self.before = Some(std::mem::replace(&mut self.now, Stretch::new(numbers, light)));
        }
        for stretch in self.before.iter_mut().chain([&mut self.now]) {
            stretch.light.grow(world.configuration());
            stretch.deposits.resize(numbers.count(), [0; 2]);
        }
        Some(Exchange { scanned: [0; 2], earlier: 0, ..self })
    }
}

impl LedgerSolution {
    /// From now on it is noted what repairs bring, until an edit after which that tells nothing; to be called again after each.
    pub fn watch(&mut self) {
        self.exchange.get_or_insert_with(|| {
            let now = Stretch::new(&self.numbers, &self.buckets);
            Exchange { before: None, now, earlier: 0, is_sample: self.visible.is_empty(), scanned: [0; 2] }
        });
    }

    /// What is still to come; `None` if it is not [watched](Self::watch).
    pub fn pending(&self) -> Option<Pending> {
        let Exchange { before, now, earlier, is_sample, scanned: [scanned, marked] } = self.exchange.as_ref()?;
        let of_both = |of: fn(&Stretch) -> u64| before.as_ref().map_or(0, of) + of(now);
        let (repaired, edits) = (of_both(|stretch| stretch.photons), of_both(|stretch| stretch.edits));
        let all = (earlier + repaired + self.outstanding).max(1) as f64;
        let sum = |([a, b], [c, d]): (&[u32; 2], &[u32; 2])| [a + c, b + d];
        let deposits = match before {
            Some(before) => before.deposits.iter().zip(&now.deposits).map(sum).collect(),
            None => now.deposits.clone(),
        };
        Some(Pending {
            numbers: self.numbers.clone(),
            light: before.as_ref().unwrap_or(now).light.clone(),
            deposits,
            ratio: self.edits_outstanding(*marked as f64 / (*scanned).max(1) as f64) / edits.max(1) as f64,
            unseen: UNSEEN * (repaired + self.outstanding) as f64 / all,
            is_sample: *is_sample,
        })
    }

    /// The sum of the edits since photons that are wrong were last right, if `marked` are in a chunk that was not scanned.
    fn edits_outstanding(&self, marked: f64) -> f64 {
        let since = |world: WorldNumber| f64::from(self.newest - world);
        let of_chunk = |held: &Held| {
            let of_marks: f64 = held.marked.iter().map(|(world, marks)| f64::from(marks.count()) * since(*world)).sum();
            of_marks + marked * since(held.right_in)
        };
        // Summed in order: the same pending photons are to give the same light.
        let rows: Vec<f64> = self.chunks.par_chunks(1024).map(|chunks| chunks.iter().map(of_chunk).sum()).collect();
        rows.iter().sum()
    }
}

impl Pending {
    /// Photons that may still be wrong for each that was repaired and tells of them. Above 1 little is known.
    pub fn ratio(&self) -> f64 {
        self.ratio
    }

    /// The light that is expected in the end of `light`, which is that of now: it goes on as it went, on sides where that is more than chance. `light` itself
    /// if what a camera sees was repaired first ([`LedgerSolution::look`]): the rest is not like that.
    pub fn expected(&self, light: &Buckets) -> Buckets {
        let mut then = light.clone();
        if self.is_sample && self.ratio > 0.0 {
            then.go_on(&self.light, self.ratio, |object| {
                let Range { start, end } = self.numbers.of_object(object);
                &self.deposits[start as usize..end as usize]
            });
        }
        then
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
    use crate::{body::TreePreset, halton::Scrambling, importance::Importance, path::FirstHits, pool::Pool, world::World};
    use glam::DVec3;
    use lightmend_scene::{Configuration, Edit, Scene};
    use std::{collections::BTreeMap, path::Path, sync::Arc};

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

    fn cornell() -> Arc<World> {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenes/cornell/cornell.ron");
        Arc::new(World::new(&Configuration::initial(&Scene::read(&path).unwrap().0), TreePreset::default()))
    }

    /// Root of the sum over all sides and lamps of the squared difference of two lights, energy.
    fn distance(a: &Buckets, b: &Buckets) -> f64 {
        let of = |light: &Buckets| -> BTreeMap<_, i64> {
            light.lit().map(|(at, bucket)| ((at.object, at.cell, at.side, at.lamp), bucket.energy.iter().sum())).collect()
        };
        let [a, b] = [a, b].map(of);
        let get = |light: &BTreeMap<_, i64>, at| light.get(at).copied().unwrap_or(0) as f64;
        let sum: f64 =
            a.keys().chain(b.keys().filter(|at| !a.contains_key(at))).map(|at| (get(&a, at) - get(&b, at)).powi(2)).sum();
        sum.sqrt()
    }

    #[test]
    fn expected_light_is_nearer_to_exact_light() {
        let home = cornell();
        let to = |x: f64| Edit::Move { object: "short box".into(), to: DVec3::new(x, 0.45, 0.0) };
        let world = |x: f64| Arc::new(home.moved_to(&home.configuration().apply(&to(x)).unwrap()));
        let pool = Pool::new(1_200_000, 72, 16, Scrambling::Seed(1)).unwrap();
        let drained = LedgerSolution::shoot(pool, home.clone(), FirstHits::Never, u64::MAX, &mut |_, _| true).unwrap();
        let mut exact = drained.clone();
        exact.change(world(1.5)).unwrap();
        while exact.repair_next().unwrap().is_some() {}
        // At once, and in five steps of which each is repaired in part.
        for steps in [1, 5] {
            let mut ledger = drained.clone();
            for step in 1..=steps {
                ledger.change(world(1.3 + 0.2 * f64::from(step) / f64::from(steps))).unwrap();
                ledger.watch();
                let parts = if step == steps { 8 } else { 2 };
                (0..parts).for_each(|_| drop(ledger.repair_next().unwrap()));
            }
            let pending = ledger.pending().unwrap();
            let [as_is, expected] =
                [ledger.buckets().clone(), pending.expected(ledger.buckets())].map(|l| distance(&l, exact.buckets()));
            assert!(ledger.unscanned > 0 && expected < 0.6 * as_is, "{steps}: {expected} of {as_is}");
            while ledger.repair_next().unwrap().is_some() {}
            assert_eq!(ledger.pending().unwrap().expected(ledger.buckets()), *exact.buckets());
        }
        // What a camera sees is not like the rest.
        let mut ledger = drained.clone();
        ledger.change(world(1.5)).unwrap();
        ledger.watch();
        ledger.scan(usize::MAX);
        ledger.look(&Importance::new(home.configuration().object_slots(), &[]));
        ledger.repair_next().unwrap();
        assert_eq!(ledger.pending().unwrap().expected(ledger.buckets()), *ledger.buckets());
        // On the way back the way there tells nothing.
        let mut ledger = drained.clone();
        for there in [true, false] {
            ledger.change(if there { world(1.5) } else { home.clone() }).unwrap();
            assert!(ledger.pending().is_none());
            ledger.watch();
            ledger.repair_next().unwrap();
        }
    }

    #[test]
    fn what_is_to_come_is_told_before_it_comes() {
        let world = cornell();
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
