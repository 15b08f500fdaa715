//! Reconstruction: smooth, faithful irradiance and its error from noisy buckets.
//!
//! [`Shapes`] knows how the surfaces hang together ([`patches`]); a [`Reconstruction`] is what the buckets say of them, estimated from coarse
//! patches to fine ([`multilevel`]): a pure function of buckets and meshes, so the same light gives the same bits. It is consistent: as the
//! pool grows it becomes the raw irradiance of the cells. It never crosses a crease, an object or a side.

pub mod multilevel;
pub mod patches;
#[cfg(test)]
mod tests;

use crate::{
    accuracy::{DIM, quantiles_by_area},
    bucket::{Buckets, ENERGY_BITS},
    irradiance::{Irradiance, Scale},
};
use glam::DVec3;
use lightmend_scene::{Configuration, LatticePoints, Mesh, luminance};
use multilevel::{Estimate, Sum, estimate};
use patches::Patches;
use rayon::prelude::*;
use std::sync::Arc;

/// How the surface of one mesh hangs together.
#[derive(Debug)]
pub struct Shape {
    mesh: Arc<Mesh>,
    /// Its lattice points.
    pub points: LatticePoints,
    /// Its patches.
    pub patches: Patches,
}

/// The shapes of a configuration's objects, each mesh made once.
#[derive(Debug, Default)]
pub struct Shapes {
    /// By object number.
    shapes: Vec<Option<Arc<Shape>>>,
}

impl Shapes {
    /// The shapes of the objects of `configuration`.
    pub fn of(configuration: &Configuration) -> Shapes {
        let mut shapes = Shapes::default();
        shapes.learn(configuration);
        shapes
    }

    /// Adds what is new in `configuration`.
    pub fn learn(&mut self, configuration: &Configuration) {
        self.shapes.resize(configuration.object_slots(), None);
        let known = |shapes: &[Option<Arc<Shape>>], mesh: &Arc<Mesh>| {
            shapes.iter().flatten().find(|s| Arc::ptr_eq(&s.mesh, mesh)).cloned()
        };
        // Meshes that no object had before, each once.
        let mut new: Vec<usize> = Vec::new();
        for (id, object) in configuration.objects() {
            let again = new.iter().any(|other| Arc::ptr_eq(&configuration.object(*other).mesh, &object.mesh));
            if !again && known(&self.shapes, &object.mesh).is_none() {
                new.push(id);
            }
        }
        let make = |id: &usize| {
            let object = configuration.object(*id);
            let points = LatticePoints::new(&object.mesh, &object.lattice);
            let patches = Patches::new(&object.mesh, &object.lattice, &points);
            Arc::new(Shape { mesh: object.mesh.clone(), points, patches })
        };
        let made: Vec<Arc<Shape>> = new.par_iter().map(make).collect();
        new.iter().zip(made).for_each(|(id, shape)| self.shapes[*id] = Some(shape));
        for (id, object) in configuration.objects() {
            if self.shapes[id].as_ref().is_none_or(|s| !Arc::ptr_eq(&s.mesh, &object.mesh)) {
                self.shapes[id] = known(&self.shapes, &object.mesh);
            }
        }
    }

    /// The shape of object `id`.
    ///
    /// # Panics
    /// If its configuration was not learned.
    pub fn get(&self, id: usize) -> &Arc<Shape> {
        self.shapes[id].as_ref().expect("the shape of an object whose configuration was learned")
    }
}

/// Irradiance of every side that light has reached.
#[derive(Debug)]
pub struct Reconstruction<'s> {
    shapes: &'s Shapes,
    configuration: Configuration,
    /// What one photon of the strongest lamp brings, lumens per channel.
    photon: DVec3,
    /// Per object and side, of the level-0 patches.
    sides: Vec<[Option<Vec<Estimate>>; 2]>,
}

