//! Many deposits at once: each page is looked for, and made its own if a snapshot shares it, once and not for every deposit.

use super::{Address, Bucket, Buckets, Deposit, dark};
use std::sync::Arc;

/// A page while deposits are counted.
enum Page<'b> {
    /// No deposit has come yet.
    Closed(&'b mut Option<Arc<[Bucket]>>),
    Open(&'b mut [Bucket]),
}

/// All pages side by side.
pub(super) struct Table<'b> {
    /// Cells of each object.
    cells: &'b [u32],
    /// Pages of an object.
    width: usize,
    pages: Vec<Page<'b>>,
}

impl<'b> Table<'b> {
    pub(super) fn new(buckets: &'b mut Buckets) -> Table<'b> {
        let width = buckets.width();
        Table { cells: &buckets.cells, width, pages: buckets.pages.iter_mut().flatten().map(Page::Closed).collect() }
    }

    /// Adds deposits `sign` times.
    pub(super) fn count(&mut self, deposits: &[Deposit], sign: i64) {
        for deposit in deposits {
            let Address { object, cell, side, lamp } = deposit.to;
            let within = 2 * usize::from(lamp) + usize::from(side);
            // It would be another object's page.
            assert!(within < self.width, "a deposit from a lamp that is not there");
            let page = &mut self.pages[object as usize * self.width + within];
            if let Page::Closed(_) = page {
                page.open(self.cells[object as usize]);
            }
            if let Page::Open(buckets) = page {
                buckets[cell as usize].count(deposit, sign);
            }
        }
    }
}

impl Page<'_> {
    #[cold]
    fn open(&mut self, cells: u32) {
        *self = match std::mem::replace(self, Page::Open(&mut [])) {
            Page::Closed(page) => Page::Open(Arc::make_mut(page.get_or_insert_with(|| dark(cells)))),
            open => open,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bucket::{CAPACITY, Full};
    use lightmend_scene::{Configuration, Scene};
    use std::iter::{empty, once};

    fn room() -> Configuration {
        let path = format!("{}/../../scenes/room/room.ron", env!("CARGO_MANIFEST_DIR"));
        Configuration::initial(&Scene::read(path.as_ref()).unwrap().0)
    }

    /// Deposits on every object but the first, no two with the same energy.
    fn scattered(room: &Configuration, count: usize) -> Vec<Deposit> {
        let deposit = |n: usize| {
            let object = 1 + n * 7 % (room.object_slots() - 1);
            let cell = (n * 31) as u32 % room.object(object).lattice.cells();
            let (side, lamp) = ((n / 3 % 2) as u8, (n / 5 % room.lamp_slots()) as u16);
            Deposit { to: Address { object: object as u32, cell, side, lamp }, energy: [n as u32, 3 * n as u32 + 1, 1 << 24] }
        };
        (0..count).map(deposit).collect()
    }

    #[test]
    fn many_at_once_are_what_they_are_one_by_one() {
        let room = room();
        let deposits = scattered(&room, 20_000);
        let mut single = Buckets::new(&room);
        let border = single.few() as usize;
        assert!((100..10_000).contains(&border));
        deposits.iter().for_each(|deposit| single.add(&[*deposit]).unwrap());
        for size in [border - 1, border, border + 1, deposits.len()] {
            let mut many = Buckets::new(&room);
            deposits.chunks(size).for_each(|batch| many.add(batch).unwrap());
            assert!(many == single && many.deposits() == 20_000, "by {size}");
            assert_eq!(many.bytes(), single.bytes());
        }
        let (first, rest) = deposits.split_at(5_000);
        let mut exchanged = Buckets::new(&room);
        exchanged.add(first).unwrap();
        exchanged.exchange(first.chunks(17), rest.chunks(1_000)).unwrap();
        exchanged.exchange(empty(), once(first)).unwrap();
        assert!(exchanged == single && exchanged.deposits() == 20_000);
    }

    #[test]
    fn a_snapshot_keeps_its_light_and_shares_the_rest() {
        let room = room();
        for count in [10, 20_000] {
            let mut buckets = Buckets::new(&room);
            let untouched = Address { object: 0, cell: 0, side: 1, lamp: 0 };
            buckets.set(untouched, Bucket { energy: [1, 2, 3], hits: 1 });
            buckets.add(&scattered(&room, count)).unwrap();
            let (snapshot, copy) = (buckets.clone(), buckets.lit().collect::<Vec<_>>());
            buckets.add(&scattered(&room, count)).unwrap();
            assert!(snapshot.lit().eq(copy) && snapshot != buckets, "{count}");
            let page = |buckets: &Buckets, object| buckets.get(object, 1, 0).map(<[Bucket]>::as_ptr);
            assert_eq!(page(&buckets, 0), page(&snapshot, 0));
            assert!(page(&buckets, 0).is_some() && buckets.get(0, 0, 0).is_none());
        }
    }

    #[test]
    fn what_does_not_fit_is_refused_whole_and_what_goes_makes_room() {
        let room = room();
        for count in [10, 20_000] {
            let deposits = scattered(&room, count);
            let mut buckets = Buckets::new(&room);
            buckets.add(&deposits).unwrap();
            let at = Address { object: 0, cell: 0, side: 0, lamp: 0 };
            buckets.set(at, Bucket { energy: [0; 3], hits: CAPACITY - count as i64 });
            let before = buckets.clone();
            let one_more = [&*deposits, &deposits[..1]];
            assert_eq!(buckets.exchange(once(&*deposits), one_more.into_iter()), Err(Full));
            assert!(buckets == before && buckets.deposits() == CAPACITY);
            buckets.exchange(once(&*deposits), once(&*deposits)).unwrap();
            assert!(buckets == before && buckets.deposits() == CAPACITY);
        }
    }

    #[test]
    #[should_panic(expected = "a lamp that is not there")]
    fn no_light_goes_to_the_next_object() {
        let room = room();
        let mut deposits = scattered(&room, 20_000);
        deposits[19_000].to.lamp = room.lamp_slots() as u16;
        Buckets::new(&room).add(&deposits).unwrap();
    }
}
