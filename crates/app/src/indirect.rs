//! Indirect light from the solver's buckets to the rasteriser's lattice points.

use lightmend_photon::{
    bucket::Buckets,
    field::Field,
    irradiance::Scale,
    reconstruction::{Reconstruction, Shapes},
    world::World,
};
use lightmend_raster::{Indirect, side_light};
use lightmend_scene::{Configuration, luminance};
use rayon::prelude::*;
use std::sync::Arc;

/// Reads light, and keeps how the surfaces hang together.
#[derive(Default)]
pub struct IndirectLight {
    shapes: Shapes,
}

impl IndirectLight {
    /// Irradiance at all lattice points of all sides that light of lamps numbered below `lamps` has reached.
    pub fn read(&mut self, configuration: &Configuration, buckets: &Buckets, scale: &Scale, lamps: usize) -> Indirect {
        drawn(configuration, &self.reconstruct(configuration, buckets, scale, lamps))
    }

    /// The light of lamps numbered below `lamps`.
    pub fn reconstruct(
        &mut self,
        configuration: &Configuration,
        buckets: &Buckets,
        scale: &Scale,
        lamps: usize,
    ) -> Reconstruction<'_> {
        self.shapes.learn(configuration);
        Reconstruction::new(&self.shapes, configuration, buckets, scale, lamps)
    }

    /// The light of all lamps on some of the objects: others are dark.
    pub fn reconstruct_some(
        &mut self,
        configuration: &Configuration,
        buckets: &Buckets,
        scale: &Scale,
        wanted: impl Fn(usize) -> bool + Sync,
    ) -> Reconstruction<'_> {
        self.shapes.learn(configuration);
        Reconstruction::of_objects(&self.shapes, configuration, buckets, scale, configuration.lamp_slots(), wanted)
    }

    /// Irradiance of every element side, reconstructed.
    pub fn field(&mut self, world: &World, buckets: &Buckets, scale: &Scale) -> Field {
        let configuration = world.configuration();
        let light = self.reconstruct(configuration, buckets, scale, configuration.lamp_slots());
        Field::reconstructed(world, &light)
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
}

/// What was reconstructed, at all lattice points of all sides that light has reached.
pub fn drawn(configuration: &Configuration, light: &Reconstruction) -> Indirect {
    let of_object = |id| [0, 1].map(|side| Some(side_light(&light.vertices(id, side)?)));
    (0..configuration.object_slots()).into_par_iter().map(of_object).collect()
}
