//! The reasons why a motion cannot be shown.

use std::fmt;

/// The reason why a motion cannot be shown.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum NoAnimation {
    /// There are fewer than two frames, or their times do not increase.
    NotRising,
    /// This node, arrow or shape does not have one value per frame, or refers to a node that does not exist.
    Inconsistent(String),
    /// A number is not finite, or a range of numbers is too large.
    NotFinite,
    /// The picture could not be written.
    NotWritten(String),
}

impl fmt::Display for NoAnimation {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::NotRising => f.write_str("an animation needs at least two frames with rising times"),
            Self::Inconsistent(what) => write!(f, "{what} does not fit to the frames and nodes of the motion"),
            Self::NotFinite => f.write_str("the motion has numbers that are not finite, or too far apart"),
            Self::NotWritten(why) => write!(f, "the animation was not written: {why}"),
        }
    }
}

impl std::error::Error for NoAnimation {}
