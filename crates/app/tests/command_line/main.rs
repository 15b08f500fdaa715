//! The program as its users meet it: what it writes, what it prints, with which status it ends.
//!
//! Every test runs the real binary in a folder of its own that holds the Cornell box.

mod bad_arguments;
mod bad_frames;
mod bad_moves;
mod bad_output;
mod bad_points;
mod bad_scene;
mod desk;
mod frame_files;
mod frames;
mod hard;
mod import;
mod interrupt;
mod invariants;
mod noticed;
mod printed;
mod report;
mod resume;
