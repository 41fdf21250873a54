//! Animations as HTML.

use std::io::{Error, Write};

use serde::Serialize;
use serde_json::ser::{Formatter, Serializer};

use crate::html::escaped;
use crate::motion::Motion;
use crate::rounding::rounded;

/// A whole document that plays the motion: it needs nothing but a browser.
pub fn page(motion: &Motion) -> String {
    format!(
        include_str!("animation/page.html"),
        title = escaped(&motion.title),
        doc = escaped(&motion.doc),
        fragment = piece(motion, "page", "h1"),
    )
}

/// The same animation as a piece of a larger document; several of them may stand in one.
pub fn fragment(motion: &Motion) -> String {
    piece(motion, "piece", "h2")
}

/// The animation; a `page` owns the keyboard and the address of the document, a `piece` only its own part.
fn piece(motion: &Motion, mode: &str, heading: &str) -> String {
    format!(
        include_str!("animation/fragment.html"),
        mode = mode,
        empty = if motion.nodes.is_empty() { " data-empty" } else { "" },
        heading = heading,
        title = escaped(&motion.title),
        doc = escaped(&motion.doc),
        css = include_str!("animation/animation.css"),
        data = data(motion),
        basics = include_str!("animation/basics.js"),
        drawing = include_str!("animation/drawing.js"),
        plots = include_str!("animation/plots.js"),
        player = include_str!("animation/player.js"),
    )
}

/// The motion as JSON that may stand in a script element.
pub fn data(motion: &Motion) -> String {
    let mut bytes = Vec::new();
    rounded(motion)
        .serialize(&mut Serializer::with_formatter(&mut bytes, Compact))
        .expect("names and numbers are JSON, and memory takes them");
    String::from_utf8(bytes).expect("JSON is UTF-8")
}

/// JSON without zeros that say nothing, and without the signs that could end a script element.
struct Compact;

impl Formatter for Compact {
    fn write_f64<W: ?Sized + Write>(&mut self, writer: &mut W, value: f64) -> Result<(), Error> {
        let (plain, scientific) = (format!("{value}"), format!("{value:e}"));
        writer.write_all(if scientific.len() < plain.len() { scientific } else { plain }.as_bytes())
    }

    fn write_string_fragment<W: ?Sized + Write>(&mut self, writer: &mut W, fragment: &str) -> Result<(), Error> {
        writer.write_all(fragment.replace('<', "\\u003c").as_bytes())
    }
}
