//! Mesh elements of all objects by one number each, with the side that was hit: a recorded hit needs four bytes, and what it deposited
//! needs no geometry.
//!
//! An object keeps its numbers for good, also while it is gone. They begin at multiples of [`RUN`], so that the object of a number is
//! looked up and not searched.

use lightmend_scene::Configuration;
use std::ops::Range;

/// No element: the path escaped.
pub const ESCAPED: u32 = u32::MAX;

/// Elements that are sure to be of one object. More: a smaller table, more numbers that no element has.
const RUN: u32 = 256;

/// A side of a mesh element.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Element {
    /// Number of the object.
    pub object: usize,
    /// Cell of the object's lattice.
    pub cell: u32,
    /// 0: front, 1: back.
    pub side: u8,
}

/// Which numbers belong to which object.
#[derive(Debug, Clone, Default)]
pub struct Numbers {
    /// First element of each object.
    first: Vec<u32>,
    /// The object of each run of elements.
    object_of: Vec<u32>,
}

impl Numbers {
    /// Gives numbers to the elements that have none. `None` if there are too many.
    pub fn cover(&mut self, configuration: &Configuration) -> Option<()> {
        for id in self.first.len()..configuration.object_slots() {
            let runs = self.object_of.len() as u32 + configuration.object(id).lattice.cells().div_ceil(RUN);
            if runs >= ESCAPED / 2 / RUN {
                return None;
            }
            self.first.push(self.object_of.len() as u32 * RUN);
            self.object_of.resize(runs as usize, id as u32);
        }
        Some(())
    }

    /// The number of a side of an element.
    pub fn of(&self, Element { object, cell, side }: Element) -> u32 {
        (self.first[object] + cell) << 1 | u32::from(side)
    }

    /// Numbers in use, with those that no element has.
    pub fn count(&self) -> usize {
        2 * RUN as usize * self.object_of.len()
    }

    /// What has this number.
    pub fn element(&self, number: u32) -> Element {
        let element = number >> 1;
        let object = self.object_of[(element / RUN) as usize] as usize;
        Element { object, cell: element - self.first[object], side: (number & 1) as u8 }
    }

    /// All numbers of an object: cell by cell, both sides.
    pub fn of_object(&self, object: usize) -> Range<u32> {
        let first = |object: usize| self.first.get(object).map_or(self.object_of.len() as u32 * RUN, |first| *first);
        first(object) << 1..first(object + 1) << 1
    }

    /// All numbers of these objects, joined where they follow one another; `objects` in order.
    pub fn of_objects(&self, objects: &[usize]) -> Vec<Range<u32>> {
        let mut found: Vec<Range<u32>> = Vec::new();
        for id in objects {
            let numbers = self.of_object(*id);
            match found.last_mut() {
                Some(last) if last.end == numbers.start => last.end = numbers.end,
                _ => found.push(numbers),
            }
        }
        found
    }
}
