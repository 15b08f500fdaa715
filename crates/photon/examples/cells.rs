//! What the size of a scene's mesh elements does to its light.
//!
//! `cargo run --release -p lightmend-photon --example cells -- SCENE REFERENCE_PHOTONS FINEST CELL…`, sizes in metres. For each CELL and pool, of
//! indirect light as the elements have it, against their own reference (`lightmend_photon::accuracy`): nRMSE raw and reconstructed, the median of
//! the reconstructed relative error and what is stated of it, and how many sides with at least 30 hits lie within one stated standard error.
//! Then as pictures show it, interpolated between lattice points: nRMSE and median at the centres of elements of FINEST metres, against theirs.

use glam::Vec3;
use lightmend_photon::{
    accuracy::{Measures, Reference},
    body::TreePreset,
    field::{Field, Side},
    halton::Scrambling,
    irradiance::Scale,
    path::FirstHits,
    pool::Pool,
    reconstruction::{Reconstruction, Shapes},
    solution::Solution,
    world::World,
};
use lightmend_scene::{Configuration, Lattice, Object, Scene, luminance};
use std::{error::Error, path::Path, sync::Arc};

const POOLS: [u64; 7] = [110_000, 300_000, 1_152_000, 2_400_000, 4_608_000, 10_000_000, 20_000_000];

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [scene, photons, finest, cells @ ..] = arguments.as_slice() else {
        return Err("usage: cells SCENE REFERENCE_PHOTONS FINEST CELL…".into());
    };
    let photons = photons.parse()?;
    let cut = |cell: &str| cut(scene.as_ref(), cell.parse()?);
    let finest = cut(finest)?;
    let at_places = reference(&finest, photons)?;
    for cell in cells {
        let world = cut(cell)?;
        let reference = reference(&world, photons)?;
        let own = reference.own;
        println!("{cell} m: {} elements; the reference's own nRMSE {:.4}", world.configuration().scene().cells(), own.nrmse);
        let shapes = Shapes::of(world.configuration());
        for photons in POOLS {
            let solution =
                Solution::shoot(pool(photons)?, world.clone(), FirstHits::Never, &mut |_, _| true).ok_or("no solution")?;
            let scale = Scale::new(&world, photons);
            let lamps = world.configuration().lamp_slots();
            let light = Reconstruction::new(&shapes, world.configuration(), solution.buckets(), &scale, lamps);
            let raw = Field::raw(&world, solution.buckets(), &scale);
            let elements = Field::reconstructed(&world, &light);
            let [before, after] = [&raw, &elements].map(|field| reference.measure(field));
            let (within, counted) = within(&world, &reference, &raw, &light);
            let Measures { nrmse, median, .. } = at_places.measure(&shown(&world, &finest, &shapes, &light));
            println!(
                "  {photons}: nRMSE {:.4} raw, {:.4} reconstructed, ratio {:.3}; median {:.4}, stated {:.4}, {:.1} % of {counted} within; \
                 shown: nRMSE {nrmse:.4}, median {median:.4}",
                before.nrmse,
                after.nrmse,
                after.nrmse / before.nrmse,
                after.median,
                light.median_error(),
                100.0 * within as f64 / counted as f64,
            );
        }
    }
    Ok(())
}

/// The scene with elements of `cell` metres.
fn cut(scene: &Path, cell: f64) -> Result<Arc<World>, Box<dyn Error>> {
    let (mut scene, _) = Scene::read(scene)?;
    for object in &mut Arc::get_mut(&mut scene).ok_or("the scene is in use")?.objects {
        let lattice = Arc::new(Lattice::new(&object.mesh, cell).ok_or("too many elements")?);
        *object = Arc::new(Object { lattice, ..Object::clone(object) });
    }
    Ok(Arc::new(World::new(&Configuration::initial(&scene), TreePreset::default())))
}

fn pool(photons: u64) -> Result<Pool, Box<dyn Error>> {
    Ok(Pool::new(photons, 288, 16, Scrambling::Seed(1))?)
}

fn reference(world: &Arc<World>, photons: u64) -> Result<Reference, Box<dyn Error>> {
    Ok(Reference::shoot(world, &pool(POOLS[0])?, photons, FirstHits::Never, &mut |_| true)?.ok_or("no reference")?)
}

/// How many sides with at least 30 hits lie within one stated standard error of the reference, and how many there are.
fn within(world: &World, reference: &Reference, raw: &Field, light: &Reconstruction) -> (u64, u64) {
    let (mut within, mut counted) = (0, 0);
    for (id, object) in world.configuration().objects() {
        for (cell, side) in (0..2 * object.lattice.cells()).map(|n| (n / 2, (n % 2) as usize)) {
            if raw.side(id, cell, side).hits < 30 {
                continue;
            }
            let estimate = light.cell(id, cell, side);
            let off = luminance(estimate.value) - luminance(reference.field.side(id, cell, side).irradiance);
            counted += 1;
            within += u64::from(off.abs() <= luminance(estimate.standard_error));
        }
    }
    (within, counted)
}

/// The light of `world` at the centres of the elements of `finest`, interpolated as pictures do.
fn shown(world: &World, finest: &World, shapes: &Shapes, light: &Reconstruction) -> Field {
    let slots = finest.configuration().object_slots();
    let mut sides: Vec<[Vec<Side>; 2]> = (0..slots).map(|_| [Vec::new(), Vec::new()]).collect();
    for (id, object) in finest.configuration().objects() {
        let lattice = &world.object(id).lattice;
        let points = &shapes.get(id).points;
        let corners: Vec<[u32; 3]> = (0..points.triangles()).flat_map(|t| points.cells_points(t)).collect();
        for side in [0, 1] {
            let values = light.vertices(id, side);
            for t in 0..points.triangles() {
                let (n, area) = (lattice.divisions(t), object.lattice.area_in(t));
                for [b1, b2] in object.lattice.centres(t).map(|centre| centre.map(|b| b as f32)) {
                    let corners = corners[lattice.cell(t, b1, b2) as usize];
                    let [u, v] = [b1 * n as f32, b2 * n as f32].map(f32::fract);
                    // An inverted cell has the points (1, 0), (0, 1), (1, 1) of its square.
                    let weights = if u + v < 1.0 { [1.0 - u - v, u, v] } else { [1.0 - v, 1.0 - u, u + v - 1.0] };
                    let at = |values: &Vec<[f32; 3]>| -> Vec3 {
                        corners.iter().zip(weights).map(|(point, w)| Vec3::from_array(values[*point as usize]) * w).sum()
                    };
                    let irradiance = values.as_ref().map(at).unwrap_or_default().as_dvec3();
                    sides[id][side].push(Side { irradiance, area, hits: 0 });
                }
            }
        }
    }
    Field::read(finest, |id, cell, side| sides[id][side][cell as usize])
}
