//! What a picture of the mechanism shows.

use super::{Context, Resolver};
use crate::document::{Document, DrawnSyntax, Position};
use crate::scene::{Drawn, DrawnKind, Value};

impl Resolver<'_> {
    pub(super) fn drawing(&mut self, document: &Document) -> Vec<Drawn> {
        let mut drawing = Vec::new();
        for (identifier, syntax) in &document.drawing {
            let kind = self.drawn(syntax);
            drawing.extend(kind.map(|kind| Drawn { name: identifier.name.clone(), kind }));
        }
        drawing
    }

    fn drawn(&mut self, syntax: &DrawnSyntax) -> Option<DrawnKind> {
        Some(match syntax {
            DrawnSyntax::Link(places) => DrawnKind::Link(self.places(places)?),
            DrawnSyntax::Guide(places) => DrawnKind::Guide(self.places(places)?),
            DrawnSyntax::Block { at, angle } => {
                let angle = angle.as_ref().map(|f| self.value(f, Context::Picture));
                DrawnKind::Block { at: self.position(at, Context::Picture)?, angle }
            }
            DrawnSyntax::Pivot(at) => DrawnKind::Pivot(self.position(at, Context::Picture)?),
            DrawnSyntax::Path(point) => DrawnKind::Path(self.point(point)?),
        })
    }

    /// All places, so that each mistake is reported, or none.
    fn places(&mut self, places: &[Position]) -> Option<Vec<[Value; 2]>> {
        let places: Vec<Option<[Value; 2]>> = places.iter().map(|p| self.position(p, Context::Picture)).collect();
        places.into_iter().collect()
    }
}
