//! The colours of the animation, and its fixed palette.

use std::collections::HashMap;

/// Red, green and blue.
pub(super) type Rgb = [u8; 3];

pub(super) const PAPER: Rgb = [251, 251, 248];
pub(super) const INK: Rgb = [34, 34, 34];
pub(super) const GROUND: Rgb = [88, 88, 88];
pub(super) const GUIDE: Rgb = [164, 168, 172];
pub(super) const TRACE: Rgb = [176, 82, 140];
pub(super) const PIN: Rgb = [255, 255, 255];
pub(super) const REACTION: Rgb = [204, 51, 17];
pub(super) const LOAD: Rgb = [0, 119, 90];

/// Fill and edge colours of successive bodies.
pub(super) const BODIES: [(Rgb, Rgb); 6] = [
    ([148, 196, 230], [0, 82, 132]),
    ([248, 190, 140], [160, 70, 0]),
    ([150, 214, 190], [0, 100, 72]),
    ([240, 220, 130], [132, 100, 0]),
    ([222, 176, 206], [124, 50, 96]),
    ([200, 204, 208], [70, 74, 80]),
];

/// Fill and edge colours of the ground.
pub(super) const FIXED: (Rgb, Rgb) = BODIES[5];

/// The transparent colour index, for pixels that equal those of the previous picture.
pub(super) const UNCHANGED: u8 = 255;

/// The palette of all animations.
#[derive(Debug)]
pub(super) struct Palette {
    colours: Vec<Rgb>,
    known: HashMap<Rgb, u8>,
}

impl Palette {
    /// Creates the palette from all colours, and their blends where two of them meet.
    pub(super) fn new() -> Self {
        let mut colours = vec![PAPER, INK, GROUND, GUIDE, TRACE, PIN, REACTION, LOAD];
        colours.extend(BODIES.iter().flat_map(|(inside, edge)| [*inside, *edge]));
        let plain = colours.clone();
        for colour in &plain[1..] {
            colours.extend((1..6).map(|part| blend(*colour, PAPER, part, 6)));
        }
        for (inside, edge) in BODIES {
            colours.extend((1..5).map(|part| blend(edge, inside, part, 5)));
            colours.extend(
                [(edge, PIN), (INK, inside), (TRACE, inside), (REACTION, inside)].map(|(a, b)| blend(a, b, 1, 2)),
            );
        }
        colours.extend((1..6).map(|part| blend(INK, PIN, part, 6)));
        colours.dedup();
        colours.truncate(usize::from(UNCHANGED));
        Self { colours, known: HashMap::new() }
    }

    /// The table for the file, including [`UNCHANGED`].
    pub(super) fn table(&self) -> Vec<u8> {
        let mut table: Vec<u8> = self.colours.iter().flatten().copied().collect();
        table.resize(3 * 256, 0);
        table
    }

    /// The index of the nearest colour.
    pub(super) fn nearest(&mut self, colour: Rgb) -> u8 {
        let colours = &self.colours;
        *self.known.entry(colour).or_insert_with(|| {
            let apart = |other: &Rgb| -> i32 {
                other.iter().zip(colour).map(|(a, b)| (i32::from(*a) - i32::from(b)).pow(2)).sum()
            };
            let nearest = colours.iter().enumerate().min_by_key(|(_, other)| apart(other));
            nearest.map_or(0, |(place, _)| place as u8)
        })
    }
}

/// Blends two colours with the weights `part` and `whole - part`.
fn blend(one: Rgb, other: Rgb, part: u32, whole: u32) -> Rgb {
    std::array::from_fn(|i| {
        ((u32::from(one[i]) * part + u32::from(other[i]) * (whole - part) + whole / 2) / whole) as u8
    })
}
