//! Recorded runs as motions: what moves where, and which curves stand beside it.

mod drawing;
mod groups;
mod motion;
mod pose;
mod recording;
mod way;

pub use groups::{Group, HEALTH, Member, groups};
pub use motion::{NoPlace, motion};
pub use recording::{Frame, Recording};
pub use way::way;
