//! What the camera sees: direct light with hard shadows, indirect light from the photons' mesh elements. wgpu, no transport.
//!
//! A frame is drawn in this order ([`renderer`], Dmitriev et al. 2002, §6):
//!
//! 1. *Depth prepass* (`prepass.wgsl`): which triangle of which object each pixel sees ([`geometry`], [`camera`]).
//! 2. *Shadow volumes* into the stencil, lamp by lamp ([`shadow`], [`volume`], [`welded`]), of what can fall into the picture ([`bounds`]).
//! 3. What is lit goes into one channel of an RGBA *mask*, four lamps to a mask ([`targets`]).
//! 4. *Composition* ([`composition`], `composition.wgsl`): indirect light ([`irradiance`]), interpolated over the mesh elements, plus every lamp's
//!    ([`frame`]) light by its goniometric diagram ([`goniometric`]) times its mask, times what the surface reflects ([`textures`]); looked up in [`table`]s.
//! 5. *Exposure and tone curve*, or false colours ([`tone`]).
//!
//! The picture is read back, or shown in a window ([`screen`]) with outlines of what is chosen ([`present`]).
//!
//! ```no_run
//! use lightmend_raster::{Device, Look, Parts, Renderer, Settings};
//! use lightmend_scene::{Configuration, Scene};
//! let (scene, _) = Scene::read("scenes/room/room.ron".as_ref())?;
//! let mut renderer = Renderer::new(Device::headless()?.into())?;
//! renderer.show(&Configuration::initial(&scene))?;
//! let look = Look::Photograph { exposure: None };
//! renderer.draw(&scene.cameras[0].1, &Settings { width: 640, height: 480, grid: 1, parts: Parts::RADIANCE, look })?;
//! let pixels = renderer.picture()?;
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

pub mod bounds;
pub mod camera;
pub mod composition;
mod device;
pub mod frame;
pub mod geometry;
pub mod goniometric;
pub mod irradiance;
mod pipelines;
pub mod present;
pub mod renderer;
pub mod screen;
pub mod shadow;
pub mod table;
pub mod targets;
pub mod textures;
pub mod timing;
pub mod tone;
pub mod volume;
pub mod welded;

pub use composition::Parts;
pub use device::{Device, RasterError};
pub use irradiance::{Indirect, side_light};
pub use present::Mark;
pub use renderer::{Renderer, Settings};
pub use screen::Screen;
pub use timing::Times;
pub use tone::{FALSE_COLOURS, Look};
