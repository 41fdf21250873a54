//! Recorded runs as figures and animations.

mod animation;
mod drawing;
mod figures;
mod pose;

pub(crate) use animation::motion;
pub(crate) use figures::figures;
