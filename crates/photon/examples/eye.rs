//! prototype
use glam::Vec3;
use lightmend_photon::{
    body::TreePreset, course::Course, field::{Field, Side}, halton::Scrambling, importance::Gaze, irradiance::Scale, ledger::LedgerSolution, path::FirstHits, pool::Pool,
    reconstruction::{Reconstruction, Shapes}, solution::Solution, visible::Visible, world::World,
};
use lightmend_scene::{Configuration, Moves, Scene, luminance};
use std::{sync::Arc, time::Instant};
fn step(l: f64) -> f64 {
    let log = l.max(1e-30).log10();
    10f64.powf(match log {
        l if l < -3.94 => -2.86,
        l if l < -1.44 => (0.405 * l + 1.6).powf(2.18) - 2.86,
        l if l < -0.0184 => l - 0.395,
        l if l < 1.9 => (0.249 * l + 0.65).powf(2.7) - 0.72,
        l => l - 1.255,
    })
}
fn main() {
    let a: Vec<String> = std::env::args().skip(1).collect();
    let (scene, _) = Scene::read(a[0].as_ref()).unwrap();
    let (moves, _) = Moves::read(a[1].as_ref(), &scene).unwrap();
    let photons: u64 = a[2].parse().unwrap();
    let cams: Vec<&str> = a.get(3).map_or(vec![], |c| c.split(',').filter(|c| !c.is_empty()).collect());
    let by_items = a.get(4).is_none_or(|g| g == "items");
    let mut configuration = Configuration::initial(&scene);
    let world = Arc::new(World::new(&configuration, TreePreset::default()));
    let pool = Pool::new(photons, 288, 16, Scrambling::Seed(1)).unwrap();
    let mut ledger = LedgerSolution::shoot(pool, world.clone(), FirstHits::AsLampsSay, u64::MAX, &mut |_, _| true).unwrap();
    let mut shapes = Shapes::default();
    for timed in &moves.edits {
        configuration = configuration.apply(&timed.edit).unwrap();
        let after = Arc::new(ledger.world().moved_to(&configuration));
        let fresh = Solution::shoot(pool, after.clone(), FirstHits::AsLampsSay, &mut |_, _| true).unwrap();
        let scale = Scale::new(&after, photons);
        shapes.learn(&configuration);
        let t = Instant::now();
        let read = |b: &lightmend_photon::bucket::Buckets| {
            let light = Reconstruction::new(&shapes, &configuration, b, &scale, configuration.lamp_slots());
            Field::read(&after, |object, cell, side| Side { irradiance: light.cell(object, cell, side).value, area: 1.0, hits: 0 })
        };
        read(fresh.buckets());
        println!("reconstruction {:.3} s", t.elapsed().as_secs_f64());
        let mut end = None;
        for (camera, view) in &scene.cameras {
            if !cams.is_empty() && !cams.contains(&camera.as_str()) { continue; }
            let t = Instant::now();
            let visible = Visible::new(&after, view);
            let look = t.elapsed().as_secs_f64();
            let lum = |v: &[[f32; 3]]| -> Vec<f64> { visible.radiance(v).iter().map(|r| luminance(r.as_dvec3())).collect() };
            let raw = visible.values(fresh.buckets(), &scale);
            let rl = lum(&raw);
            let pixels: Vec<f64> = { let (_, _, p) = visible.picture(); let mut c = vec![0.0; rl.len()]; p.flatten().for_each(|s| c[s] += 1.0); c };
            let share = |now: &[f64], right: &[f64]| { now.iter().zip(right).zip(&pixels).filter(|((n, r), _)| (**n - **r).abs() > step(**r)).map(|(_, p)| p).sum::<f64>() / 76800.0 };
            let mut seen_objects = vec![false; configuration.object_slots()];
            visible.ids().iter().for_each(|i| seen_objects[i.0] = true);
            let shown = |b: &lightmend_photon::bucket::Buckets| {
                let light = Reconstruction::of_objects(&shapes, &configuration, b, &scale, configuration.lamp_slots(), |id| seen_objects[id]);
                lum(&visible.ids().iter().map(|(o, c, s)| light.cell(*o, *c, *s).value.as_vec3().to_array()).collect::<Vec<_>>())
            };
            let mut course = Course::ledger(&ledger);
            course.change(after.clone()).unwrap();
            { course.watch(); };
            if by_items { course.look(&Gaze::Sides(visible.importance(&after, |_| 1.0).into())); }
            let ids = visible.ids();
            println!("{camera}: item buffer {look:.3} s, {} sides seen", ids.len());
            let mut next = 0.0;
            loop {
                let done = course.step().unwrap().is_none();
                if done || course.share() >= next {
                    let t = Instant::now();
                    let pending = course.pending().unwrap();
                    let cost = t.elapsed().as_secs_f64();
                    let t = Instant::now();
                    let values = visible.values(course.light(), &scale);
                    let now = lum(&values);
                    let drawn = pending.draw(course.light(), |id| seen_objects[id]);
                    let cost1 = t.elapsed().as_secs_f64();
                    let raw_est = share(&now, &lum(&visible.values(&drawn, &scale)));
                    let t = Instant::now();
                    let after_shown = shown(&drawn);
                    let cost_rec = t.elapsed().as_secs_f64();
                    let now_shown = shown(course.light());
                    let shown_est = share(&now_shown, &after_shown);
                    let rec = share(&now_shown, &shown(fresh.buckets()));
                    println!("{:6.1} %  r {:8.3}  raw {:8.4} %  told {:8.4} %  shown {:8.4} %  told {:8.4} %  {:.1} + {:.1} + {:.1} ms", course.share() * 100.0, pending.ratio(), share(&now, &rl) * 100.0, raw_est * 100.0, rec * 100.0, shown_est * 100.0, cost * 1e3, cost1 * 1e3, cost_rec * 1e3);
                    next = course.share() + if course.share() < 0.7 { 0.1 } else { 0.02 };
                }
                if done { break; }
            }
            end = Some(course.finish().unwrap().1.unwrap());
        }
        let Some(l) = end else { return };
        ledger = l;
    }
    let _ = Vec3::ZERO;
}
