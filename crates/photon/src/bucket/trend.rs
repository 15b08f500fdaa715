//! What light comes to if it goes on changing as it changed.
//!
//! A change is known from some of the photons that it concerns. On a cell's side where few of them went or came it may be chance; then its
//! neighbours are asked, cells that follow one another, and it is taken to change as they do together, in proportion to its light.

use super::{Bucket, Buckets};
use std::{ops::Range, sync::Arc};

/// A change goes on if it is more than so many of its standard errors. More: light lags behind what moves; fewer: it is noise. (Of the ROOM's table, dragged
/// with 20 and 4 million photons, 1.0, 1.4, 2.0, 2.8 leave 33, 32, 32, 36 and 31, 29, 29, 31 % of the change, but the first leave three times the error at first.)
const SURE: f64 = 2.0;

/// Cells that are asked together, most first, each a multiple of the next.
const TOGETHER: [usize; 3] = [256, 16, 1];

/// Energy per channel, and hits.
type Light = [f64; 4];

/// A page as it is now and as it was.
struct Page<'p> {
    now: &'p mut [Bucket],
    was: Option<&'p [Bucket]>,
}

impl Buckets {
    /// What has changed since `before` changes `ratio` times more on each side of each cell, less by what may be chance: `events` says how many
    /// deposits went or came on the sides of an object's cells since then, two by two.
    pub(crate) fn go_on<'e>(&mut self, before: &Buckets, ratio: f64, events: impl Fn(usize) -> &'e [[u32; 2]]) {
        for (object, pages) in self.pages.iter_mut().enumerate() {
            for side in 0..2 {
                let mut changed = Vec::new();
                for (lamp, page) in pages.iter_mut().skip(side).step_by(2).enumerate() {
                    let was = before.get(object, side, lamp);
                    if let Some(page) = page.as_mut().filter(|page| was.is_none_or(|was| !std::ptr::eq(was, &***page))) {
                        changed.push(Page { now: Arc::make_mut(page), was });
                    }
                }
                if changed.is_empty() {
                    continue;
                }
                let events: Vec<u32> = events(object).iter().skip(side).step_by(2).map(|[went, came]| went + came).collect();
                let cells = self.cells[object] as usize;
                for start in (0..cells).step_by(TOGETHER[0]) {
                    let block = start..(start + TOGETHER[0]).min(cells);
                    self.deposits += go_on_in(&mut changed, block.clone(), &events[block], ratio);
                }
            }
        }
    }
}

/// The same on some cells of one side of an object, each with its events; how many hits more there are.
fn go_on_in(pages: &mut [Page], cells: Range<usize>, events: &[u32], ratio: f64) -> i64 {
    if events.iter().all(|events| *events == 0) {
        return 0;
    }
    let known = |page: &Page| {
        let was = |cell: usize| page.was.and_then(|was| was.get(cell)).copied().unwrap_or_default();
        cells.clone().map(|cell| [was(cell), page.now[cell]].map(light)).collect()
    };
    let block = Block { pages: pages.iter().map(known).collect(), events, ratio };
    let none = Trend { shares: vec![Light::default(); pages.len()], events: 0.0 };
    let mut more = 0;
    block.follow(0..cells.len(), &TOGETHER, &none, &mut |page, cell, change| {
        let bucket = &mut pages[page].now[cells.start + cell];
        // Rounded by hand: `round` is a call on processors before SSE 4.1.
        let then = |now: i64, change: f64| (now + (change + 0.5f64.copysign(change)) as i64).max(0);
        let hits = then(bucket.hits, change[3]);
        more += hits - bucket.hits;
        *bucket = Bucket { energy: std::array::from_fn(|channel| then(bucket.energy[channel], change[channel])), hits };
    });
    more
}

fn light(Bucket { energy: [red, green, blue], hits }: Bucket) -> Light {
    [red as f64, green as f64, blue as f64, hits as f64]
}

fn energy(light: &Light) -> f64 {
    light[0] + light[1] + light[2]
}

/// Cells of one side of an object.
struct Block<'e> {
    /// By page and cell: what was there, and what is.
    pages: Vec<Vec<[Light; 2]>>,
    /// By cell.
    events: &'e [u32],
    ratio: f64,
}

/// How light goes on that is not known better.
struct Trend {
    /// Of each page, the share of its light that comes.
    shares: Vec<Light>,
    /// Deposits that went and came for each unit of energy.
    events: f64,
}

/// What is known of a page on some cells.
#[derive(Clone, Copy, Default)]
struct Known {
    /// The light that is there.
    now: Light,
    /// What comes if it goes on as it did there.
    own: Light,
    /// What comes by the trend.
    usual: Light,
}

