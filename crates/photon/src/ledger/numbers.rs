//! Triangles of all objects by one number each, so that a recorded hit needs four bytes.
//!
//! An object keeps its numbers for good, also while it is gone. Where another mesh takes its place, the numbers stay if they suffice;
//! which mesh a number means is told by the world in which the path was recorded.

use lightmend_scene::Configuration;
use std::ops::Range;

/// No triangle: the path escaped.
pub const ESCAPED: u32 = u32::MAX;

/// Which numbers belong to which object.
#[derive(Debug, Clone, Default)]
pub struct Numbers {
    /// First number and object of every range, in order.
    ranges: Vec<(u32, u32)>,
    /// The newest range of each object.
    of_object: Vec<Range<u32>>,
    /// One past the last number given away.
    end: u32,
}

impl Numbers {
    /// Gives numbers to the triangles that have none. `None` if there are too many.
    pub fn cover(&mut self, configuration: &Configuration) -> Option<()> {
        self.of_object.resize(self.of_object.len().max(configuration.object_slots()), 0..0);
        for (id, object) in configuration.objects() {
            let triangles = object.mesh.triangles.len();
            if triangles > self.of_object[id].len() {
                // Twice as many when a mesh was replaced by a larger one, so that replacing can go on.
                let wanted = triangles.max(2 * self.of_object[id].len());
                let end =
                    u32::try_from(wanted).ok().and_then(|wanted| self.end.checked_add(wanted)).filter(|end| *end < ESCAPED)?;
                self.ranges.push((self.end, id as u32));
                self.of_object[id] = self.end..end;
                self.end = end;
            }
        }
        Some(())
    }

    /// The number of a triangle.
    pub fn of(&self, object: usize, in_mesh: usize) -> u32 {
        self.of_object[object].start + in_mesh as u32
    }

    /// The object of a triangle and its number in the object's mesh.
    pub fn triangle(&self, number: u32) -> (usize, usize) {
        let (first, object) = self.ranges[self.ranges.partition_point(|(first, _)| *first <= number) - 1];
        (object as usize, (number - first) as usize)
    }

    /// All numbers that these objects have or had, joined where they follow one another; `objects` in order.
    pub fn of_objects(&self, objects: &[usize]) -> Vec<Range<u32>> {
        let mut found: Vec<Range<u32>> = Vec::new();
        for (n, (first, object)) in self.ranges.iter().enumerate() {
            if objects.binary_search(&(*object as usize)).is_ok() {
                let end = self.ranges.get(n + 1).map_or(self.end, |(next, _)| *next);
                match found.last_mut() {
                    Some(last) if last.end == *first => last.end = end,
                    _ => found.push(*first..end),
                }
            }
        }
        found
    }
}
