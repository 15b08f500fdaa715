//! Photons under way, eight by eight, coordinate by coordinate.

use super::Log;
use crate::{
    lanes::{LANES, Lanes, dots},
    packet::{Rays, Vectors},
    path::{Brought, LONGEST_PATH, Photon, Record, Rules, before, reflectance},
    pool::PhotonIndex,
    sampling::cosine_hemispheres,
    stream::Numbered,
    triangle::{Aim, Hit, Ray, Triangle, aims, axes, points},
    world::World,
};

/// Photons under way, eight of them: about to leave a lamp or a surface.
#[derive(Clone)]
pub struct Eight<'w> {
    /// By which a log knows them.
    pub numbers: [u32; LANES],
    indices: [PhotonIndex; LANES],
    /// The lamps that they left.
    pub lamps: [u16; LANES],
    /// Whether their next hits deposit.
    counts: [bool; LANES],
    hits: [u32; LANES],
    /// What is left of them, per channel.
    pub throughput: Vectors,
    origin: Vectors,
    direction: Vectors,
    axes: [[u8; 3]; LANES],
    shear: Vectors,
    leaves: [Option<&'w Triangle>; LANES],
    near: [f32; LANES],
}

impl<'w> Eight<'w> {
    const NONE: Eight<'w> = Eight {
        numbers: [0; LANES],
        indices: [PhotonIndex(0); LANES],
        lamps: [0; LANES],
        counts: [false; LANES],
        hits: [0; LANES],
        throughput: [[0.0; LANES]; 3],
        origin: [[0.0; LANES]; 3],
        direction: [[0.0; LANES]; 3],
        axes: [[0; 3]; LANES],
        shear: [[0.0; LANES]; 3],
        leaves: [None; LANES],
        near: [0.0; LANES],
    };

    /// The ray that one of them is on.
    #[inline(always)]
    pub fn ray(&self, k: usize) -> Ray<'w> {
        Ray {
            origin: lane(&self.origin, k).into(),
            direction: lane(&self.direction, k).into(),
            leaves: self.leaves[k],
            near: self.near[k],
            axes: self.axes[k],
            shear: lane(&self.shear, k),
        }
    }

    /// Their rays.
    #[inline(always)]
    pub fn rays(&self) -> Rays<'_> {
        Rays { origin: &self.origin, direction: &self.direction, shear: &self.shear, axes: &self.axes }
    }

    /// One of them.
    #[inline(always)]
    pub fn photon(&self, k: usize) -> Photon<'w> {
        let brings = Brought { lamp: self.lamps[k], throughput: lane(&self.throughput, k).into(), counts: self.counts[k] };
        Photon::under_way(self.indices[k], self.hits[k], brings, self.ray(k))
    }

    /// Sets the directions and what follows from them.
    #[inline(always)]
    fn aim<L: Lanes>(&mut self, l: L, directions: [L::Numbers; 3]) {
        // Adding zero turns -0 into 0, as a ray does.
        let [x, y, z] = directions;
        let directions = [l.add(x, l.splat(0.0)), l.add(y, l.splat(0.0)), l.add(z, l.splat(0.0))];
        let Aim { not_x, z_above_y, down, shear } = aims(l, directions);
        (self.direction, self.shear) = (l.store_vectors(directions), l.store_vectors(shear));
        let (not_x, z_above_y, down) = (l.bits(not_x), l.bits(z_above_y), l.bits(down));
        let bit = |mask: u32, k: usize| mask >> k & 1 != 0;
        self.axes = std::array::from_fn(|k| axes(bit(not_x, k), bit(z_above_y, k), bit(down, k)));
    }

    /// They arrive, or the first ones; who of them goes on, a bit each.
    #[inline(always)]
    pub fn land<L: Lanes>(&self, l: L, rules: &Rules, world: &World, met: &[Option<Hit>], log: &mut impl Log) -> (Landing, u32) {
        let [mut normal, mut reflected] = [[[0.0; LANES]; 3]; 2];
        for (k, hit) in met.iter().enumerate() {
            if let Some(hit) = hit {
                set_lane(&mut normal, k, hit.triangle.normal.to_array());
            }
        }
        let [x, y, z] = l.load_vectors(&normal);
        let back = l.less(l.splat(0.0), dots(l, [x, y, z], l.load_vectors(&self.direction)));
        let facing = [l.choose(back, l.negative(x), x), l.choose(back, l.negative(y), y), l.choose(back, l.negative(z), z)];
        let back = l.bits(back);
        let (mut u, mut of) = ([1.0; LANES], [1.0; LANES]);
        for (k, hit) in met.iter().enumerate() {
            let Some(hit) = hit else {
                log.missed(self.numbers[k], &self.ray(k));
                continue;
            };
            let side = (back >> k & 1) as u8;
            log.of(self.numbers[k]).hit(hit, side, lane(&self.throughput, k).into(), self.lamps[k], self.counts[k], world);
            set_lane(&mut reflected, k, reflectance(world, hit).to_array());
            [u[k], of[k]] = rules.sequence.fraction(self.indices[k].0, 2 + 2 * self.hits[k] as usize);
        }
        let [red, green, blue] = l.load_vectors(&reflected);
        let survival = l.max(red, l.max(green, blue));
        let [of_red, of_green, of_blue] = l.load_vectors(&self.throughput);
        let throughput =
            [l.mul(of_red, l.div(red, survival)), l.mul(of_green, l.div(green, survival)), l.mul(of_blue, l.div(blue, survival))];
        let survival = l.store(survival);
        let mut chances = [0.0; LANES];
        for k in 0..LANES {
            chances[k] = f64::from(survival[k]);
        }
        let numbers = l.load_doubles(&u) / l.load_doubles(&of);
        let (numbers, remapped) = (l.store_doubles(numbers), l.store_doubles(numbers / l.load_doubles(&chances)));
        let mut going = 0;
        for k in 0..met.len() {
            let (survives, spent) = (numbers[k] < chances[k], self.hits[k] + 1 == LONGEST_PATH);
            going |= u32::from(survives & !spent) << k;
            u[k] = if survives { remapped[k].min(1.0f64.next_down()) } else { 1.0 };
        }
        (Landing { throughput: l.store_vectors(throughput), u, facing: l.store_vectors(facing) }, going)
    }
}

