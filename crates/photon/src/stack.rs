//! What a ray has yet to visit of a tree.

use crate::lanes::LANES;

/// Seven per level of the deepest tree, 32 levels of any split, 24 of halves, 24 of the exact splits of small branches, and room for
/// storing eight at a time.
const SIZE: usize = 640;

/// Children of nodes and where the ray enters them, in one place for all rays that come after one another.
pub struct Stack {
    enters: [f32; SIZE],
    children: [u32; SIZE],
    len: usize,
}

impl Stack {
    /// An empty one.
    pub const fn new() -> Stack {
        Stack { enters: [0.0; SIZE], children: [0; SIZE], len: 0 }
    }

    /// Nothing is left to visit.
    #[inline(always)]
    pub fn clear(&mut self) {
        self.len = 0;
    }

    /// Puts the first `count` of eight on top, the last of them topmost.
    #[inline(always)]
    pub fn push(&mut self, count: usize, enters: &[f32; LANES], children: &[u32; LANES]) {
        let top = self.len;
        self.enters[top..top + LANES].copy_from_slice(enters);
        self.children[top..top + LANES].copy_from_slice(children);
        self.len = top + count;
    }

    /// How many there are.
    #[inline(always)]
    pub fn len(&self) -> usize {
        self.len
    }

    /// Puts one in its place among those from `bottom` on, the nearest on top.
    #[inline(always)]
    pub fn insert(&mut self, bottom: usize, (enter, child): (f32, u32)) {
        let mut place = self.len;
        self.len += 1;
        while place > bottom && self.enters[place - 1] < enter {
            self.enters[place] = self.enters[place - 1];
            self.children[place] = self.children[place - 1];
            place -= 1;
        }
        (self.enters[place], self.children[place]) = (enter, child);
    }

    /// The topmost child that the ray enters within `limit`; those above it are dropped.
    #[inline(always)]
    pub fn pop(&mut self, limit: f32) -> Option<u32> {
        loop {
            self.len = self.len.checked_sub(1)?;
            if self.enters[self.len] <= limit {
                return Some(self.children[self.len]);
            }
        }
    }
}
