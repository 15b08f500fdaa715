//! The ways to read irradiance from buckets that are measured beside one another.

use crate::indirect::IndirectLight;
use lightmend_photon::{bucket::Buckets, field::Field, irradiance::Scale, world::World};
use lightmend_raster::Indirect;
use lightmend_scene::Configuration;

/// A way to read irradiance.
pub struct Readout {
    /// Its name in tables and figures.
    pub name: &'static str,
    /// Irradiance of every element side.
    pub field: fn(&World, &Buckets, &Scale) -> Field,
    /// The light of frames, of lamps numbered below the last number.
    pub frame: fn(&mut IndirectLight, &Configuration, &Buckets, &Scale, usize) -> Indirect,
}

/// All of them.
pub const READOUTS: [Readout; 1] = [Readout { name: "raw", field: Field::raw, frame: IndirectLight::read }];
