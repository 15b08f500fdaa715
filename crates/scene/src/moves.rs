//! Scripted moves: timed edits and camera keys.

use crate::{
    Configuration, Edit, Scene, SceneError, View, Warning,
    format::{is_zero, read_ron, write_ron},
};
use glam::DVec3;
use serde::{Deserialize, Serialize};
use std::{path::Path, sync::Arc};

/// A moves file, checked against its scene. Edits are in order of time.
#[derive(Debug, Clone, PartialEq)]
pub struct Moves {
    /// Frames per second of playback.
    pub fps: f64,
    /// What happens.
    pub edits: Vec<TimedEdit>,
    /// Where the camera is.
    pub cameras: Vec<CameraKey>,
}

/// An edit and its time, seconds.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TimedEdit {
    /// Seconds from the start.
    pub at: f64,
    /// What changes.
    pub edit: Edit,
}

/// A camera at a time, seconds.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct CameraKey {
    /// Seconds from the start.
    pub at: f64,
    /// Metres.
    pub eye: DVec3,
    /// Metres.
    pub target: DVec3,
    /// Vertical, degrees.
    pub fov: f64,
}

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct MovesFile {
    #[serde(default = "default_fps")]
    fps: f64,
    /// Where positions count from, metres; those of a recording from the scene's own origin.
    #[serde(default, skip_serializing_if = "is_zero")]
    origin: DVec3,
    edits: Vec<TimedEdit>,
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    cameras: Vec<CameraKey>,
}

fn default_fps() -> f64 {
    25.0
}

fn folder(path: &Path) -> &Path {
    path.parent().unwrap_or(Path::new(""))
}

impl Moves {
    /// Reads a moves file and tries its edits, one after the other, on the scene.
    pub fn read(path: &Path, scene: &Arc<Scene>) -> Result<(Moves, Vec<Warning>), SceneError> {
        let file: MovesFile = read_ron(path)?;
        let mut moves = Moves { fps: file.fps, edits: file.edits, cameras: file.cameras };
        moves.check_times().map_err(|what| SceneError::content(path, what))?;
        moves.edits.sort_by(|a, b| a.at.total_cmp(&b.at));
        moves.cameras.sort_by(|a, b| a.at.total_cmp(&b.at));
        let by = file.origin - scene.file.origin;
        for key in &mut moves.cameras {
            (key.eye, key.target) = (key.eye + by, key.target + by);
        }
        let mut configuration = Configuration::initial(scene);
        let mut warnings = Vec::new();
        for (number, timed) in moves.edits.iter_mut().enumerate() {
            let place = |e: SceneError| SceneError::content(path, format!("edit {number} (at {} s): {e}", timed.at));
            timed.edit.relocate(folder(path), folder(&scene.path)).map_err(place)?;
            timed.edit.shift(&configuration, by);
            timed.edit.steps(&configuration).map_err(place)?;
            configuration = configuration.apply_warning(&timed.edit, &mut warnings).map_err(place)?;
        }
        Ok((moves, warnings))
    }

    /// Writes a moves file; its paths are relative to the folder that it will stand in, those in memory to the scene's.
    pub fn write(&self, path: &Path, scene: &Scene) -> Result<(), SceneError> {
        let (edits, cameras) = (self.edits.clone(), self.cameras.clone());
        let mut file = MovesFile { fps: self.fps, origin: scene.file.origin, edits, cameras };
        for timed in &mut file.edits {
            timed.edit.relocate(folder(&scene.path), folder(path))?;
        }
        write_ron(path, &file)
    }

    /// The camera of a time: halfway between two keys it is halfway from one to the other, in a straight line; before the first key and
    /// after the last it stands still. `None` without keys.
    pub fn camera(&self, at: f64) -> Option<View> {
        let next = self.cameras.partition_point(|key| key.at <= at);
        let before = self.cameras.get(next.saturating_sub(1))?;
        let after = self.cameras.get(next).unwrap_or(before);
        let share = if after.at > before.at { ((at - before.at) / (after.at - before.at)).clamp(0.0, 1.0) } else { 0.0 };
        let between = View {
            eye: before.eye.lerp(after.eye, share),
            target: before.target.lerp(after.target, share),
            fov: before.fov + (after.fov - before.fov) * share,
        };
        // On the way between two good views the eye may cross its target.
        Some(if between.fault().is_none() { between } else { View { eye: before.eye, target: before.target, fov: before.fov } })
    }