/// One of eight vectors.
#[inline(always)]
pub fn lane(vectors: &Vectors, k: usize) -> [f32; 3] {
    vectors.map(|coordinates| coordinates[k])
}

#[inline(always)]
fn set_lane(vectors: &mut Vectors, k: usize, to: [f32; 3]) {
    vectors.iter_mut().zip(to).for_each(|(coordinates, to)| coordinates[k] = to);
}

/// What becomes of eight photons at the surfaces that they met.
#[derive(Clone)]
pub struct Landing {
    /// What is left of them, per channel.
    pub throughput: Vectors,
    /// Random numbers, remapped after the decision that they survive; 1 if they do not.
    pub u: [f64; LANES],
    /// Normals on the side where they arrived.
    facing: Vectors,
}

/// A photon before it leaves its lamp.
#[derive(Clone, Copy)]
pub struct Start {
    number: u32,
    index: PhotonIndex,
    /// Which lamp, and in which direction.
    u: [f64; 2],
}

/// Photons with their numbers.
pub fn starts(rules: &Rules, indices: impl Iterator<Item = (u32, PhotonIndex)>) -> Vec<Start> {
    let start =
        |(number, index): (u32, PhotonIndex)| Start { number, index, u: [0, 1].map(|d| rules.sequence.value(index.0, d)) };
    indices.map(start).collect()
}

/// The most columns among which photons are sorted, and the rows.
const GRID: [usize; 2] = [16, 128];

