//! Animations in HTML.

use std::io::{Error, Write};

use serde::Serialize;
use serde_json::ser::{Formatter, Serializer};

use crate::html::escaped;
use crate::motion::Motion;
use crate::rounding::rounded;

/// Creates a complete document that plays the motion in any browser.
pub fn page(motion: &Motion) -> String {
    document(&motion.title, &recorded(motion, "page", "h1"))
}

/// Creates an animation of the motion as a part of a larger document, which may contain several.
pub fn fragment(motion: &Motion) -> String {
    recorded(motion, "piece", "h2")
}

/// Creates a complete document whose motion is computed in the browser, by a WebAssembly module for a scene. `pack`
/// compresses its script and style sheet, like module and scene.
///
/// # Errors
/// The script or style sheet cannot be compressed.
pub fn simulator_page<E>(page: &SimulatorPage, pack: impl Fn(&[u8]) -> Result<String, E>) -> Result<String, E> {
    let scripts = [
        include_str!("animation/simulator.js"),
        include_str!("animation/panel.js"),
        include_str!("animation/drag.js"),
        include_str!("animation/export.js"),
    ];
    let (source, tools) = match page.scene {
        Some(_) => (include_str!("animation/embedded.js"), ""),
        None => {
            let scripts = concat!(include_str!("animation/edit_tools.js"), include_str!("animation/live.js"));
            (scripts, include_str!("animation/edit_tools.css"))
        }
    };
    let script =
        pack(format!("(() => {{\n\"use strict\";\n{}}})();", player(&(scripts.concat() + source))).as_bytes())?;
    let style = pack(style(&(include_str!("animation/panel.css").to_owned() + tools)).as_bytes())?;
    let piece = Piece {
        mode: "page",
        heading: "h1",
        title: page.title,
        doc: page.doc,
        // Hidden until the style sheet is loaded.
        style: ".qrm-frame{visibility:hidden}".to_owned(),
        data: &data(&Packed { page, style, script }),
        panel: include_str!("animation/panel.html"),
        // No text in it has these signs.
        script: compact(include_str!("animation/loader.js")).replace(" = ", "="),
    };
    Ok(document(page.title, &piece.html()))
}

/// The data of a page that simulates a scene, with the compressed style sheet and script.
#[derive(Serialize)]
struct Packed<'a> {
    #[serde(flatten)]
    page: &'a SimulatorPage<'a>,
    style: String,
    script: String,
}

/// A page that simulates a scene.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct SimulatorPage<'a> {
    /// The title of the page: the moving thing.
    #[serde(skip)]
    pub title: &'a str,
    /// A sentence about the scene.
    #[serde(skip)]
    pub doc: &'a str,
    /// The name of the scene on a command line.
    pub command: &'a str,
    /// Whether a server writes values to the file of the scene.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    pub is_writable: bool,
    /// The simulator: WebAssembly, compressed by gzip, in base 91.
    pub module: &'a str,
    /// The scene in the simulator's format, compressed and in base 91 too; `None` if a server provides it.
    pub scene: Option<&'a str>,
}

fn document(title: &str, fragment: &str) -> String {
    format!(include_str!("animation/page.html"), title = escaped(title), fragment = fragment)
}

fn recorded(motion: &Motion, mode: &str, heading: &str) -> String {
    let piece = Piece {
        mode,
        heading,
        title: &motion.title,
        doc: &motion.doc,
        style: style(""),
        data: &data(&rounded(motion)),
        panel: "",
        script: player(include_str!("animation/recorded.js")),
    };
    piece.html()
}

/// An animation. A `page` owns the keyboard and the address of the document, a `piece` only its own part.
struct Piece<'a> {
    mode: &'a str,
    heading: &'a str,
    title: &'a str,
    doc: &'a str,
    /// The style sheet of the animation.
    style: String,
    /// The data, as JSON, for the script that supplies the motion.
    data: &'a str,
    /// The HTML below the controls.
    panel: &'a str,
    /// The script of the animation.
    script: String,
}

/// The style sheet of an animation and its panel.
fn style(panel: &str) -> String {
    // Spaces next to these signs have no meaning in a style sheet.
    const TIGHT: [(&str, &str); 6] = [(": ", ":"), ("; ", ";"), (", ", ","), (" {", "{"), ("{ ", "{"), (" }", "}")];
    let text = compact(&format!("{}{panel}", include_str!("animation/animation.css")));
    TIGHT.iter().fold(text, |text, (loose, tight)| text.replace(loose, tight))
}

impl Piece<'_> {
    fn html(&self) -> String {
        format!(
            include_str!("animation/fragment.html"),
            mode = self.mode,
            heading = self.heading,
            title = escaped(self.title),
            doc = escaped(self.doc),
            css = self.style,
            panel = self.panel,
            data = self.data,
            script = self.script,
        )
    }
}

/// The script of an animation, including the part that installs the motion.
fn player(source: &str) -> String {
    let parts = [
        include_str!("animation/basics.js"),
        include_str!("animation/elements.js"),
        include_str!("animation/machine.js"),
        include_str!("animation/drawing.js"),
        include_str!("animation/plots.js"),
        include_str!("animation/player.js"),
        source,
    ];
    compact(&parts.concat())
}

/// A script or a style sheet without indentation, comment lines, and unnecessary line ends.
fn compact(text: &str) -> String {
    let is_comment = |line: &&str| ["//", "/*", "* ", "*/"].iter().any(|start| line.starts_with(start));
    let kept = text.lines().map(str::trim).filter(|line| !line.is_empty() && !is_comment(line));
    kept.flat_map(|line| [line, if line.ends_with([';', '{', ',', '(', '[']) { "" } else { "\n" }]).collect()
}

/// A value as JSON that can be placed in a script element.
fn data(value: &impl Serialize) -> String {
    let mut bytes = Vec::new();
    value
        .serialize(&mut Serializer::with_formatter(&mut bytes, Compact))
        .expect("names and numbers are JSON, and memory takes them");
    String::from_utf8(bytes).expect("JSON is UTF-8")
}

/// JSON without redundant zeros, and without characters that could end a script element.
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
