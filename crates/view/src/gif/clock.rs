//! The speed of the animation.

/// The delay between pictures, in hundredths of a second as in GIF.
const DELAY: usize = 4;
const MOST_FRAMES: usize = 400;

/// The times of the pictures.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Clock {
    /// The time of each picture in the motion.
    pub(super) times: Vec<f64>,
    /// The time for which each picture is shown, in hundredths of a second.
    pub(super) delay: u16,
    /// The text about the speed of the animation; empty in real time.
    pub(super) speed: String,
    /// The time between two pictures in the motion.
    step: f64,
}

impl Clock {
    /// Creates the clock of a motion recorded at these times; `None` if they do not increase.
    pub(super) fn new(times: &[f64]) -> Option<Self> {
        let (first, last) = (*times.first()?, *times.last()?);
        let length = last - first;
        if !(length > 0.0 && length.is_finite()) {
            return None;
        }
        let (factor, speed) = pace(length);
        let shown = length * factor * 100.0;
        let delay = DELAY.max((shown / MOST_FRAMES as f64).ceil() as usize);
        let count = ((shown / delay as f64).round() as usize).clamp(2, MOST_FRAMES);
        let step = length * (delay as f64 / shown);
        let times = (0..count).map(|i| first + (step * i as f64).min(length)).collect();
        Some(Self { times, delay: delay as u16, speed, step })
    }

    /// Formats a time: `t = 0.123 s`.
    pub(super) fn reading(&self, time: f64) -> String {
        let decimals = 1 - self.step.log10().floor() as i32;
        match decimals {
            ..-6 | 8.. => format!("t = {time:.3e} s"),
            _ => format!("t = {time:.*} s", decimals.max(0) as usize),
        }
    }
}

/// The ratio of the displayed duration to the length of a run in seconds, and the text about it.
fn pace(length: f64) -> (f64, String) {
    if (1.0..=20.0).contains(&length) {
        return (1.0, String::new());
    }
    // Slow motion takes at least 2 s, fast motion at most 15 s.
    let (least, is_slowed) = if length < 1.0 { (2.0 / length, true) } else { (length / 15.0, false) };
    let mut factor = 10f64.powf(least.log10().floor());
    // A logarithm may be rounded up.
    factor = if factor > least { factor / 10.0 } else { factor };
    let factor = [1.0, 2.0, 5.0, 10.0].map(|digit| digit * factor).into_iter().find(|f| *f >= least).unwrap_or(least);
    let written = if factor < 1e6 { format!("{factor:.0}") } else { format!("{factor:.0e}") };
    if is_slowed { (factor, format!("slowed {written}x")) } else { (1.0 / factor, format!("{written}x faster")) }
}
