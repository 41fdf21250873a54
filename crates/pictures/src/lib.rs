//! Converts recorded runs into motions: moving shapes, and curves next to them.

mod drawing;
mod force_elements;
mod groups;
mod motion;
mod parts;
mod pose;
mod position_error;
mod recording;
mod source;
mod teeth;

pub use groups::{Group, HEALTH, MAX_CURVES, Member, groups, printed_unit};
pub use motion::{NoPlace, motion};
pub use position_error::position_error;
pub use recording::{Frame, Recording};
pub use source::Sources;
