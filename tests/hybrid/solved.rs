//! A scene solved by photons and drawn, and the two compared element by element.

use glam::DVec3;
use lightmend_photon::{
    bucket::{Buckets, ENERGY_BITS},
    irradiance::Scale,
    path::FirstHits,
    reconstruction::{Reconstruction, Shapes},
};
use lightmend_raster::{Indirect, Parts, Renderer, side_light};
use lightmend_scene::{Configuration, Scene, View};
use lightmend_tests::{
    pixels::{all_around, draw, pixels, renderer},
    pool, shoot, world,
};
use std::{
    collections::{BTreeMap, btree_map::Entry},
    sync::Arc,
};

const SIZE: u32 = 640;

/// A view sees the whole of an element if its pixels cover its area to this share.
const WHOLE: f64 = 0.01;

/// With fewer pixels the sum over them says too little.
const FEWEST_PIXELS: usize = 200;

/// With fewer photons expected their number is not normally distributed.
const FEWEST_PHOTONS: f64 = 30.0;

/// Object, cell, side.
type Element = (usize, u32, usize);

/// What the pixels of one view add up to on an element.
#[derive(Debug, Clone, Copy, Default)]
struct Seen {
    pixels: usize,
    /// m².
    area: f64,
    /// Lumens.
    direct: DVec3,
    /// Squares of green lux, by area.
    squares: f64,
    /// Lumens.
    indirect: DVec3,
}

impl Seen {
    fn add(&mut self, other: &Seen) {
        self.pixels += other.pixels;
        self.area += other.area;
        self.direct += other.direct;
        self.squares += other.squares;
        self.indirect += other.indirect;
    }

    /// Keeps it if it is the whole of `area` m², with more pixels than what is there.
    fn keep<K: Ord>(&self, area: f64, place: Entry<'_, K, Seen>) {
        if (self.area / area - 1.0).abs() <= WHOLE && self.pixels >= FEWEST_PIXELS {
            let best = place.or_default();
            if self.pixels > best.pixels {
                *best = *self;
            }
        }
    }

    /// Of mean direct irradiance: what a grid of n pixels errs in the mean of something with an edge (a shadow's) goes with n^−¾, since
    /// only the √n pixels along the edge matter, each by chance (Matoušek 1999, §1.4).
    fn variance(&self) -> f64 {
        let spread = self.squares / self.area - (self.direct.y / self.area).powi(2);
        spread.max(0.0) * (self.pixels as f64).powf(-1.5)
    }
}

/// A scene solved and drawn.
pub struct Hybrid {
    configuration: Configuration,
    scale: Scale,
    /// All light.
    always: Buckets,
    /// Without what the rasteriser draws.
    indirect: Buckets,
    shapes: Shapes,
    /// Irradiance at the lattice points of each object's sides.
    irradiance: Indirect,
    /// Elements of which the whole was seen; the sums of the eye with the most pixels.
    elements: BTreeMap<Element, Seen>,
    /// Sides of objects of which the whole was seen, likewise.
    sides: BTreeMap<(usize, usize), Seen>,
}

impl Hybrid {
    /// Of `photons` photons, seen from cameras and all around from `eyes`.
    pub fn new(scene: &Arc<Scene>, eyes: &[[f64; 3]], photons: u64) -> Hybrid {
        let configuration = Configuration::initial(scene);
        let world = world(scene);
        let solve = |first_hits| shoot(pool(photons), &world, first_hits).buckets().clone();
        let (always, indirect) = (solve(FirstHits::Always), solve(FirstHits::AsLampsSay));
        let scale = Scale::new(&world, photons);
        let shapes = Shapes::of(&configuration);
        let light = Reconstruction::new(&shapes, &configuration, &indirect, &scale, configuration.lamp_slots());
        let side = |id: usize, side| Some(side_light(&light.vertices(id, side)?));
        let irradiance: Indirect = (0..configuration.object_slots()).map(|id| [side(id, 0), side(id, 1)]).collect();
        let (elements, sides) = (BTreeMap::new(), BTreeMap::new());
        let mut hybrid = Hybrid { configuration, scale, always, indirect, shapes, irradiance, elements, sides };

        let mut renderer = renderer();
        renderer.show(&hybrid.configuration).unwrap();
        renderer.light(&hybrid.irradiance).unwrap();
        for eye in eyes {
            // The six views from a point see every direction once.
            hybrid.look(&mut renderer, &all_around((*eye).into()));
        }
        for (_, view) in &scene.cameras {
            hybrid.look(&mut renderer, &[*view]);
        }
        hybrid
    }

