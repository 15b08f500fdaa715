//! Up to eight rays that leave lamps in much the same direction, through trees together.
//!
//! Boxes are tested against all of them at once, by the intervals in which their origins and directions lie (Reshetov, Soupikov, Hurley
//! 2005, *Multi-Level Ray Tracing Algorithm*). Rounding is monotonic, so what one of the rays enters, the packet enters too: what is met
//! is what each ray would meet by itself, to the bit. Triangles are tested one by one against all the rays.

use crate::{
    lanes::{LANES, Lanes},
    stack::Stack,
    tree::{Block, Planes, SLACK, Skew, Tree, Visit, Way, inverse},
    triangle::{Aim, Hit, Triangle, aims},
};

/// Coordinates of eight vectors.
pub type Vectors = [[f32; LANES]; 3];

/// Eight rays, coordinate by coordinate.
pub struct Rays<'r> {
    /// Metres.
    pub origin: &'r Vectors,
    /// Distances are in multiples of its length.
    pub direction: &'r Vectors,
    /// As of [`Ray`](crate::triangle::Ray).
    pub shear: &'r Vectors,
    /// As of [`Ray`](crate::triangle::Ray).
    pub axes: &'r [[u8; 3]; LANES],
}

/// Those of eight rays, a bit each, whose directions have the signs and the largest coordinate of the first of them.
#[inline(always)]
pub fn alike<L: Lanes>(l: L, direction: &Vectors, of: u32) -> u32 {
    let [x, y, z] = l.load_vectors(direction);
    let (zero, first) = (l.splat(0.0), of.trailing_zeros());
    let Aim { not_x, z_above_y, .. } = aims(l, [x, y, z]);
    let marks = [l.less(x, zero), l.less(y, zero), l.less(z, zero), not_x, z_above_y].map(|mask| l.bits(mask));
    marks.iter().fold(of, |alike, mark| alike & if mark >> first & 1 != 0 { *mark } else { !mark })
}

/// Rays that are [`alike`].
pub struct Packet<L: Lanes> {
    lanes: L,
    /// From where boxes are entered soonest, and left last, per axis.
    origin: [[L::Numbers; 3]; 2],
    /// The least and the greatest inverse of directions.
    inverse: [[L::Numbers; 3]; 2],
    /// Which plane of a box is entered, per axis.
    near: [usize; 3],
    /// The rays' own axes.
    axes: [usize; 3],
    skew: Skew<L>,
}

impl<L: Lanes> Packet<L> {
    /// Of those of eight rays whose bits are set; they are [`alike`].
    #[inline(always)]
    pub fn new(l: L, rays: &Rays, of: u32) -> Packet<L> {
        let first = of.trailing_zeros() as usize % LANES;
        let (zero, mut near) = (l.splat(0.0), [0, 1, 2]);
        let (mut origin, mut inverses) = ([[zero; 3]; 2], [[zero; 3]; 2]);
        for axis in 0..3 {
            let (mut origins, mut directions) = (rays.origin[axis], rays.direction[axis]);
            for k in 0..LANES {
                if of >> k & 1 == 0 {
                    (origins[k], directions[k]) = (origins[first], directions[first]);
                }
            }
            let (low, high) = bounds(origins);
            let (least, most) = bounds(directions.map(inverse));
            let back = least < 0.0;
            near[axis] = if back { axis + 3 } else { axis };
            let [soonest, last] = if back { [low, high] } else { [high, low] };
            (origin[0][axis], origin[1][axis]) = (l.splat(soonest), l.splat(last));
            (inverses[0][axis], inverses[1][axis]) = (l.splat(least), l.splat(most));
        }
        let [x, y, z] = rays.axes[first].map(usize::from);
        // Known from here on, and not looked at again for every triangle.
        assert!(x < 3 && y < 3 && z < 3);
        let turned = [l.load(&rays.origin[x]), l.load(&rays.origin[y]), l.load(&rays.origin[z])];
        let skew = Skew { origin: turned, shear: l.load_vectors(rays.shear) };
        Packet { lanes: l, origin, inverse: inverses, near, axes: [x, y, z], skew }
    }

    /// Between which distances rays cross eight planes, if they start at origin number `end`.
    #[inline(always)]
    fn at(&self, planes: &Planes, plane: usize, axis: usize, end: usize) -> [L::Numbers; 2] {
        let l = self.lanes;
        let way = l.sub(l.load(&planes[plane]), self.origin[end][axis]);
        [l.mul(way, self.inverse[0][axis]), l.mul(way, self.inverse[1][axis])]
    }
}