    fn check_times(&self) -> Result<(), String> {
        if !(self.fps.is_finite() && self.fps > 0.0) {
            return Err(format!("fps is {}; it must be positive", self.fps));
        }
        let fault = |at: f64| !(at.is_finite() && at >= 0.0);
        for (number, timed) in self.edits.iter().enumerate() {
            if fault(timed.at) {
                return Err(format!("edit {number}: its time, {}, must be a number of seconds, not below 0", timed.at));
            }
        }
        for (number, key) in self.cameras.iter().enumerate() {
            let view = View { eye: key.eye, target: key.target, fov: key.fov };
            if let Some(fault) = view.fault() {
                return Err(format!("camera key {number}: {fault}"));
            }
            if fault(key.at) {
                return Err(format!("camera key {number}: its time must be a number of seconds, not below 0"));
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_written_reads_as_the_same_in_any_folder() {
        let room = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenes/room").canonicalize().unwrap();
        let (scene, _) = Scene::read(&room.join("room.ron")).unwrap();
        let cup = scene.objects.iter().find(|o| o.name == "cup west").unwrap().stated();
        let lamp = scene.lamps[0].stated();
        let absolute = room.join("ies/washer.ies").to_string_lossy().into_owned();
        let (felt, name) = (|| "felt".to_owned(), |name: &str| name.to_owned());
        let edits = [
            Edit::Add(crate::format::ObjectEntry { name: name("new cup"), ..cup }),
            Edit::Put { object: name("new cup"), on: None, to: DVec3::new(0.1, 1e-17, -3.5), rotation: DVec3::ZERO },
            Edit::AddMaterial { name: felt(), reflectance: DVec3::splat(1.0 / 3.0), texture: Some(name("textures/rug.png")) },
            Edit::Paint { object: name("table"), material: Some(felt()) },
            Edit::Texture { material: felt(), texture: None },
            Edit::Texture { material: felt(), texture: Some(name("textures/rug.png")) },
            Edit::Paint { object: name("table"), material: None },
            Edit::RemoveMaterial { material: felt() },
            Edit::AddLamp(crate::format::LampEntry { name: name("new"), rated: Some(DVec3::ONE), ..lamp }),
            Edit::Relamp { lamp: name("new"), photometry: None, intensity: Some(DVec3::splat(400.0)) },
            Edit::Relamp { lamp: name("new"), photometry: Some(name("ies/pendant.ies")), intensity: Some(DVec3::ONE) },
            Edit::Relamp { lamp: name("new"), photometry: Some(absolute), intensity: None },
        ];
        let edits = edits.into_iter().enumerate().map(|(k, edit)| TimedEdit { at: k as f64 / 3.0, edit }).collect();
        let key = CameraKey { at: 0.125, eye: DVec3::ZERO, target: DVec3::ONE, fov: 60.0 };
        let moves = Moves { fps: 30.0, edits, cameras: vec![key] };
        let elsewhere = tempfile::tempdir().unwrap();
        // In the scene's own folder nothing is left.
        let beside = tempfile::Builder::new().suffix(".ron").tempfile_in(&room).unwrap();
        for path in [beside.path(), &elsewhere.path().join("moves.ron")] {
            moves.write(path, &scene).unwrap();
            assert_eq!(Moves::read(path, &scene).unwrap().0, moves);
        }
        let still = Moves { fps: 25.0, edits: vec![], cameras: vec![] };
        still.write(beside.path(), &scene).unwrap();
        assert_eq!(Moves::read(beside.path(), &scene).unwrap().0, still);
    }

    #[test]
    fn what_may_be_left_out_may_be_left_out() {
        let read = |text: &str| read_text(text).unwrap().edits.remove(0).edit;
        let (object, lamp) = ("table".to_owned(), "pendant".to_owned());
        assert_eq!(
            read("(edits: [(at: 0.0, edit: Paint(object: \"table\", material: \"oak\"))])"),
            Edit::Paint { object: object.clone(), material: Some("oak".into()) }
        );
        assert_eq!(
            read("(edits: [(at: 0.0, edit: Paint(object: \"table\"))])"),
            Edit::Paint { object: object.clone(), material: None }
        );
        assert_eq!(
            read("(edits: [(at: 0.0, edit: Relamp(lamp: \"pendant\", photometry: \"a.ies\"))])"),
            Edit::Relamp { lamp, photometry: Some("a.ies".into()), intensity: None }
        );
        assert_eq!(
            read("(edits: [(at: 0.0, edit: Put(object: \"table\", on: None, to: (1.0, 0.0, 0.0), rotation: (0.0, 0.0, 0.0)))])"),
            Edit::Put { object, on: None, to: DVec3::X, rotation: DVec3::ZERO }
        );
    }

    fn read_text(text: &str) -> Result<MovesFile, SceneError> {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("moves.ron");
        std::fs::write(&path, text).unwrap();
        read_ron(&path)
    }

    #[test]
    fn cameras_go_from_key_to_key() {
        let key = |at: f64, x: f64| CameraKey { at, eye: DVec3::X * x, target: DVec3::new(x, 1.0, 0.0), fov: 40.0 + x };
        let moves = Moves { fps: 25.0, edits: vec![], cameras: vec![key(1.0, 0.0), key(3.0, 4.0), key(3.0, 8.0)] };
        let eye = |at: f64| moves.camera(at).unwrap().eye.x;
        assert_eq!(
            [eye(0.0), eye(1.0), eye(2.0), eye(3.0), eye(9.0)],
            [0.0, 0.0, 2.0, 8.0, 8.0],
            "two keys at one time are a cut"
        );
        assert_eq!(moves.camera(1.5).unwrap().fov, 41.0);
        assert_eq!(Moves { cameras: vec![], ..moves }.camera(0.0), None);
    }
}
