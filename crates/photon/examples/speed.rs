//! How fast photons are traced, in one run: the rays of a pool alone, then the pool with all that belongs to it.
//!
//! `cargo run --release -p lightmend-photon --example speed -- SCENE [PHOTONS]` (one thread). Only the ratios carry over to another
//! machine or moment.

use lightmend_photon::{
    body::TreePreset,
    halton::{Scrambling, Sequence},
    path::{End, FirstHits, Record, Rules, trace},
    pool::{PhotonIndex, Pool},
    solution::Solution,
    triangle::{Hit, Ray},
    world::World,
};
use lightmend_scene::{Configuration, Scene};
use std::{error::Error, hint::black_box, sync::Arc, time::Instant};

/// Remembers where the rays of paths start and where they go.
#[derive(Default)]
struct Segments {
    points: Vec<glam::Vec3>,
    starts: Vec<usize>,
}

impl Record for Segments {
    fn hit(&mut self, hit: &Hit, _: u8, _: glam::Vec3, _: u16, _: bool, _: &World) {
        self.points.push(hit.triangle.point(hit.weights));
    }
    fn end(&mut self, _: End, _: glam::Vec3, _: u16) {}
    fn ray(&mut self) {}
}

fn main() -> Result<(), Box<dyn Error>> {
    let mut arguments = std::env::args().skip(1);
    let path = arguments.next().ok_or("usage: speed SCENE [PHOTONS]")?;
    let photons: u64 = arguments.next().map_or(Ok(1_152_000), |n| n.parse())?;
    rayon::ThreadPoolBuilder::new().num_threads(1).build_global()?;
    let (scene, _) = Scene::read(path.as_ref())?;
    let world = Arc::new(World::new(&Configuration::initial(&scene), TreePreset::default()));
    let pool = Pool::new(photons, 288, 16, Scrambling::Seed(1))?;
    let rules = Rules { sequence: Sequence::new(pool.scrambling), first_hits: FirstHits::Always };
    println!("{}: {} triangles, {} elements, {photons} photons, 1 thread", scene.name, scene.triangles(), scene.cells());

    let mut segments = Segments::default();
    for class in 0..288 {
        for index in (class..photons.min(200_000)).step_by(288) {
            segments.starts.push(segments.points.len());
            let Some((lamp, _)) = world.choice().choose(rules.sequence.value(index, 0)) else { continue };
            segments.points.push(world.lamps()[lamp].position.as_vec3());
            trace(&rules, &world, PhotonIndex(index), &mut segments);
        }
    }
    segments.starts.push(segments.points.len());
    let rays: Vec<Ray> = segments
        .starts
        .windows(2)
        .flat_map(|path| segments.points[path[0]..path[1]].windows(2))
        .map(|ends| Ray::new(ends[0].lerp(ends[1], 1e-4), ends[1] - ends[0], None, 0.0))
        .collect();

    for round in 0..3 {
        let start = Instant::now();
        for ray in &rays {
            black_box(world.nearest(ray));
        }
        let alone = rays.len() as f64 / start.elapsed().as_secs_f64() / 1e6;
        let start = Instant::now();
        let mut traced = 0;
        let solution = Solution::shoot(pool, world.clone(), FirstHits::Always, &mut |_, rays| {
            traced += rays;
            true
        });
        black_box(solution.map(|s| s.buckets().bytes()));
        let whole = traced as f64 / start.elapsed().as_secs_f64() / 1e6;
        println!("round {round}: rays alone {alone:.2} Mrays/s, whole pool {whole:.2} Mrays/s, ratio {:.2}", whole / alone);
    }
    Ok(())
}