/// The smallest and the largest.
#[inline(always)]
fn bounds(numbers: [f32; LANES]) -> (f32, f32) {
    let (mut low, mut high, mut half) = (numbers, numbers, LANES / 2);
    while half > 0 {
        for k in 0..half {
            low[k] = if low[k + half] < low[k] { low[k + half] } else { low[k] };
            high[k] = if high[k + half] > high[k] { high[k + half] } else { high[k] };
        }
        half /= 2;
    }
    (low[0], high[0])
}

impl<L: Lanes> Way for Packet<L> {
    type Lanes = L;

    #[inline(always)]
    fn lanes(&self) -> L {
        self.lanes
    }

    #[inline(always)]
    fn soonest(&self, planes: &Planes, axis: usize) -> L::Numbers {
        let [a, b] = self.at(planes, self.near[axis], axis, 0);
        self.lanes.min(a, b)
    }

    #[inline(always)]
    fn latest(&self, planes: &Planes, axis: usize) -> L::Numbers {
        let [a, b] = self.at(planes, 3 + 2 * axis - self.near[axis], axis, 1);
        self.lanes.max(a, b)
    }
}

/// What the rays of a packet met so far.
pub struct Found<'t, L: Lanes> {
    lanes: L,
    distance: L::Numbers,
    weights: [L::Numbers; 3],
    triangles: [Option<&'t Triangle>; LANES],
}

impl<'t, L: Lanes> Found<'t, L> {
    /// Nothing, by those of eight rays whose bits are set. The others will meet nothing.
    #[inline(always)]
    pub fn nothing(l: L, of: u32) -> Found<'t, L> {
        let mut farthest = [f32::MAX; LANES];
        for (k, farthest) in farthest.iter_mut().enumerate() {
            *farthest = if of >> k & 1 != 0 { f32::MAX } else { -1.0 };
        }
        Found { lanes: l, distance: l.load(&farthest), weights: [l.splat(0.0); 3], triangles: [None; LANES] }
    }

    /// How far to search on.
    #[inline(always)]
    pub fn limit(&self) -> f32 {
        bounds(self.lanes.store(self.distance)).1 * SLACK
    }

    /// What each ray met.
    #[inline(always)]
    pub fn hits(self) -> [Option<Hit<'t>>; LANES] {
        let (distance, weights) = (self.lanes.store(self.distance), self.lanes.store_vectors(self.weights));
        let mut hits = [None; LANES];
        for (k, hit) in hits.iter_mut().enumerate() {
            *hit = self.triangles[k].map(|triangle| Hit { distance: distance[k], weights: weights.map(|w| w[k]), triangle });
        }
        hits
    }

    /// Those for which a triangle at the distance of what they met is to be preferred.
    #[cold]
    fn ties(&self, triangle: &Triangle, equal: u32) -> u32 {
        let preferred = |k: &usize| equal >> k & 1 != 0 && self.triangles[*k].is_none_or(|met| triangle.order() < met.order());
        (0..LANES).filter(preferred).fold(0, |bits, k| bits | 1 << k)
    }
}

struct Firsts<'t, 'f, L: Lanes> {
    triangles: &'t [Triangle],
    found: &'f mut Found<'t, L>,
}

impl<L: Lanes> Visit<Packet<L>> for Firsts<'_, '_, L> {
    #[inline(always)]
    fn block(&mut self, packet: &Packet<L>, block: &Block, limit: f32) -> f32 {
        let (l, found, mut nearer) = (packet.lanes, &mut *self.found, false);
        for (k, number) in block.numbers().enumerate() {
            let Some(met) = packet.skew.meets(l, block.splat(l, k, packet.axes), found.distance) else { continue };
            let triangle = &self.triangles[number];
            let mut closer = l.and(met.reached, l.less(met.distance, found.distance));
            if l.bits(closer) != l.bits(met.reached) {
                let equal = l.bits(l.but_not(met.reached, closer));
                closer = l.or(closer, l.select(found.ties(triangle, equal)));
            }
            found.distance = l.choose(closer, met.distance, found.distance);
            for corner in 0..3 {
                found.weights[corner] = l.choose(closer, met.weights[corner], found.weights[corner]);
            }
            let closer = l.bits(closer);
            for (k, met) in found.triangles.iter_mut().enumerate() {
                *met = if closer >> k & 1 != 0 { Some(triangle) } else { *met };
            }
            nearer = true;
        }
        if nearer { found.limit() } else { limit }
    }
}

