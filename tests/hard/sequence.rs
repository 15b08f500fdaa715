//! 9. Sequence: indices about 2³², lamps that do not divide the interval, large and tiny groups.

use crate::sound::{self, Space};
use glam::DVec3;
use lightmend_photon::{
    body::TreePreset,
    bucket::ENERGY_BITS,
    halton::{DIMENSIONS, INDEX_LIMIT, RadicalInverse, Scrambling, primes},
    irradiance::Scale,
    path::{FirstHits, Rules, trace},
    pool::{GroupId, PhotonIndex, Pool},
    record::Outcome,
    world::World,
};
use lightmend_scene::{Configuration, Edit, Scene};
use lightmend_tests::{Builder, count, own_scene, shoot, sphere, table::Row, world};
use std::sync::Arc;

pub fn rows() -> Vec<Row> {
    let mut rows = numerators();
    rows.extend(past_32_bits());
    for lamps in [3, 5, 7, 100] {
        rows.extend(lamps_of(lamps));
    }
    rows.extend(groups());
    rows
}

/// Φ_b(i) of every base against whole numbers of 128 bits.
fn numerators() -> Vec<Row> {
    let middle = 1u64 << 32;
    let indices: Vec<u64> = [0, middle - 2, middle - 1, middle, middle + 1, middle + 12_345, INDEX_LIMIT - 1].into();
    let (mut wrong, mut not_below_one, mut inexact) = (0, 0, 0);
    for base in primes().take(DIMENSIONS) {
        let inverse = RadicalInverse::new(base, Scrambling::None);
        inexact += usize::from(inverse.denominator() >= 1 << 53);
        for index in &indices {
            let (mut rest, mut numerator, mut denominator) = (*index, 0u128, 1u128);
            while rest > 0 {
                numerator = numerator * u128::from(base) + u128::from(rest % base);
                denominator *= u128::from(base);
                rest /= base;
            }
            wrong +=
                usize::from(u128::from(inverse.numerator(*index)) * denominator != numerator * u128::from(inverse.denominator()));
            not_below_one += usize::from(!(0.0..1.0).contains(&inverse.value(*index)));
        }
    }
    let case = "64 bases at 2³² − 2 … 2³² + 12,345 and the last index";
    let quantity = "wrong numerators; values not in [0, 1); denominators of more than 53 bits";
    let mut rows = vec![Row::exactly(
        case,
        quantity,
        "0; 0; 0".to_owned(),
        "whole numbers of 128 bits",
        format!("{wrong}; {not_below_one}; {inexact}"),
    )];
    // Photons of a group about the last index of 32 bits: one elementary interval still.
    let groups: u64 = 2u64.pow(10) * 3u64.pow(5);
    let mut apart = 0;
    for scrambling in [Scrambling::None, Scrambling::Seed(3)] {
        for (base, power) in [(2u64, 10u32), (3, 5)] {
            let inverse = RadicalInverse::new(base, scrambling);
            let interval = inverse.denominator() / base.pow(power);
            for group in 0..count(2_000, groups) {
                let first = inverse.numerator(group) / interval;
                let past = (middle / groups) * groups;
                apart += (0..4).filter(|m| inverse.numerator(past + m * groups + group) / interval != first).count();
            }
        }
    }
    let case = "N_g = 2¹⁰3⁵ = 248,832, past 2³²";
    rows.push(Row::exactly(case, "photons outside their group's elementary interval", 0, "Eq. 3 of the seed", apart));
    rows
}

/// Paths of photons whose indices straddle 2³².
fn past_32_bits() -> Vec<Row> {
    let rho = f64::from(0.8f32);
    let (points, triangles) = sphere(3);
    let scene = Builder::default().object("sphere", 0.8, points, triangles).lamp([0.4, 0.1, -0.2], 100.0).build(&[]);
    let world = world(&scene);
    let photons = count(100_000, 5_000_000);
    let pool = lightmend_tests::pool(photons);
    let rules = Rules { sequence: pool.sequence(), first_hits: FirstHits::Always };
    let mut outcome = Outcome::new(1, false);
    let middle = 1u64 << 32;
    (middle - photons / 2..middle + photons / 2).for_each(|i| trace(&rules, &world, PhotonIndex(i), &mut outcome));
    let got = outcome.deposits.len() as f64 / photons as f64 - 1.0;
    let case = "sphere of reflectance 0.8, photons about 2³²";
    let lost = outcome.tallies[0].escaped + outcome.tallies[0].cut;
    vec![
        Row::near(
            case,
            "indirect ÷ direct flux",
            rho / (1.0 - rho),
            "ρ / (1 − ρ); 4 standard errors",
            got,
            4.0 / (rho * photons as f64).sqrt(),
        ),
        Row::exactly(case, "photons lost", 0, "closed", lost),
    ]
}

