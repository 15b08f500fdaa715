//! Mesh elements: the cells of a barycentric lattice on the source triangles.
//!
//! Elements are arithmetic, not triangles: rays meet source triangles, and the cell follows from the barycentric coordinates of
//! the hit. A triangle cut into n² equal cells has rows i = ⌊b₁n⌋ of 2(n−i)−1 cells, alternately upright and inverted.

use crate::Mesh;

/// The cells of one mesh: how each triangle is cut and where its cells begin.
#[derive(Debug, Clone, PartialEq)]
pub struct Lattice {
    /// How each triangle is cut; one more entry than triangles.
    cuts: Vec<Cut>,
    /// Area of one cell of each triangle, m².
    cell_area: Vec<f64>,
}

/// How a triangle is cut.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Cut {
    /// Its first cell.
    pub first: u32,
    /// Divisions n of its edges; at least 1 for a triangle.
    pub divisions: u32,
}

impl Cut {
    /// The cell of a point; `b1`, `b2` are the barycentric weights of the second and third corner.
    #[inline(always)]
    pub fn cell(self, b1: f32, b2: f32) -> u32 {
        // Without branches: how finely a triangle is cut cannot be foreseen, and a wrong guess costs more than all of this.
        let Cut { first, divisions: n } = self;
        let (x, y) = ((b1 * n as f32).max(0.0), (b2 * n as f32).max(0.0));
        let row = (x as u32).min(n - 1);
        let column = (y as u32).min(n - 1 - row);
        let inverted = ((x - row as f32) + (y - column as f32) > 1.0) & (row + column < n - 1);
        first + row * (2 * n - row) + 2 * column + u32::from(inverted)
    }
}

impl Lattice {
    /// Cuts every triangle of longest edge e into ⌈e / cell⌉² cells. `cell` in metres.
    /// `None` if there are more cells than a `u32` can number.
    pub fn new(mesh: &Mesh, cell: f64) -> Option<Lattice> {
        let mut lattice = Lattice { cuts: Vec::new(), cell_area: Vec::new() };
        let mut total = 0u64;
        let number = |total: u64| u32::try_from(total).ok().filter(|t| *t < u32::MAX / 2);
        for t in 0..mesh.triangles.len() {
            let [a, b, c] = mesh.corners(t);
            let longest = a.distance(b).max(b.distance(c)).max(c.distance(a));
            let n = (longest / cell).ceil().max(1.0);
            if n > 30_000.0 {
                return None;
            }
            let n = n as u32;
            lattice.cuts.push(Cut { first: number(total)?, divisions: n });
            total += u64::from(n) * u64::from(n);
            lattice.cell_area.push((b - a).cross(c - a).length() / 2.0 / f64::from(n) / f64::from(n));
        }
        lattice.cuts.push(Cut { first: number(total)?, divisions: 0 });
        Some(lattice)
    }

    /// All cells of the mesh, counted once (not per side).
    pub fn cells(&self) -> u32 {
        self.cuts[self.cuts.len() - 1].first
    }

    /// Divisions of triangle `t`'s edges.
    pub fn divisions(&self, t: usize) -> u32 {
        self.cuts[t].divisions
    }

    /// Corners of the cells of triangle `t`: its lattice points.
    pub fn points_in(&self, t: usize) -> u32 {
        let n = self.cuts[t].divisions;
        (n + 1) * (n + 2) / 2
    }

    /// How triangle `t` is cut.
    pub fn cut(&self, t: usize) -> Cut {
        self.cuts[t]
    }

    /// The cell of a point of triangle `t`; `b1`, `b2` are the barycentric weights of its second and third corner.
    pub fn cell(&self, t: usize, b1: f32, b2: f32) -> u32 {
        self.cuts[t].cell(b1, b2)
    }

    /// The triangle that cell `cell` belongs to.
    pub fn triangle_of(&self, cell: u32) -> usize {
        self.cuts.partition_point(|cut| cut.first <= cell) - 1
    }

    /// Area of cell `cell`, m².
    pub fn area(&self, cell: u32) -> f64 {
        self.cell_area[self.triangle_of(cell)]
    }

    /// Area of each cell of triangle `t`, m².
    pub fn area_in(&self, t: usize) -> f64 {
        self.cell_area[t]
    }

    /// The cells of triangle `t`.
    pub fn cells_of(&self, t: usize) -> std::ops::Range<u32> {
        self.cuts[t].first..self.cuts[t + 1].first
    }

    /// The centres of the cells of triangle `t`, in the order of [`cells_of`](Self::cells_of): barycentric weights of its second and third corner.
    pub fn centres(&self, t: usize) -> impl Iterator<Item = [f64; 2]> + use<> {
        let n = self.divisions(t);
        (0..n).flat_map(move |i| {
            (0..2 * (n - i) - 1).map(move |m| {
                let third = if m % 2 == 0 { 1.0 / 3.0 } else { 2.0 / 3.0 };
                [i, m / 2].map(|step| (f64::from(step) + third) / f64::from(n))
            })
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DVec3;

    fn triangle(size: f64) -> Mesh {
        Mesh {
            positions: vec![DVec3::ZERO, DVec3::X * size, DVec3::Y * size],
            triangles: vec![[0, 1, 2]],
            material_of: vec![0],
            materials: vec!["m".into()],
            uvs: vec![],
        }
    }

    #[test]
    fn every_cell_is_met_equally_often() {
        let lattice = Lattice::new(&triangle(1.0), 0.3).unwrap();
        let n = lattice.divisions(0);
        assert_eq!((n, lattice.cells()), (5, 25));
        let mut met = vec![0u32; 25];
        let fine = 100; // points at the middles of a finer lattice, 400 a cell
        for i in 0..fine {
            for j in 0..fine - i {
                for (dx, dy) in [(1.0 / 3.0, 1.0 / 3.0), (2.0 / 3.0, 2.0 / 3.0)] {
                    let (x, y) = ((i as f32 + dx) / fine as f32, (j as f32 + dy) / fine as f32);
                    if x + y < 1.0 {
                        met[lattice.cell(0, x, y) as usize] += 1;
                    }
                }
            }
        }
        assert!(met.iter().all(|m| *m == 400), "{met:?}");
    }

    #[test]
    fn rounding_never_leaves_the_triangle() {
        let lattice = Lattice::new(&triangle(1.0), 0.01).unwrap();
        for (b1, b2) in [(1.0, 0.0), (0.0, 1.0), (0.5, 0.5), (1.0000001, 0.0), (-1e-9, 1.0000001), (0.50000006, 0.5)] {
            assert!(lattice.cell(0, b1, b2) < lattice.cells());
        }
        assert_eq!(lattice.triangle_of(lattice.cells() - 1), 0);
    }
}