impl Tree {
    /// Makes what is found the nearest of itself and what the rays meet here.
    #[inline(always)]
    pub fn nearest_each<'t, L: Lanes>(
        &self,
        triangles: &'t [Triangle],
        packet: &Packet<L>,
        stack: &mut Stack,
        found: &mut Found<'t, L>,
    ) {
        self.walk(packet, found.limit(), stack, Firsts { triangles, found });
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{
        body::TreePreset,
        lanes::{Portable, Task, widest},
        triangle::Ray,
        world::World,
    };
    use glam::{DVec3, Vec3};
    use lightmend_scene::{Configuration, Edit, Scene};

    struct Together<'a> {
        world: &'a World,
        rays: &'a [Ray<'a>; LANES],
        of: u32,
    }

    impl<'a> Task for Together<'a> {
        type Output = [Option<Hit<'a>>; LANES];

        fn run<L: Lanes>(self, l: L) -> Self::Output {
            let [mut origin, mut direction, mut shear] = [[[0.0; LANES]; 3]; 3];
            for (k, ray) in self.rays.iter().enumerate() {
                for axis in 0..3 {
                    (origin[axis][k], direction[axis][k], shear[axis][k]) =
                        (ray.origin[axis], ray.direction[axis], ray.shear[axis]);
                }
            }
            let axes = self.rays.map(|ray| ray.axes);
            let rays = Rays { origin: &origin, direction: &direction, shear: &shear, axes: &axes };
            self.world.nearest_each(l, &rays, self.of, &mut Stack::new())
        }
    }

    /// Narrow and wide packets, some of the rays aimed at corners and along edges, where several triangles are equally near.
    #[test]
    fn together_rays_meet_what_each_meets_by_itself() {
        let path = format!("{}/../../scenes/room/room.ron", env!("CARGO_MANIFEST_DIR"));
        let room = Configuration::initial(&Scene::read(path.as_ref()).unwrap().0);
        let moved = room.apply(&Edit::Move { object: "table".into(), to: DVec3::new(2.6, 1.0, 0.0) }).unwrap();
        let world = World::new(&room, TreePreset::default()).moved_to(&moved);
        let triangles = world.still().triangles();
        let (mut state, mut met, mut ties) = (1u64, 0, 0);
        let mut random = |below: usize| {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (state >> 33) as usize % below
        };
        for round in 0..20_000 {
            let mut coordinate = || random(1000) as f32 / 1000.0;
            let from = Vec3::new(0.5 + 4.0 * coordinate(), 0.5 + 3.0 * coordinate(), 0.2 + 2.0 * coordinate());
            let spread = [0.0, 0.001, 0.1, 2.0][round % 4];
            let first = random(triangles.len());
            let rays: [Ray; LANES] = std::array::from_fn(|_| {
                let [a, b, c] = triangles[(first + random(3)) % triangles.len()].corners;
                let target = [a, (a + b) / 2.0, (a + b + c) / 3.0][random(3)];
                let mut off = || (random(1001) as f32 / 500.0 - 1.0) * spread;
                let (off, aside) = (Vec3::new(off(), off(), off()), if round % 8 < 4 { 0.0 } else { off() * 0.1 });
                let direction = target + off - from;
                // Some straight along an axis or in a plane.
                let direction = if random(10) == 0 { direction * Vec3::AXES[random(3)] } else { direction };
                Ray::new(from + aside, if direction == Vec3::ZERO { Vec3::X } else { direction }, None, 0.0)
            });
            let of = if round % 3 == 0 { 1 + random(255) as u32 } else { 255 };
            let portable = Together { world: &world, rays: &rays, of }.run(Portable);
            let wide = widest(Together { world: &world, rays: &rays, of });
            for k in 0..LANES {
                let alone = if of >> k & 1 != 0 { world.nearest(&rays[k]) } else { None };
                let bits = |hit: Option<Hit>| {
                    hit.map(|hit| (hit.distance.to_bits(), hit.weights.map(f32::to_bits), std::ptr::from_ref(hit.triangle)))
                };
                assert!(bits(alone) == bits(portable[k]) && bits(alone) == bits(wide[k]), "round {round}, ray {k}");
                met += u32::from(alone.is_some());
                ties += u32::from(alone.is_some_and(|hit| world.layers(&rays[k], hit).len() > 1 || hit.weights.contains(&0.0)));
            }
        }
        assert!(met > 100_000 && ties > 1_000, "{met} met, {ties} of them on edges or where surfaces coincide");
    }
}
