//! How far the textures of a scene hide errors of its light: `perception` says what a texture hides on a mesh, this what meshes there are.

use crate::{
    failure::Failure,
    figure,
    output::{self, say},
};
use lightmend_perception::{Luminance, Masking, MeshLimit, cache_folder, masking_map};
use lightmend_photon::{
    importance::{UNIT, Unmasked},
    visible::footprint,
};
use lightmend_scene::{Configuration, Material, Object, Scene, Texture, View};
use std::{
    collections::BTreeMap,
    path::{Path, PathBuf},
    sync::Arc,
};

/// Looks at textures, each once for every density of mesh that it lies on.
pub struct Maskings {
    folder: Option<PathBuf>,
    textures: Vec<(Arc<Texture>, Luminance)>,
    tables: BTreeMap<(usize, MeshLimit), Arc<Masking>>,
}

/// A texture on a triangle.
pub struct Covered {
    /// What it hides.
    pub masking: Arc<Masking>,
    /// The mesh that it was looked at on.
    pub limit: MeshLimit,
    /// Texels that lie on a metre, √(texels per m²).
    pub texels_per_metre: f64,
}

impl Maskings {
    /// Nothing looked at yet; what was at earlier starts is in the user's cache.
    pub fn new() -> Maskings {
        Maskings { folder: cache_folder(), textures: Vec::new(), tables: BTreeMap::new() }
    }

    /// What hides errors on triangle `t` of an object; `None` if nothing does.
    pub fn on(&mut self, object: &Object, t: usize) -> Option<Covered> {
        let texture = object.material(t).texture.as_ref()?;
        let (limit, texels_per_metre) = density(object, t, texture)?;
        let number = self.textures.iter().position(|(known, _)| Arc::ptr_eq(known, texture)).unwrap_or_else(|| {
            self.textures.push((texture.clone(), Luminance::from(&**texture)));
            self.textures.len() - 1
        });
        let look = || Arc::new(Masking::cached(&self.textures[number].1, limit, self.folder.as_deref()));
        let masking = self.tables.entry((number, limit)).or_insert_with(look).clone();
        Some(Covered { masking, limit, texels_per_metre })
    }

    /// Elevation of the threshold on a triangle of which a pixel covers a square with an edge of `footprint` metres.
    pub fn elevation(&mut self, object: &Object, t: usize, footprint: f64) -> f64 {
        let covered = self.on(object, t);
        covered.map_or(1.0, |covered| f64::from(covered.masking.at((covered.texels_per_metre * footprint).max(1e-9))))
    }

    /// 1 ÷ T_e of all triangles with a texture, each as seen at its centre.
    pub fn unmasked(&mut self, configuration: &Configuration, view: &View) -> Unmasked {
        let up = configuration.scene().up;
        let mut all = vec![Box::default(); configuration.object_slots()];
        for (id, object) in configuration.objects() {
            if object.materials.iter().all(|material| material.texture.is_none()) {
                continue;
            }
            let motion = configuration.object_motion(id);
            let of_triangle = |t: usize| {
                let [a, b, c] = object.mesh.corners(t).map(|corner| motion.point(corner));
                let (centre, normal) = ((a + b + c) / 3.0, (b - a).cross(c - a).normalize_or_zero());
                let elevation = self.elevation(object, t, footprint(view, up, centre, normal));
                (f64::from(UNIT) / elevation).round() as u32
            };
            all[id] = (0..object.mesh.triangles.len()).map(of_triangle).collect();
        }
        Unmasked(all)
    }
}

/// What the cells of triangle `t` can show of indirect light, and texels per metre. `None` if the texture is drawn out to nothing.
///
/// A cell is as wide as the legs of a right-angled triangle of its area in texels.
fn density(object: &Object, t: usize, texture: &Texture) -> Option<(MeshLimit, f64)> {
    let [width, height] = texture.size().map(f64::from);
    let [a, b, c] = object.mesh.uvs.get(t)?;
    let texels = (*b - *a).perp_dot(*c - *a).abs() / 2.0 * width * height;
    let cells = f64::from(object.lattice.divisions(t)).powi(2);
    let area = object.lattice.area_in(t) * cells;
    (texels > 0.0 && area > 0.0).then(|| (MeshLimit::of_cells((2.0 * texels / cells).sqrt()), (texels / area).sqrt()))
}

