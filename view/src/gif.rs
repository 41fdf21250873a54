//! Animations as GIF.

mod canvas;
mod clock;
mod film;
mod force_elements;
mod hull;
mod labels;
mod palette;
mod shapes;
mod stage;
mod teeth;
mod track;

use std::fmt;

use crate::motion::Motion;

use self::clock::Clock;
use self::stage::Stage;

/// The motion as an animated GIF that repeats for ever: at most 640 by 480 pixels, in real time if the run lasts from 1
/// s to 20 s, otherwise slowed or quickened by a factor that the picture states.
///
/// # Errors
/// The motion is not what [`Motion`] says, or lies too far apart to draw.
pub fn gif(motion: &Motion) -> Result<Vec<u8>, NoAnimation> {
    track::check(motion)?;
    let stage = Stage::new(motion).ok_or(NoAnimation::NotFinite)?;
    let clock = Clock::new(&motion.times).ok_or(NoAnimation::NotRising)?;
    film::shot(motion, &stage, &clock).map_err(|e| NoAnimation::NotWritten(e.to_string()))
}

/// Why a motion cannot be shown.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum NoAnimation {
    /// There are fewer than two frames, or their times do not rise.
    NotRising,
    /// This node, arrow or shape has no value for each frame, or means a node that does not exist.
    Inconsistent(String),
    /// A number is not finite, or numbers lie so far apart that their difference is not.
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
