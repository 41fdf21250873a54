//! Scene text to a syntax tree with places. The only module that knows TOML.

mod characters;
mod drawing;
mod form;
mod identifier;
mod joints;
mod known;
mod links;
mod loads;
mod lookup_tables;
mod outputs;
mod places;
mod reader;
mod sections;
mod table;
mod values;

use crate::diagnostic::{Diagnostic, Span};
use crate::parser::{Condition, Formula};
pub use drawing::{DrawnSyntax, ForceElementKind};
pub use identifier::{Identifier, Target};
pub use joints::{JointFriction, JointKind, JointSyntax, LinkPoint};
pub use links::{LinkSyntax, Mass, Shape};
pub use loads::{Along, FrictionSyntax, LoadSyntax, SpringSyntax};
pub use outputs::{DisplacementSyntax, JointPart, OutputSyntax, OutputValue};
use reader::Reader;

/// A scene file as written: every formula parsed, no name looked up.
#[derive(Debug, Default)]
pub struct Document {
    /// The scene's name.
    pub name: Identifier,
    /// The description of the scene, for people.
    pub doc: String,
    /// The generalized coordinates, in the order of q.
    pub coordinates: Vec<CoordinateSyntax>,
    /// `[parameters]`
    pub parameters: Vec<ParameterSyntax>,
    /// The names of `[tables]`.
    pub tables: Vec<Identifier>,
    /// `[links]`
    pub links: Vec<LinkSyntax>,
    /// `[joints]`
    pub joints: Vec<JointSyntax>,
    /// Loops of four links; only where there are links.
    pub four_bars: Vec<FourBar>,
    /// `[points]`
    pub points: Vec<(Identifier, [Formula; 2])>,
    /// `[bodies]`
    pub bodies: Vec<BodySyntax>,
    /// `[constraints]`
    pub constraints: Vec<ConstraintSyntax>,
    /// `[loads]`
    pub loads: Vec<(Identifier, LoadSyntax)>,
    /// `[initial] given`
    pub given: Vec<(Identifier, Formula)>,
    /// `[initial] solve`
    pub solve: Vec<(Identifier, Formula)>,
    /// Where the given values stand.
    pub given_span: Span,
    /// Whether something that may declare names could not be read, so that names may seem unknown that are not.
    pub lost_names: bool,
    /// Whether nothing is wrong but inside formulae.
    pub is_whole: bool,
    /// `[outputs]`
    pub outputs: Vec<OutputSyntax>,
    /// `[drawing]`
    pub drawing: Vec<(Identifier, DrawnSyntax)>,
    /// `[reference]`
    pub references: Vec<ReferenceSyntax>,
    /// `[[extreme]]`
    pub extremes: Vec<ExtremeSyntax>,
    /// `[run]`
    pub run: RunSyntax,
}

/// A loop of four links that pins join, by the names of links, points and coordinates.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct FourBar {
    /// The ground, a link beside it, the coupler, and the other link beside the ground.
    pub links: [String; 4],
    /// The pins of each link.
    pub sides: [[String; 2]; 4],
    /// The angles of the links beside the ground.
    pub angles: [String; 2],
}

/// An entry of `coordinates`.
#[derive(Debug)]
pub struct CoordinateSyntax {
    /// The name of the coordinate.
    pub identifier: Identifier,
    /// The unit of the coordinate.
    pub unit: String,
    /// The description of the coordinate.
    pub doc: String,
}

/// An entry of `[parameters]`.
#[derive(Debug)]
pub struct ParameterSyntax {
    /// The name of the parameter.
    pub identifier: Identifier,
    /// The value of the parameter.
    pub value: Formula,
    /// The unit of the parameter.
    pub unit: String,
    /// The description of the parameter.
    pub doc: String,
    /// Whether it is kept in the generated code even when it is zero.
    pub runtime: bool,
}

