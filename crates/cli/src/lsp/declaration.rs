//! The names that a scene declares.

use std::ops::Range;

use qrm_scene::document::{Document, Identifier};

/// The kind of a name.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Kind {
    Coordinate,
    Parameter,
    Table,
    Link,
    Joint,
    Point,
    Body,
    Constraint,
    Load,
    Output,
}

impl Kind {
    /// The word for the kind.
    pub(super) fn word(self) -> &'static str {
        match self {
            Self::Coordinate => "coordinate",
            Self::Parameter => "parameter",
            Self::Table => "table",
            Self::Link => "link",
            Self::Joint => "joint",
            Self::Point => "point",
            Self::Body => "body",
            Self::Constraint => "constraint",
            Self::Load => "load",
            Self::Output => "output",
        }
    }
}

/// A name at the place where it is declared.
#[derive(Clone, Debug)]
pub(super) struct Declaration {
    pub(super) name: String,
    pub(super) kind: Kind,
    pub(super) span: Range<usize>,
}

/// The names that a scene declares, in the order of the file; also of a scene with mistakes.
pub(super) fn declarations(source: &str) -> Vec<Declaration> {
    let (document, _) = Document::parse(source);
    let mut found = Vec::new();
    let mut add = |kind: Kind, identifier: &Identifier| {
        let Identifier { name, span } = identifier.clone();
        // Names of links are also written out by the reader, without a place of their own.
        if source.get(span.clone()).is_some_and(|text| text.trim_matches(['"', '\'']) == name) {
            found.push(Declaration { name, kind, span });
        }
    };
    document.coordinates.iter().for_each(|entry| add(Kind::Coordinate, &entry.identifier));
    document.parameters.iter().for_each(|entry| add(Kind::Parameter, &entry.identifier));
    document.tables.iter().for_each(|entry| add(Kind::Table, entry));
    for link in &document.links {
        add(Kind::Link, &link.identifier);
        link.points.iter().for_each(|(point, _)| add(Kind::Point, point));
    }
    document.joints.iter().for_each(|entry| add(Kind::Joint, &entry.identifier));
    document.points.iter().for_each(|(entry, _)| add(Kind::Point, entry));
    document.bodies.iter().for_each(|entry| add(Kind::Body, &entry.identifier));
    document.constraints.iter().for_each(|entry| add(Kind::Constraint, &entry.identifier));
    document.loads.iter().for_each(|(entry, _)| add(Kind::Load, entry));
    document.outputs.iter().for_each(|entry| add(Kind::Output, &entry.identifier));
    found.sort_by_key(|declaration| declaration.span.start);
    found
}

/// The declared name that a word in a formula belongs to: `phi` of `phi_dot`, `crank` of `phi_crank`.
pub(super) fn stem<'w>(word: &'w str, declarations: &[Declaration]) -> Option<&'w str> {
    let is_declared = |name: &str| declarations.iter().any(|declaration| declaration.name == name);
    let prefixes = ["", "phi_", "s_", "theta_", "lambda_", "force_"];
    let suffixes = ["", "_dot", "_ddot", "_drive", "_x", "_y"];
    let mut stems = prefixes.iter().flat_map(|prefix| {
        let rest = word.strip_prefix(prefix);
        suffixes.iter().filter_map(move |suffix| rest?.strip_suffix(suffix))
    });
    stems.find(|stem| !stem.is_empty() && is_declared(stem))
}
