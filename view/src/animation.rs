//! Animations as HTML.

use std::io::{Error, Write};

use serde::Serialize;
use serde_json::ser::{Formatter, Serializer};

use crate::html::escaped;
use crate::motion::Motion;
use crate::rounding::rounded;

/// A whole document that plays the motion: it needs nothing but a browser.
pub fn page(motion: &Motion) -> String {
    document(&motion.title, &motion.doc, &recorded(motion, "page", "h1"))
}

/// The same animation as a piece of a larger document; several of them may stand in one.
pub fn fragment(motion: &Motion) -> String {
    recorded(motion, "piece", "h2")
}

/// A whole document whose motion is computed in the browser, by a module of WebAssembly for a scene.
pub fn live_page(scene: &LiveScene) -> String {
    let source = [include_str!("animation/simulator.js"), include_str!("animation/panel.js")].concat();
    let piece = Piece {
        mode: "page",
        heading: "h1",
        title: &scene.title,
        doc: &scene.doc,
        data: &format!("{{\"module\":\"{}\",\"scene\":\"{}\"}}", scene.module, scene.data),
        panel: include_str!("animation/panel.html"),
        source: &source,
    };
    document(&scene.title, &scene.doc, &without_comments(&piece.html()))
}

/// The text without indentation, empty lines, and lines that are comments of a script: half of it is the simulator, and
/// what is not read need not be sent.
fn without_comments(text: &str) -> String {
    let is_comment = |line: &&str| ["//", "/*", "* ", "*/"].iter().any(|start| line.starts_with(start));
    let kept = text.lines().map(str::trim).filter(|line| !line.is_empty() && !is_comment(line));
    kept.flat_map(|line| [line, "\n"]).collect()
}

/// A scene that is simulated in the browser.
#[derive(Clone, Debug)]
pub struct LiveScene {
    /// What moves.
    pub title: String,
    /// A sentence about it.
    pub doc: String,
    /// The simulator: WebAssembly, compressed by gzip, in base64.
    pub module: String,
    /// The scene as the simulator takes it, compressed and in base64 likewise.
    pub data: String,
}

fn document(title: &str, doc: &str, fragment: &str) -> String {
    format!(include_str!("animation/page.html"), title = escaped(title), doc = escaped(doc), fragment = fragment)
}

fn recorded(motion: &Motion, mode: &str, heading: &str) -> String {
    let piece = Piece {
        mode,
        heading,
        title: &motion.title,
        doc: &motion.doc,
        data: &data(motion),
        panel: "",
        source: include_str!("animation/recorded.js"),
    };
    piece.html()
}

/// An animation; a `page` owns the keyboard and the address of the document, a `piece` only its own part.
struct Piece<'a> {
    mode: &'a str,
    heading: &'a str,
    title: &'a str,
    doc: &'a str,
    /// What the source takes, as JSON.
    data: &'a str,
    /// What stands below the controls.
    panel: &'a str,
    /// The script that installs the motion.
    source: &'a str,
}

impl Piece<'_> {
    fn css(&self) -> String {
        let panel = if self.panel.is_empty() { "" } else { include_str!("animation/panel.css") };
        format!("{}{panel}", include_str!("animation/animation.css"))
    }

    fn html(&self) -> String {
        format!(
            include_str!("animation/fragment.html"),
            mode = self.mode,
            heading = self.heading,
            title = escaped(self.title),
            doc = escaped(self.doc),
            css = self.css(),
            panel = self.panel,
            data = self.data,
            basics = include_str!("animation/basics.js"),
            drawing = include_str!("animation/drawing.js"),
            plots = include_str!("animation/plots.js"),
            player = include_str!("animation/player.js"),
            source = self.source,
        )
    }
}

/// The motion as JSON that may stand in a script element.
fn data(motion: &Motion) -> String {
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
