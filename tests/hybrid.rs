//! Rasteriser and photons together against photons alone.
