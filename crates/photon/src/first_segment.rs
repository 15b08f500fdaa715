//! Which groups of photons can meet what changed before they meet anything else: known before one photon is shot.
//!
//! A group is an elementary interval of the first two dimensions (Dmitriev et al. 2002, Eq. 3 to 6), so a solid angle at a lamp; by
//! the Chinese remainder theorem each residue modulo N_g is one interval and each interval one residue. The first points of the sequence
//! therefore visit all intervals equally often: they enumerate the solid angles, in the lamp's own distribution, whatever it is.

use crate::{
    path::{Photon, Rules},
    pool::{GroupId, PhotonIndex, Pool},
    triangle::Ray,
    world::{Difference, World},
};
use glam::Vec3;

/// Points that are looked at, of one copy: the others share the intervals. More: small objects are not overlooked (a cup is, in one of
/// two scenes, with 16 points a group; 28 suffice); fewer: an edit costs less; these take a fifth of what repairing one group takes.
const POINTS: u64 = 8192;

/// Rays that leave the lamps, each with the group that it tells of.
pub struct FirstSegments<'w> {
    rays: Vec<(GroupId, usize, Ray<'w>)>,
    world: &'w World,
    groups: usize,
}

impl<'w> FirstSegments<'w> {
    /// Of a pool's groups in `world`.
    pub fn new(pool: &Pool, rules: &Rules, world: &'w World) -> FirstSegments<'w> {
        let leave = |point: u64| {
            let index = PhotonIndex(point * u64::from(pool.copies()));
            let photon = Photon::emit(rules, world, index)?;
            Some((pool.resembled(index), photon.lamp(), *photon.ray()))
        };
        FirstSegments { rays: (0..POINTS).filter_map(leave).collect(), world, groups: pool.groups() as usize }
    }

    /// How many of each group's leave a lamp that changed, or enter a box about an object that changed, where it stood or where it
    /// stands. What is in between hides nothing.
    pub fn reaching(&self, before: &World, changed: &Difference) -> Vec<u32> {
        let stood = changed.phantoms.iter().filter_map(|id| before.bounds_of(*id));
        let boxes: Vec<[Vec3; 2]> = stood.chain(changed.objects.iter().filter_map(|id| self.world.bounds_of(*id))).collect();
        let mut reaching = vec![0; self.groups];
        for (group, lamp, ray) in &self.rays {
            let of_lamp = changed.choice || changed.lamps.binary_search(lamp).is_ok();
            reaching[group.0 as usize] += u32::from(of_lamp || boxes.iter().any(|bounds| enters(ray, bounds)));
        }
        reaching
    }
}

/// Whether a ray enters a box, or starts in it: by slabs.
fn enters(ray: &Ray, bounds: &[Vec3; 2]) -> bool {
    let [a, b] = bounds.map(|corner| (corner - ray.origin) / ray.direction);
    a.min(b).max_element().max(0.0) <= a.max(b).min_element()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{
        body::TreePreset,
        halton::Scrambling,
        path::{FirstHits, Touched, trace_both},
        record::{Outcome, Watch},
        solution::Solution,
    };
    use glam::DVec3;
    use lightmend_scene::{Configuration, Edit, Scene};
    use std::{path::Path, sync::Arc};

    /// The ROOM, and the ROOM after an edit.
    fn worlds(edit: Edit) -> [Arc<World>; 2] {
        let room = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenes/room/room.ron");
        let before = Configuration::initial(&Scene::read(&room).unwrap().0);
        let world = World::new(&before, TreePreset::default());
        let after = world.moved_to(&before.apply(&edit).unwrap());
        [world, after].map(Arc::new)
    }

    fn table() -> Edit {
        Edit::Move { object: "table".into(), to: DVec3::new(2.4, 3.0, 0.0) }
    }

    #[test]
    fn no_photon_that_meets_the_change_first_is_overlooked() {
        for copies in [1, 8] {
            let pool = Pool::new(100_000, 288, 4, Scrambling::Seed(1)).unwrap().in_copies(copies).unwrap();
            let [before, after] = worlds(table());
            let rules = Rules { sequence: pool.sequence(), first_hits: FirstHits::AsLampsSay };
            let changed = before.difference(&after);
            let phantoms = before.phantoms(&changed.phantoms);
            let mut met = vec![0; 288];
            for index in (0..POINTS).map(|point| PhotonIndex(point * u64::from(copies))) {
                let mut common = Watch::default();
                let [mut old, mut new] = [Outcome::new(4, true), Outcome::new(4, false)];
                let both = [&*before, &*after];
                let touched = trace_both(&rules, both, &changed, &phantoms, index, &mut common, &mut old, &mut new);
                met[pool.resembled(index).0 as usize] += u32::from(touched != Touched::Nothing && common.rays == 1);
            }
            let reaching = FirstSegments::new(&pool, &rules, &after).reaching(&before, &changed);
            assert!(reaching.iter().zip(&met).all(|(reaching, met)| reaching >= met));
            let [all, right] = [&reaching, &met].map(|count| count.iter().sum::<u32>());
            assert!(right > 500 && all < right * 5 / 4, "boxes are not much larger than a table: {right} of {all}");
        }
    }

    #[test]
    fn all_that_leaves_a_changed_lamp_is_reached() {
        let pool = Pool::new(100_000, 288, 16, Scrambling::Seed(1)).unwrap();
        let [before, after] = worlds(Edit::MoveLamp { lamp: "pendant".into(), to: DVec3::new(1.9, 3.0, 1.7) });
        let rules = Rules { sequence: pool.sequence(), first_hits: FirstHits::AsLampsSay };
        let segments = FirstSegments::new(&pool, &rules, &after);
        let reaching = segments.reaching(&before, &before.difference(&after));
        let of_lamp = segments.rays.iter().filter(|(_, lamp, _)| after.configuration().lamp(*lamp).name == "pendant").count();
        assert_eq!(reaching.iter().sum::<u32>(), of_lamp as u32);
        // Each group keeps to one lamp.
        assert!(reaching.iter().all(|count| [0, 28, 29].contains(count)));
    }

    #[test]
    fn what_a_lamp_shines_at_is_found_without_pilots() {
        let pool = Pool::new(100_000, 288, 16, Scrambling::Seed(1)).unwrap();
        let [before, after] = worlds(table());
        let mut solution = Solution::shoot(pool, before.clone(), FirstHits::AsLampsSay, &mut |_, _| true).unwrap();
        solution.change(after.clone());
        let reaching = FirstSegments::new(&pool, solution.rules(), &after).reaching(&before, &before.difference(&after));
        let most = (0..288).map(GroupId).rev().max_by_key(|group| reaching[group.0 as usize]);
        assert_eq!(solution.most_urgent(), most);
    }
}
