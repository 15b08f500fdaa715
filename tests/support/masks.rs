//! The rasteriser's masks against rays, pixel by pixel.

use crate::rays::{Rays, Sight};
use glam::{DVec2, DVec3};
use lightmend_raster::{Look, Parts, Renderer, Settings, camera::Camera};
use lightmend_scene::View;
use rayon::prelude::*;
use std::ops::AddAssign;

/// Cosines to the lamp below this are left out: there the rounding of a corner's coordinates moves a shadow's edge by a thousand
/// times as much, and the light is a thousandth.
const GRAZING: f64 = 1e-3;

/// What rasterisers round corners to, pixels.
const GRID: f64 = 1.0 / 256.0;

/// What a pixel is for one lamp.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Light {
    /// Nothing is seen there.
    Nothing,
    /// It is turned away from the lamp.
    Away,
    /// It faces the lamp along its surface, more or less.
    Grazing,
    /// Something stands between it and the lamp.
    Shadow,
    /// The lamp is in sight.
    Lit,
}

/// Pixels of masks.
#[derive(Debug, Clone, Copy, Default)]
pub struct Tally {
    /// Masks.
    pub masks: usize,
    /// Pixels that face the lamp.
    pub facing: usize,
    /// Those of them that see it.
    pub lit: usize,
    /// Those facing it whose eight neighbours are not all as they are.
    pub edges: usize,
    /// Pixels that face the lamp at a cosine of less than 1/1000; not compared.
    pub grazing: usize,
    /// Wrong, with an edge within a pixel.
    pub wrong_at_edges: usize,
    /// Wrong, with the outline of the triangle seen within 1/256 of a pixel.
    pub wrong_on_outlines: usize,
    /// Wrong.
    pub wrong: usize,
}

impl AddAssign for Tally {
    fn add_assign(&mut self, other: Tally) {
        self.masks += other.masks;
        self.facing += other.facing;
        self.lit += other.lit;
        self.edges += other.edges;
        self.grazing += other.grazing;
        self.wrong_at_edges += other.wrong_at_edges;
        self.wrong_on_outlines += other.wrong_on_outlines;
        self.wrong += other.wrong;
    }
}

/// What is to be said for a wrong pixel.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Excuse {
    /// Visibility changes within a pixel.
    Edge,
    /// Its centre is on the outline of what it sees, to the 1/256 of a pixel that rasterisers count in: beside a lit rim, where the
    /// shadow of the rim begins.
    Outline,
    /// Nothing.
    None,
}

/// One mask, what rays say of it, and where they differ.
pub struct Compared {
    /// By pixel, row by row from the top.
    pub expected: Vec<Light>,
    /// Pixels where the mask says otherwise.
    pub differ: Vec<(usize, Excuse)>,
}

/// What a picture's pixels see.
pub struct Picture<'r> {
    rays: &'r Rays,
    camera: Camera,
    size: [u32; 2],
    sights: Vec<Option<Sight>>,
}