impl Block<'_> {
    /// Goes on as `trend` says but for what deviates from it by more than chance, so many cells together, then fewer. `change` hears of what comes on
    /// each page and cell.
    fn follow(&self, cells: Range<usize>, together: &[usize], trend: &Trend, change: &mut impl FnMut(usize, usize, Light)) {
        let [size, finer @ ..] = together else { return };
        let mut known = vec![Known::default(); self.pages.len()];
        let mut next = Trend { shares: trend.shares.clone(), events: 0.0 };
        for start in cells.clone().step_by(*size) {
            let some = start..(start + size).min(cells.end);
            let (mut deviation, mut all, mut lit, mut hits) = (0.0, 0.0, 0.0, 0.0);
            for ((known, share), page) in known.iter_mut().zip(&trend.shares).zip(&self.pages) {
                let [mut was, mut now] = [Light::default(); 2];
                for cell in &page[some.clone()] {
                    for k in 0..4 {
                        was[k] += cell[0][k];
                        now[k] += cell[1][k];
                    }
                }
                let own = std::array::from_fn(|k| self.ratio * (now[k] - was[k]));
                *known = Known { now, own, usual: std::array::from_fn(|k| share[k] * now[k]) };
                deviation += energy(&known.own) - energy(&known.usual);
                (all, lit, hits) = (all + energy(&now) + energy(&was), lit + energy(&now), hits + now[3] + was[3]);
            }
            let events: u32 = self.events[some.clone()].iter().sum();
            // Of so many events, all of the usual energy; where there were none, as many as there are with the neighbours.
            let expected = f64::from(events).max(trend.events * lit);
            let variance = expected * (self.ratio * all / f64::max(hits, 1.0)).powi(2);
            let certain = if deviation == 0.0 { 0.0 } else { (1.0 - SURE.powi(2) * variance / deviation.powi(2)).max(0.0) };
            let comes = |Known { own, usual, .. }: &Known| std::array::from_fn(|k| usual[k] + certain * (own[k] - usual[k]));
            if finer.is_empty() {
                known.iter().enumerate().for_each(|(page, known)| change(page, start, comes(known)));
                continue;
            }
            for (share, known) in next.shares.iter_mut().zip(&known) {
                let (now, comes): (_, Light) = (known.now, comes(known));
                *share = std::array::from_fn(|k| if now[k] > 0.0 { comes[k] / now[k] } else { 0.0 });
            }
            next.events = f64::from(events) / lit.max(1.0);
            self.follow(some, finer, &next, change);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bucket::Address;
    use lightmend_scene::{Configuration, Scene};

    /// Light that went from `was` to `now` hits of energy 10 on cells of the same object, by so many events each, and goes on twice as far.
    fn then(changes: &[(i64, i64, u32)]) -> Vec<i64> {
        let path = format!("{}/../../scenes/room/room.ron", env!("CARGO_MANIFEST_DIR"));
        let room = Configuration::initial(&Scene::read(path.as_ref()).unwrap().0);
        let object = room.objects().find(|(_, object)| object.lattice.cells() >= 32).unwrap().0;
        let (mut before, mut now) = (Buckets::new(&room), Buckets::new(&room));
        let mut events = vec![[0; 2]; 2 * room.object(object).lattice.cells() as usize];
        for (cell, (was, is, went)) in changes.iter().enumerate() {
            let at = Address { object: object as u32, cell: cell as u32, side: 1, lamp: 0 };
            before.set(at, Bucket { energy: [10 * was; 3], hits: *was });
            now.set(at, Bucket { energy: [10 * is; 3], hits: *is });
            events[2 * cell + 1] = [*went, 0];
        }
        let (all, mut then) = (now.deposits(), now.clone());
        then.go_on(&before, 2.0, |of| if of == object { &events } else { &[] });
        let page = then.get(object, 1, 0).unwrap();
        assert!(
            page.iter().all(|bucket| (bucket.energy[0] - 10 * bucket.hits).abs() <= 5),
            "hits and energy go together but for rounding"
        );
        assert_eq!(
            then.deposits() - all,
            page.iter().zip(now.get(object, 1, 0).unwrap()).map(|(a, b)| a.hits - b.hits).sum::<i64>()
        );
        page[..changes.len()].iter().map(|bucket| bucket.hits).collect()
    }

    #[test]
    fn light_goes_on_as_far_as_it_is_certain() {
        // A hundred hits went by a hundred events: ten standard errors. Four by four: two.
        let [far, chance] = [(1000, 900, 100), (1000, 996, 4)].map(|change| then(&[change])[0]);
        assert!((700..=710).contains(&far), "{far}");
        assert_eq!(chance, 996);
        // As many came as went.
        assert_eq!(then(&[(1000, 1000, 100)]), [1000]);
        assert_eq!(then(&[(100, 0, 100)]), [0], "no light is less than none");
    }

    #[test]
    fn neighbours_tell_what_a_cell_does_not() {
        let alike = then(&[(100, 96, 4); 16]);
        assert!(alike.iter().all(|hits| (88..=90).contains(hits)), "{alike:?}");
        // Of the last one it is known that it does not change: sixteen of its hits should have gone.
        let mut one = [(100, 84, 16); 16];
        one[15] = (100, 100, 0);
        let stays = then(&one)[15];
        assert!(stays > 90, "{stays}");
    }
}
