//! Objects that moved, each with a tree of its own, and what rays meet first of them and of all else.

use crate::{
    body::Body,
    boxes::Boxes,
    lanes::{LANES, Lanes, Task, widest},
    packet::{Found, Packet},
    stack::{STACK, Stack},
    tree::{Beam, Way, limit},
    triangle::{Hit, Ray},
};
use glam::Vec3;
use lightmend_scene::{Mesh, Motion};
use std::sync::Arc;

/// An object where it stands, with a tree of its own.
pub(crate) struct Placed {
    pub(crate) id: usize,
    pub(crate) mesh: Arc<Mesh>,
    pub(crate) motion: Motion,
    pub(crate) body: Body,
}

/// Objects with trees of their own, in order of their numbers, and their boxes side by side.
#[derive(Clone, Default)]
pub struct Crowd {
    placed: Vec<Arc<Placed>>,
    boxes: Boxes,
}

impl Crowd {
    pub(crate) fn new(placed: Vec<Arc<Placed>>) -> Crowd {
        let boxes = Boxes::new(placed.iter().map(|placed| placed.body.bounds()));
        Crowd { placed, boxes }
    }

    pub(crate) fn find(&self, id: usize) -> Option<&Arc<Placed>> {
        self.placed.binary_search_by_key(&id, |placed| placed.id).ok().map(|n| &self.placed[n])
    }

    /// They, in order of their numbers.
    pub(crate) fn placed(&self) -> &[Arc<Placed>] {
        &self.placed
    }

    /// The boxes about them, padded.
    pub fn bounds(&self) -> impl Iterator<Item = [Vec3; 2]> + '_ {
        self.placed.iter().map(|placed| placed.body.bounds())
    }

    /// The nearest of `best` and these objects.
    pub fn nearest<'t>(&'t self, ray: &Ray, best: Option<Hit<'t>>) -> Option<Hit<'t>> {
        STACK.with_borrow_mut(|stack| widest(Nearest { ray, crowd: self, still: None, best, stack }))
    }

    /// Makes `best` the nearest of itself and these objects, each behind its box.
    #[inline(always)]
    pub(crate) fn meet<'t, L: Lanes>(&'t self, beam: &Beam<L>, stack: &mut Stack, best: &mut Option<Hit<'t>>) {
        for (planes, placed) in self.boxes.eights().iter().zip(self.placed.chunks(LANES)) {
            let (mut mask, enter) = beam.enters(planes, limit(best));
            if mask == 0 {
                continue;
            }
            let enter = beam.lanes.store(enter);
            while mask != 0 {
                let k = mask.trailing_zeros() as usize;
                mask &= mask - 1;
                if enter[k] <= limit(best) {
                    placed[k].body.nearest(beam, stack, best);
                }
            }
        }
    }

    /// [`meet`](Self::meet) of eight rays.
    #[inline(always)]
    pub(crate) fn meet_each<'t, L: Lanes>(&'t self, packet: &Packet<L>, stack: &mut Stack, found: &mut Found<'t, L>) {
        for (planes, placed) in self.boxes.eights().iter().zip(self.placed.chunks(LANES)) {
            let (mut mask, enter) = packet.enters(planes, found.limit());
            if mask == 0 {
                continue;
            }
            let enter = packet.lanes().store(enter);
            while mask != 0 {
                let k = mask.trailing_zeros() as usize;
                mask &= mask - 1;
                if enter[k] <= found.limit() {
                    placed[k].body.nearest_each(packet, stack, found);
                }
            }
        }
    }
}

/// What the ray meets first of some bodies.
pub(crate) struct Nearest<'t, 'r> {
    pub(crate) stack: &'r mut Stack,
    pub(crate) ray: &'r Ray<'r>,
    pub(crate) crowd: &'t Crowd,
    pub(crate) still: Option<&'t Body>,
    pub(crate) best: Option<Hit<'t>>,
}

impl<'t> Task for Nearest<'t, '_> {
    type Output = Option<Hit<'t>>;

    /// What moved first, each behind its box, then the rest.
    #[inline(always)]
    fn run<L: Lanes>(self, lanes: L) -> Option<Hit<'t>> {
        let Nearest { ray, crowd, still, mut best, stack } = self;
        let beam = Beam::new(lanes, ray);
        crowd.meet(&beam, stack, &mut best);
        if let Some(body) = still {
            body.nearest(&beam, stack, &mut best);
        }
        best
    }
}
