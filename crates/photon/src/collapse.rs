//! Which branches of a binary tree become nodes with eight children: those that make rays visit least.
//!
//! Ylitie, Karras, Laine 2017, *Efficient Incoherent Ray Traversal on GPUs Through Compressed Wide BVHs*, §3.1: dynamic programming from
//! the leaves up. A block of triangles costs as much as a node (measured: three times more or less changes nothing).

use crate::{lanes::LANES, split::Branch};

/// How to collapse a binary tree.
pub struct Collapse<'a> {
    branches: &'a [Branch],
    /// Per branch, the least cost of putting it under one parent in at most 1, 2, … 7 of its places, and of a node with its children.
    costs: Vec<[f32; LANES]>,
}

impl Collapse<'_> {
    /// Finds the cheapest way.
    pub fn new(branches: &[Branch]) -> Collapse<'_> {
        let mut collapse = Collapse { branches, costs: vec![[0.0; LANES]; branches.len()] };
        for branch in (0..branches.len()).rev() {
            let own = branches[branch].bounds.weight();
            let mut costs = [own; LANES];
            if branches[branch].halves.is_some() {
                let inner = own + collapse.shared_out(branch, LANES).0;
                costs[0] = if collapse.is_block(branch) { own } else { inner };
                for places in 2..LANES {
                    costs[places - 1] = costs[places - 2].min(collapse.shared_out(branch, places).0);
                }
                costs[LANES - 1] = inner;
            }
            collapse.costs[branch] = costs;
        }
        collapse
    }

    /// Whether what is in the branch becomes one block, if it is not spread over several.
    pub fn is_block(&self, branch: usize) -> bool {
        self.branches[branch].items.len() <= LANES
    }

    /// The children of the node that a branch becomes, at most eight.
    pub fn children(&self, branch: usize) -> Vec<usize> {
        let mut children = Vec::with_capacity(LANES);
        match self.branches[branch].halves {
            Some(_) => self.spread(branch, LANES, &mut children),
            None => children.push(branch),
        }
        children
    }

    /// The least cost of giving its halves so many places together, and how many the first one gets.
    fn shared_out(&self, branch: usize, places: usize) -> (f32, usize) {
        let [a, b] = self.branches[branch].halves.expect("has halves").map(|half| half as usize);
        let ways = (1..places).map(|k| (self.costs[a][k - 1] + self.costs[b][places - k - 1], k));
        ways.min_by(|x, y| x.0.total_cmp(&y.0)).expect("two places or more")
    }

    fn spread(&self, branch: usize, places: usize, children: &mut Vec<usize>) {
        let [a, b] = self.branches[branch].halves.expect("has halves").map(|half| half as usize);
        let first = self.shared_out(branch, places).1;
        self.put(a, first, children);
        self.put(b, places - first, children);
    }

    fn put(&self, branch: usize, places: usize, children: &mut Vec<usize>) {
        let costs = &self.costs[branch];
        // As few places as are as good.
        let places = (1..=places).find(|p| costs[p - 1] == costs[places - 1]).expect("itself");
        if places == 1 {
            children.push(branch);
        } else {
            self.spread(branch, places, children);
        }
    }
}
