//! 10. Accumulation: exact sums in any order, and no sum that can overflow.

use glam::DVec3;
use lightmend_photon::{
    body::TreePreset,
    bucket::{Address, Bucket, Buckets, CAPACITY, Deposit, ENERGY_BITS, Full, MOST_DEPOSITS, energy},
    halton::Scrambling,
    path::{FirstHits, LONGEST_PATH},
    pool::Pool,
    saved::Saved,
    shooting::Shooting,
    solution::Solution,
    world::World,
};
use lightmend_scene::{Configuration, Edit, Scene};
use lightmend_tests::{Builder, count, pool, shoot, table::Row, world};
use rayon::prelude::*;
use std::sync::Arc;

const LARGEST: u64 = 1 << ENERGY_BITS;

fn room() -> Arc<Scene> {
    Builder::default().cuboid("room", 0.5, [0.0; 3], [4.0, 3.0, 2.5], true).lamp([1.0, 1.2, 2.1], 100.0).build(&[])
}

/// Deposit number `n`: all cells of the room in turn, any energy from nothing to the largest.
fn deposit(n: u64) -> Deposit {
    let to = Address { object: 0, cell: (n % 12) as u32, side: 0, lamp: 0 };
    let energy = [n % (LARGEST + 1), LARGEST, (n * 7919) % 1021].map(|e| e as u32);
    Deposit { to, energy }
}

/// The exact sums of the first `n` deposits: in whole periods of each channel, and what is left one by one.
fn exact(n: u64) -> [u128; 3] {
    let series = |period: u64, term: &dyn Fn(u64) -> u64| {
        let (whole, rest) = (n / period, n % period);
        let sum = |end: u64| (0..end).map(|i| u128::from(term(i))).sum::<u128>();
        u128::from(whole) * sum(period) + sum(rest)
    };
    [series(LARGEST + 1, &|i| i), u128::from(n) * u128::from(LARGEST), series(1021, &|i| (i * 7919) % 1021)]
}

fn total(buckets: &Buckets) -> [u128; 3] {
    buckets.lit().fold([0; 3], |sum, (_, b)| std::array::from_fn(|c| sum[c] + b.energy[c] as u128))
}

/// Adds deposits in the order of `numbers`, a thousand at a time.
fn add(buckets: &mut Buckets, numbers: impl Iterator<Item = u64>) {
    let mut batch = Vec::with_capacity(1000);
    for n in numbers {
        batch.push(deposit(n));
        if batch.len() == 1000 {
            buckets.add(&batch).unwrap();
            batch.clear();
        }
    }
    buckets.add(&batch).unwrap();
}

pub fn rows() -> Vec<Row> {
    let scene = room();
    let configuration = Configuration::initial(&scene);
    let n = count(10_000_000, 10_000_000_000);
    let right = exact(n).map(|e| e.to_string()).join(", ");
    let case = format!("{n} deposits");
    let mut rows = Vec::new();
    let mut all: Vec<Buckets> = Vec::new();
    for (order, threads) in
        [("one after the other", 1u64), ("in 2 threads, interleaved", 2), ("in 7 threads, interleaved, backwards", 7)]
    {
        let parts: Vec<Buckets> = (0..threads)
            .into_par_iter()
            .map(|thread| {
                let mut own = Buckets::new(&configuration);
                let turns = (n - thread).div_ceil(threads);
                let number = |turn: u64| thread + turn * threads;
                if threads == 7 {
                    add(&mut own, (0..turns).rev().map(number))
                } else {
                    add(&mut own, (0..turns).map(number))
                }
                own
            })
            .collect();
        let mut sum = Buckets::new(&configuration);
        parts.iter().rev().for_each(|part| sum.merge(part).unwrap());
        rows.push(Row::exactly(
            &case,
            &format!("sums {order}"),
            right.clone(),
            "arithmetic series, 128 bits",
            total(&sum).map(|e| e.to_string()).join(", "),
        ));
        all.push(sum);
    }
    let differ = all.iter().filter(|sum| **sum != all[0]).count();
    rows.push(Row::exactly(&case, "orders whose buckets differ", 0, "sums are exact", differ));
    rows.extend(capacity(&configuration));
    rows.push(full(&scene));
    let (said, same) = refused_repair();
    let case = "a repair that brings more than fits";
    let refused = Full.to_string();
    rows.push(Row::exactly(case, "what is said", refused, "refused in one line", said));
    rows.push(Row::exactly(case, "whether the light is as before", true, "nothing of it is added", same));
    rows.push(residue(&scene));
    rows
}

