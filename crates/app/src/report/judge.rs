//! What the light of one state is judged by: its reference, its first camera, and a fresh solution.

use super::{
    frames::Frames,
    jobs::{FIRST_HITS, Job},
    readout::READOUTS,
};
use crate::{failure::Failure, indirect::IndirectLight, masking::Maskings, onlooker::Onlooker, progress};
use lightmend_photon::{
    accuracy::{Measures, Reference, without_own},
    balance::Balance,
    body::TreePreset,
    bucket::Buckets,
    irradiance::Scale,
    solution::Solution,
    world::World,
};
use lightmend_raster::Renderer;
use std::sync::Arc;

/// How wrong the light is, by one way to read it.
#[derive(Clone, Copy)]
pub struct Errors {
    /// Over all element sides.
    pub measures: Measures,
    /// Visible error of the first camera against the reference, if there is one.
    pub visible: Option<f64>,
    /// Mean FLIP of its frame, where it was drawn.
    pub flip: Option<f64>,
}

/// What light is read and drawn with, in one state after the other.
pub struct Instruments {
    /// `None` where nothing can draw.
    pub renderer: Option<Renderer>,
    /// Keeps how the surfaces hang together.
    pub reader: IndirectLight,
    /// Keeps what textures hide.
    pub maskings: Maskings,
}

/// Judges the light of a state.
pub struct Judge<'a> {
    world: &'a Arc<World>,
    reference: Reference,
    visible: Option<Seen>,
    frames: Option<Frames<'a>>,
    reader: &'a mut IndirectLight,
}

/// What the first camera sees of the reference, and its own visible error.
struct Seen {
    onlooker: Onlooker,
    right: Vec<[f32; 3]>,
    own: f64,
    /// Luminance of the drained light, as it is shown; empty until that is known.
    drained: Vec<f64>,
}

impl<'a> Judge<'a> {
    /// Shoots the reference; `None` if interrupted.
    pub fn new(
        job: &Job,
        world: &'a Arc<World>,
        instruments: &'a mut Instruments,
        quiet: bool,
    ) -> Result<Option<Judge<'a>>, Failure> {
        let bar = progress::bar(job.reference_photons, "reference", quiet);
        let reference = Reference::shoot(world, &job.pool, job.reference_photons, FIRST_HITS, &mut |photons| {
            bar.set_position(photons);
            !progress::interrupted()
        });
        bar.finish_and_clear();
        let Some(reference) = reference? else { return Ok(None) };
        let view = job.scene.cameras.first().map(|(_, view)| *view);
        let visible = view.map(|view| {
            let onlooker = Onlooker::new(world, &view, &mut instruments.maskings);
            let visible = onlooker.visible();
            let right = visible.values_of(&reference.field);
            let own = visible.difference(&visible.values_of(&reference.off), &right);
            Seen { onlooker, right, own, drained: Vec::new() }
        });
        let Instruments { renderer, reader, .. } = instruments;
        let frames = match (view, renderer) {
            (Some(view), Some(renderer)) => Frames::new(renderer, world, view, &reference, reader)?,
            _ => None,
        };
        Ok(Some(Judge { world, reference, visible, frames, reader }))
    }

    /// Errors of light that stems from so many photons, by each way to read it; `frame` says whether to draw one too.
    pub fn errors(&mut self, light: &Buckets, photons: u64, frame: bool) -> Result<Vec<Errors>, Failure> {
        let scale = Scale::new(self.world, photons);
        // A frame shows reconstructed light.
        let frames = self.frames.as_mut().filter(|_| frame);
        let flip = frames.map(|frames| frames.flip(self.reader, light, &scale)).transpose()?;
        READOUTS
            .iter()
            .map(|readout| {
                let field = (readout.field)(self.reader, self.world, light, &scale);
                let visible = self.visible.as_ref().map(|Seen { onlooker, right, own, .. }| {
                    let visible = onlooker.visible();
                    without_own(visible.difference(&visible.values_of(&field), right), *own)
                });
                Ok(Errors { measures: self.reference.measure(&field), visible, flip })
            })
            .collect()
    }

    /// This is the exact light of the state, of so many photons.
    pub fn ends_with(&mut self, light: &Buckets, photons: u64) {
        let scale = Scale::new(self.world, photons);
        if let Some(seen) = &mut self.visible {
            seen.drained = seen.onlooker.shown(self.reader, self.world.configuration(), light, &scale);
        }
    }

    /// Share of the pixels of the first camera in which one could notice that this is not the exact light; `None` without a camera.
    pub fn noticed(&mut self, light: &Buckets, photons: u64) -> Option<f64> {
        let scale = Scale::new(self.world, photons);
        let seen = self.visible.as_ref()?;
        let now = seen.onlooker.shown(self.reader, self.world.configuration(), light, &scale);
        Some(seen.onlooker.noticed(&now, &seen.drained))
    }

    /// Maps of what could be noticed, and where it can be in this light.
    pub fn map(&mut self, light: &Buckets, photons: u64) -> Result<Option<image::RgbImage>, Failure> {
        let scale = Scale::new(self.world, photons);
        let Some(seen) = &self.visible else { return Ok(None) };
        let now = seen.onlooker.shown(self.reader, self.world.configuration(), light, &scale);
        seen.onlooker.map(&now, &seen.drained).map(Some)
    }

    /// The reference's own errors.
    pub fn own(&self) -> Errors {
        Errors { measures: self.reference.own, visible: self.visible.as_ref().map(|seen| seen.own), flip: None }
    }

    /// Photons of the reference.
    pub fn reference_photons(&self) -> u64 {
        self.reference.photons
    }
}

/// A fresh solution, with other trees, and what became of its photons; `None` if interrupted.
pub fn fresh(job: &Job, world: &World, quiet: bool) -> Option<(Solution, Balance)> {
    let other_trees = Arc::new(World::new(world.configuration(), TreePreset::Fast));
    let bar = progress::bar(job.pool.photons(), "fresh solution", quiet);
    let solution = Solution::shoot(job.pool, other_trees, FIRST_HITS, &mut |photons, _| {
        bar.set_position(photons);
        !progress::interrupted()
    });
    bar.finish_and_clear();
    let solution = solution.filter(|s| s.pool().photons() == job.pool.photons())?;
    let balance = Balance::trace(solution.rules(), world, job.pool.photons());
    (!progress::interrupted()).then_some((solution, balance))
}
