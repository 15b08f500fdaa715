//! Other people's furniture, photometric files and textures on the desk: none does any harm, what cannot be used is told in a line, and
//! all of it can be undone to the bit.

use super::{
    dialogs::Dialog,
    panels,
    session::Selection,
    trial::{Trial, start},
};
use lightmend_photon::{path::FirstHits, solution::Solution};
use lightmend_scene::{Edit, format};
use std::path::{Path, PathBuf};

fn corpus(folder: &str) -> Option<PathBuf> {
    let corpus = std::env::var_os("LIGHTMEND_CORPUS").map(|corpus| Path::new(&corpus).join(folder));
    if corpus.is_none() {
        println!("skipped: LIGHTMEND_CORPUS is not set");
    }
    corpus
}

fn files(folder: &Path, extensions: &[&str], found: &mut Vec<PathBuf>) {
    let mut entries: Vec<PathBuf> = std::fs::read_dir(folder).unwrap().flatten().map(|entry| entry.path()).collect();
    entries.sort();
    for path in entries {
        if path.is_dir() {
            files(&path, extensions, found);
        } else if extensions.iter().any(|e| path.extension().is_some_and(|x| x.eq_ignore_ascii_case(e))) {
            found.push(path);
        }
    }
}

#[test]
fn other_peoples_furniture_is_added_and_taken_away() {
    let Some(folder) = corpus("furniture") else { return };
    let mut models = Vec::new();
    files(&folder, &["obj"], &mut models);
    files(&folder.parent().unwrap().join("hostile"), &["obj"], &mut models);
    let mut trial = Trial::new();
    let before = trial.state();
    let (mut added, mut refused) = (0, 0);
    for path in &models {
        let now = trial.state();
        let Dialog::Model(model) = Dialog::chosen_object(&trial.desk.session, path.clone()) else { panic!("a model") };
        match model.add(&mut trial.desk.session) {
            Ok(()) if trial.state() != now => {
                added += 1;
                let Some(Selection::Object(id)) = trial.desk.session.selection else {
                    panic!("{}: it is selected", path.display())
                };
                let [low, high] = super::pick::bounds(&trial.desk.session.configuration, id);
                let size = high - low;
                assert!(size.is_finite() && size.max_element() > 0.0 && size.max_element() < 4.0, "{}: {size}", path.display());
                trial.frame([]);
                trial
                    .desk
                    .session
                    .drag(id, trial.desk.session.configuration.object_motion(id).translation + glam::DVec3::X * 0.1);
                trial.desk.session.end();
                // Two of three stay, so that the room fills.
                if added % 3 == 0 {
                    trial.desk.session.undo();
                    trial.desk.session.undo();
                    assert!(trial.state() == now, "{}", path.display());
                }
            }
            Ok(()) => refused += 1,
            Err(error) => {
                refused += 1;
                assert!(trial.state() == now && !error.to_string().contains('\n'), "{}: {error}", path.display());
            }
        }
    }
    println!("{added} models added, {refused} refused");
    assert!(added > 10);
    let light = trial.desk.session.solver.wait_until_exact();
    let fresh = Solution::shoot(start().pool, light.world.clone(), FirstHits::AsLampsSay, &mut |_, _| true).unwrap();
    assert!(light.buckets == *fresh.buckets());
    while trial.desk.session.history.last_done().is_some() {
        trial.desk.session.undo();
    }
    assert!(trial.state() == before);
}

#[test]
fn other_peoples_lamps_and_textures_are_swapped_in_and_out() {
    let Some(folder) = corpus("ies") else { return };
    let (mut lamps, mut images) = (Vec::new(), Vec::new());
    files(&folder, &["ies"], &mut lamps);
    files(&folder.parent().unwrap().join("textures"), &["png", "jpg"], &mut images);
    files(&folder.parent().unwrap().join("hostile"), &["png"], &mut images);
    let mut trial = Trial::new();
    let before = trial.state();
    let lamp = trial.state().lamps().next().unwrap().0;
    trial.desk.session.selection = Some(Selection::Lamp(lamp));
    let mut swapped = 0;
    for path in &lamps {
        let now = trial.state();
        panels::relamp(&mut trial.desk.session, lamp, Some(path));
        swapped += usize::from(trial.state() != now);
        trial.frame([]);
    }
    for path in &images {
        let Ok(texture) = format::path_from(trial.folder.path(), path) else { continue };
        let edit = Edit::Texture { material: "oak".into(), texture: Some(texture) };
        trial.desk.session.perform("Texture", vec![edit]);
    }
    println!("{swapped} of {} photometric files, {} images", lamps.len(), images.len());
    assert!(swapped > 30);
    while trial.desk.session.history.last_done().is_some() {
        trial.desk.session.undo();
    }
    assert!(trial.state() == before);
}
