//! Masks against ray-traced visibility.
