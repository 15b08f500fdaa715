//! Many rays through a tree together: node by node, each with the list of the rays that enter it.
//!
//! Barringer, Akenine-Möller 2014, *Dynamic Ray Stream Traversal*. A ray by itself waits for each of its steps, and for branches that nobody
//! can foresee; the rays of a list do not wait for one another. Each still visits what it would visit by itself, but for the order.

use crate::{
    lanes::{LANES, Lanes},
    packet::Rays,
    tree::{BLOCK, Block, LARGE, Left, Node, Skew, Tree, limit},
    triangle::{Hit, Ray, Triangle},
};

/// A ray, as tests of boxes and triangles want it: small, so that those of a stream stay near at hand.
struct Line {
    origin: [f32; 3],
    /// Of its direction.
    inverse: [f32; 3],
    shear: [f32; 3],
    axes: [u8; 3],
    /// How far to search on.
    limit: f32,
}

/// A node or block, and where the numbers of the rays that enter it are listed.
#[derive(Clone, Copy)]
struct Entry {
    at: u32,
    first: u32,
    len: u32,
    /// When it is its turn, lists from here on are no longer needed.
    end: u32,
}

/// Rays, and room for lists of them.
#[derive(Default)]
pub struct Stream {
    lines: Vec<Line>,
    /// Which children each ray of a list enters, a bit each.
    masks: Vec<u8>,
    lists: Vec<u16>,
    entries: Vec<Entry>,
}

/// Rays by their numbers in a [`Stream`].
pub trait Numbered<'r> {
    /// Ray number `n`.
    fn ray(&self, n: usize) -> Ray<'r>;
}

impl Stream {
    /// How many rays at most.
    pub const MOST: usize = (1 << 16) - LANES;

    /// Begins anew.
    pub fn clear(&mut self) {
        self.lines.clear();
    }

    /// Adds the first `count` of eight rays.
    #[inline(always)]
    pub fn extend<L: Lanes>(&mut self, l: L, rays: &Rays, count: usize) {
        let Rays { origin, direction, shear, axes } = rays;
        let mut inverses = [[0.0; LANES]; 3];
        for axis in 0..3 {
            // What `inverse` is of one.
            let inverse = l.div(l.splat(1.0), l.load(&direction[axis]));
            inverses[axis] = l.store(l.min(l.max(inverse, l.splat(-LARGE)), l.splat(LARGE)));
        }
        for k in 0..count {
            self.lines.push(Line {
                origin: [origin[0][k], origin[1][k], origin[2][k]],
                inverse: [inverses[0][k], inverses[1][k], inverses[2][k]],
                shear: [shear[0][k], shear[1][k], shear[2][k]],
                axes: axes[k],
                limit: f32::INFINITY,
            });
        }
    }

    /// Ray number `n` is searched on up to `limit` only.
    pub fn shorten(&mut self, n: usize, limit: f32) {
        self.lines[n].limit = limit;
    }
}

