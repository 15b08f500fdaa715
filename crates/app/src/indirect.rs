//! Indirect light from the solver's buckets to the rasteriser's lattice points.

use lightmend_photon::{bucket::Buckets, irradiance::Scale, vertex_irradiance::vertex_irradiance};
use lightmend_raster::{Indirect, side_light};
use lightmend_scene::{Configuration, LatticePoints, Mesh, luminance};
use rayon::prelude::*;
use std::sync::Arc;

/// Lattice points of the meshes in use, each made once.
#[derive(Default)]
pub struct IndirectLight {
    /// By object number.
    points: Vec<Option<(Arc<Mesh>, Arc<LatticePoints>)>>,
}

impl IndirectLight {
    /// Irradiance at all lattice points of all sides that light of lamps numbered below `lamps` has reached.
    pub fn read(&mut self, configuration: &Configuration, buckets: &Buckets, scale: &Scale, lamps: usize) -> Indirect {
        self.learn(configuration);
        (0..configuration.object_slots())
            .into_par_iter()
            .map(|id| {
                let points = self.points[id].as_ref().filter(|_| configuration.has_object(id));
                [0, 1].map(|side| {
                    let (_, points) = points?;
                    let lattice = &configuration.object(id).lattice;
                    let lux = vertex_irradiance(buckets, scale, id, side, lattice, points, lamps)?;
                    Some(side_light(&lux))
                })
            })
            .collect()
    }

    /// How far the light still is from what it will be, as a share of that: illuminance, in all channels alike.
    pub fn outstanding(
        &mut self,
        configuration: &Configuration,
        now: (&Buckets, &Scale),
        right: (&Buckets, &Scale),
        lamps: usize,
    ) -> Indirect {
        let [now, right] = [now, right].map(|(buckets, scale)| self.read(configuration, buckets, scale, lamps));
        let illuminance = |[r, g, b, _]: &[f32; 4]| luminance(glam::DVec3::from_array([*r, *g, *b].map(f64::from)));
        let at = |light: &Option<Arc<[[f32; 4]]>>, point: usize| light.as_ref().map_or(0.0, |light| illuminance(&light[point]));
        let side = |now: Option<Arc<[[f32; 4]]>>, right: Option<Arc<[[f32; 4]]>>| {
            let points = now.as_ref().or(right.as_ref())?.len();
            let share = |point| {
                let right = at(&right, point);
                let off = (at(&now, point) - right).abs();
                // What will be dark is wholly off as long as it is not.
                let share = if off > 0.0 { off / right.max(off.min(1e-9)).max(f64::MIN_POSITIVE) } else { 0.0 } as f32;
                [share, share, share, 0.0]
            };
            Some((0..points).map(share).collect())
        };
        now.into_iter().zip(right).map(|([a, b], [c, d])| [side(a, c), side(b, d)]).collect()
    }

    fn learn(&mut self, configuration: &Configuration) {
        self.points.resize_with(configuration.object_slots(), || None);
        for id in 0..configuration.object_slots() {
            let object = configuration.object(id);
            let known = |points: &Option<(Arc<Mesh>, Arc<LatticePoints>)>| {
                points.as_ref().filter(|(mesh, _)| Arc::ptr_eq(mesh, &object.mesh)).map(|(_, points)| points.clone())
            };
            if configuration.has_object(id) && known(&self.points[id]).is_none() {
                let points = self.points.iter().find_map(known);
                let points = points.unwrap_or_else(|| Arc::new(LatticePoints::new(&object.mesh, &object.lattice)));
                self.points[id] = Some((object.mesh.clone(), points));
            }
        }
    }
}