/// The order of photons in which those leave together that leave in much the same direction: by columns, then by rows.
pub fn neighbours(starts: &[Start]) -> Vec<u32> {
    let (mut low, mut high) = ([1.0f64; 2], [0.0f64; 2]);
    for start in starts {
        for d in 0..2 {
            low[d] = low[d].min(start.u[d]);
            high[d] = high[d].max(start.u[d]);
        }
    }
    // Eight of them then leave from about a square.
    let columns = (starts.len() / 16).isqrt().clamp(1, GRID[0]);
    let mut scale = [columns, GRID[1]].map(|cells| cells as f64 * (1.0 - 1e-9));
    for d in 0..2 {
        scale[d] /= (high[d] - low[d]).max(f64::MIN_POSITIVE);
    }
    let mut before = [0u32; GRID[0] * GRID[1]];
    let mut places = Vec::with_capacity(starts.len());
    for start in starts {
        let [column, row] = [0, 1].map(|d| ((start.u[d] - low[d]) * scale[d]) as usize);
        let place = column % GRID[0] * GRID[1] + row % GRID[1];
        before[place] += 1;
        places.push(place as u16);
    }
    let mut sum = 0;
    for count in &mut before {
        sum += std::mem::replace(count, sum);
    }
    let mut order = vec![0; starts.len()];
    for (n, place) in (0..).zip(places) {
        let place = &mut before[usize::from(place)];
        order[*place as usize] = n;
        *place += 1;
    }
    order
}

/// Photons side by side; all eights but the last are full.
#[derive(Default)]
pub struct Flock<'w> {
    /// Perhaps more than there are photons for: a flock that is cleared keeps them, and what is in them.
    eights: Vec<Eight<'w>>,
    /// How many photons.
    pub len: usize,
}

impl<'w> Numbered<'w> for Flock<'w> {
    #[inline(always)]
    fn ray(&self, n: usize) -> Ray<'w> {
        self.eights[n / LANES].ray(n % LANES)
    }
}

impl<'w> Flock<'w> {
    /// Without photons.
    pub fn clear(&mut self) {
        self.len = 0;
    }

    /// They, eight by eight.
    pub fn eights(&self) -> &[Eight<'w>] {
        &self.eights[..self.len.div_ceil(LANES)]
    }

