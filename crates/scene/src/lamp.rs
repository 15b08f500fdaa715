//! Point lamps: where their light goes, in candela, and how much of it there is, in lumens.

use crate::{Motion, Photometry, Pose, Up, format::LampEntry, scene::same};
use glam::{DMat3, DVec3};
use serde::{Deserialize, Serialize};
use std::sync::Arc;

/// Who draws a lamp's direct light (Dmitriev et al. 2002, §6).
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Direct {
    /// The rasteriser: the lamp's photons count from their second hit on.
    #[default]
    Rasteriser,
    /// The photons: they count from their first hit on.
    Photons,
}

/// A point lamp.
#[derive(Debug, Clone)]
pub struct Lamp {
    /// Unique.
    pub name: String,
    /// Luminous intensity, candela per linear Rec. 709 channel; with a photometric file the factor of the file's candela.
    pub intensity: DVec3,
    /// The intensity that its share of the photons follows: dimming and recolouring leave it as it is.
    pub rated: DVec3,
    /// Whether it is switched on.
    pub lit: bool,
    /// How the intensity depends on direction; without it the same in all.
    pub photometry: Option<Arc<Photometry>>,
    /// Who draws its direct light.
    pub direct: Direct,
    /// The object it stands on, by index.
    pub carrier: Option<usize>,
    /// Where it stands, relative to its carrier.
    pub pose: Pose,
    /// What a scene file says of it, but for its pose and light.
    pub entry: LampEntry,
}

impl PartialEq for Lamp {
    /// Equal in all that a scene file can say.
    fn eq(&self, other: &Self) -> bool {
        let photometry = match (&self.photometry, &other.photometry) {
            (Some(a), Some(b)) => same(a, b),
            (a, b) => a.is_none() && b.is_none(),
        };
        self.name == other.name
            && (self.intensity, self.rated, self.lit) == (other.intensity, other.rated, other.lit)
            && (self.direct, self.carrier, self.pose) == (other.direct, other.carrier, other.pose)
            && photometry
    }
}

impl Lamp {
    /// What a scene file says of it.
    pub fn stated(&self) -> LampEntry {
        LampEntry {
            position: self.pose.position,
            rotation: self.pose.rotation,
            intensity: self.intensity,
            rated: (self.rated != self.intensity).then_some(self.rated),
            off: !self.lit,
            ..self.entry.clone()
        }
    }

    /// Luminous flux, lumens per channel; none when switched off.
    pub fn flux(&self) -> DVec3 {
        if self.lit { self.intensity * self.unit_flux() } else { DVec3::ZERO }
    }

    /// Luminous flux of the rated intensity.
    pub fn rated_flux(&self) -> DVec3 {
        self.rated * self.unit_flux()
    }

    fn unit_flux(&self) -> f64 {
        self.photometry.as_ref().map_or(4.0 * std::f64::consts::PI, |p| p.luminous_flux())
    }

    /// Luminous intensity towards `direction` (lamp axes, any length), candela per channel.
    pub fn candela(&self, direction: DVec3) -> DVec3 {
        if self.lit { self.intensity * self.photometry.as_ref().map_or(1.0, |p| p.candela(direction)) } else { DVec3::ZERO }
    }
}

/// From lamp axes to scene axes: a lamp's z is the scene's up before the lamp is turned.
pub fn lamp_rotation(up: Up, motion: &Motion) -> DMat3 {
    match up {
        Up::Z => motion.rotation,
        Up::Y => motion.rotation * DMat3::from_cols(DVec3::X, DVec3::NEG_Z, DVec3::Y),
    }
}

/// Luminance of a linear Rec. 709 triple.
pub fn luminance(rgb: DVec3) -> f64 {
    rgb.dot(DVec3::new(0.2126, 0.7152, 0.0722))
}
