//! 2. Scale and offset: the ROOM in other units, and far from the origin.

use glam::DVec3;
use lightmend_photon::{irradiance::Scale, path::FirstHits};
use lightmend_scene::{
    Configuration, Moves, Scene,
    format::{SceneFile, write_ron},
    obj::write_obj,
};
use lightmend_tests::{count, own_scene, pool, shoot, table::Row, world};
use std::{fs::File, io::BufWriter, sync::Arc};
use tempfile::TempDir;

/// The ROOM, larger by `factor` and then moved; its lamps as much stronger as light gets weaker.
pub fn room(factor: f64, offset: DVec3) -> (TempDir, Arc<Scene>) {
    let scene = own_scene("room");
    let folder = tempfile::tempdir().unwrap();
    let mut file: SceneFile = scene.file.clone();
    file.relocate(scene.path.parent().unwrap(), folder.path()).unwrap();
    file.cell *= factor;
    for (n, entry) in file.objects.iter_mut().enumerate() {
        let object = scene.objects.iter().find(|o| o.name == entry.name).unwrap();
        let mut mesh = (*object.mesh).clone();
        mesh.positions.iter_mut().for_each(|p| *p *= factor);
        let name = format!("{n}.obj");
        write_obj(&mut BufWriter::new(File::create(folder.path().join(&name)).unwrap()), &[(entry.name.clone(), &mesh)]).unwrap();
        (entry.mesh, entry.part) = (name, None);
        entry.position = entry.position * factor + if entry.on.is_none() { offset } else { DVec3::ZERO };
    }
    for lamp in &mut file.lamps {
        lamp.position = lamp.position * factor + if lamp.on.is_none() { offset } else { DVec3::ZERO };
        lamp.intensity *= factor * factor;
        lamp.rated = lamp.rated.map(|r| r * factor * factor);
    }
    for camera in &mut file.cameras {
        (camera.eye, camera.target) = (camera.eye * factor + offset, camera.target * factor + offset);
    }
    let path = folder.path().join("room.ron");
    write_ron(&path, &file).unwrap();
    let scene = Scene::read(&path).unwrap().0;
    (folder, scene)
}

/// Mean illuminance of the green channel over all surfaces, lux, and photons lost.
pub fn light(scene: &Arc<Scene>, photons: u64) -> (f64, i64) {
    let world = world(scene);
    let solution = shoot(pool(photons), &world, FirstHits::Always);
    let scale = Scale::new(&world, photons);
    let lumens: f64 = solution.buckets().lit().map(|(at, b)| b.energy[1] as f64 * scale.lumens(usize::from(at.lamp)).y).sum();
    let area: f64 = scene
        .objects
        .iter()
        .map(|o| {
            (0..o.mesh.triangles.len()).map(|t| o.lattice.area_in(t) * f64::from(o.lattice.divisions(t)).powi(2)).sum::<f64>()
        })
        .sum();
    (lumens / area, solution.tallies().iter().map(|t| t.escaped + t.cut).sum())
}

pub fn rows() -> Vec<Row> {
    let photons = count(50_000, 2_000_000);
    let mut rows = Vec::new();
    let (_folder, home) = room(1.0, DVec3::ZERO);
    let right = light(&home, photons).0;
    let base = shoot(pool(photons), &world(&home), FirstHits::Always);
    for (case, factor) in [("ROOM 1,024 times as large", 1024.0), ("ROOM 1/1,024 as large", 1.0 / 1024.0)] {
        let solution = shoot(pool(photons), &world(&room(factor, DVec3::ZERO).1), FirstHits::Always);
        rows.push(Row::exactly(
            case,
            "buckets other than the ROOM's",
            0,
            "powers of two round nothing",
            usize::from(!solution.equals(&base)),
        ));
    }
    for (case, factor) in [("ROOM in kilometres (× 1000)", 1e3), ("ROOM in millimetres (÷ 1000)", 1e-3)] {
        let (got, lost) = light(&room(factor, DVec3::ZERO).1, photons);
        rows.push(Row::near(case, "mean illuminance, lux", right, "the ROOM's: candela · s², metres · s", got, 2e-3));
        rows.push(Row::exactly(case, "photons lost", 0, "closed", lost));
    }
    for (distance, metres) in [("100 m", 1e2), ("1 km", 1e3), ("10 km", 1e4), ("990 km", 9.9e5)] {
        let case = format!("ROOM {distance} from the origin");
        let (got, lost) = light(&room(1.0, DVec3::new(metres, -metres / 2.0, 0.0)).1, photons);
        rows.push(Row::near(&case, "mean illuminance, lux", right, "the ROOM's; noise of other photons' paths", got, 5e-3));
        rows.push(Row::exactly(&case, "photons lost", 0, "closed", lost));
    }
    rows.extend(recentred());
    rows
}

/// What goes in and comes out of a scene that is counted from elsewhere.
fn recentred() -> Vec<Row> {
    let case = "ROOM 990 km from the origin";
    let offset = DVec3::new(9.9e5, -4.95e5, 0.0);
    let (folder, scene) = room(1.0, offset);
    let write = |name: &str, text: &str| {
        let path = folder.path().join(name);
        std::fs::write(&path, text).unwrap();
        path
    };
    // A script that knows nothing of it.
    let home = Configuration::initial(&own_scene("room"));
    let to = home.object(home.object_id("table").unwrap()).pose.position + DVec3::new(0.25, 0.5, 0.0);
    let script =
        |to: DVec3| format!("(edits: [(at: 0.0, edit: Move(object: \"table\", to: ({:?}, {:?}, {:?})))])", to.x, to.y, to.z);
    let path = write("far.ron", &script(to + offset));
    let moves = Moves::read(&path, &scene).unwrap().0;
    let moved = moves.edits.iter().fold(Configuration::initial(&scene), |at, timed| at.apply(&timed.edit).unwrap());
    let table = |at: &Configuration| at.object_motion(at.object_id("table").unwrap()).translation;
    let got = (table(&moved) + scene.file.origin - offset).distance(to);
    let mut rows = vec![Row::at_most(case, "a script's move, metres off", "where it says", got, 1e-9)];
    // Saved and read again, and a recording of it.
    let saved = folder.path().join("saved.ron");
    moved.write(&saved).unwrap();
    let (saved, warnings) = Scene::read(&saved).unwrap();
    let differs = Configuration::initial(&saved).content_hash() != moved.content_hash();
    rows.push(Row::exactly(
        case,
        "saved and read again: scenes that differ, warnings",
        "0, 0".to_owned(),
        "the same numbers",
        format!("{}, {}", usize::from(differs), warnings.len()),
    ));
    let recorded = folder.path().join("recorded.ron");
    moves.write(&recorded, &scene).unwrap();
    let again = Moves::read(&recorded, &scene).unwrap().0;
    rows.push(Row::exactly(
        case,
        "a recording read again: edits that differ",
        0,
        "the same numbers",
        usize::from(again != moves),
    ));
    rows
}
