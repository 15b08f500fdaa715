//! What must hold of every scene: no photon is lost, every number is one, and bits depend on nothing but photons and scene.

use lightmend_photon::{
    body::TreePreset,
    bucket::Buckets,
    gather::Gather,
    irradiance::Scale,
    ledger::LedgerSolution,
    path::FirstHits,
    pool::{PhotonIndex, Pool},
    probe,
    reconstruction::{Reconstruction, Shapes},
    record::{Outcome, Tally},
    solution::Solution,
    wave::trace_each_portably,
    world::World,
};
use lightmend_scene::{Configuration, Scene};
use lightmend_tests::{count, pool, shoot, table::Row};
use rayon::prelude::*;
use std::sync::Arc;

/// Whether light can leave.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Space {
    /// It cannot.
    Closed,
    /// It can.
    Open,
}

/// The photons of a look at a scene.
pub fn photons() -> u64 {
    count(20_000, 1_000_000)
}

/// A row about a scene as its file states it.
pub fn row(case: &str, scene: &Arc<Scene>, space: Space) -> Row {
    of(case, &Configuration::initial(scene), space, pool(photons()))
}

/// A row about a configuration, lit by `pool`.
pub fn of(case: &str, configuration: &Configuration, space: Space, pool: Pool) -> Row {
    let world = Arc::new(World::new(configuration, TreePreset::Medium));
    let solution = shoot(pool, &world, FirstHits::Always);
    let lost = match space {
        Space::Closed => solution.tallies().iter().map(|t| t.escaped).sum::<i64>(),
        Space::Open => 0,
    };
    let broken = not_finite(&solution);
    let differ = builds_that_differ(configuration, &solution);
    let kept = match space {
        Space::Closed => "photons lost",
        Space::Open => "(open)",
    };
    let source = if space == Space::Closed { "closed space; exact sums" } else { "exact sums" };
    let quantity = format!("{kept}; numbers not finite; builds whose bits differ");
    Row::exactly(case, &quantity, "0; 0; 0".to_owned(), source, format!("{lost}; {broken}; {differ}"))
}

/// Of the other tree, of one and three threads, of the ledger, and without wide lanes.
fn builds_that_differ(configuration: &Configuration, solution: &Solution) -> usize {
    let threads = |n| rayon::ThreadPoolBuilder::new().num_threads(n).build().unwrap();
    let fast = Arc::new(World::new(configuration, TreePreset::Fast));
    let again = |world: &Arc<World>| shoot(*solution.pool(), world, FirstHits::Always);
    let ledger = || {
        let made = LedgerSolution::shoot(*solution.pool(), fast.clone(), FirstHits::Always, 1 << 33, &mut |_, _| true);
        made.unwrap().to_solution().unwrap()
    };
    let builds =
        [threads(1).install(|| again(&fast)), threads(3).install(|| again(solution.world())), threads(3).install(ledger)];
    builds.iter().filter(|build| !build.equals(solution)).count() + usize::from(!same_portably(solution))
}

/// Whether the instructions that every processor has lead to the same bits.
fn same_portably(solution: &Solution) -> bool {
    let lamps = solution.tallies().len();
    let trace = |class: u64| {
        let mut outcome = Outcome::new(lamps, false);
        let photons = (class..solution.pool().photons()).step_by(288).map(PhotonIndex);
        trace_each_portably(solution.rules(), solution.world(), photons, &mut outcome);
        outcome
    };
    let outcomes: Vec<Outcome> = (0..288).into_par_iter().map(trace).collect();
    let mut buckets = Buckets::new(solution.world().configuration());
    let mut tallies = vec![Tally::default(); lamps];
    for outcome in outcomes {
        buckets.add(&outcome.deposits).unwrap();
        tallies.iter_mut().zip(&outcome.tallies).for_each(|(sum, tally)| sum.add(tally));
    }
    buckets == *solution.buckets() && tallies == solution.tallies()
}

/// How many numbers that are read from a solution are not finite: raw and reconstructed irradiance of every cell and side with their
/// errors, lattice points of pictures, and what a probe reads in the middle of every 50th cell or so.
pub fn not_finite(solution: &Solution) -> usize {
    let world = solution.world();
    let configuration = world.configuration();
    let scale = Scale::new(world, solution.pool().photons());
    let shapes = Shapes::of(configuration);
    let light = Reconstruction::new(&shapes, configuration, solution.buckets(), &scale, configuration.lamp_slots());
    let gather = Gather { world, light: &light, buckets: solution.buckets(), scale: &scale, rays: 1 };
    let mut broken = usize::from(!light.median_error().is_finite());
    for (id, object) in configuration.objects() {
        for side in 0..2 {
            let points = light.vertices(id, side).unwrap_or_default();
            broken += points.as_flattened().iter().filter(|x| !x.is_finite()).count();
        }
        let every = (object.mesh.triangles.len() / 50).max(1);
        for t in 0..object.mesh.triangles.len() {
            // An irradiance is a flux over an area: a triangle without one never meets a ray, and has none.
            if object.lattice.area_in(t) == 0.0 {
                continue;
            }
            for (cell, side) in object.lattice.cells_of(t).flat_map(|cell| [(cell, 0), (cell, 1)]) {
                let raw = scale.irradiance(solution.buckets(), id, cell, side, object.lattice.area(cell));
                let smooth = light.cell(id, cell, side);
                let numbers = [raw.value, raw.standard_error, smooth.value, smooth.standard_error];
                broken += numbers.iter().filter(|v| !v.is_finite()).count();
            }
            if t % every == 0 {
                let corners = object.mesh.corners(t).map(|p| configuration.object_motion(id).point(p));
                let normal = (corners[1] - corners[0]).cross(corners[2] - corners[0]).normalize_or_zero();
                let middle = corners.iter().sum::<glam::DVec3>() / 3.0;
                for normal in [normal, -normal] {
                    let Some(place) = probe::locate(world, middle, normal) else { continue };
                    let gathered = gather.at(&place, t);
                    let numbers = [probe::direct(world, middle, normal), gathered.value, gathered.standard_error];
                    broken += numbers.iter().filter(|v| !v.is_finite()).count();
                }
            }
        }
    }
    broken
}
