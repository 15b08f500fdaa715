//! What a ray has yet to visit of a tree.

use std::mem::MaybeUninit;

/// Above 7 per level of the deepest tree: 32 levels of any split, 24 of halves, 24 of the exact splits of small branches.
const SIZE: usize = 640;

/// Where the ray enters a child, and which child.
pub type Entry = (f32, u32);

/// A stack that is not cleared when it is made: that would be five kilobytes a ray, by estimate half of what tracing it takes.
pub struct Stack {
    entries: [MaybeUninit<Entry>; SIZE],
    len: usize,
}

impl Stack {
    /// An empty one.
    #[inline(always)]
    pub fn new() -> Stack {
        Stack { entries: [const { MaybeUninit::uninit() }; SIZE], len: 0 }
    }

    /// How many entries there are.
    #[inline(always)]
    pub fn len(&self) -> usize {
        self.len
    }

    #[inline(always)]
    #[allow(unsafe_code)]
    fn get(&self, n: usize) -> Entry {
        debug_assert!(n < self.len);
        // SAFETY: private, and called for n < len alone; entries below len have been written.
        unsafe { self.entries[n].assume_init() }
    }

    /// Puts an entry in its place among those from `bottom` on, the nearest on top.
    #[inline(always)]
    pub fn insert(&mut self, bottom: usize, entry: Entry) {
        let mut place = self.len;
        self.entries[place].write(entry);
        self.len += 1;
        while place > bottom {
            let below = self.get(place - 1);
            if below.0 >= entry.0 {
                break;
            }
            self.entries[place].write(below);
            place -= 1;
        }
        self.entries[place].write(entry);
    }

    /// The entry on top.
    #[inline(always)]
    pub fn pop(&mut self) -> Option<Entry> {
        if self.len == 0 {
            return None;
        }
        let top = self.get(self.len - 1);
        self.len -= 1;
        Some(top)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn entries_come_nearest_first_above_the_bottom() {
        let mut stack = Stack::new();
        stack.insert(0, (0.5, 9));
        for (n, enter) in [3.0, 1.0, 2.0, 2.0, 4.0].into_iter().enumerate() {
            stack.insert(1, (enter, n as u32));
        }
        let order: Vec<u32> = std::iter::from_fn(|| stack.pop()).map(|entry| entry.1).collect();
        assert_eq!([order[0], order[3], order[4], order[5]], [1, 0, 4, 9]);
        assert!(stack.pop().is_none());
    }

    #[test]
    #[should_panic]
    fn it_never_overflows_silently() {
        let mut stack = Stack::new();
        (0..=SIZE).for_each(|n| stack.insert(n, (0.0, 0)));
    }
}
