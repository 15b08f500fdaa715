//! The window as its users meet it: the real program on a screen, with real events of mouse and keyboard.
//!
//! Pictures of what was on the screen are kept in `target/window`. Without Xvfb nothing can be tried, and every test says so.

mod kill;
mod measure;
mod mishaps;
mod program;
mod room;
mod screen;
mod walk;