/// A black sphere about so many lamps of different strength.
fn lamps_of(lamps: usize) -> Vec<Row> {
    let (points, triangles) = sphere(3);
    let mut builder = Builder::default().object("sphere", 0.0, points, triangles);
    for n in 0..lamps {
        let place = DVec3::new((n as f64 * 0.7).sin(), (n as f64 * 1.3).cos(), (n as f64 * 2.1).sin()) * 0.3;
        builder = builder.lamp(place.to_array(), 10.0 + n as f64);
    }
    let scene = builder.build(&[]);
    let world = world(&scene);
    let groups = 72 * (lamps.clamp(1, 64).next_power_of_two() as u32);
    let photons = count(100_003, 5_000_003).max(u64::from(groups) * 20);
    let pool = Pool::new(photons, groups, 16, Scrambling::Seed(1)).unwrap();
    let case = format!("{lamps} lamps");
    let chances: f64 = (0..lamps).map(|l| world.choice().chance(l)).sum();
    let solution = shoot(pool, &world, FirstHits::Always);
    let scale = Scale::new(&world, photons);
    let mut got = vec![0.0; lamps];
    for (at, bucket) in solution.buckets().lit() {
        got[usize::from(at.lamp)] += bucket.energy[0] as f64 * scale.lumens(usize::from(at.lamp)).x;
    }
    // The points of a sequence in an interval of a power of two: one more or less.
    let worst = (0..lamps)
        .map(|l| {
            let expected = photons as f64 * world.choice().chance(l);
            (got[l] / scene.lamps[l].flux().x - 1.0).abs() * expected
        })
        .fold(0.0, f64::max);
    let sequence = pool.sequence();
    let straddle = (0..groups).map(GroupId).filter(|g| {
        let correctives = || pool.photons_of(*g).skip(pool.pilots_per_group() as usize).take(64);
        let lamp = |i: PhotonIndex| world.choice().choose(sequence.value(i.0, 0)).map(|(lamp, _)| lamp);
        let first = correctives().next().and_then(lamp);
        correctives().any(|i| lamp(i) != first)
    });
    let mut rows = vec![
        Row::exactly(&case, "sum of the lamps' chances", 1.0, "shares of a power of two", chances),
        Row::at_most(
            &case,
            "photons that a lamp has too many or too few, at most",
            "an elementary interval's share of a prefix",
            worst,
            (photons as f64).log2(),
        ),
    ];
    // Beyond 64 lamps groups stay at 4,608, and may be less fine than the lamps' shares.
    if lamps <= 64 {
        rows.push(Row::exactly(
            &case,
            "groups whose photons leave two lamps",
            0,
            "lamps' shares are elementary intervals",
            straddle.count(),
        ));
    }
    rows
}

/// Groups too many, too small, and larger than all photons.
fn groups() -> Vec<Row> {
    let mut rows = Vec::new();
    let scene = own_scene("cornell");
    let edit = Edit::Move { object: "short box".into(), to: DVec3::new(1.2, 0.9, 0.0) };
    let moved = Configuration::initial(&scene).apply(&edit).unwrap();
    // The large power with repair where there is time: as many groups as repairs.
    let (large, powers) = (count(10_368, 248_832), if count(0, 1) == 0 { "2⁷3⁴" } else { "2¹⁰3⁵" });
    let large_case = format!("N_g = {powers}, one photon a group and some over");
    let pools = [
        ("groups of one photon", 288, 288, 1, 1),
        ("groups of two, 64 copies", 2 * 288 * 64, 288, 1, 64),
        ("one group", 5_000, 1, 16, 1),
        (&large_case, large + 7, large as u32, 1, 1),
        ("N_g = 2·3·5·7·11, R = 1", 4_620, 2_310, 1, 1),
    ];
    for (case, photons, groups, ratio, copies) in pools {
        let pool = Pool::new(photons, groups, ratio, Scrambling::Seed(5)).unwrap().in_copies(copies).unwrap();
        let mut solution = shoot(pool, &world(&scene), FirstHits::AsLampsSay);
        solution.change(Arc::new(solution.world().moved_to(&moved)));
        while solution.repair_next().unwrap().is_some() {}
        let fresh = shoot(pool, &Arc::new(World::new(&moved, TreePreset::Fast)), FirstHits::AsLampsSay);
        let differ = usize::from(!solution.equals(&fresh)) + usize::from(sound::not_finite(&solution) > 0);
        rows.push(Row::exactly(
            case,
            "after a move and repair: bits other than a fresh solution's, or numbers not finite",
            0,
            "the signature invariant",
            differ,
        ));
        let members: u64 = (0..groups).map(|g| pool.photons_in(GroupId(g))).sum();
        rows.push(Row::exactly(case, "photons of all groups", photons, "each is in one", members));
    }
    let refused = Pool::new(287, 288, 1, Scrambling::None).err().map_or("nothing".to_owned(), |e| e.to_string());
    let right = "287 photons are too few for 288 groups with a pilot among 1 photons each: at least 288 are needed".to_owned();
    rows.push(Row::exactly("fewer photons than groups", "what is said", right, "refused in one line", refused));
    rows.push(sound::of(
        "N_g = 2³3²5·7, soundness",
        &Configuration::initial(&closed()),
        Space::Closed,
        Pool::new(20_160, 2520, 8, Scrambling::None).unwrap(),
    ));
    rows.push(unit());
    rows
}

fn closed() -> Arc<Scene> {
    Builder::default().cuboid("room", 0.5, [0.0; 3], [4.0, 3.0, 2.5], true).lamp([1.0, 1.2, 2.1], 100.0).build(&[])
}

/// The least pool, read out: one photon.
fn unit() -> Row {
    let pool = Pool::new(1, 1, 1, Scrambling::None).unwrap();
    let solution = shoot(pool, &world(&closed()), FirstHits::Always);
    let hits: i64 = solution.buckets().lit().map(|(_, b)| b.hits).sum();
    let energy: i64 = solution.buckets().lit().map(|(_, b)| b.energy[0]).sum();
    Row::exactly(
        "a pool of one photon",
        "energy of its hits, photons",
        hits as f64,
        "grey surfaces take nothing from a survivor",
        energy as f64 / f64::from(1u32 << ENERGY_BITS),
    )
}
