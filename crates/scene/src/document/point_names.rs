//! The points that a scene names outside formulae.

use super::{Along, DisplacementSyntax, Document, DrawnSyntax, Identifier, LoadSyntax, OutputValue, Position, Target};

impl Document {
    /// Calls a function with the name of each point in loads, outputs and drawings.
    pub fn for_each_point_name(&mut self, mut f: impl FnMut(&mut Identifier)) {
        for (_, load) in &mut self.loads {
            match load {
                LoadSyntax::Force { target: Target::Point(point), .. } => f(point),
                LoadSyntax::Spring(spring) => {
                    if let Along::Between(from, to) = &mut spring.along {
                        [from, to].into_iter().for_each(&mut f);
                    }
                }
                LoadSyntax::Force { .. } | LoadSyntax::Torque { .. } | LoadSyntax::Gravity(_) => {}
            }
        }
        for output in &mut self.outputs {
            match &mut output.value {
                OutputValue::Reaction { target: Target::Point(point), .. }
                | OutputValue::ShakingMoment(point)
                | OutputValue::Norm { at: Some(point), .. } => f(point),
                OutputValue::FreeBody { displacements, .. } => {
                    for DisplacementSyntax { points, turn, .. } in displacements {
                        points.iter_mut().chain(turn.as_mut().map(|(_, about, _)| about)).for_each(&mut f);
                    }
                }
                _ => {}
            }
        }
        for (_, drawn) in &mut self.drawing {
            if let DrawnSyntax::Path(point) = drawn {
                f(point);
            }
            for position in drawn.positions_mut() {
                if let Position::Point(point) = position {
                    f(point);
                }
            }
        }
    }
}

impl DrawnSyntax {
    fn positions_mut(&mut self) -> Vec<&mut Position> {
        match self {
            Self::Link(all) | Self::Guide(all) => all.iter_mut().collect(),
            Self::Rod(ends) | Self::ForceElement(_, ends) | Self::Belt { at: ends, .. } => ends.iter_mut().collect(),
            Self::Block { at, on, .. } => std::iter::once(at).chain(on).collect(),
            Self::Pivot(at) | Self::Gear { at, .. } | Self::Cam { at, .. } => vec![at],
            Self::Rack { on, wheel, .. } => vec![on, wheel],
            Self::Path(_) => Vec::new(),
        }
    }
}
