//! Which group comes next, in a pool of any number of groups: a tournament whose winner is known at once.
//!
//! Comparing all groups before each repair would take N_g² comparisons in all; a match between two neighbours, then between the winners, takes
//! log₂ N_g whenever the urgency of one of them changes.

use crate::pool::GroupId;

/// V·P, then P; higher comes first. `None`: the group is up to date.
pub type Key = Option<(u64, u64)>;

/// The keys of all groups.
#[derive(Clone, Default)]
pub struct Urgency {
    /// Winner by winner: `keys[1]` of all, `keys[n]` of those below 2n and 2n + 1, and the groups themselves in the second half.
    keys: Vec<Key>,
}

impl Urgency {
    /// Of groups 0, 1, 2 …
    pub fn new(groups: impl ExactSizeIterator<Item = Key>) -> Urgency {
        let leaves = groups.len().next_power_of_two();
        let mut keys = vec![None; leaves];
        keys.extend(groups);
        keys.resize(2 * leaves, None);
        for n in (1..leaves).rev() {
            keys[n] = keys[2 * n].max(keys[2 * n + 1]);
        }
        Urgency { keys }
    }

    /// The key of one group is another now.
    pub fn set(&mut self, group: GroupId, key: Key) {
        let mut n = self.keys.len() / 2 + group.0 as usize;
        self.keys[n] = key;
        while n > 1 {
            n /= 2;
            self.keys[n] = self.keys[2 * n].max(self.keys[2 * n + 1]);
        }
    }

    /// The group of the highest key, among equals the first. `None` if all are up to date.
    pub fn first(&self) -> Option<GroupId> {
        let leaves = self.keys.len() / 2;
        self.keys.get(1).copied().flatten()?;
        let mut n = 1;
        while n < leaves {
            n = if self.keys[2 * n] == self.keys[n] { 2 * n } else { 2 * n + 1 };
        }
        Some(GroupId((n - leaves) as u32))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::hash::mix;

    #[test]
    fn the_winner_is_that_of_comparing_all() {
        for groups in [1u64, 2, 5, 64, 100] {
            let key = |n: u64| mix(n).is_multiple_of(3).then_some((mix(n) % 7, mix(n) % 5));
            let mut keys: Vec<Key> = (0..groups).map(key).collect();
            let mut urgency = Urgency::new(keys.iter().copied());
            for step in 0..300 {
                let highest = keys.iter().flatten().max();
                let first = highest.map(|highest| keys.iter().position(|key| key.as_ref() == Some(highest)).unwrap() as u32);
                assert_eq!(urgency.first().map(|group| group.0), first, "{groups} groups, step {step}");
                let changed = mix(step) % groups;
                keys[changed as usize] = key(step + groups);
                urgency.set(GroupId(changed as u32), keys[changed as usize]);
            }
        }
        assert_eq!(Urgency::default().first(), None);
    }
}
