//! Draws the pictures and encodes them one after another.

use std::io;

use ::gif::{DisposalMethod, Encoder, EncodingError, Frame, Repeat};
use embedded_graphics::mono_font::ascii::{FONT_6X10, FONT_8X13, FONT_9X15_BOLD};

use crate::motion::Motion;

use super::canvas::Canvas;
use super::clock::Clock;
use super::labels::{self, plain};
use super::palette::{GROUND, INK, Palette, UNCHANGED};
use super::shapes;
use super::stage::Stage;
use super::track::Moment;

/// Encodes the whole animation.
pub(super) fn encode(motion: &Motion, stage: &Stage, clock: &Clock) -> Result<Vec<u8>, EncodingError> {
    let (width, height) = (stage.width as u16, stage.height as u16);
    let mut palette = Palette::new();
    let mut bytes = Vec::new();
    let mut encoder = Encoder::new(&mut bytes, width, height, &palette.table())?;
    encoder.set_repeat(Repeat::Infinite)?;
    let backdrop = backdrop(motion, stage).ok_or(io::Error::other("the picture has no area"))?;
    let labels = labels::place_labels(motion, stage);
    let mut shown: Vec<u8> = Vec::new();
    for &time in &clock.times {
        let moment = Moment::at(&motion.times, time);
        let mut canvas = backdrop.clone();
        shapes::draw(&mut canvas, motion, stage, moment);
        labels.iter().for_each(|label| label.draw(&mut canvas, motion, stage, moment));
        let said = format!("{}   {}", clock.reading(time), clock.speed);
        canvas.write(said.trim_end(), &FONT_8X13, (12, 28), INK);
        let picture = indexed(&canvas, &mut palette);
        encoder.write_frame(&changed(&shown, &picture, usize::from(width), clock.delay))?;
        shown = picture;
    }
    drop(encoder);
    Ok(bytes)
}

/// Draws the parts that all pictures share: title, paths, and the scale of the arrows.
fn backdrop(motion: &Motion, stage: &Stage) -> Option<Canvas> {
    let mut canvas = Canvas::new(stage.width, stage.height)?;
    shapes::draw_traces(&mut canvas, motion, stage);
    let most = (stage.width as usize - 24) / 9;
    let title: String = plain(&motion.title).chars().take(most).collect();
    canvas.write(&title, &FONT_9X15_BOLD, (12, 9), INK);
    if stage.largest > 0.0 {
        let mut x = 12;
        let words = [(true, "reaction"), (false, "load")];
        let kinds = words.iter().filter_map(|(is_reaction, word)| {
            motion.arrows.iter().find(|arrow| arrow.is_reaction == *is_reaction).map(|arrow| (arrow, *word))
        });
        let scale = format!("longest arrow: {}", newtons(stage.largest));
        let words = kinds.map(|(arrow, word)| (shapes::colour_of(arrow), word.to_owned())).chain([(GROUND, scale)]);
        for (colour, word) in words {
            canvas.write(&word, &FONT_6X10, (x, stage.height as i32 - 16), colour);
            x += 6 * (word.len() as i32 + 2);
        }
    }
    Some(canvas)
}

/// A force with three digits.
fn newtons(force: f64) -> String {
    let (number, unit) = match force {
        1e6..1e9 => (force / 1e6, "MN"),
        1e3..1e6 => (force / 1e3, "kN"),
        1e-2..1e3 => (force, "N"),
        _ => return format!("{force:.2e} N"),
    };
    format!("{number:.*} {unit}", (2 - number.log10().floor() as i32).clamp(0, 4) as usize)
}

/// Converts a picture to the colours of the palette.
fn indexed(canvas: &Canvas, palette: &mut Palette) -> Vec<u8> {
    let mut last = ([0, 0, 0], palette.nearest([0, 0, 0]));
    let place = |colour| {
        // Most neighbouring pixels have the same colour.
        if colour != last.0 {
            last = (colour, palette.nearest(colour));
        }
        last.1
    };
    canvas.colours().map(place).collect()
}

/// The part of a picture that differs from the previous one, with equal pixels transparent.
fn changed<'a>(before: &[u8], picture: &[u8], width: usize, delay: u16) -> Frame<'a> {
    let height = picture.len() / width;
    let differs = |x: usize, y: usize| before.get(y * width + x) != picture.get(y * width + x);
    let rows: Vec<usize> = (0..height).filter(|y| (0..width).any(|x| differs(x, *y))).collect();
    let columns: Vec<usize> = (0..width).filter(|x| rows.iter().any(|y| differs(*x, *y))).collect();
    // A frame has at least one pixel.
    let range = |kept: &[usize]| (kept.first().copied().unwrap_or(0), kept.last().copied().unwrap_or(0) + 1);
    let ((top, bottom), (left, right)) = (range(&rows), range(&columns));
    let pixels = (top..bottom).flat_map(|y| (left..right).map(move |x| (x, y)));
    let buffer = pixels.map(|(x, y)| if differs(x, y) { picture[y * width + x] } else { UNCHANGED });
    Frame {
        delay,
        dispose: DisposalMethod::Keep,
        transparent: Some(UNCHANGED),
        top: top as u16,
        left: left as u16,
        width: (right - left) as u16,
        height: (bottom - top) as u16,
        buffer: buffer.collect::<Vec<u8>>().into(),
        ..Frame::default()
    }
}
