//! Animations as GIF.

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
