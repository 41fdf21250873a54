//! Colours, line widths and font sizes, and the style sheet with the dark mode.

use plotters::style::{Color, FontStyle, IntoFont, RGBColor, ShapeStyle, TextStyle};

/// Drawing units per CSS pixel: plotters uses integer coordinates only.
pub(super) const UNITS: i32 = 20;

/// The width of curves, in hundredths of a pixel.
pub(super) const CURVE: u32 = 180;
pub(super) const THIN: u32 = 80;

/// A colour in light mode and in dark mode.
#[derive(Clone, Copy, Debug)]
pub(super) struct Shade {
    pub(super) paper: RGBColor,
    dark: RGBColor,
}

const fn shade(paper: (u8, u8, u8), dark: (u8, u8, u8)) -> Shade {
    Shade { paper: RGBColor(paper.0, paper.1, paper.2), dark: RGBColor(dark.0, dark.1, dark.2) }
}

pub(super) const PAPER: Shade = shade((255, 255, 255), (22, 25, 30));
pub(super) const TEXT: Shade = shade((26, 26, 26), (232, 234, 237));
pub(super) const MUTED: Shade = shade((74, 74, 74), (176, 182, 190));
pub(super) const AXIS: Shade = shade((96, 96, 96), (140, 147, 156));
pub(super) const ZERO: Shade = shade((168, 168, 168), (92, 98, 107));
pub(super) const GRID: Shade = shade((226, 226, 226), (48, 53, 61));
pub(super) const LIGHT_GRID: Shade = shade((242, 242, 242), (33, 37, 43));

/// The style of a curve.
#[derive(Clone, Copy, Debug)]
pub(super) struct Pen {
    pub(super) line: Shade,
    /// The colour of text, which needs more contrast than a line.
    pub(super) ink: Shade,
    /// Lengths of dashes and gaps in drawing units; empty for a solid line.
    dashes: &'static str,
}

/// Colours after Okabe and Ito, which people with any kind of colour vision can distinguish. The dashes are for prints
/// without colours.
const PENS: [Pen; 7] = [
    pen((0, 114, 178), (0, 90, 142), (98, 182, 240), ""),
    pen((213, 94, 0), (166, 72, 0), (255, 148, 84), "230 70"),
    pen((0, 145, 106), (0, 110, 80), (64, 206, 160), "120 50"),
    pen((176, 82, 140), (148, 62, 116), (232, 158, 204), "230 60 40 60"),
    pen((222, 150, 0), (140, 94, 0), (243, 190, 72), "60 50"),
    pen((70, 165, 220), (26, 104, 150), (150, 214, 255), "230 60 40 60 40 60"),
    pen((108, 108, 108), (84, 84, 84), (190, 190, 190), "400 80"),
];

const fn pen(line: (u8, u8, u8), ink: (u8, u8, u8), dark: (u8, u8, u8), dashes: &'static str) -> Pen {
    Pen { line: shade(line, dark), ink: shade(ink, dark), dashes }
}

/// The pen of a curve by its index; pens repeat.
pub(super) fn pen_of(curve: usize) -> Pen {
    PENS[curve % PENS.len()]
}

/// The style of a line; its width is in hundredths of a pixel.
pub(super) fn stroke(shade: Shade, width: u32) -> ShapeStyle {
    shade.paper.stroke_width(width * UNITS as u32 / 100)
}

/// The style of text; its size is in CSS pixels.
pub(super) fn letters(shade: Shade, size: f64, is_bold: bool) -> TextStyle<'static> {
    // The backend divides by 1.24, which must not leave a rounding error in the output.
    let wanted = size * f64::from(UNITS);
    let near = [wanted * 1.24, (wanted * 1.24).next_down(), (wanted * 1.24).next_up()];
    let size = near.into_iter().find(|size| size / 1.24 == wanted).unwrap_or(near[0]);
    let font = ("sans-serif", size).into_font();
    let font = if is_bold { font.style(FontStyle::Bold) } else { font };
    TextStyle { color: shade.paper.to_backend_color(), ..TextStyle::from(font) }
}

/// The style sheet, identical in all figures and restricted to them, so that a page can contain several.
pub(super) fn style_sheet() -> String {
    let lines = PENS.map(|pen| pen.line);
    let inks = PENS.map(|pen| pen.ink);
    let mut css = String::from(
        "svg.qrm{max-width:100%;height:auto;background:#FFFFFF}\
         svg.qrm text{font-family:Helvetica,Arial,Liberation Sans,sans-serif;font-variant-numeric:tabular-nums}\
         svg.qrm polyline{stroke-linejoin:round;stroke-linecap:round}",
    );
    // Dashes would make thin lines unreadable.
    for pen in PENS.iter().filter(|pen| !pen.dashes.is_empty()) {
        let (colour, width) = (hex(pen.line.paper), CURVE * UNITS as u32 / 100);
        css += &format!("svg.qrm [stroke=\"{colour}\"][stroke-width=\"{width}\"]{{stroke-dasharray:{}}}", pen.dashes);
    }
    // A halo in the colour of the background keeps letters readable where they cross a line.
    let of_labels: Vec<String> = inks.iter().map(|ink| format!("svg.qrm text[fill=\"{}\"]", hex(ink.paper))).collect();
    let of_labels = of_labels.join(",");
    css += &format!("{of_labels}{{paint-order:stroke;stroke:#FFFFFF;stroke-width:70;stroke-linejoin:round}}");
    css += &format!(
        "@media screen and (prefers-color-scheme:dark){{svg.qrm{{background:{dark}}}{of_labels}{{stroke:{dark}}}",
        dark = hex(PAPER.dark)
    );
    for shade in [PAPER, TEXT, MUTED, AXIS, ZERO, GRID, LIGHT_GRID].iter().chain(&lines).chain(&inks) {
        let (paper, dark) = (hex(shade.paper), hex(shade.dark));
        css += &format!("svg.qrm [fill=\"{paper}\"]{{fill:{dark}}}svg.qrm [stroke=\"{paper}\"]{{stroke:{dark}}}");
    }
    css + "}"
}

/// Formats a colour like plotters.
pub(super) fn hex(colour: RGBColor) -> String {
    let (r, g, b) = colour.rgb();
    format!("#{r:02X}{g:02X}{b:02X}")
}