impl Tree {
    /// Makes each of `met` the nearest of itself and what its ray meets here.
    #[inline(always)]
    pub fn nearest_of_all<'t, 'r, L: Lanes>(
        &self,
        l: L,
        triangles: &'t [Triangle],
        rays: &impl Numbered<'r>,
        stream: &mut Stream,
        met: &mut [Option<Hit<'t>>],
    ) {
        if self.nodes.is_empty() || met.is_empty() {
            return;
        }
        let Stream { lines, masks, lists, entries } = stream;
        let all = met.len().next_multiple_of(LANES);
        masks.resize(all + LANES, 0);
        lists.clear();
        lists.extend(0..all as u16);
        entries.clear();
        entries.push(Entry { at: 0, first: 0, len: met.len() as u32, end: all as u32 });
        while let Some(Entry { at, first, len, end }) = entries.pop() {
            let (own, end) = (first as usize..(first + len) as usize, end as usize);
            if at & BLOCK != 0 {
                self.blocks[(at ^ BLOCK) as usize].meet_each(l, triangles, &lists[own], lines, rays, met);
            } else {
                let len = len as usize;
                let room = end + LANES * (len + LANES);
                if lists.len() < room {
                    lists.resize(room, 0);
                }
                let (listed, free) = lists.split_at_mut(end);
                let node = &self.nodes[at as usize];
                let listed = &listed[own.start..];
                let (mut any, enter) = node.enter_each(l, &listed[..len], lines, masks);
                let masks = &masks[..len.next_multiple_of(LANES)];
                let mut sorted = [(0.0, Entry { at: 0, first: 0, len: 0, end: 0 }); LANES];
                let (mut children, mut used) = (0, 0);
                while any != 0 {
                    let k = any.trailing_zeros() as usize & 7;
                    any &= any - 1;
                    let count = pick(l, listed, masks, k, &mut free[used..]);
                    let (mean, child) = (enter[k] / count as f32, node.children[k]);
                    let mut place = children & 7;
                    while place > 0 && sorted[place - 1].0 < mean {
                        sorted[place] = sorted[place - 1];
                        place -= 1;
                    }
                    sorted[place] = (mean, Entry { at: child, first: (end + used) as u32, len: count as u32, end: 0 });
                    children += 1;
                    used += count.next_multiple_of(LANES);
                    if child & BLOCK != 0 {
                        l.fetch(&self.blocks[(child ^ BLOCK) as usize]);
                    } else {
                        l.fetch(&self.nodes[child as usize]);
                    }
                }
                for (_, entry) in &sorted[..children] {
                    entries.push(Entry { end: (end + used) as u32, ..*entry });
                }
            }
        }
    }
}

/// Lists the rays that enter child number `k`; how many. Lists are read and written eight by eight.
#[inline(always)]
fn pick<L: Lanes>(l: L, listed: &[u16], masks: &[u8], k: usize, to: &mut [u16]) -> usize {
    let (listed, masks, mut count) = (listed.as_chunks::<LANES>().0, masks.as_chunks::<LANES>().0, 0);
    for (numbers, masks) in listed.iter().zip(masks) {
        // One bit of each byte, gathered into one.
        let bits = (u64::from_le_bytes(*masks) >> k & 0x0101_0101_0101_0101).wrapping_mul(0x0102_0408_1020_4080) >> 56;
        to[count..count + LANES].copy_from_slice(&l.pack(numbers, bits as u8));
        count += bits.count_ones() as usize;
    }
    count
}

impl Node {
    /// Which children some rays enter: a mask for each ray, and for all together with the sums of the distances where they enter.
    #[inline(always)]
    fn enter_each<L: Lanes>(&self, l: L, listed: &[u16], lines: &[Line], masks: &mut [u8]) -> (u8, [f32; LANES]) {
        let [x0, y0, z0, x1, y1, z1] = &self.planes;
        // What is no child would be entered, since its planes are not looked at in the order of the ray.
        let children = l.bits(l.at_most(l.load(x0), l.load(x1)));
        let (mut sum, mut any) = (l.splat(0.0), 0);
        masks[listed.len()..][..LANES].fill(0);
        for (n, mask) in listed.iter().zip(masks) {
            let Line { origin: [x, y, z], inverse: [ix, iy, iz], limit, .. } = &lines[*n as usize];
            let (ox, oy, oz) = (l.splat(*x), l.splat(*y), l.splat(*z));
            let (ix, iy, iz) = (l.splat(*ix), l.splat(*iy), l.splat(*iz));
            let x = (l.mul(l.sub(l.load(x0), ox), ix), l.mul(l.sub(l.load(x1), ox), ix));
            let y = (l.mul(l.sub(l.load(y0), oy), iy), l.mul(l.sub(l.load(y1), oy), iy));
            let z = (l.mul(l.sub(l.load(z0), oz), iz), l.mul(l.sub(l.load(z1), oz), iz));
            let enter = l.max(l.max(l.min(x.0, x.1), l.min(y.0, y.1)), l.max(l.min(z.0, z.1), l.splat(0.0)));
            let leave = l.min(l.min(l.max(x.0, x.1), l.max(y.0, y.1)), l.min(l.max(z.0, z.1), l.splat(*limit)));
            let inside = l.at_most(enter, leave);
            sum = l.add(sum, l.choose(inside, enter, l.splat(0.0)));
            *mask = (l.bits(inside) & children) as u8;
            any |= *mask;
        }
        (any, l.store(sum))
    }
}

impl Block {
    /// Makes what some rays met the nearest of itself and these triangles.
    #[inline(always)]
    fn meet_each<'t, 'r, L: Lanes>(
        &self,
        l: L,
        triangles: &'t [Triangle],
        listed: &[u16],
        lines: &mut [Line],
        rays: &impl Numbered<'r>,
        met: &mut [Option<Hit<'t>>],
    ) {
        for n in listed {
            let (line, best) = (&mut lines[*n as usize], &mut met[*n as usize]);
            let [x, y, z] = line.axes.map(usize::from);
            assert!(x < 3 && y < 3 && z < 3);
            let skew = Skew {
                origin: [l.splat(line.origin[x]), l.splat(line.origin[y]), l.splat(line.origin[z])],
                shear: [l.splat(line.shear[0]), l.splat(line.shear[1]), l.splat(line.shear[2])],
            };
            let farthest = best.map_or(f32::MAX, |b| b.distance);
            let Some(found) = skew.meets(l, self.load(l, [x, y, z]), l.splat(farthest)) else { continue };
            let ray = rays.ray(*n as usize);
            let left = Left::new(&ray, triangles);
            for hit in found.hits(l, self, triangles) {
                if ray.prefers(&hit, best, left.differs_from(hit.triangle)) {
                    *best = Some(hit);
                    // It is looked at when the photon arrives.
                    l.fetch(hit.triangle);
                }
            }
            line.limit = limit(best);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{
        body::TreePreset,
        hash::mix,
        lanes::{Portable, Task, widest},
        packet::Vectors,
        stack::Stack,
        world::World,
    };
    use glam::Vec3;
    use lightmend_scene::{Configuration, Edit, Scene};

    struct Given<'a>(&'a [Ray<'a>]);

    impl<'a> Numbered<'a> for Given<'a> {
        fn ray(&self, n: usize) -> Ray<'a> {
            self.0[n]
        }
    }

    struct Together<'a>(&'a World, &'a [Ray<'a>]);

