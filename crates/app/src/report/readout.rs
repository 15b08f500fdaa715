//! The ways to read irradiance from buckets that are measured beside one another.

use crate::indirect::IndirectLight;
use lightmend_photon::{bucket::Buckets, field::Field, irradiance::Scale, world::World};

/// A way to read irradiance.
pub struct Readout {
    /// Its name in tables and figures.
    pub name: &'static str,
    /// Irradiance of every element side.
    pub field: fn(&mut IndirectLight, &World, &Buckets, &Scale) -> Field,
}

/// All of them: as photons left it, and as frames and `probe` show it.
pub const READOUTS: [Readout; 2] = [
    Readout { name: "raw", field: |_, world, buckets, scale| Field::raw(world, buckets, scale) },
    Readout { name: "reconstructed", field: IndirectLight::field },
];
