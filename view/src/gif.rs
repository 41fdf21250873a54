//! Animations as GIF.
