//! Shadow volumes into the stencil, four lamps to a mask (Dmitriev et al. 2002, §6.1.1). Twin of `shadow.wgsl`.
//!
//! For every lamp: sides of the volumes that the camera is outside of, counted in front of what is seen; whole volumes of those that
//! it may be inside of, counted behind. What is then not 0 in the stencil is in shadow; writing that to the lamp's channel sets the stencil
//! back to 0 for the next lamp. A volume ends where nothing is left between the eye and what it sees. Volumes are kept until their caster or their lamp moves; what cannot fall on anything in the picture is not drawn, and
//! nothing outside the part of the picture that it can fall on.

use crate::{
    bounds::{Bounds, Rectangle},
    camera::Camera,
    device::{Device, RasterError},
    frame::DrawnLamp,
    geometry::{Geometry, Thing},
    volume::{Caster, Whole},
};
use bytemuck::{Pod, Zeroable};
use glam::DVec3;
use rayon::prelude::*;
use std::ops::Range;

/// Indices in the arena.
#[derive(Debug, Clone, Default)]
struct Placed {
    indices: Vec<u32>,
    /// First index in the arena, once it is there.
    at: Option<u32>,
}

/// What one lamp and one object make, as far as it was needed.
#[derive(Debug, Clone, Default)]
struct Volume {
    /// Version of the object and place of the lamp that it is for.
    of: Option<(u64, DVec3)>,
    sides: Option<Placed>,
    /// Shell, near ends towards the lamp, near ends away from it.
    whole: Option<[Placed; 3]>,
}

impl Volume {
    fn parts(&mut self) -> impl Iterator<Item = &mut Placed> {
        self.sides.iter_mut().chain(self.whole.iter_mut().flatten())
    }
}

/// Which pipeline draws.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Count {
    /// Sides, in front of what is seen.
    Before,
    /// Fronts outwards, behind what is seen.
    Behind,
    /// Fronts inwards, behind what is seen.
    BehindTurned,
}

/// A part of a volume to draw.
#[derive(Debug, Clone, PartialEq)]
pub struct Draw {
    /// How.
    pub count: Count,
    /// Indices in the arena.
    pub indices: Range<u32>,
    /// Left, top, width, height, pixels.
    pub scissor: [u32; 4],
    /// How many times as far from the lamp as the caster it ends; 0 if it does not.
    times: f32,
}

/// What is drawn for one lamp.
#[derive(Debug, Clone, PartialEq)]
pub struct Draws {
    /// Parts of volumes.
    pub parts: Vec<Draw>,
    /// About them: left, top, width, height, pixels.
    pub scissor: [u32; 4],
    /// Number of the first of them among the [`Volumes::casts`].
    pub first: u32,
}

/// What all vertices of a volume share. Twin of `throw_shadow` in `shadow.wgsl`.
#[repr(C)]
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
struct Cast {
    lamp: [f32; 3],
    times: f32,
}

/// All volumes, and the arena that holds their triangles.
pub struct Volumes {
    /// By lamp in the order of drawing, then by piece.
    volumes: Vec<Vec<Volume>>,
    /// Their triangles.
    pub arena: wgpu::Buffer,
    used: u32,
    /// Lamp and end of each part of a volume that is drawn.
    pub casts: wgpu::Buffer,
    /// How many volumes were made anew for the last picture; all others were kept.
    pub made: usize,
}

const INDEX: wgpu::BufferUsages = wgpu::BufferUsages::INDEX;
const VERTEX: wgpu::BufferUsages = wgpu::BufferUsages::VERTEX;

/// A part of a thing, as it casts shadows.
struct Piece<'a> {
    thing: &'a Thing,
    caster: &'a Caster,
    /// The first vertex of its volumes.
    first: u32,
}

/// What one piece adds to a lamp's stencil.
struct Wanted {
    piece: usize,
    whole: bool,
    scissor: [u32; 4],
    times: f32,
}

impl Volumes {
    /// None yet.
    pub fn new(device: &Device) -> Result<Volumes, RasterError> {
        let [arena, casts] = [device.buffer("shadow volumes", 0, INDEX)?, device.buffer("casts", 0, VERTEX)?];
        Ok(Volumes { volumes: Vec::new(), arena, used: 0, casts, made: 0 })
    }

