//! What is there: objects, mesh elements, materials, lamps, moves. No light, no GPU.
//!
//! A scene file ([`mod@format`]) becomes a [`Scene`]: meshes read ([`obj`]) and cut into cells ([`Lattice`]), materials and
//! lamps ([`Photometry`]) resolved, all in order of names. What edits can change is a [`Configuration`]: immutable, cheap to
//! clone, and made anew by every [`Edit`]. A script of edits is a [`Moves`] file; a [`Recording`] makes one of what a person does.
//!
//! ```no_run
//! use lightmend_scene::{Configuration, Edit, Scene};
//! let (scene, warnings) = Scene::read("scenes/room/room.ron".as_ref())?;
//! let before = Configuration::initial(&scene);
//! let after = before.apply(&Edit::Move { object: "table".into(), to: glam::DVec3::new(2.6, 1.0, 0.0) })?;
//! assert_ne!(before, after);
//! # Ok::<(), lightmend_scene::SceneError>(())
//! ```

mod camera;
mod configuration;
mod edit;
mod error;
pub mod format;
mod lamp;
mod lattice;
mod lattice_points;
mod load;
mod material;
mod mesh;
mod moves;
pub mod obj;
mod photometry;
mod pose;
mod recording;
mod scene;
mod timeline;
pub mod trig;

pub use camera::View;
pub use configuration::Configuration;
pub use edit::Edit;
pub use error::{SceneError, Warning};
pub use format::Up;
pub use lamp::{Direct, Lamp, lamp_rotation, luminance};
pub use lattice::{Cut, Lattice};
pub use lattice_points::LatticePoints;
pub use material::{Material, Texture, srgb_to_linear};
pub use mesh::Mesh;
pub use moves::{CameraKey, Moves, TimedEdit};
pub use photometry::{Photometry, Symmetry};
pub use pose::{FARTHEST, Motion, Pose, within_reach};
pub use recording::Recording;
pub use scene::{Object, Scene, unknown};