/// Texels per pixel along an edge at which pictures are drawn: a texture of 1024 texels fills a quarter of a screen then.
const SHOWN: f64 = 4.0;

/// Width of a half of a picture at most.
const WIDTH: u32 = 512;

/// Writes a picture of every texture on every density of mesh that the scene has: the texture, and its threshold elevation beside it,
/// black at 1 and white at the highest.
pub fn write_maps(scene: &Scene, folder: &Path, talks: bool) -> Result<(), Failure> {
    let mut maskings = Maskings::new();
    let mut on: BTreeMap<(String, MeshLimit), (Arc<Texture>, Covered)> = BTreeMap::new();
    for object in &scene.objects {
        for t in 0..object.mesh.triangles.len() {
            let Material { texture: Some(texture), texture_path: Some(path), .. } = object.material(t) else { continue };
            let Some(covered) = maskings.on(object, t) else { continue };
            let stem = Path::new(path).file_stem().map_or_else(|| "texture".into(), |stem| stem.to_string_lossy());
            on.insert((stem.into_owned(), covered.limit), (texture.clone(), covered));
        }
    }
    let file = |stem: &str, limit: MeshLimit| format!("{stem}_{}.png", (1.0 / limit.frequency()) as u32);
    let files: Vec<String> = on.keys().map(|(stem, limit)| file(stem, *limit)).collect();
    let folder = output::folder(folder, &files)?;
    if talks && on.is_empty() {
        say("\nnothing has a texture");
    } else if talks {
        say(&format!("\n{:<28} {:>10} {:>8}  threshold elevation at 1, 4, 16 texels a pixel", "texture", "texels/m", "detail"));
    }
    for ((stem, limit), (texture, Covered { masking, texels_per_metre, .. })) in &on {
        let picture = Luminance::from(&**texture);
        let map = masking_map(&picture, *limit, SHOWN);
        let highest = map.iter().copied().fold(1.0, f64::max);
        let [near, middle, far] = [1.0, SHOWN, 16.0].map(|texels| masking.at(texels));
        if talks {
            let period = 1.0 / limit.frequency();
            say(&format!("{stem:<28} {texels_per_metre:>10.0} {period:>8}  {near:.2}, {middle:.2}, {far:.2}"));
        }
        let note = format!("T_e {middle:.2} on average, white {highest:.2}; detail from {} texels on", 1.0 / limit.frequency());
        output::png(&folder.join(file(stem, *limit)), &beside(texture, &map, highest, note)?)?;
    }
    Ok(())
}

fn beside(texture: &Texture, map: &[f64], highest: f64, note: String) -> Result<image::RgbImage, Failure> {
    let [width, height] = texture.size();
    let byte = |v: f64| (v.clamp(0.0, 1.0) * 255.0).round() as u8;
    let shown: Vec<glam::Vec3> = texture.linear().collect();
    let step = width.div_ceil(WIDTH).max(1);
    let (across, down) = (width / step, (height / step).max(1));
    let pixel = |x: u32, y: u32| {
        let texel = |x: u32| (y * step * width + x * step) as usize;
        image::Rgb(match x {
            _ if y >= down => return image::Rgb([255; 3]),
            x if x < across => shown[texel(x)].to_array().map(|v| byte(f64::from(v).powf(1.0 / 2.2))),
            x => [byte((map[texel(x - across)] - 1.0) / (highest - 1.0).max(1e-9)); 3],
        })
    };
    figure::with_text(image::RgbImage::from_fn(2 * across, down + 24, pixel), &[(note, [4, down + 4])])
}