    /// What is to be drawn, lamp by lamp, of what can fall on something in a picture of `size` pixels.
    pub fn draws(
        &mut self,
        device: &Device,
        geometry: &Geometry,
        lamps: &[DrawnLamp],
        camera: &Camera,
        size: [u32; 2],
    ) -> Result<Vec<Draws>, RasterError> {
        let things = &geometry.things;
        let receivers: Vec<(Bounds, Rectangle)> = things
            .iter()
            .filter(|thing| !thing.hidden)
            .filter_map(|thing| Some((thing.bounds, thing.bounds.in_picture(camera)?)))
            .collect();
        // Between the eye and what it sees nothing is outside of this box.
        let stage = receivers.iter().map(|(bounds, _)| bounds);
        let stage = Bounds::about(stage.flat_map(|b| [b.low, b.high]).chain(camera.near_corners()).chain([camera.eye]));
        let piece = |(thing, (caster, first))| Piece { thing, caster, first };
        let pieces = things.iter().flat_map(|t| std::iter::repeat(t).zip(t.casters.iter().zip(t.firsts.iter().copied())));
        let pieces: Vec<Piece> = pieces.map(piece).collect();
        let work: Vec<(usize, usize)> = (0..lamps.len()).flat_map(|l| (0..pieces.len()).map(move |p| (l, p))).collect();
        let wanted: Vec<Option<Wanted>> = work
            .par_iter()
            .map(|(lamp, piece)| wanted(&pieces[*piece], *piece, lamps[*lamp].position, &receivers, &stage, camera, size))
            .collect();
        self.volumes.resize_with(lamps.len(), Vec::new);
        self.volumes.iter_mut().for_each(|row| row.resize_with(pieces.len(), Volume::default));
        let rows = self.volumes.par_iter_mut().zip(lamps).zip(wanted.par_chunks(pieces.len().max(1)));
        let made = rows.map(|((row, lamp), wanted)| {
            let made = row.par_iter_mut().zip(wanted).filter_map(|(volume, wanted)| {
                let wanted = wanted.as_ref()?;
                volume.make(&pieces[wanted.piece], lamp.position, wanted.whole).then_some(())
            });
            made.count()
        });
        self.made = made.sum();
        self.upload(device)?;
        let mut casts: Vec<Cast> = Vec::new();
        let mut all = Vec::new();
        for (lamp, (wanted, row)) in lamps.iter().zip(wanted.chunks(pieces.len().max(1)).zip(&self.volumes)) {
            let mut parts = Vec::new();
            for wanted in wanted.iter().flatten() {
                let Wanted { scissor, times, .. } = *wanted;
                let volume = &row[wanted.piece];
                let mut draw = |count: Count, part: &Placed, times: f32| {
                    if let Some(at) = part.at.filter(|_| !part.indices.is_empty()) {
                        parts.push(Draw { count, indices: at..at + part.indices.len() as u32, scissor, times });
                    }
                };
                match (&volume.whole, &volume.sides) {
                    (Some([shell, towards, away]), _) if wanted.whole => {
                        draw(Count::Behind, shell, 0.0);
                        draw(Count::Behind, towards, 0.0);
                        draw(Count::BehindTurned, away, 0.0);
                    }
                    (_, Some(sides)) => draw(Count::Before, sides, times),
                    _ => {}
                }
            }
            let parts = merged(parts);
            let first = casts.len() as u32;
            casts.extend(parts.iter().map(|part| Cast { lamp: lamp.position.as_vec3().to_array(), times: part.times }));
            all.push(Draws { scissor: about(&parts), parts, first });
        }
        if (casts.len() * size_of::<Cast>()) as u64 > self.casts.size() {
            self.casts = device.buffer("casts", (2 * casts.len() * size_of::<Cast>()) as u64, VERTEX)?;
        }
        device.queue.write_buffer(&self.casts, 0, bytemuck::cast_slice(&casts));
        Ok(all)
    }

    /// Writes what is new; makes room, and forgets what is old, when the arena is full.
    fn upload(&mut self, device: &Device) -> Result<(), RasterError> {
        let new = self.volumes.iter_mut().flatten().flat_map(Volume::parts).filter(|p| p.at.is_none());
        let needed: u64 = new.map(|part| part.indices.len() as u64).sum();
        if (u64::from(self.used) + needed) * 4 > self.arena.size() {
            let all: u64 = self.volumes.iter_mut().flatten().flat_map(Volume::parts).map(|p| p.indices.len() as u64).sum();
            if all * 8 > self.arena.size() {
                self.arena = device.buffer("shadow volumes", all * 16, INDEX)?;
            }
            self.used = 0;
            self.volumes.iter_mut().flatten().flat_map(Volume::parts).for_each(|part| part.at = None);
        }
        let mut new: Vec<u32> = Vec::new();
        let first = self.used;
        for part in self.volumes.iter_mut().flatten().flat_map(Volume::parts).filter(|p| p.at.is_none()) {
            part.at = Some(first + new.len() as u32);
            new.extend(&part.indices);
        }
        self.used += new.len() as u32;
        device.queue.write_buffer(&self.arena, u64::from(first) * 4, bytemuck::cast_slice(&new));
        Ok(())
    }
}