impl<'s> Reconstruction<'s> {
    /// From the light of the lamps numbered below `lamps`.
    pub fn new(
        shapes: &'s Shapes,
        configuration: &Configuration,
        buckets: &Buckets,
        scale: &Scale,
        lamps: usize,
    ) -> Reconstruction<'s> {
        Reconstruction::of_objects(shapes, configuration, buckets, scale, lamps, |_| true)
    }

    /// The same of some of the objects: all others are dark.
    pub fn of_objects(
        shapes: &'s Shapes,
        configuration: &Configuration,
        buckets: &Buckets,
        scale: &Scale,
        lamps: usize,
        wanted: impl Fn(usize) -> bool + Sync,
    ) -> Reconstruction<'s> {
        let of_object = |id: usize| {
            [0, 1].map(|side| {
                let is_read = |_: &&Arc<Shape>| configuration.has_object(id) && wanted(id);
                let patches = &shapes.shapes[id].as_ref().filter(is_read)?.patches;
                Some(estimate(patches, &sums(patches, buckets, scale, [id, side], lamps)?))
            })
        };
        let sides = (0..configuration.object_slots()).into_par_iter().map(of_object).collect();
        let strongest = (0..lamps).fold(DVec3::ZERO, |most, lamp| most.max(scale.lumens(lamp)));
        let photon = strongest * (1u64 << ENERGY_BITS) as f64;
        Reconstruction { shapes, configuration: configuration.clone(), photon, sides }
    }

    /// Irradiance of one side (0: front, 1: back) of a cell: its mean. Hits are not counted.
    pub fn cell(&self, object: usize, cell: u32, side: usize) -> Irradiance {
        let patch = || self.shapes.get(object).patches.of_cell(cell);
        let estimate = self.sides[object][side].as_ref().and_then(|estimates| Some(&estimates[patch()?]));
        estimate.map_or_else(|| self.dark(object, cell), |estimate| self.irradiance(object, cell, estimate))
    }

    /// An estimate as irradiance: colours are as uncertain as illuminance.
    fn irradiance(&self, object: usize, cell: u32, estimate: &Estimate) -> Irradiance {
        let light = luminance(estimate.value);
        if light <= 0.0 {
            return self.dark(object, cell);
        }
        Irradiance { value: estimate.value, standard_error: estimate.value * (estimate.variance.sqrt() / light), hits: 0 }
    }

    /// Where no photon came, one could have: its light is the error.
    fn dark(&self, object: usize, cell: u32) -> Irradiance {
        let area = self.configuration.object(object).lattice.area(cell);
        Irradiance { standard_error: self.photon / area, ..Irradiance::default() }
    }

    /// Irradiance at each lattice point of one side of object `object`, lux per linear Rec. 709 channel; `None` if light never reached that side.
    /// The points of a group have the mean of the cells around them, by area, as in Gouraud-shaded radiosity (Cohen and Wallace 1993).
    pub fn vertices(&self, object: usize, side: usize) -> Option<Vec<[f32; 3]>> {
        let estimates = self.sides[object][side].as_ref()?;
        let Shape { points, patches, .. } = &**self.shapes.get(object);
        let lattice = &self.configuration.object(object).lattice;
        let mut around = vec![(DVec3::ZERO, 0.0); points.groups() as usize];
        for t in 0..points.triangles() {
            for (cell, corners) in lattice.cells_of(t).zip(points.cells_points(t)) {
                let Some(patch) = patches.of_cell(cell) else { continue };
                for point in corners {
                    let (flux, area) = &mut around[points.group(point) as usize];
                    *flux += estimates[patch].value * lattice.area_in(t);
                    *area += lattice.area_in(t);
                }
            }
        }
        // The points of a triangle without an area are never seen.
        let mean = |(flux, area): &(DVec3, f64)| if *area > 0.0 { (*flux / *area).as_vec3().to_array() } else { [0.0; 3] };
        Some((0..points.count()).map(|point| mean(&around[points.group(point) as usize])).collect())
    }

    /// The estimated median of the relative error of illuminance, by area, over the element sides brighter than 5 % of the lit ones' mean. The median of a normal
    /// error is 0.6745 of its standard deviation. 0 in the dark.
    pub fn median_error(&self) -> f64 {
        let mut lit: Vec<(f64, f64, f64)> = Vec::new();
        for (id, sides) in self.sides.iter().enumerate() {
            for estimates in sides.iter().flatten() {
                let cells = &self.shapes.get(id).patches.cells;
                let of = |(e, area): (&Estimate, &f64)| (luminance(e.value), e.variance.sqrt(), *area);
                lit.extend(estimates.iter().zip(&cells.area).map(of).filter(|(light, _, _)| *light > 0.0));
            }
        }
        let (light, area) = lit.iter().fold((0.0, 0.0), |(l, a), (light, _, area)| (l + light * area, a + area));
        let bright = lit.iter().filter(|(l, _, _)| *l * area > DIM * light);
        let errors = bright.map(|(light, error, area)| (0.6745 * error / light, *area)).collect();
        let [median] = quantiles_by_area(errors, [0.5]);
        median
    }
}

/// What photons brought to the level-0 patches of one side of an object; `None` if none ever came.
fn sums(patches: &Patches, buckets: &Buckets, scale: &Scale, [object, side]: [usize; 2], lamps: usize) -> Option<Vec<Sum>> {
    let pages: Vec<_> = (0..lamps).filter_map(|lamp| Some((buckets.get(object, side, lamp)?, scale.lumens(lamp)))).collect();
    if pages.is_empty() {
        return None;
    }
    let mut sums = vec![Sum::default(); patches.cells.count()];
    for (page, lumens) in &pages {
        for (cell, bucket) in page.iter().enumerate().filter(|(_, bucket)| bucket.hits > 0) {
            let Some(patch) = patches.of_cell(cell as u32) else { continue };
            let flux = DVec3::from_array(bucket.energy.map(|e| e as f64)) * *lumens;
            sums[patch].flux += flux;
            sums[patch].squares += luminance(flux).powi(2) / bucket.hits as f64;
        }
    }
    Some(sums)
}