    /// Adds up what views see that have nothing in common.
    fn look(&mut self, renderer: &mut Renderer, views: &[View]) {
        let cells = |id: usize| self.configuration.object(id).lattice.cells() as usize;
        let mut here: Vec<Vec<Seen>> = (0..self.irradiance.len()).map(|id| vec![Seen::default(); 2 * cells(id)]).collect();
        for view in views {
            let direct = draw(renderer, view, SIZE, Parts::DIRECT_IRRADIANCE);
            let indirect = draw(renderer, view, SIZE, Parts::INDIRECT_IRRADIANCE);
            for pixel in pixels(renderer, &self.configuration, view, SIZE) {
                let lattice = &self.configuration.object(pixel.object).lattice;
                let cell = lattice.cell(pixel.triangle, pixel.weights[0] as f32, pixel.weights[1] as f32);
                let lux = |light: &[[f32; 4]]| DVec3::from_slice(&light[pixel.index].map(f64::from)[..3]);
                here[pixel.object][2 * cell as usize + pixel.side].add(&Seen {
                    pixels: 1,
                    area: pixel.area,
                    direct: lux(&direct) * pixel.area,
                    squares: lux(&direct).y.powi(2) * pixel.area,
                    indirect: lux(&indirect) * pixel.area,
                });
            }
        }
        for (id, here) in here.iter().enumerate() {
            let lattice = &self.configuration.object(id).lattice;
            let mut sides = [Seen::default(); 2];
            let mut area = 0.0;
            for cell in 0..lattice.cells() {
                area += lattice.area(cell);
                for side in 0..2 {
                    let seen = &here[2 * cell as usize + side];
                    sides[side].add(seen);
                    seen.keep(lattice.area(cell), self.elements.entry((id, cell, side)));
                }
            }
            (0..2).for_each(|side| sides[side].keep(area, self.sides.entry((id, side))));
        }
    }

    fn area(&self, element: &Element) -> f64 {
        self.configuration.object(element.0).lattice.area(element.1)
    }

    /// Lumens that photons bring to an element's side directly, the variance if each comes by itself, and what one of the brightest brings.
    fn direct_by_photons(&self, (object, cell, side): &Element) -> (DVec3, DVec3, DVec3) {
        let (mut sum, mut variance, mut most) = (DVec3::ZERO, DVec3::ZERO, DVec3::ZERO);
        for lamp in 0..self.configuration.lamp_slots() {
            let at = |buckets: &Buckets| buckets.get(*object, *side, lamp).map(|page| page[*cell as usize]).unwrap_or_default();
            let (all, indirect) = (at(&self.always), at(&self.indirect));
            let unit = self.scale.lumens(lamp);
            let energy: [f64; 3] = std::array::from_fn(|c| (all.energy[c] - indirect.energy[c]) as f64);
            let photon = unit * (1u64 << ENERGY_BITS) as f64;
            sum += DVec3::from_array(energy) * unit;
            variance += photon * photon * (all.hits - indirect.hits) as f64;
            most = most.max(photon);
        }
        (sum, variance, most)
    }