/// Neighbours in the arena that cover nearly the same part of the picture are one draw: on lavapipe each costs some 30 µs.
fn merged(parts: Vec<Draw>) -> Vec<Draw> {
    /// How much more of the picture, and how much farther from the lamp, a merged draw may reach than the larger of the two.
    const MORE: f32 = 1.25;
    let mut all: Vec<Draw> = Vec::new();
    for part in parts {
        let together = all.last().map(|last| Draw {
            indices: last.indices.start..part.indices.end,
            scissor: about(&[last.clone(), part.clone()]),
            times: if last.times == 0.0 || part.times == 0.0 { 0.0 } else { last.times.max(part.times) },
            ..part
        });
        let fits = |last: &Draw, together: &Draw| {
            let area = |draw: &Draw| draw.scissor[2] as f32 * draw.scissor[3] as f32;
            last.count == part.count
                && last.indices.end == part.indices.start
                && (last.times == 0.0) == (part.times == 0.0)
                && area(together) <= MORE * area(last).max(area(&part))
                && together.times <= MORE * last.times.min(part.times)
        };
        match (all.last_mut(), together) {
            (Some(last), Some(together)) if fits(last, &together) => *last = together,
            _ => all.push(part),
        }
    }
    all
}

/// The smallest part of the picture that holds all of those.
fn about(parts: &[Draw]) -> [u32; 4] {
    let low = |axis: usize| parts.iter().map(|p| p.scissor[axis]).min().unwrap_or(0);
    let high = |axis: usize| parts.iter().map(|p| p.scissor[axis] + p.scissor[axis + 2]).max().unwrap_or(0);
    [low(0), low(1), high(0) - low(0), high(1) - low(1)]
}

impl Volume {
    /// Makes what is missing; whether anything was.
    fn make(&mut self, piece: &Piece, lamp: DVec3, whole: bool) -> bool {
        let of = Some((piece.thing.version, lamp));
        if self.of != of {
            *self = Volume { of, ..Volume::default() };
        }
        let placed = |indices: Vec<u32>| Placed { indices, at: None };
        let missing = if whole { self.whole.is_none() } else { self.sides.is_none() };
        if missing && whole {
            let Whole { shell, towards, away } = piece.caster.whole(lamp, piece.first);
            self.whole = Some([shell, towards, away].map(placed));
        } else if missing {
            self.sides = Some(placed(piece.caster.sides(lamp, piece.first)));
        }
        missing
    }
}

/// Whether and how a piece's shadow of a lamp is to be drawn.
fn wanted(
    piece: &Piece,
    number: usize,
    lamp: DVec3,
    receivers: &[(Bounds, Rectangle)],
    stage: &Bounds,
    camera: &Camera,
    [width, height]: [u32; 2],
) -> Option<Wanted> {
    let caster = piece.caster;
    // A little farther than it needs to be, for rounding.
    let end = caster.bounds.shadow_reaches(lamp, stage)?[1] * 1.001;
    let times = if end.is_finite() { end as f32 } else { 0.0 };
    let mut reach: Option<([f64; 2], Rectangle)> = None;
    for (receiver, rectangle) in receivers {
        let Some([from, to]) = caster.bounds.shadow_reaches(lamp, receiver) else { continue };
        let ([least, most], about) = reach.unwrap_or(([from, to], *rectangle));
        reach = Some(([least.min(from), most.max(to)], about.with(rectangle)));
    }
    let (reach, receivers) = reach?;
    let shadow = caster.bounds.shadow_in_picture(lamp, reach, camera)?;
    let scissor = shadow.common(&receivers)?.pixels(width, height);
    if scissor[2] == 0 || scissor[3] == 0 {
        return None;
    }
    // Through what is hidden from cameras the eye may look into a volume: only whole ones are right there.
    let whole = piece.thing.hidden || caster.may_shade_near_plane(lamp, camera);
    Some(Wanted { piece: number, whole, scissor, times })
}
