//! The division of the sheet, in CSS pixels.

use super::{Figure, Panel, text};

/// The width of the sheet.
pub(super) const WIDTH: f64 = 800.0;
/// The margin to the left of titles and to the right of everything.
pub(super) const MARGIN: f64 = 16.0;
/// The distance from the plotting area to the right edge: room for half a label of the time axis.
pub(super) const RIGHT: f64 = 26.0;
/// The room for the time axis below the lowest panel.
pub(super) const TIME_AXIS: f64 = 44.0;
/// The font sizes.
pub(super) const TITLE: f64 = 16.0;
pub(super) const HEADER: f64 = 13.0;
pub(super) const TICK: f64 = 12.0;
pub(super) const LABEL: f64 = 11.5;
/// The length of the line before a name in the legend.
pub(super) const SAMPLE: f64 = 26.0;

const ROW: f64 = 19.0;

/// The position of a panel.
#[derive(Clone, Debug)]
pub(super) struct Place {
    /// The vertical centre of the line that describes the ordinate.
    pub(super) header: f64,
    /// Curves in the legend: the index, the start of the sample, the vertical centre of the line, and the text.
    pub(super) entries: Vec<(usize, f64, f64, String)>,
    /// The top of the plotting area.
    pub(super) top: f64,
    pub(super) bottom: f64,
}

/// The height of the sheet and the positions of its panels. `descriptions` describe the ordinates.
pub(super) fn divided(figure: &Figure, descriptions: &[String]) -> (f64, Vec<Place>) {
    let mut y = if figure.title.is_empty() { 8.0 } else { 40.0 };
    let is_alone = figure.panels.len() == 1;
    let mut places = Vec::new();
    for (panel, description) in figure.panels.iter().zip(descriptions) {
        let header = y + 0.5 * ROW;
        let (entries, rows) = legend(panel, description, header);
        let top = y + ROW * f64::from(rows) + 9.0;
        let whole = if figure.abscissa.is_isometric { 640.0 } else { 420.0 };
        let height = if is_alone { (whole - TIME_AXIS - top).max(240.0) } else { height_of_one(rows) };
        places.push(Place { header, entries, top, bottom: top + height });
        y = top + height + 14.0;
    }
    (y - 14.0 + TIME_AXIS, places)
}

/// The height of a panel's plotting area.
pub(super) fn height_of(figure: &Figure) -> f64 {
    match figure.panels.len() {
        1 if figure.abscissa.is_isometric => 530.0,
        1 => 310.0,
        _ => height_of_one(1),
    }
}

fn height_of_one(rows: u32) -> f64 {
    (176.0 - ROW * f64::from(rows)).max(130.0)
}

/// The legend after the description, and its number of rows. A single curve needs none.
fn legend(panel: &Panel, description: &str, header: f64) -> (Vec<(usize, f64, f64, String)>, u32) {
    let mut entries = Vec::new();
    let (mut x, mut row) = (MARGIN + text::width(description, HEADER) + 26.0, 0);
    if panel.curves.len() < 2 {
        return (entries, 1);
    }
    for (i, curve) in panel.curves.iter().enumerate() {
        let name =
            if curve.doc.is_empty() { curve.name.clone() } else { format!("{}\u{2002}{}", curve.name, curve.doc) };
        let name = text::cut(&text::clean(&name), TICK, WIDTH - 2.0 * MARGIN - SAMPLE - 8.0);
        let width = SAMPLE + 7.0 + text::width(&name, TICK);
        if x + width > WIDTH - MARGIN {
            (x, row) = (MARGIN, row + 1);
        }
        entries.push((i, x, header + ROW * f64::from(row), name));
        x += width + 18.0;
    }
    (entries, row + 1)
}