    impl<'a> Task for Together<'a> {
        type Output = Vec<Option<Hit<'a>>>;

        fn run<L: Lanes>(self, l: L) -> Self::Output {
            let Together(world, rays) = self;
            let mut stream = Stream::default();
            for eight in rays.chunks(LANES) {
                let ([mut origin, mut direction, mut shear], mut axes): ([Vectors; 3], _) =
                    ([[[0.0; LANES]; 3]; 3], [[0; 3]; LANES]);
                for (k, ray) in eight.iter().enumerate() {
                    for axis in 0..3 {
                        (origin[axis][k], direction[axis][k], shear[axis][k]) =
                            (ray.origin[axis], ray.direction[axis], ray.shear[axis]);
                    }
                    axes[k] = ray.axes;
                }
                let rays = Rays { origin: &origin, direction: &direction, shear: &shear, axes: &axes };
                stream.extend(l, &rays, eight.len());
            }
            let mut met = vec![None; rays.len()];
            world.nearest_of_all(l, &Given(rays), &mut stream, &mut Stack::new(), &mut met);
            met
        }
    }

    /// Rays that leave surfaces in all directions, some of them straight along an axis or towards corners, past what moved and what did not.
    #[test]
    fn together_rays_meet_what_each_meets_by_itself() {
        let path = format!("{}/../../scenes/room/room.ron", env!("CARGO_MANIFEST_DIR"));
        let room = Configuration::initial(&Scene::read(path.as_ref()).unwrap().0);
        let moved = room.apply(&Edit::Move { object: "table".into(), to: glam::DVec3::new(2.6, 1.0, 0.0) }).unwrap();
        let worlds = [World::new(&room, TreePreset::default()), World::new(&room, TreePreset::default()).moved_to(&moved)];
        for world in &worlds {
            let triangles = world.still().triangles();
            let ray = |n: u64| {
                let random = |k: u64| (mix(8 * n + k) >> 40) as f32 / (1u64 << 24) as f32;
                let left = &triangles[(random(0) * triangles.len() as f32) as usize];
                let (u, v) = (random(1), random(2));
                let from = left.point([1.0 - u.max(v), u.min(v), (u - v).abs()]) + left.normal * 1e-4;
                let direction = Vec3::new(random(3), random(4), random(5)) * 2.0 - 1.0;
                let direction = match n % 7 {
                    0 => direction * Vec3::AXES[n as usize % 3],
                    1 => triangles[(random(6) * triangles.len() as f32) as usize].corners[1] - from,
                    _ => direction,
                };
                Ray::new(from, direction, Some(left), 1e-4)
            };
            for count in [1usize, 3, 64, 5000] {
                let rays: Vec<Ray> = (0..count as u64).map(ray).filter(|ray| ray.direction.length() > 1e-3).collect();
                let bits = |hit: &Option<Hit>| {
                    hit.map(|hit| (hit.distance.to_bits(), hit.weights.map(f32::to_bits), std::ptr::from_ref(hit.triangle)))
                };
                let alone: Vec<_> = rays.iter().map(|ray| bits(&world.nearest(ray))).collect();
                let met = |hits: Vec<Option<Hit>>| hits.iter().map(bits).collect::<Vec<_>>();
                assert!(alone == met(widest(Together(world, &rays))), "{count} rays");
                assert!(alone == met(Together(world, &rays).run(Portable)), "{count} rays, portably");
                assert!(count < 64 || alone.iter().filter(|hit| hit.is_some()).count() > count / 2);
            }
        }
    }
}
