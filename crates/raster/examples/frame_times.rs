//! Milliseconds per pass and frames per second, with nothing moving and with one object moving; of new indirect light; of showing the
//! picture.
//!
//! `cargo run --release -p lightmend-raster --example frame_times -- scenes/room/room.ron [object [folder for pictures]]`
//!
//! Indirect light is even, 50 lux on every side of every element, so that all of it is read. Every frame is waited for; medians of
//! 31 frames after 3 that are not counted.

use glam::DVec3;
use lightmend_raster::{Device, Indirect, Look, Mark, Parts, Renderer, Settings, Times, side_light};
use lightmend_scene::{Configuration, Edit, LatticePoints, Scene, View};
use std::{error::Error, path::Path, sync::Arc, time::Instant};

const FRAMES: usize = 31;

fn main() -> Result<(), Box<dyn Error>> {
    let mut arguments = std::env::args().skip(1);
    let path = arguments.next().ok_or("usage: speed SCENE [object [folder for pictures]]")?;
    let (scene, _) = Scene::read(Path::new(&path))?;
    let still = Configuration::initial(&scene);
    let object = match arguments.next() {
        Some(name) => name,
        None => scene.objects.iter().find(|o| o.movable).map(|o| o.name.clone()).ok_or("nothing is movable")?,
    };
    let folder = arguments.next();
    let mut renderer = Renderer::new(Device::headless()?.into())?;
    println!("{} on {}: {} triangles, {} elements", scene.name, renderer.device().name, scene.triangles(), scene.cells());
    renderer.show(&still)?;
    let even = |object: &lightmend_scene::Object| {
        let points = LatticePoints::new(&object.mesh, &object.lattice).count() as usize;
        [0, 1].map(|_| Some(side_light(&vec![[50.0; 3]; points])))
    };
    let indirect: Indirect = scene.objects.iter().map(|object| even(object)).collect();
    renderer.light(&indirect)?;
    let number = still.object_id(&object)?;
    light(&mut renderer, indirect, number)?;
    present(&mut renderer, &scene.cameras.first().ok_or("there is no camera")?.1, number)?;

    let from = still.object(number).pose.position;
    let moved = |frame: usize| {
        let to = from + DVec3::X * 0.01 * frame as f64;
        still.apply(&Edit::Move { object: object.clone(), to })
    };
    println!(
        "{:<14} {:>9} {:<22} {:>8} {:>8} {:>8} {:>8} {:>8} {:>8} {:>8} {:>7}",
        "camera", "size", "", "prepare", "prepass", "shadows", "compose", "exposure", "tone", "frame", "fps"
    );
    for (width, height) in [(640, 480), (1280, 720)] {
        for (name, view) in &scene.cameras {
            for (what, moving) in [("nothing moves".to_owned(), false), (format!("{object} moves"), true)] {
                let mut rows = Vec::new();
                for frame in 0..FRAMES + 3 {
                    let configuration = if moving { moved(frame)? } else { still.clone() };
                    let start = Instant::now();
                    renderer.show(&configuration)?;
                    let times = draw(&mut renderer, view, width, height)?;
                    rows.push((times, start.elapsed().as_secs_f64() * 1000.0));
                }
                let rows = &rows[3..];
                let median = |of: fn(&Times) -> f64| middle(rows.iter().map(|(times, _)| of(times)).collect());
                let frame = middle(rows.iter().map(|(_, whole)| *whole).collect());
                println!(
                    "{name:<14} {:>9} {what:<22} {:>8.2} {:>8.2} {:>8.2} {:>8.2} {:>8.2} {:>8.2} {frame:>8.2} {:>7.1}",
                    format!("{width}x{height}"),
                    median(|t| t.preparation),
                    median(|t| t.prepass),
                    median(|t| t.shadows),
                    median(|t| t.composition),
                    median(|t| t.exposure),
                    median(|t| t.tone),
                    1000.0 / frame
                );
            }
            if let Some(folder) = &folder {
                std::fs::create_dir_all(folder)?;
                renderer.show(&still)?;
                draw(&mut renderer, view, width, height)?;
                let pixels = renderer.picture()?.into_flattened();
                let picture = image::RgbImage::from_raw(width, height, pixels).ok_or("no pixels")?;
                picture.save(format!("{folder}/{} {name} {width}.png", scene.name))?;
            }
        }
    }
    Ok(())
}

/// New light for all sides, for one object, and for none.
fn light(renderer: &mut Renderer, mut indirect: Indirect, object: usize) -> Result<(), Box<dyn Error>> {
    let renew = |sides: &mut [Option<Arc<[[f32; 4]]>>; 2]| {
        sides.iter_mut().flatten().for_each(|points| *points = points.iter().copied().collect());
    };
    for what in ["all", "every second object", "one object", "nothing"] {
        let mut took = Vec::new();
        for _ in 0..FRAMES {
            match what {
                "all" => indirect.iter_mut().for_each(renew),
                "every second object" => indirect.iter_mut().step_by(2).for_each(renew),
                "one object" => renew(&mut indirect[object]),
                _ => {}
            }
            let start = Instant::now();
            renderer.light(&indirect)?;
            let called = start.elapsed().as_secs_f64() * 1000.0;
            // What was written is copied when the next commands are given.
            renderer.device().queue.submit([]);
            renderer.device().wait()?;
            took.push((called, start.elapsed().as_secs_f64() * 1000.0));
        }
        let [call, whole] = [|t: &(f64, f64)| t.0, |t: &(f64, f64)| t.1].map(|of| middle(took.iter().map(of).collect()));
        let bytes = renderer.uploaded_bytes() as f64 / 1e6;
        println!("light of {what:<20} {bytes:>8.2} MB {call:>8.2} ms, {whole:>8.2} ms until it is there");
    }
    Ok(())
}

/// The picture into a target, as it is and scaled, with and without an outline.
fn present(renderer: &mut Renderer, view: &View, object: usize) -> Result<(), Box<dyn Error>> {
    let format = wgpu::TextureFormat::Bgra8Unorm;
    let (width, height) = (1280, 720);
    let target = renderer.device().device.create_texture(&wgpu::TextureDescriptor {
        label: None,
        size: wgpu::Extent3d { width, height, depth_or_array_layers: 1 },
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format,
        usage: wgpu::TextureUsages::RENDER_ATTACHMENT,
        view_formats: &[],
    });
    let target = target.create_view(&wgpu::TextureViewDescriptor::default());
    let mark = Mark { object, colour: [1.0, 0.8, 0.2, 1.0] };
    for (size, marks) in [(1, 0), (1, 1), (1, 8), (2, 0), (2, 1)] {
        let (w, h) = (width / size, height / size);
        draw(renderer, view, w, h)?;
        let mut took = Vec::new();
        for _ in 0..FRAMES {
            let mut encoder = renderer.device().device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
            renderer.present(&mut encoder, &target, format, [0, 0, width, height], &vec![mark; marks])?;
            renderer.device().queue.submit([encoder.finish()]);
            took.push(renderer.finish()?.present);
        }
        println!("present {w}x{h} at {width}x{height}, {marks} marks {:>8.2} ms", middle(took));
    }
    Ok(())
}

fn draw(renderer: &mut Renderer, view: &View, width: u32, height: u32) -> Result<Times, Box<dyn Error>> {
    let look = Look::Photograph { exposure: None };
    renderer.draw(view, &Settings { width, height, grid: 1, parts: Parts::RADIANCE, look })?;
    Ok(renderer.finish()?)
}

fn middle(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    values[values.len() / 2]
}
