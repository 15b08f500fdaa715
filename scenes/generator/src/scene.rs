//! A scene and its moves as RON text (docs/scene-format.md), one object a line.

use std::fmt::Write;

use glam::DVec3;

use crate::mesh::{Mesh, number};
use crate::solid::v;

/// A thing that stands somewhere.
#[derive(Clone, Debug)]
pub struct Object {
    name: String,
    pub(crate) mesh: String,
    part: Option<String>,
    movable: bool,
    on: Option<String>,
    position: DVec3,
    rotation: DVec3,
    hidden: bool,
}

impl Object {
    /// The object `name` with the whole mesh `mesh` at the origin, fixed.
    pub fn new(name: &str, mesh: &str) -> Self {
        Object {
            name: name.into(),
            mesh: mesh.into(),
            part: None,
            movable: false,
            on: None,
            position: DVec3::ZERO,
            rotation: DVec3::ZERO,
            hidden: false,
        }
    }

    /// Only this part of the mesh.
    pub fn part(mut self, part: &str) -> Self {
        self.part = Some(part.into());
        self
    }

    /// May be moved.
    pub fn movable(mut self) -> Self {
        self.movable = true;
        self
    }

    /// Rides on the object `carrier`.
    pub fn on(mut self, carrier: &str) -> Self {
        self.on = Some(carrier.into());
        self
    }

    /// Where its origin stands, metres.
    pub fn at(mut self, x: f64, y: f64, z: f64) -> Self {
        self.position = v(x, y, z);
        self
    }

    /// Turned about the upright axis, degrees.
    pub fn turned(mut self, degrees: f64) -> Self {
        self.rotation = v(0.0, 0.0, degrees);
        self
    }

    /// Cameras look through it.
    pub fn hidden(mut self) -> Self {
        self.hidden = true;
        self
    }

    fn ron(&self, folder: &str) -> String {
        let mut s = format!("(name: {:?}, mesh: \"{folder}{}.obj\"", self.name, self.mesh);
        if let Some(part) = &self.part {
            s += &format!(", part: {part:?}");
        }
        if self.movable {
            s += ", movable: true";
        }
        if let Some(on) = &self.on {
            s += &format!(", on: {on:?}");
        }
        if self.position != DVec3::ZERO {
            s += &format!(", position: {}", triple(self.position));
        }
        if self.rotation != DVec3::ZERO {
            s += &format!(", rotation: {}", triple(self.rotation));
        }
        if self.hidden {
            s += ", hidden_from_camera: true";
        }
        s + ")"
    }
}

/// A point lamp.
#[derive(Clone, Debug)]
pub struct Lamp {
    /// Unique among the lamps.
    pub name: &'static str,
    /// The object that carries it, if one does.
    pub on: Option<&'static str>,
    /// Metres, relative to the carrier.
    pub position: DVec3,
    /// Degrees about x, y, z.
    pub rotation: DVec3,
    /// Candela, or the factor of the photometric file, per linear Rec. 709 channel.
    pub intensity: DVec3,
    /// Path of the photometric file.
    pub photometry: Option<&'static str>,
}

impl Lamp {
    fn ron(&self) -> String {
        let mut s = format!("(name: {:?}", self.name);
        if let Some(on) = self.on {
            s += &format!(", on: {on:?}");
        }
        s += &format!(", position: {}", triple(self.position));
        if self.rotation != DVec3::ZERO {
            s += &format!(", rotation: {}", triple(self.rotation));
        }
        s += &format!(", intensity: {}", triple(self.intensity));
        if let Some(file) = self.photometry {
            s += &format!(", photometry: {file:?}");
        }
        s + ")"
    }
}

/// A place to look from: metres, and the vertical angle of view in degrees.
#[derive(Clone, Copy, Debug)]
pub struct Camera {
    /// Unique among the cameras.
    pub name: &'static str,
    /// Where the eye is.
    pub eye: DVec3,
    /// What it looks at.
    pub target: DVec3,
    /// Vertical angle of view, degrees.
    pub fov: f64,
}

impl Camera {
    fn view(&self) -> String {
        format!("eye: {}, target: {}, fov: {}", triple(self.eye), triple(self.target), float(self.fov))
    }
}

