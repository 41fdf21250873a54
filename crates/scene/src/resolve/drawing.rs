//! The resolution of the picture of the mechanism.

use super::Resolver;
use super::context::Context;
use crate::document::{Document, DrawnSyntax, Position};
use crate::parser::Formula;
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
            DrawnSyntax::Rod(ends) => DrawnKind::Rod(self.ends(ends)?),
            DrawnSyntax::ForceElement(kind, ends) => DrawnKind::ForceElement(*kind, self.ends(ends)?),
            DrawnSyntax::Block { at, angle, on } => {
                let angle = self.angle(angle);
                let (at, on) = (self.drawn_place(at), on.as_ref().map(|on| self.drawn_place(on)));
                DrawnKind::Block { at: at?, angle, on: on.flatten() }
            }
            DrawnSyntax::Pivot(at) => DrawnKind::Pivot(self.drawn_place(at)?),
            DrawnSyntax::Gear { at, radius, angle, is_internal } => {
                let (radius, angle) = (self.value(radius, Context::Constant), self.angle(angle));
                DrawnKind::Gear { at: self.drawn_place(at)?, radius, angle, is_internal: *is_internal }
            }
            DrawnSyntax::Rack { on, wheel, radius, angle } => {
                let (radius, angle) = (self.value(radius, Context::Constant), self.angle(angle));
                let (on, wheel) = (self.drawn_place(on), self.drawn_place(wheel));
                DrawnKind::Rack { on: on?, wheel: wheel?, radius, angle }
            }
            DrawnSyntax::Belt { at, radii, is_crossed, angle } => {
                let radii = [0, 1].map(|pulley| self.value(&radii[pulley], Context::Constant));
                let angle = self.angle(angle);
                DrawnKind::Belt { at: self.ends(at)?, radii, is_crossed: *is_crossed, angle }
            }
            DrawnSyntax::Cam { at, angle, profile, is_flat } => {
                let (profile, angle) = (self.value(profile, Context::Profile), self.angle(angle));
                DrawnKind::Cam { at: self.drawn_place(at)?, angle, profile, is_flat: *is_flat }
            }
            DrawnSyntax::Path(point) => DrawnKind::Path(self.point(point)?),
        })
    }

    fn angle(&mut self, angle: &Option<Formula>) -> Option<Value> {
        angle.as_ref().map(|f| self.value(f, Context::Picture))
    }

    fn drawn_place(&mut self, place: &Position) -> Option<[Value; 2]> {
        self.position(place, Context::Picture)
    }

    fn ends(&mut self, [first, second]: &[Position; 2]) -> Option<[[Value; 2]; 2]> {
        let (first, second) = (self.drawn_place(first), self.drawn_place(second));
        Some([first?, second?])
    }

    /// Resolves positions; reports all errors and then returns `None`.
    fn places(&mut self, places: &[Position]) -> Option<Vec<[Value; 2]>> {
        let places: Vec<Option<[Value; 2]>> = places.iter().map(|place| self.drawn_place(place)).collect();
        places.into_iter().collect()
    }
}
