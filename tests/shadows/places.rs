//! Where cameras stand and lamps hang, seen from the thing whose shadows are looked at.

use glam::DVec3;
use lightmend_scene::{Configuration, Scene, View};
use std::sync::Arc;

/// Numbers from 0 to 1 that are the same every time (Steele, Lea and Flood 2014, SplitMix64).
pub struct Numbers(pub u64);

impl Numbers {
    /// The next.
    pub fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        (z ^ (z >> 31)) as f64 / u64::MAX as f64
    }

    fn within(&mut self, [low, high]: [DVec3; 2]) -> DVec3 {
        low + (high - low) * DVec3::new(self.next(), self.next(), self.next())
    }
}

/// The box about points: its corners of least and of largest coordinates.
pub fn extent(points: impl Iterator<Item = DVec3>) -> [DVec3; 2] {
    points.fold([DVec3::INFINITY, DVec3::NEG_INFINITY], |[low, high], p| [low.min(p), high.max(p)])
}

/// The box about the objects that are called so.
fn extent_of(scene: &Arc<Scene>, called: impl Fn(&str) -> bool) -> [DVec3; 2] {
    let configuration = Configuration::initial(scene);
    let objects = configuration.objects().filter(|(_, object)| called(&object.name));
    extent(objects.flat_map(|(id, object)| {
        let motion = configuration.object_motion(id);
        object.mesh.positions.iter().map(move |p| motion.point(*p))
    }))
}

/// Cameras anywhere in a scene, looking anywhere, also from inside of what stands there.
pub fn random_views(scene: &Arc<Scene>, count: u64) -> Vec<(String, View)> {
    let all = extent_of(scene, |_| true);
    let mut numbers = Numbers(7);
    let view = |n: u64| {
        let (eye, target) = (numbers.within(all), numbers.within(all));
        (format!("random {n}"), View { eye, target, fov: 30.0 + 60.0 * numbers.next() })
    };
    (0..count).map(view).collect()
}

/// The camera before the thing.
fn front(middle: DVec3) -> View {
    View { eye: DVec3::new(2.6, -2.0, 1.6), target: middle, fov: 60.0 }
}

/// Cameras about the objects whose names start with "thing": before and behind them, among and under them, in their shadow, and
/// in the planes of their faces.
pub fn about(scene: &Arc<Scene>) -> Vec<(String, View)> {
    let [low, high] = extent_of(scene, |name| name.starts_with("thing"));
    let middle = (low + high) / 2.0;
    let away = (middle - lamps([low, high])[0].1).with_z(0.0).normalize();
    let half = (high - low).length() / 2.0;
    let shadow = (middle + away * (half + 0.05)).with_z(0.12).clamp(DVec3::new(-2.9, -2.4, 0.0), DVec3::new(2.9, 2.4, 2.7));
    let under = low + (high - low) * DVec3::new(0.55, 0.45, 0.3);
    let flat = DVec3::new(2.7, middle.y - 1.9, high.z);
    let along = DVec3::new(high.x, -2.3, 0.9);
    [
        ("before", front(middle)),
        ("behind", View { eye: DVec3::new(-2.6, 2.1, 0.5), target: middle, fov: 60.0 }),
        ("under", View { eye: under, target: middle + DVec3::new(1.0, -0.7, -0.6), fov: 85.0 }),
        ("in the shadow", View { eye: shadow, target: middle, fov: 75.0 }),
        ("in the shadow, outwards", View { eye: shadow, target: shadow + away + DVec3::new(0.2, 0.1, -0.05), fov: 75.0 }),
        ("in the plane of its top", View { eye: flat, target: middle.with_z(high.z), fov: 50.0 }),
        ("in the plane of its side", View { eye: along, target: DVec3::new(high.x, 0.0, 0.4), fov: 50.0 }),
        ("close above", View { eye: middle.with_z(high.z + 2e-3), target: middle + DVec3::new(2.0, 1.0, -0.3), fov: 70.0 }),
    ]
    .map(|(name, view)| (name.into(), view))
    .into()
}

/// Where lamps hang about a thing with this box.
pub fn lamps([low, high]: [DVec3; 2]) -> Vec<(&'static str, DVec3)> {
    let middle = (low + high) / 2.0;
    let View { eye, target, .. } = front(middle);
    let forward = (target - eye).normalize();
    // Half as far again as the near plane, a ten-thousandth of the reach of 3 m.
    let near = 1.5 * 3e-4;
    // Not in a surface: what a lamp lights that lies in a sheet is not defined.
    let level = high.z.max(0.02);
    let inside = low + (high - low) * DVec3::new(0.47, 0.53, 0.75) + DVec3::Z * if high.z > low.z { 0.0 } else { 0.1 };
    vec![
        ("high", DVec3::new(-1.9, -1.4, 2.5)),
        ("level with its top", DVec3::new(1.7, -1.2, level)),
        ("over its side", DVec3::new(high.x, middle.y, 2.4)),
        ("in it", inside),
        ("at the near plane", eye + forward * near),
        ("behind the camera", eye - forward * 0.2),
        ("low", DVec3::new(2.0, 1.8, 0.05)),
        ("under its top", inside.with_z(high.z - 2e-3)),
    ]
}
