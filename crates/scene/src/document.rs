//! Parses the text of a scene into a syntax tree with locations. Only this module and its submodules know TOML.

mod characters;
mod drawing;
mod force_elements;
mod form;
mod identifier;
mod joints;
mod known;
mod links;
mod loads;
mod lookup_tables;
mod outputs;
mod places;
mod point_names;
mod reader;
mod sections;
mod table;
mod values;

use std::collections::BTreeMap;

use crate::diagnostic::{Diagnostic, Span};
use crate::parser::{Condition, Formula};
use crate::scene::EliminationForm;
pub use drawing::{DrawnSyntax, ForceElementKind};
pub use identifier::{Identifier, Target};
pub use joints::{JointFriction, JointKind, JointSyntax, LinkPoint};
pub use links::{LinkSyntax, Mass, Shape};
pub use loads::{Along, FrictionSyntax, LoadSyntax, SpringSyntax};
pub use outputs::{DisplacementSyntax, JointPart, OutputSyntax, OutputValue};
use reader::Reader;

/// A scene file as written: formulae are parsed, but names not looked up.
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
    /// The names of the points of links in the expanded scene, by `LINK.POINT`.
    pub point_names: BTreeMap<String, String>,
    /// Loops of four links; present only in scenes with links.
    pub four_bars: Vec<FourBar>,
    /// Rough places of joints at the start.
    pub near: Vec<NearSyntax>,
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
    /// The location of the given values.
    pub given_span: Span,
    /// Whether a part that may declare names could not be read: names may then seem unknown by mistake.
    pub has_unread_declarations: bool,
    /// Whether there are no errors outside formulae.
    pub is_well_formed: bool,
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

/// A loop of four links joined by pins, by the names of links, points and coordinates.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct FourBar {
    /// The ground, a link joined to it, the coupler, and the other link joined to the ground.
    pub links: [String; 4],
    /// The pins of each link.
    pub sides: [[String; 2]; 4],
    /// The angles of the two links joined to the ground.
    pub angles: [String; 2],
}

/// The rough place of a joint at the start.
#[derive(Debug)]
pub struct NearSyntax {
    /// The name of the joint.
    pub joint: Identifier,
    /// A point of the joint.
    pub point: String,
    /// The points of each moving link of the joint.
    pub links: Vec<Vec<String>>,
    /// The rough place.
    pub place: [Formula; 2],
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
    /// Whether generated code keeps the parameter even if it is zero.
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

/// The side of zero towards which a joint lets its residual move.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
pub enum Side {
    /// `<= 0`: the joint prevents positive residuals, and its multiplier is not negative.
    Below,
    /// `>= 0`: the joint prevents negative residuals, and its multiplier is not positive.
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
    /// The side towards which the residual may move.
    pub one_sided: Option<Side>,
    /// Whether the constraint is the drive of a joint.
    pub is_drive: bool,
    /// The description of the constraint.
    pub doc: String,
}

/// An entry of `[reference]`.
#[derive(Debug)]
pub struct ReferenceSyntax {
    /// The name of the reference.
    pub identifier: Identifier,
    /// The source of the values.
    pub doc: String,
    /// The time of the values.
    pub t: Formula,
    /// The accuracy of the values.
    pub accuracy: Formula,
    /// The values.
    pub values: Vec<(Identifier, Formula)>,
}

/// An entry of `[[extreme]]`.
#[derive(Debug)]
pub struct ExtremeSyntax {
    /// The name of the variant.
    pub identifier: Identifier,
    /// The extreme property of the variant, for people.
    pub doc: String,
    /// Parameters with changed values.
    pub set: Vec<(Identifier, Formula)>,
    /// The end time of the run.
    pub end_time: Option<Formula>,
    /// The accuracy of the values.
    pub accuracy: Option<Formula>,
    /// The known values at the end of the run of the variant.
    pub values: Vec<(Identifier, Formula)>,
}

/// `[run]`
#[derive(Debug, Default)]
pub struct RunSyntax {
    /// Step length.
    pub step: Option<Formula>,
    /// The stop condition.
    pub until: Option<Condition<String>>,
    /// The latest end of a run with a stop condition.
    pub max_time: Option<Formula>,
    /// The end of a run without a stop condition.
    pub end_time: Option<Formula>,
    /// The location of the request for implicit methods, if there is one.
    pub stiff: Option<Span>,
    /// The location of the request for inverse dynamics, if there is one.
    pub inverse: Option<Span>,
    /// The form of the kernel, if the scene asks for one.
    pub elimination: Option<(EliminationForm, Span)>,
    /// The start of the table.
    pub span: Span,
    /// Whether all of the table could be read.
    pub is_well_formed: bool,
}

impl Document {
    /// Reads a scene's text and reports all errors of its form.
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
        document.has_unread_declarations = reader.has_unread_declarations;
        document.is_well_formed = reader.findings.len() == reader.unreadable;
        (document, reader.findings)
    }
}
