//! Light that leaves the lamps and lands in mesh elements. CPU, no pictures.
//!
//! Follow one photon: its index becomes random numbers ([`halton`]), which choose a lamp ([`emission`]) and, at every hit
//! ([`triangle`], [`body`], [`world`]), whether and where it goes on ([`path`], many side by side: `wave.rs`); each hit deposits ([`record`]) integer energy in a mesh
//! element ([`bucket`]), which is read as irradiance ([`irradiance`]; at points: [`gather`], [`probe`]), for pictures between the elements' corners
//! ([`mod@reconstruction`]); a [`mod@reference`] by path tracing is what it is held against. A [`pool`] of photons is shot ([`shooting`]) and, after edits, repaired group by group ([`solution`]: Algorithm 1
//! of Dmitriev et al. 2002; or photon by photon with a [`ledger`] of their paths), in the background ([`solver`], with [`courtesy`]) or as an experiment, order against order ([`course`], [`recovery`], [`drag`], seen
//! by a camera: [`visible`], [`importance`]). All element sides together are a [`field`], which a reference judges ([`accuracy`], [`balance`]).
//!
//! After any sequence of edits, once nothing is stale, every bucket equals that of a fresh solution to the bit.
//!
//! ```no_run
//! use lightmend_photon::{halton::Scrambling, path::FirstHits, pool::Pool, solver::{Controls, Settings, Solver}};
//! use lightmend_scene::{Configuration, Edit, Scene};
//! let (scene, _) = Scene::read("scenes/room/room.ron".as_ref())?;
//! let room = Configuration::initial(&scene);
//! let pool = Pool::new(1_152_000, 288, 16, Scrambling::Seed(1))?;
//! let settings = Settings { pool, first_hits: FirstHits::AsLampsSay, ledger_bytes: 1 << 30, threads: 2, courteous: true, controls: Controls::default() };
//! let solver = Solver::start(room.clone(), settings)?;
//! solver.edit(room.apply(&Edit::Move { object: "table".into(), to: glam::DVec3::new(2.6, 1.0, 0.0) })?);
//! let light = solver.wait_until_exact();
//! assert!(light.exact);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

pub mod accuracy;
pub mod balance;
pub mod body;
mod boxes;
pub mod bucket;
mod collapse;
pub mod course;
pub mod courtesy;
mod crowd;
pub mod drag;
pub mod emission;
pub mod field;
mod finish;
mod first_segment;
pub mod gather;
pub mod halton;
mod hash;
pub mod importance;
pub mod irradiance;
mod lanes;
pub mod ledger;
mod packet;
pub mod path;
pub mod pool;
pub mod probe;
mod random;
pub mod reconstruction;
pub mod record;
pub mod recovery;
pub mod reference;
mod reinsert;
pub mod sampling;
pub mod saved;
pub mod shooting;
pub mod solution;
pub mod solver;
mod split;
mod stack;
mod stream;
mod tree;
pub mod triangle;
mod urgency;
pub mod visible;
pub mod wave;
pub mod world;