    /// Interpolated light, as drawn: over an element the mean of its three points, over an object's side what its buckets hold.
    /// Returns of how many sides the whole was seen.
    pub fn check_indirect(&self, name: &str) -> usize {
        let mut worst = 0.0f64;
        for ((object, cell, side), seen) in &self.elements {
            let lattice = &self.configuration.object(*object).lattice;
            let t = lattice.triangle_of(*cell);
            let corners =
                self.shapes.get(*object).points.cells_points(t).nth((cell - lattice.cells_of(t).start) as usize).unwrap();
            let values =
                corners.map(|p| self.irradiance[*object][*side].as_ref().map_or(0.0, |points| f64::from(points[p as usize][1])));
            let mean = values.iter().sum::<f64>() / 3.0;
            let spread = values.iter().copied().fold(0.0, f64::max) - values.iter().copied().fold(f64::INFINITY, f64::min);
            // What is not seen, or seen twice along the rim, and what the grid of pixels errs (see `Seen::variance`).
            let slack = spread * (WHOLE + 3.0 * (seen.pixels as f64).powf(-0.75)) + 1e-5 * mean;
            let error = (seen.indirect.y / seen.area - mean).abs();
            assert!(error <= slack, "{name}: object {object}, cell {cell}, side {side}: {error} of {values:?}, {seen:?}");
            worst = worst.max(if mean > 0.0 { error / mean } else { 0.0 });
        }
        let mut compared = 0;
        for ((object, side), seen) in &self.sides {
            let lattice = &self.configuration.object(*object).lattice;
            let (mut area, mut flux, mut variance) = (0.0, 0.0, 0.0);
            for cell in 0..lattice.cells() {
                let irradiance = self.scale.irradiance(&self.indirect, *object, cell, *side, lattice.area(cell));
                area += lattice.area(cell);
                flux += irradiance.value.y * lattice.area(cell);
                variance += if irradiance.hits > 0 { (irradiance.standard_error.y * lattice.area(cell)).powi(2) } else { 0.0 };
            }
            let drawn = seen.indirect.y / seen.area * area;
            let object = &self.configuration.object(*object).name;
            println!(
                "{name}: side {side} of {object}: {drawn:.4} lm drawn, {flux:.4} ± {:.4} lm in buckets, {:+.4} %",
                variance.sqrt(),
                (drawn / flux - 1.0) * 100.0
            );
            // The same photons: they differ only by the up to 1 % that is not seen, along edges, and by the grid of pixels.
            assert!((drawn / flux - 1.0).abs() < 0.005, "{object}");
            compared += 1;
        }
        println!("{name}: interpolated light off the elements' by {:.3} % at most; {compared} sides of objects", worst * 100.0);
        compared
    }

    /// The rasteriser's direct light against the photons'; `side_of` and `factor` are for mistakes on purpose.
    pub fn compare_direct(&self, side_of: impl Fn(usize) -> usize, factor: f64) -> Statistic {
        let mut statistic = Statistic::default();
        for (element, seen) in &self.elements {
            let drawn = seen.direct / seen.area * self.area(element) * factor;
            let (photons, variance, most) = self.direct_by_photons(&(element.0, element.1, side_of(element.2)));
            statistic.drawn += drawn.y;
            statistic.shot += photons.y;
            statistic.sides[element.2] += 1;
            if drawn.y / most.y >= FEWEST_PHOTONS {
                // Where photons are missing that should be there, one counts as one.
                let noise = variance.y.max(most.y * most.y) + seen.variance() * self.area(element).powi(2);
                let z = (drawn.y - photons.y) / noise.sqrt();
                statistic.elements += 1;
                statistic.sum += z;
                statistic.squares += z * z;
                statistic.worst = if z.abs() > statistic.worst.abs() { z } else { statistic.worst };
            } else if drawn.y == 0.0 {
                statistic.dark += 1;
                statistic.dark_hits += photons.y / most.y;
            }
        }
        statistic
    }
}

/// How two kinds of light differ, in standard deviations of photons that come each by itself.
#[derive(Debug, Default)]
pub struct Statistic {
    pub elements: usize,
    pub sum: f64,
    pub squares: f64,
    pub worst: f64,
    /// Lumens, green.
    pub drawn: f64,
    pub shot: f64,
    /// Elements in the totals, by side.
    pub sides: [usize; 2],
    /// Elements that the rasteriser leaves black, and photons on them.
    pub dark: usize,
    pub dark_hits: f64,
}

impl Statistic {
    pub fn chi_squared(&self) -> f64 {
        self.squares / self.elements as f64
    }

    /// The mean deviation, in its own standard deviations.
    pub fn mean(&self) -> f64 {
        self.sum / (self.elements as f64).sqrt()
    }

    /// Too much on the whole, as a share.
    pub fn total(&self) -> f64 {
        self.drawn / self.shot - 1.0
    }

    pub fn print(&self, name: &str) {
        println!(
            "{name}: {} elements (front, back {:?}), χ² per element {:.3}, mean {:+.2} σ, worst {:+.2} σ, total {:+.3} %, {:.1} photons on {} black elements",
            self.elements,
            self.sides,
            self.chi_squared(),
            self.mean(),
            self.worst,
            self.total() * 100.0,
            self.dark_hits,
            self.dark
        );
    }
}
