//! Frames against golden pictures.
