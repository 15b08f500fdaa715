//! dev
use lightmend_photon::{body::TreePreset, halton::Scrambling, path::FirstHits, pool::Pool, solution::Solution, world::World};
use lightmend_scene::{Configuration, Scene};
fn main() {
    let a: Vec<String> = std::env::args().collect();
    let c = Configuration::initial(&Scene::read(a[1].as_ref()).unwrap().0);
    let world = std::sync::Arc::new(World::new(&c, TreePreset::default()));
    for (seed, copies) in [(1, 1), (7, 4)] {
        let s = Solution::shoot(Pool::new(a[2].parse().unwrap(), 288, 4, Scrambling::Seed(seed)).unwrap().in_copies(copies).unwrap(), world.clone(), FirstHits::Always, &mut |_, _| true).unwrap();
        let mut out = Vec::new();
        s.buckets().dump(&c, &mut out).unwrap();
        let h = out.iter().fold(0xcbf29ce484222325u64, |h, b| (h ^ u64::from(*b)).wrapping_mul(0x100000001b3));
        println!("{h:016x} {} bytes {:?}", out.len(), s.tallies().iter().map(|t| (t.absorbed, t.escaped, t.escaped_energy)).collect::<Vec<_>>());
    }
}