    /// Room for eight more, to be set in place: copying them would take as long as computing them.
    #[inline(always)]
    fn next(&mut self) -> &mut Eight<'w> {
        let used = self.len / LANES;
        if used == self.eights.len() {
            self.eights.push(Eight::NONE);
        }
        &mut self.eights[used]
    }

    /// Those of eight number `n`.
    pub fn lanes(&self, n: usize) -> usize {
        (self.len - n * LANES).min(LANES)
    }

    /// Adds photons and leaves none.
    pub fn join(&mut self, others: &mut &[(u32, Photon<'w>)]) {
        std::mem::take(others).iter().for_each(|(number, photon)| self.push(*number, photon));
    }

    /// Adds a photon.
    fn push(&mut self, number: u32, photon: &Photon<'w>) {
        let k = self.len % LANES;
        let (eight, ray, Brought { lamp, throughput, counts }) = (self.next(), photon.ray(), photon.brings());
        (eight.numbers[k], eight.indices[k], eight.hits[k]) = (number, photon.index(), photon.hits());
        (eight.lamps[k], eight.counts[k]) = (lamp, counts);
        (eight.axes[k], eight.leaves[k], eight.near[k]) = (ray.axes, ray.leaves, ray.near);
        set_lane(&mut eight.throughput, k, throughput.to_array());
        set_lane(&mut eight.origin, k, ray.origin.to_array());
        set_lane(&mut eight.direction, k, ray.direction.to_array());
        set_lane(&mut eight.shear, k, ray.shear);
        self.len += 1;
    }

    /// Emits photons, in an order.
    #[inline(always)]
    pub fn emit_all<L: Lanes>(
        &mut self,
        l: L,
        rules: &Rules,
        world: &'w World,
        starts: &[Start],
        order: &[u32],
        log: &mut impl Log,
    ) {
        self.eights.reserve(order.len().div_ceil(LANES));
        for eight in order.chunks(LANES) {
            self.emit(l, rules, world, starts, eight, log);
        }
    }

    /// Emits eight photons (or fewer, the last ones).
    #[inline(always)]
    fn emit<L: Lanes>(&mut self, l: L, rules: &Rules, world: &'w World, starts: &[Start], order: &[u32], log: &mut impl Log) {
        let (mut u, mut v) = ([0.0; LANES], [0.0; LANES]);
        let eight = self.next();
        let (mut alike, mut dark) = (true, false);
        for (k, start) in order.iter().map(|n| &starts[*n as usize]).enumerate() {
            let chosen = world.choice().choose(start.u[0]);
            log.emitted(start.number, chosen.map(|(lamp, _)| lamp as u16));
            let Some((lamp, remapped)) = chosen else {
                dark = true;
                continue;
            };
            let Brought { lamp: number, counts, .. } = Brought::from_lamp(rules, world, lamp as u16);
            (u[k], v[k]) = (remapped, start.u[1]);
            (eight.numbers[k], eight.indices[k], eight.lamps[k], eight.counts[k]) = (start.number, start.index, number, counts);
            alike &= number == eight.lamps[0];
        }
        if dark {
            return;
        }
        let lamp = |k: usize| usize::from(eight.lamps[k]);
        let direction = if alike {
            world.emissions(l, lamp(0), &u, &v)
        } else {
            let mut direction = [[0.0; LANES]; 3];
            (0..order.len()).for_each(|k| set_lane(&mut direction, k, world.emission(lamp(k), u[k], v[k]).to_array()));
            direction
        };
        for k in 0..order.len() {
            let placed = &world.lamps()[lamp(k)];
            set_lane(&mut eight.origin, k, placed.start(lane(&direction, k).into()).to_array());
        }
        (eight.hits, eight.throughput, eight.leaves, eight.near) = ([0; LANES], [[1.0; LANES]; 3], [None; LANES], [0.0; LANES]);
        eight.aim(l, l.load_vectors(&direction));
        self.len += order.len();
    }

    /// The survivors leave the surfaces that they met: `places` are theirs among `from`, `met` and `landings`.
    #[inline(always)]
    pub fn leave<L: Lanes>(
        &mut self,
        l: L,
        rules: &Rules,
        step_back: f32,
        from: &Flock<'w>,
        (met, landings): (&[Option<Hit<'w>>], &[Landing]),
        places: &[u32],
    ) {
        let eight = self.next();
        let (mut u, mut v, mut of, mut distance) = ([0.0; LANES], [0.0; LANES], [1.0; LANES], [0.0; LANES]);
        let [mut facing, mut along, mut weights] = [[[0.0; LANES]; 3]; 3];
        let mut corners = [[[0.0; LANES]; 3]; 3];
        for (k, place) in places.iter().map(|place| *place as usize).enumerate() {
            let (n, j) = (place / LANES, place % LANES);
            let (was, landing) = (&from.eights[n], &landings[n]);
            let Some(hit) = &met[place] else { continue };
            (eight.numbers[k], eight.indices[k], eight.lamps[k]) = (was.numbers[j], was.indices[j], was.lamps[j]);
            (eight.hits[k], eight.counts[k], eight.leaves[k]) = (was.hits[j] + 1, true, Some(hit.triangle));
            set_lane(&mut eight.throughput, k, lane(&landing.throughput, j));
            set_lane(&mut facing, k, lane(&landing.facing, j));
            set_lane(&mut along, k, lane(&was.direction, j));
            set_lane(&mut weights, k, hit.weights);
            corners.iter_mut().zip(&hit.triangle.corners).for_each(|(to, corner)| set_lane(to, k, corner.to_array()));
            distance[k] = hit.distance;
            u[k] = landing.u[j];
            [v[k], of[k]] = rules.sequence.fraction(was.indices[j].0, 3 + 2 * was.hits[j] as usize);
        }
        let (facing, along) = (l.load_vectors(&facing), l.load_vectors(&along));
        let directions = cosine_hemispheres(l, facing, l.load_doubles(&u), l.load_doubles(&v) / l.load_doubles(&of));
        let corners = [l.load_vectors(&corners[0]), l.load_vectors(&corners[1]), l.load_vectors(&corners[2])];
        let points = points(l, corners, l.load_vectors(&weights));
        eight.origin = l.store_vectors(before(l, points, l.load(&distance), facing, along, step_back));
        eight.near = [step_back; LANES];
        eight.aim(l, directions);
        self.len += places.len();
    }
}
