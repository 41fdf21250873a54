//! A canvas.

use std::convert::Infallible;

use embedded_graphics::Drawable;
use embedded_graphics::Pixel;
use embedded_graphics::draw_target::DrawTarget;
use embedded_graphics::geometry::{OriginDimensions, Point as At, Size};
use embedded_graphics::mono_font::{MonoFont, MonoTextStyle};
use embedded_graphics::pixelcolor::{Rgb888, RgbColor};
use embedded_graphics::text::{Baseline, Text};
use tiny_skia::{Color, FillRule, LineCap, LineJoin, Paint, Path, PathBuilder, Pixmap, Stroke, Transform};

use super::palette::{PAPER, Rgb};
use super::stage::Point;

/// A picture.
#[derive(Clone, Debug)]
pub(super) struct Canvas {
    pixmap: Pixmap,
}

impl Canvas {
    /// Creates an empty canvas; `None` if it has no area.
    pub(super) fn new(width: u32, height: u32) -> Option<Self> {
        let mut pixmap = Pixmap::new(width, height)?;
        pixmap.fill(Color::from_rgba8(PAPER[0], PAPER[1], PAPER[2], 255));
        Some(Self { pixmap })
    }

    /// The colours of all pixels, row by row.
    pub(super) fn colours(&self) -> impl Iterator<Item = Rgb> {
        self.pixmap.pixels().iter().map(|pixel| [pixel.red(), pixel.green(), pixel.blue()])
    }

    /// Draws a line through points, with round ends.
    pub(super) fn line(&mut self, points: &[Point], width: f32, colour: Rgb) {
        self.stroke(path(points, false), width, colour);
    }

    /// Draws the outline of a polygon, with round corners.
    pub(super) fn outline(&mut self, points: &[Point], width: f32, colour: Rgb) {
        self.stroke(path(points, true), width, colour);
    }

    /// Fills a polygon.
    pub(super) fn polygon(&mut self, points: &[Point], colour: Rgb, opacity: u8) {
        self.fill(path(points, true), colour, opacity);
    }

    /// Fills the region inside one polygon and outside another.
    pub(super) fn ring(&mut self, outside: &[Point], inside: &[Point], colour: Rgb) {
        let mut builder = PathBuilder::new();
        for polygon in [outside, inside] {
            if let Some(path) = path(polygon, true) {
                builder.push_path(&path);
            }
        }
        if let Some(path) = builder.finish() {
            self.pixmap.fill_path(&path, &paint(colour, 255), FillRule::EvenOdd, Transform::identity(), None);
        }
    }

    /// Fills a disc.
    pub(super) fn disc(&mut self, centre: Point, radius: f32, colour: Rgb) {
        self.fill(PathBuilder::from_circle(centre.0, centre.1, radius), colour, 255);
    }

    /// Writes text to the right of and below a point, with a halo that keeps the letters readable on any background.
    pub(super) fn write(&mut self, text: &str, font: &MonoFont<'_>, (x, y): (i32, i32), colour: Rgb) {
        let style = |colour: Rgb| MonoTextStyle::new(font, Rgb888::new(colour[0], colour[1], colour[2]));
        let rim = [(-1, -1), (0, -1), (1, -1), (-1, 0), (1, 0), (-1, 1), (0, 1), (1, 1)];
        let layers = rim.into_iter().map(|offset| (offset, PAPER)).chain([((0, 0), colour)]);
        for ((dx, dy), colour) in layers {
            let Ok(_) =
                Text::with_baseline(text, At::new(x + dx, y + dy), style(colour), Baseline::Top).draw(&mut *self);
        }
    }

    fn fill(&mut self, path: Option<Path>, colour: Rgb, opacity: u8) {
        if let Some(path) = path {
            self.pixmap.fill_path(&path, &paint(colour, opacity), FillRule::Winding, Transform::identity(), None);
        }
    }

    fn stroke(&mut self, path: Option<Path>, width: f32, colour: Rgb) {
        let stroke = Stroke { width, line_cap: LineCap::Round, line_join: LineJoin::Round, ..Stroke::default() };
        if let Some(path) = path {
            self.pixmap.stroke_path(&path, &paint(colour, 255), &stroke, Transform::identity(), None);
        }
    }
}

fn paint(colour: Rgb, opacity: u8) -> Paint<'static> {
    let mut paint = Paint { anti_alias: true, ..Paint::default() };
    paint.set_color_rgba8(colour[0], colour[1], colour[2], opacity);
    paint
}

fn path(points: &[Point], is_closed: bool) -> Option<Path> {
    let mut path = PathBuilder::new();
    let (first, rest) = points.split_first()?;
    path.move_to(first.0, first.1);
    rest.iter().for_each(|point| path.line_to(point.0, point.1));
    if is_closed {
        path.close();
    }
    path.finish()
}

impl OriginDimensions for Canvas {
    fn size(&self) -> Size {
        Size::new(self.pixmap.width(), self.pixmap.height())
    }
}

impl DrawTarget for Canvas {
    type Color = Rgb888;
    type Error = Infallible;

    fn draw_iter<I: IntoIterator<Item = Pixel<Rgb888>>>(&mut self, pixels: I) -> Result<(), Infallible> {
        let (width, height) = (self.pixmap.width() as i32, self.pixmap.height() as i32);
        for Pixel(At { x, y }, colour) in pixels {
            if (0..width).contains(&x) && (0..height).contains(&y) {
                let colour = Color::from_rgba8(colour.r(), colour.g(), colour.b(), 255);
                self.pixmap.pixels_mut()[(y * width + x) as usize] = colour.premultiply().to_color_u8();
            }
        }
        Ok(())
    }
}