/// A material: linear reflectance per channel, and a texture that multiplies it.
pub type Material = (&'static str, [f64; 3], Option<&'static str>);

/// A whole scene.
pub struct Scene {
    /// The scene's name and that of its file.
    pub name: &'static str,
    /// Longest edge of a mesh element, metres.
    pub cell: f64,
    /// What the meshes are made of.
    pub materials: Vec<Material>,
    /// What stands in it.
    pub objects: Vec<Object>,
    /// What lights it.
    pub lamps: Vec<Lamp>,
    /// From where it is seen; the first is the usual one.
    pub cameras: Vec<Camera>,
    /// The OBJ files, in this folder beside the scene ("" or ending in "/").
    pub meshes: (&'static str, Vec<Mesh>),
}

impl Scene {
    /// The text of the scene file.
    pub fn ron(&self) -> String {
        let mut s = String::from("// Written by lightmend-scenes: change scenes/generator, not this file.\n");
        s += &format!("(\n    name: {:?},\n    up: z,\n    cell: {},\n    materials: {{\n", self.name, float(self.cell));
        for (name, [r, g, b], texture) in &self.materials {
            let texture = texture.map(|t| format!(", texture: {t:?}")).unwrap_or_default();
            s += &format!("        {name:?}: (reflectance: {}{texture}),\n", triple(v(*r, *g, *b)));
        }
        s += "    },\n    objects: [\n";
        for o in &self.objects {
            s += &format!("        {},\n", o.ron(self.meshes.0));
        }
        s += "    ],\n    lamps: [\n";
        for l in &self.lamps {
            s += &format!("        {},\n", l.ron());
        }
        s += "    ],\n    cameras: [\n";
        for c in &self.cameras {
            s += &format!("        (name: {:?}, {}),\n", c.name, c.view());
        }
        s + "    ],\n)\n"
    }

    /// The number of mesh elements, one per cell, not per side.
    pub fn elements(&self) -> usize {
        let count = |o: &Object| {
            self.meshes.1.iter().filter(|m| m.name == o.mesh).map(|m| m.cells(o.part.as_deref(), self.cell)).sum::<usize>()
        };
        self.objects.iter().map(count).sum()
    }

    /// Its movable objects' names.
    pub fn movables(&self) -> impl Iterator<Item = &str> {
        self.objects.iter().filter(|o| o.movable).map(|o| o.name.as_str())
    }

    /// Its camera of that name, for a moves file that is best seen from there.
    pub fn camera(&self, name: &str) -> Option<Camera> {
        self.cameras.iter().find(|c| c.name == name).copied()
    }
}

/// What an edit does: the object, and its new pose.
pub enum Edit {
    /// To this position, metres.
    Move(&'static str, DVec3),
    /// To this angle about the upright axis, degrees.
    Turn(&'static str, f64),
    /// Along a straight line to this position in steps of at most so many metres, within so many seconds.
    Drag(&'static str, DVec3, f64, f64),
}

/// The text of a moves file: edits at their times in seconds, seen from a camera if the scene's first is not the best.
pub fn moves(edits: &[(f64, Edit)], camera: Option<Camera>) -> String {
    let mut s = String::from("(\n    edits: [\n");
    for (at, edit) in edits {
        let edit = match edit {
            Edit::Move(o, to) => format!("Move(object: {o:?}, to: {})", triple(*to)),
            Edit::Turn(o, to) => format!("Turn(object: {o:?}, to: {})", triple(v(0.0, 0.0, *to))),
            Edit::Drag(o, to, step, seconds) => {
                format!("Drag(object: {o:?}, to: {}, step: {}, seconds: {})", triple(*to), float(*step), float(*seconds))
            }
        };
        // Writing to a String cannot fail.
        let _ = writeln!(s, "        (at: {}, edit: {edit}),", float(*at));
    }
    s += "    ],\n";
    if let Some(c) = camera {
        s += &format!("    cameras: [\n        (at: 0.0, {}),\n    ],\n", c.view());
    }
    s + ")\n"
}

fn float(x: f64) -> String {
    let s = number(x);
    if s.contains('.') { s } else { s + ".0" }
}

fn triple(p: DVec3) -> String {
    format!("({}, {}, {})", float(p.x), float(p.y), float(p.z))
}