/// An entry of `[bodies]`.
#[derive(Debug)]
pub struct BodySyntax {
    /// The name of the body.
    pub identifier: Identifier,
    /// Mass.
    pub mass: Option<Formula>,
    /// Position of the centre of mass.
    pub com: Option<Position>,
    /// Orientation.
    pub angle: Option<Formula>,
    /// Moment of inertia about the centre of mass.
    pub inertia: Option<Formula>,
}

/// A place in the plane: a named point or two formulae.
#[derive(Clone, Debug)]
pub enum Position {
    /// The name of a point.
    Point(Identifier),
    /// Abscissa and ordinate.
    Pair([Formula; 2]),
}

/// The side of zero on which a joint would let its residual go.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
pub enum Side {
    /// `<= 0`: the joint keeps the residual from rising, and its multiplier is not negative.
    Below,
    /// `>= 0`: the joint keeps the residual from falling, and its multiplier is not positive.
    Above,
}

/// An entry of `[constraints]`.
#[derive(Debug)]
pub struct ConstraintSyntax {
    /// The name of the constraint.
    pub identifier: Identifier,
    /// The formula that must be zero.
    pub residual: Formula,
    /// Unit of the residual.
    pub unit: String,
    /// The side that the joint does not keep the residual from.
    pub one_sided: Option<Side>,
    /// Whether it is the drive of a joint.
    pub is_drive: bool,
    /// The description of the constraint.
    pub doc: String,
}

/// An entry of `[reference]`.
#[derive(Debug)]
pub struct ReferenceSyntax {
    /// The name of the reference.
    pub identifier: Identifier,
    /// Where it is from.
    pub doc: String,
    /// The time of the values.
    pub t: Formula,
    /// How accurate the values are.
    pub accuracy: Formula,
    /// The values.
    pub values: Vec<(Identifier, Formula)>,
}

/// An entry of `[[extreme]]`.
#[derive(Debug)]
pub struct ExtremeSyntax {
    /// The name of the variant.
    pub identifier: Identifier,
    /// The description of what is extreme in the variant.
    pub doc: String,
    /// Parameters with other values.
    pub set: Vec<(Identifier, Formula)>,
    /// When it ends.
    pub end_time: Option<Formula>,
    /// How accurate the values are.
    pub accuracy: Option<Formula>,
    /// The known values at the end of the run of the variant.
    pub values: Vec<(Identifier, Formula)>,
}

/// `[run]`
#[derive(Debug, Default)]
pub struct RunSyntax {
    /// Step of the integration.
    pub step: Option<Formula>,
    /// When to stop.
    pub until: Option<Condition<String>>,
    /// When to stop at the latest.
    pub max_time: Option<Formula>,
    /// A fixed end.
    pub end_time: Option<Formula>,
    /// Whether implicit methods are to be used, and where that stands.
    pub stiff: Option<Span>,
    /// Whether a function for inverse dynamics is asked for, and where that stands.
    pub inverse: Option<Span>,
    /// Where the table begins.
    pub span: Span,
    /// Whether all of it could be read.
    pub is_whole: bool,
}

impl Document {
    /// Reads a scene's text, and reports everything that is wrong with its form.
    pub fn parse(source: &str) -> (Self, Vec<Diagnostic>) {
        let mut reader = Reader::new(source);
        let mut document = Self::default();
        let parsed = table::parse(source, &mut reader.findings);
        reader.findings.extend(characters::findings(source));
        if reader.findings.is_empty() && parsed.is_empty() {
            reader.findings.push(
                Diagnostic::whole_file("the scene is empty")
                    .help("a scene begins with `name = \"...\"` and `coordinates = [...]`"),
            );
        }
        if reader.findings.is_empty() {
            document.read(&mut reader, &parsed);
        }
        document.lost_names = reader.lost;
        document.is_whole = reader.findings.len() == reader.unreadable;
        (document, reader.findings)
    }
}
