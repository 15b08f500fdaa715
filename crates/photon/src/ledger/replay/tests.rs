//! The light that is taken back by the record is the light that was left.

use super::*;
use crate::{body::TreePreset, halton::Scrambling, path::FirstHits, pool::Pool, record::Tally, wave::trace_apart};
use lightmend_scene::{Configuration, Scene};

#[test]
fn old_light_from_the_record_is_that_which_was_left() {
    for name in ["room", "cornell"] {
        let path = format!("{}/../../scenes/{name}/{name}.ron", env!("CARGO_MANIFEST_DIR"));
        let home = Configuration::initial(&Scene::read(path.as_ref()).unwrap().0);
        let world = World::new(&home, TreePreset::Fast);
        let surfaces = Surfaces::new(&world, None);
        let (mut numbers, lamps) = (Numbers::default(), home.lamp_slots());
        numbers.cover(&home).unwrap();
        let grid = Grid::new(world.bounds(), world.reach().metres);
        let recorder = Recorder { numbers: &numbers, grid: &grid };
        let (changed, nobody) = (Difference::default(), Crowd::default());
        for first_hits in [FirstHits::AsLampsSay, FirstHits::Always] {
            let sequence = Pool::new(5000, 288, 16, Scrambling::Seed(1)).unwrap().sequence();
            let rules = Rules { sequence, first_hits };
            let passage = Passage {
                rules: &rules,
                before: &world,
                surfaces: &surfaces,
                after: &world,
                changed: &changed,
                moved_out: &[],
                moved_in: &nobody,
                recorder,
            };
            let (mut replayed, mut hits) = (0, 0);
            for index in (0..3000).map(PhotonIndex) {
                let (mut left, mut drafts) = (Outcome::new(lamps, false), Drafts::default());
                drafts.clear(1);
                let clerk = &mut Clerk { recorder, drafts: &mut drafts, outcome: &mut left };
                trace_apart(&rules, &world, std::iter::once((0, index)), &[], clerk);
                let (lamp, path) = (drafts.lamps[0], &drafts.paths[0]);
                let triangles: Vec<_> = path.iter().map(|entry| passage.triangle(entry)).collect();
                let recorded = Recorded { entries: path, triangles: &triangles };
                let emit = || Photon::emit(&rules, &world, index).unwrap();
                for from in 0..path.len() {
                    let mut before = Outcome::new(lamps, false);
                    let photon = passage.replay(emit(), &triangles[..from], &mut before).unwrap();
                    let brought = if from == 0 { Brought::from_lamp(&rules, &world, lamp) } else { photon.brings() };
                    let mut old = Outcome::new(lamps, true);
                    replayed += passage.take_back(brought, || photon, recorded, from, &mut old);
                    hits += path.len() - from;
                    assert_eq!(old.deposits, left.deposits[before.deposits.len()..], "{name}, {index:?} from {from}");
                    let mut tally = left.tallies[usize::from(lamp)];
                    tally.add(&old.tallies[usize::from(lamp)]);
                    assert_eq!(tally, Tally::default(), "{name}, {index:?} from {from}");
                }
            }
            // Only the ROOM has a texture, and few paths are reflected by it.
            assert!((replayed > 0) == (name == "room") && 3 * replayed < hits as u64, "{replayed} of {hits}");
        }
    }
}