/// What fits, by arithmetic.
fn capacity(configuration: &Configuration) -> Vec<Row> {
    let case = "capacity of a sum";
    let slab = u128::from(Shooting::SLAB) * u128::from(LONGEST_PATH);
    let most = (MOST_DEPOSITS as u128 + slab) * u128::from(LARGEST);
    let share = most as f64 / i64::MAX as f64;
    let largest = energy(glam::Vec3::ONE)[0];
    let fit = i64::MAX as u64 / LARGEST;
    let mut one = Buckets::new(configuration);
    let at = deposit(0).to;
    let before = MOST_DEPOSITS * LARGEST as i64;
    one.set(at, Bucket { energy: [before; 3], hits: MOST_DEPOSITS });
    one.add(&[Deposit { to: at, energy: [LARGEST as u32; 3] }]).unwrap();
    let after = one.get(0, 0, 0).map_or(0, |page| page[0].energy[0]);
    let refused =
        Pool::new(MOST_DEPOSITS as u64 + 1, 288, 16, Scrambling::Seed(1)).err().map_or("none".into(), |e| e.to_string());
    vec![
        Row::exactly(case, "a photon that has lost nothing", LARGEST as u32, "2²⁴: the largest quantum", largest),
        Row::exactly(case, "largest quanta that fit", (1u64 << 39) - 1, "⌊(2⁶³ − 1) / 2²⁴⌋, 55 times 10¹⁰", fit),
        Row::at_most(
            case,
            "the fullest bucket that can be, as a share of 2⁶³",
            "(2³⁸ + a slab of 294,912 paths of 65,536 hits) · 2²⁴",
            share,
            1.0,
        ),
        Row::exactly(case, "the sum after 2³⁸ + 1 largest quanta", before + LARGEST as i64, "integers", after),
        Row::exactly(
            "a pool of 2³⁸ + 1 photons",
            "what is said",
            format!("{} photons are too many: the limit is {MOST_DEPOSITS}", MOST_DEPOSITS + 1),
            "refused in one line",
            refused,
        ),
    ]
}

/// A pool whose buckets can count no more.
fn full(scene: &Arc<Scene>) -> Row {
    let world = world(scene);
    let pool = pool(50_000);
    let shot = shoot(pool, &world, FirstHits::Always);
    let Saved { mut buckets, tallies, photons, scrambling, copies, first_hits } = shot.to_saved().unwrap();
    buckets.set(deposit(0).to, Bucket { energy: [1 << 62; 3], hits: MOST_DEPOSITS });
    let saved = Saved { buckets, tallies, photons, scrambling, copies, first_hits };
    let mut resumed = Solution::resume(pool.grown(60_000), world, saved, &mut |_, _| true).unwrap();
    let grown = resumed.grow(1000).map_or(0, |work| work.photons);
    let quantity = "photons after it was asked for 60,000, and after 1,000 more";
    let measured = format!("{}, {}", resumed.pool().photons() - grown, resumed.pool().photons());
    Row::exactly(
        "50,000 photons, one bucket holding 2³⁸ hits",
        quantity,
        "50000, 50000".to_owned(),
        "not one is shot that might not be counted",
        measured,
    )
}

/// A repair in buckets that are full to the last: what is said, and whether the light is as it was.
pub fn refused_repair() -> (String, bool) {
    let builder = Builder::default().cuboid("room", 0.5, [0.0; 3], [4.0, 3.0, 2.5], true);
    let builder = builder.cuboid("box", 0.5, [1.0, 1.0, 0.5], [2.0, 2.0, 1.0], false).lamp([1.2, 1.3, 2.1], 100.0);
    let home = Configuration::initial(&builder.build(&[]));
    // Of a brighter box each photon goes on that went on before, and others too: hits are only ever added.
    let bright = home.apply(&Edit::Reflect { material: "of box".into(), to: DVec3::ONE }).unwrap();
    let world = Arc::new(World::new(&home, TreePreset::default()));
    let pool = pool(50_000);
    let mut saved = shoot(pool, &world, FirstHits::Always).to_saved().unwrap();
    let Deposit { to, .. } = deposit(0);
    let bucket = saved.buckets.get(0, 0, 0).map_or(Bucket::default(), |page| page[to.cell as usize]);
    let left = CAPACITY - saved.buckets.deposits();
    saved.buckets.set(to, Bucket { hits: bucket.hits + left, ..bucket });
    let mut solution = Solution::resume(pool, world.clone(), saved, &mut |_, _| true).unwrap();
    solution.change(Arc::new(world.moved_to(&bright)));
    loop {
        let before = solution.buckets().clone();
        match solution.repair_next() {
            Ok(Some(_)) => {}
            Ok(None) => return ("nothing".into(), true),
            Err(full) => return (full.to_string(), *solution.buckets() == before),
        }
    }
}

/// What is added and taken away leaves nothing.
fn residue(scene: &Arc<Scene>) -> Row {
    let solution = shoot(pool(20_000), &world(scene), FirstHits::Always);
    let mut buckets = solution.buckets().clone();
    let deposits: Vec<Deposit> = (0..1_000_000).map(deposit).collect();
    let back: Vec<Deposit> = deposits.iter().rev().copied().collect();
    buckets.add(&deposits).unwrap();
    buckets.exchange(std::iter::once(&*back), std::iter::empty()).unwrap();
    let left: DVec3 = buckets
        .lit()
        .zip(solution.buckets().lit())
        .map(|((_, a), (_, b))| DVec3::from_array(std::array::from_fn(|c| (a.energy[c] - b.energy[c]) as f64)))
        .sum();
    Row::exactly(
        "a million deposits, taken back backwards",
        "what is left",
        0.0,
        "integers",
        if buckets == *solution.buckets() { left.length() } else { f64::INFINITY },
    )
}