impl<'r> Picture<'r> {
    /// Of the object and triangle that each pixel sees.
    pub fn new(rays: &'r Rays, view: &View, size: [u32; 2], seen: &[Option<(usize, usize)>]) -> Picture<'r> {
        let aspect = f64::from(size[0]) / f64::from(size[1]);
        let configuration = rays.world.configuration();
        let camera = Camera::new(view, configuration.scene().up, aspect, configuration.reach());
        let mut picture = Picture { rays, camera, size, sights: Vec::new() };
        picture.sights = seen
            .par_iter()
            .enumerate()
            .map(|(pixel, of)| rays.sight(&picture.camera, picture.at(pixel, DVec2::splat(0.5)), (*of)?))
            .collect();
        picture
    }

    /// From −1 to 1 to the right and upwards; `within` is the place in the pixel, from its left upper corner.
    fn at(&self, pixel: usize, within: DVec2) -> DVec2 {
        let [width, height] = self.size.map(|s| s as usize);
        let place = DVec2::new((pixel % width) as f64, (pixel / width) as f64) + within;
        DVec2::new(2.0 * place.x / width as f64 - 1.0, 1.0 - 2.0 * place.y / height as f64)
    }

    fn cosine(&self, sight: &Sight, lamp: usize) -> f64 {
        (self.rays.lamp(lamp) - sight.point).normalize_or_zero().dot(sight.normal)
    }

    /// Whether what is seen changes within a pixel: something is seen there which does not face the lamp, or sees it where the
    /// pixel does not.
    fn edge(&self, pixel: usize, lamp: usize, lit: bool) -> bool {
        let place = self.rays.lamp(lamp);
        let sampled = (0..81).any(|k| {
            let within = DVec2::new(f64::from(k % 9), f64::from(k / 9)) / 4.0 - 0.5;
            let at = self.at(pixel, within);
            let Some(of) = self.rays.first(&self.camera, at) else { return false };
            let Some(sight) = self.rays.sight(&self.camera, at, of) else { return false };
            self.cosine(&sight, lamp) <= 0.0
                || (self.rays.sees(&sight, place) != lit && self.rays.sees_exactly(&sight, place) != lit)
        });
        sampled || (lit && self.thin_shadow(pixel, place))
    }

    /// Whether a shadow is within a pixel, however thin.
    fn thin_shadow(&self, pixel: usize, lamp: DVec3) -> bool {
        let centre = self.at(pixel, DVec2::splat(0.5));
        let pixels = DVec2::new(f64::from(self.size[0]), f64::from(self.size[1])) / 2.0;
        self.sights[pixel].is_some_and(|sight| {
            self.rays.shaded_nearby(&sight, lamp).into_iter().any(|point| {
                let Some(at) = self.camera.project(point) else { return false };
                ((at - centre) * pixels).abs().max_element() <= 1.0
                    && self.rays.first(&self.camera, at) == Some(sight.of)
                    && !self.rays.sees_exactly(&Sight { point, ..sight }, lamp)
            })
        })
    }

    fn on_outline(&self, pixel: usize) -> bool {
        let at = self.at(pixel, DVec2::splat(0.5));
        self.sights[pixel].is_some_and(|sight| self.rays.outline_distance(&self.camera, at, sight.of, self.size) <= GRID)
    }

    /// Compares a mask of lamp number `lamp`.
    pub fn compare(&self, mask: &[bool], lamp: usize) -> Compared {
        let place = self.rays.lamp(lamp);
        let light = |(sight, mask): (&Option<Sight>, &bool)| {
            let Some(sight) = sight else { return Light::Nothing };
            let cosine = self.cosine(sight, lamp);
            let as_light = |lit: bool| if lit { Light::Lit } else { Light::Shadow };
            match cosine {
                _ if cosine <= 0.0 => Light::Away,
                _ if cosine < GRAZING => Light::Grazing,
                // Rays of single precision are right but at contacts and at edges.
                _ if self.rays.sees(sight, place) == *mask => as_light(*mask),
                _ => as_light(self.rays.sees_exactly(sight, place)),
            }
        };
        let expected: Vec<Light> = self.sights.par_iter().zip(mask).map(light).collect();
        let differ = |pixel: usize| {
            let lit = expected[pixel] == Light::Lit;
            if lit == mask[pixel] || !matches!(expected[pixel], Light::Lit | Light::Shadow) {
                return None;
            }
            let excuse = if self.edge(pixel, lamp, lit) {
                Excuse::Edge
            } else if self.on_outline(pixel) {
                Excuse::Outline
            } else {
                Excuse::None
            };
            Some((pixel, excuse))
        };
        let differ = (0..mask.len()).into_par_iter().filter_map(differ).collect();
        Compared { expected, differ }
    }
}

impl Compared {
    /// Counts.
    pub fn tally(&self, width: usize) -> Tally {
        let counted = |which: &[Light]| self.expected.iter().filter(|l| which.contains(l)).count();
        let height = self.expected.len() / width;
        let uneven = |pixel: &usize| {
            let (x, y) = (pixel % width, pixel / width);
            let facing = matches!(self.expected[*pixel], Light::Lit | Light::Shadow);
            let mut near = (y.saturating_sub(1)..(y + 2).min(height))
                .flat_map(|y| (x.saturating_sub(1)..(x + 2).min(width)).map(move |x| y * width + x));
            facing && near.any(|n| self.expected[n] != self.expected[*pixel])
        };
        Tally {
            masks: 1,
            facing: counted(&[Light::Lit, Light::Shadow]),
            lit: counted(&[Light::Lit]),
            edges: (0..self.expected.len()).filter(uneven).count(),
            grazing: counted(&[Light::Grazing]),
            wrong_at_edges: self.excused(Excuse::Edge),
            wrong_on_outlines: self.excused(Excuse::Outline),
            wrong: self.excused(Excuse::None),
        }
    }

    /// How many wrong pixels have this excuse.
    pub fn excused(&self, excuse: Excuse) -> usize {
        self.differ.iter().filter(|(_, e)| *e == excuse).count()
    }
}

/// Draws what a camera sees.
pub fn draw(renderer: &mut Renderer, view: &View, [width, height]: [u32; 2]) {
    let look = Look::Photograph { exposure: Some(1.0) };
    renderer.draw(view, &Settings { width, height, grid: 1, parts: Parts::DIRECT_IRRADIANCE, look }).unwrap();
}
