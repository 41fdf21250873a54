//! Animations in GIF.

mod canvas;
mod clock;
mod film;
mod force_elements;
mod hull;
mod labels;
mod no_animation;
mod palette;
mod shapes;
mod stage;
mod teeth;
mod track;

use crate::motion::Motion;

use self::clock::Clock;
pub use self::no_animation::NoAnimation;
use self::stage::Stage;

/// Encodes the motion as an endlessly repeating GIF of at most 640 by 480 pixels. It runs in real time if the run lasts
/// from 1 s to 20 s, and otherwise slower or faster by a factor that the picture shows.
///
/// # Errors
/// The motion violates the rules of [`Motion`], or its range is too large to draw.
pub fn gif(motion: &Motion) -> Result<Vec<u8>, NoAnimation> {
    track::check(motion)?;
    let stage = Stage::new(motion).ok_or(NoAnimation::NotFinite)?;
    let clock = Clock::new(&motion.times).ok_or(NoAnimation::NotRising)?;
    film::encode(motion, &stage, &clock).map_err(|e| NoAnimation::NotWritten(e.to_string()))
}
