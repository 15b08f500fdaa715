//! Irradiance at lattice points, between which a picture interpolates.
//!
//! The store of light is the mesh (Dmitriev et al. 2002, §3): a bucket per cell and side. As in Gouraud-shaded radiosity (Cohen and
//! Wallace 1993) each vertex gets the mean of the cells around it, here by area and within creases only: the points of a group
//! ([`LatticePoints`]) have one irradiance, E = Σ flux / Σ area over the cells that touch any of them. The constant is reproduced, and
//! no light is lost: interpolated linearly, a group carries E · Σ area / 3 = Σ flux / 3, and each cell has three points.
//!
//! Nothing is filtered: photon noise stays, only averaged over the six or so cells around a point. Cells that another object partly
//! covers stay too dark.

use crate::{
    bucket::{Bucket, Buckets},
    irradiance::Scale,
};
use glam::{DVec3, DVec4};
use lightmend_scene::{Lattice, LatticePoints};

/// Irradiance at each lattice point of one side (0: front, 1: back) of object `object`, lux per linear Rec. 709 channel, in the order
/// of `points`; `lattice` and `points` are the object's. Counts the lamps numbered below `lamps`. `None` if light of none of them ever
/// reached that side. One pass over the cells, sums in order: same input, same bits.
pub fn vertex_irradiance(
    buckets: &Buckets,
    scale: &Scale,
    object: usize,
    side: usize,
    lattice: &Lattice,
    points: &LatticePoints,
    lamps: usize,
) -> Option<Vec<[f32; 3]>> {
    let page = |lamp| Some((buckets.get(object, side, lamp)?, scale.lumens(lamp)));
    let pages: Vec<(&[Bucket], DVec3)> = (0..lamps).filter_map(page).collect();
    if pages.is_empty() {
        return None;
    }

    // Lumens, and square metres, of the cells around each group of points.
    let mut around = vec![DVec4::ZERO; points.groups() as usize];
    for t in 0..points.triangles() {
        let area = lattice.area_in(t);
        for (cell, corners) in lattice.cells_of(t).zip(points.cells_points(t)) {
            let from_lamp =
                |(page, lumens): &(&[Bucket], DVec3)| DVec3::from_array(page[cell as usize].energy.map(|e| e as f64)) * *lumens;
            let light = pages.iter().map(from_lamp).sum::<DVec3>().extend(area);
            corners.iter().for_each(|point| around[points.group(*point) as usize] += light);
        }
    }

    // The points of a triangle without an area are never seen.
    let mean = |sum: DVec4| if sum.w > 0.0 { sum.truncate() / sum.w } else { DVec3::ZERO };
    let of_point = |point| mean(around[points.group(point) as usize]).as_vec3().to_array();
    Some((0..points.count()).map(of_point).collect())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{
        body::TreePreset,
        bucket::{Address, ENERGY_BITS},
        world::World,
    };
    use lightmend_scene::{Configuration, Mesh, Object, Scene};
    use std::{path::Path, sync::Arc};

    /// A mesh alone in the Cornell box's scene, and its cells' light from the only lamp.
    struct Lit {
        lattice: Arc<Lattice>,
        points: LatticePoints,
        buckets: Buckets,
        scale: Scale,
    }

    impl Lit {
        fn new(mesh: Mesh, cell: f64) -> Lit {
            let cornell = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenes/cornell/cornell.ron");
            let mut scene = Arc::into_inner(Scene::read(&cornell).unwrap().0).unwrap();
            let lattice = Arc::new(Lattice::new(&mesh, cell).unwrap());
            let points = LatticePoints::new(&mesh, &lattice);
            let shape = Object { mesh: Arc::new(mesh), lattice: lattice.clone(), ..(*scene.objects[0]).clone() };
            scene.objects = vec![Arc::new(shape)];
            let configuration = Configuration::initial(&Arc::new(scene));
            let buckets = Buckets::new(&configuration);
            // A large pool, so that rounding to whole units of energy does not matter.
            let scale = Scale::new(&World::new(&configuration, TreePreset::Fast), 1 << 30);
            Lit { lattice, points, buckets, scale }
        }

        /// Gives the front of a cell an irradiance, lux.
        fn light(&mut self, cell: u32, lux: [f64; 3]) {
            let units = DVec3::from_array(lux) * self.lattice.area(cell) / self.scale.lumens(0);
            let to = Address { object: 0, cell, side: 0, lamp: 0 };
            self.buckets.set(to, Bucket { energy: units.to_array().map(|e| e.round() as i64), hits: 1 });
        }

        fn side(&self, side: usize) -> Option<Vec<[f32; 3]>> {
            vertex_irradiance(&self.buckets, &self.scale, 0, side, &self.lattice, &self.points, 1)
        }

        /// Irradiance of the front's points.
        fn front(&self) -> Vec<[f32; 3]> {
            self.side(0).unwrap()
        }

        /// Whether any of the points of triangle `t` is lit.
        fn reaches(&self, t: usize) -> bool {
            let front = self.front();
            self.points.points_of(t).any(|p| front[p as usize] != [0.0; 3])
        }
    }

    fn mesh(positions: Vec<DVec3>, triangles: Vec<[u32; 3]>) -> Mesh {
        let material_of = vec![0; triangles.len()];
        Mesh { positions, triangles, material_of, materials: vec!["m".into()], uvs: vec![] }
    }

    /// A box of `size` metres with one corner at the origin; faces −x, +x, −y, +y, −z, +z, two triangles each.
    fn cuboid(size: DVec3) -> Mesh {
        let corners = (0..8).map(|c| DVec3::new((c & 1) as f64, (c >> 1 & 1) as f64, (c >> 2) as f64) * size);
        let faces = [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]];
        mesh(corners.collect(), faces.into_iter().flat_map(|[a, b, c, d]| [[a, b, c], [a, c, d]]).collect())
    }

    /// Two unit squares with a common edge, bent by `degrees` out of one plane, two triangles each.
    fn bend(degrees: f64) -> Mesh {
        let (sin, cos) = degrees.to_radians().sin_cos();
        let xz = [(-1.0, 0.0), (0.0, 0.0), (cos, sin)];
        let positions = [0.0, 1.0].into_iter().flat_map(|y| xz.map(|(x, z)| DVec3::new(x, y, z))).collect();
        mesh(positions, vec![[0, 1, 4], [0, 4, 3], [1, 2, 5], [1, 5, 4]])
    }

    /// Interpolated light of the front, integrated over the cells, lumens.
    fn flux(lit: &Lit) -> DVec3 {
        let front = lit.front();
        let at = |p: u32| DVec3::from_array(front[p as usize].map(f64::from));
        let triangle = |t: usize| {
            lit.points.cells_points(t).map(|p| p.map(at).into_iter().sum::<DVec3>()).sum::<DVec3>() * lit.lattice.area_in(t) / 3.0
        };
        (0..lit.points.triangles()).map(triangle).sum()
    }

    fn close(a: DVec3, b: DVec3, relative: f64) -> bool {
        (a - b).abs().max_element() <= relative * b.max_element()
    }

    const LUX: [f64; 3] = [300.0, 200.0, 100.0];

    #[test]
    fn what_is_the_same_everywhere_stays_so() {
        let slivers = mesh(
            vec![DVec3::ZERO, DVec3::X, DVec3::new(1.0, 1e-4, 0.0), DVec3::new(0.3, 2e-4, 0.0), DVec3::X * 0.5],
            vec![[0, 1, 2], [0, 2, 3], [0, 4, 1]], // the last has no area
        );
        for (mesh, cell) in [
            (cuboid(DVec3::ONE), 3.0),
            (cuboid(DVec3::ONE), 0.05),
            (cuboid(DVec3::new(2.0, 1e-3, 0.7)), 0.04),
            (slivers.clone(), 3.0),
            (slivers, 0.03),
        ] {
            let mut lit = Lit::new(mesh, cell);
            (0..lit.lattice.cells()).for_each(|cell| lit.light(cell, LUX));
            let front = lit.front();
            assert_eq!(front.len(), lit.points.count() as usize);
            for t in 0..lit.points.triangles() {
                let expected = if lit.lattice.area_in(t) > 0.0 { DVec3::from_array(LUX) } else { DVec3::ZERO };
                for p in lit.points.points_of(t) {
                    let found = DVec3::from_array(front[p as usize].map(f64::from));
                    // Single precision, and whole units of energy in the smallest cells.
                    assert!(close(found, expected, 1e-6), "{found} at point {p}, cells of {cell} m");
                }
            }
        }
    }

    #[test]
    fn light_does_not_leak_over_the_edges_of_a_box() {
        let mut lit = Lit::new(cuboid(DVec3::ONE), 0.1);
        for cell in [10, 11].into_iter().flat_map(|t| lit.lattice.cells_of(t)).collect::<Vec<_>>() {
            lit.light(cell, LUX);
        }
        assert!((0..10).all(|t| !lit.reaches(t)));
        let front = lit.front();
        for p in lit.points.first(10)..lit.points.count() {
            let found = DVec3::from_array(front[p as usize].map(f64::from));
            assert!(close(found, DVec3::from_array(LUX), 1e-6), "up to the edges: {found}");
        }
    }

    #[test]
    fn a_shallow_bend_shares_its_light_and_a_crease_does_not() {
        for (degrees, shares) in [(0.0, true), (20.0, true), (-20.0, true), (40.0, false), (-40.0, false)] {
            let mut lit = Lit::new(bend(degrees), 0.1);
            for cell in [0, 1].into_iter().flat_map(|t| lit.lattice.cells_of(t)).collect::<Vec<_>>() {
                lit.light(cell, LUX);
            }
            assert_eq!(lit.reaches(3), shares, "{degrees}°");
            // Amid the common edge three cells of each square meet: half of the light.
            let n = lit.lattice.divisions(0);
            let amid = lit.points.first(0) + LatticePoints::index(n, n / 2, n - n / 2);
            let half = if shares { 0.5 } else { 1.0 };
            let found = DVec3::from_array(lit.front()[amid as usize].map(f64::from));
            assert!(close(found, DVec3::from_array(LUX) * half, 1e-6), "{degrees}°: {found}");
        }
    }

    #[test]
    fn interpolation_keeps_the_flux() {
        let square = mesh(vec![DVec3::ZERO, DVec3::X, DVec3::X + DVec3::Y, DVec3::Y], vec![[0, 1, 2], [0, 2, 3]]);
        // One cell amid a square, then light from cell to cell as it comes, also up to edges, creases and unequal neighbours.
        for (mesh, cell, everywhere) in
            [(square, 0.03, false), (bend(20.0), 0.1, true), (cuboid(DVec3::new(2.0, 0.01, 0.7)), 0.2, true)]
        {
            let mut lit = Lit::new(mesh, cell);
            let mut sum = DVec3::ZERO;
            for cell in 0..lit.lattice.cells() {
                let part = if everywhere { f64::from(cell * 7919 % 101) / 100.0 } else { f64::from(u8::from(cell == 700)) };
                lit.light(cell, LUX.map(|lux| lux * part));
                sum += DVec3::from_array(LUX) * part * lit.lattice.area(cell);
            }
            let found = flux(&lit);
            assert!(sum.min_element() > 0.0 && close(found, sum, 1e-6), "{found} of {sum}");
        }
    }

    #[test]
    fn a_side_that_no_light_reached_has_none() {
        let mut lit = Lit::new(cuboid(DVec3::ONE), 0.5);
        assert_eq!((lit.side(0), lit.side(1)), (None, None));
        lit.light(3, LUX);
        assert!(lit.side(0).is_some());
        assert_eq!(lit.side(1), None);
    }

    #[test]
    fn a_point_has_the_flux_around_it_over_the_area() {
        // One triangle, one cell, one whole unit of energy a channel.
        let mut lit = Lit::new(mesh(vec![DVec3::ZERO, DVec3::X * 2.0, DVec3::Y], vec![[0, 1, 2]]), 9.0);
        let to = Address { object: 0, cell: 0, side: 0, lamp: 0 };
        lit.buckets.set(to, Bucket { energy: [1 << ENERGY_BITS; 3], hits: 1 });
        let irradiance = lit.scale.irradiance(&lit.buckets, 0, 0, 0, 1.0);
        assert_eq!(lit.front(), [irradiance.value.as_vec3().to_array(); 3], "the triangle has 1 m²");
    }
}
