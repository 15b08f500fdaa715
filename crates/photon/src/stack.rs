//! What a ray has yet to visit of a tree.

use std::cell::RefCell;

/// Of the deepest tree. Splits make 82 at most (32 of any kind, 27 of halves, 23 of the exact ones); reinsertion goes no deeper than this.
pub const LEVELS: usize = 90;
const SIZE: usize = 7 * LEVELS;

/// Room for children of nodes and where rays enter them. One serves all rays of a thread: clearing five kilobytes for each would be a
/// good part of what it takes to trace it.
pub struct Stack([(f32, u32); SIZE]);

/// What one ray has yet to visit. How many there are is kept out of memory: every step waits for it.
pub struct Waiting<'s> {
    entries: &'s mut [(f32, u32); SIZE],
    len: usize,
}

impl Stack {
    /// An empty one.
    pub const fn new() -> Stack {
        Stack([(0.0, 0); SIZE])
    }

    /// For a ray that has nothing to visit yet.
    #[inline(always)]
    pub fn begin(&mut self) -> Waiting<'_> {
        Waiting { entries: &mut self.0, len: 0 }
    }
}

impl Waiting<'_> {
    /// How many there are.
    #[inline(always)]
    pub fn len(&self) -> usize {
        self.len
    }

    /// Puts one in its place among those from `bottom` on, the nearest on top.
    #[inline(always)]
    pub fn insert(&mut self, bottom: usize, entry: (f32, u32)) {
        let mut place = self.len;
        self.len += 1;
        while place > bottom && self.entries[place - 1].0 < entry.0 {
            self.entries[place] = self.entries[place - 1];
            place -= 1;
        }
        self.entries[place] = entry;
    }

    /// The topmost child that the ray enters within `limit`; those above it are dropped.
    #[inline(always)]
    pub fn pop(&mut self, limit: f32) -> Option<u32> {
        loop {
            self.len = self.len.checked_sub(1)?;
            let (enter, child) = self.entries[self.len];
            if enter <= limit {
                return Some(child);
            }
        }
    }
}

thread_local! {
    /// Of the rays that a thread traces.
    pub(crate) static STACK: RefCell<Stack> = const { RefCell::new(Stack::new()) };
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn entries_come_nearest_first_above_the_bottom() {
        let mut room = Stack::new();
        let mut stack = room.begin();
        stack.insert(0, (0.5, 9));
        for (n, enter) in [3.0, 1.0, 2.0, 2.0, 4.0].into_iter().enumerate() {
            stack.insert(1, (enter, n as u32));
        }
        let order: Vec<u32> = std::iter::from_fn(|| stack.pop(3.5)).collect();
        assert_eq!([order[0], order[3], order[4]], [1, 0, 9], "the farthest is beyond the limit");
        assert!(order.len() == 5 && stack.pop(3.5).is_none());
    }

    #[test]
    #[should_panic]
    fn it_never_overflows_silently() {
        let mut room = Stack::new();
        let mut stack = room.begin();
        (0..=SIZE).for_each(|n| stack.insert(n, (0.0, 0)));
    }
}
