//! dev: shoots a pool alone.
use lightmend_photon::{body::TreePreset, halton::Scrambling, path::FirstHits, pool::Pool, solution::Solution, world::World};
use lightmend_scene::{Configuration, Scene};
fn main() {
    let a: Vec<String> = std::env::args().collect();
    rayon::ThreadPoolBuilder::new().num_threads(1).build_global().unwrap();
    let world =
        std::sync::Arc::new(World::new(&Configuration::initial(&Scene::read(a[1].as_ref()).unwrap().0), TreePreset::default()));
    let mut traced = 0u64;
    for _ in 0..a[2].parse::<u32>().unwrap() {
        Solution::shoot(
            Pool::new(400_000, 288, 16, Scrambling::Seed(1)).unwrap(),
            world.clone(),
            FirstHits::Always,
            &mut |_, r| {
                traced += r;
                true
            },
        );
    }
    println!("{traced}");
}
