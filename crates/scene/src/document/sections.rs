//! The sections of a scene file, key by key.

use super::drawing::drawn;
use super::joints::joint;
use super::known::{extreme, reference, values};
use super::links::link;
use super::loads::load;
use super::lookup_tables::{has_formulae, lookup_table};
use super::outputs::{is_force_of_joint, output};
use super::reader::{self, Reader};
use super::table::{self, Table};
use super::values::{position, side};
use super::{
    BodySyntax, ConstraintSyntax, CoordinateSyntax, Document, Identifier, LinkSyntax, OutputSyntax, ParameterSyntax,
};
use crate::diagnostic::{Diagnostic, Span};
use crate::names::{is_identifier, suggestion};
use crate::scene::EliminationForm;

impl Document {
    fn read_tables(&mut self, r: &mut Reader, tables: Vec<(Identifier, reader::Value)>) {
        for (identifier, value) in tables {
            let table = lookup_table(r, identifier.clone(), value);
            r.declarations.tables.extend(table);
            self.tables.push(identifier);
        }
    }

    pub(super) fn read(&mut self, r: &mut Reader, root: &table::Root) {
        let mut root = root.table();
        if let Some(name) = root.required(r, "name").and_then(|v| r.text(v)) {
            if !name.name.starts_with(|c: char| c.is_ascii_alphabetic())
                || !name.name.chars().all(|c| c.is_ascii_alphanumeric() || c == '-' || c == '_')
            {
                r.findings.push(
                    Diagnostic::error(
                        format!("`{}` cannot be the name of a scene", name.name),
                        name.span.clone(),
                        "not a name",
                    )
                    .help("use letters, digits, `-` and `_`, beginning with a letter"),
                );
            }
            self.name = name;
        }
        self.doc = root.string(r, "doc");
        // Links have their own coordinates.
        let has_links = root.is_there("links");
        let coordinates = if has_links { root.optional("coordinates") } else { root.required(r, "coordinates") };
        r.has_unread_declarations |= coordinates.is_none() && !has_links;
        for value in coordinates.map(|v| r.array(v)).unwrap_or_default() {
            let coordinate = coordinate(r, value);
            r.has_unread_declarations |= coordinate.is_none();
            if let Some(CoordinateSyntax { identifier, unit, .. }) = &coordinate {
                let unit = if unit.is_empty() { "rad" } else { unit };
                r.declarations.declare_coordinate(&identifier.name, unit);
            }
            self.coordinates.extend(coordinate);
        }
        // Tables of numbers are read first, since every formula may call them.
        let (later, tables): (Vec<_>, Vec<_>) =
            root.entries(r, "tables").into_iter().partition(|(_, value)| has_formulae(*value));
        r.declarations.tables_of_parameters = later.iter().map(|(identifier, _)| identifier.name.clone()).collect();
        self.read_tables(r, tables);
        for (identifier, value) in root.entries(r, "parameters") {
            let parameter = parameter(r, identifier, value);
            if let Some(ParameterSyntax { identifier, unit, .. }) = &parameter {
                r.declarations.declare_parameter(&identifier.name, unit);
            }
            self.parameters.extend(parameter);
        }
        self.read_tables(r, later);
        for (identifier, value) in root.entries(r, "links") {
            let link = link(r, identifier, value);
            r.has_unread_declarations |= link.is_none();
            if let Some(LinkSyntax { identifier, coordinate, .. }) = &link {
                let coordinate =
                    coordinate.as_ref().map_or_else(|| format!("phi_{}", identifier.name), |own| own.name.clone());
                r.declarations.declare_coordinate(&coordinate, "rad");
            }
            self.links.extend(link);
        }
        for (identifier, value) in root.entries(r, "joints") {
            let joint = joint(r, identifier, value);
            r.has_unread_declarations |= joint.is_none();
            self.joints.extend(joint);
        }
        for (identifier, value) in root.entries(r, "points") {
            let position = r.pair(value, "m");
            self.points.push((identifier, position));
        }
        for (identifier, value) in root.entries(r, "bodies") {
            self.bodies.extend(body(r, identifier, value));
        }
        for (identifier, value) in root.entries(r, "constraints") {
            self.constraints.extend(constraint(r, identifier, value));
        }
        for (identifier, value) in root.entries(r, "loads") {
            if let Some(load) = load(r, &identifier, value) {
                self.loads.push((identifier, load));
            }
        }
        self.read_initial(r, &mut root);
        for (identifier, value) in root.entries(r, "outputs") {
            self.outputs.extend(output(r, identifier, value));
        }
        // Only conditions may contain outputs.
        r.declarations.declare_energies();
        for OutputSyntax { identifier, unit, value, .. } in &self.outputs {
            let parts: &[&str] = if is_force_of_joint(value) { &["", "_x", "_y"] } else { &[""] };
            parts.iter().for_each(|part| r.declarations.declare(&format!("{}{part}", identifier.name), unit));
        }
        for (identifier, value) in root.entries(r, "drawing") {
            if let Some(drawn) = drawn(r, &identifier, value) {
                self.drawing.push((identifier, drawn));
            }
        }
        for (identifier, value) in root.entries(r, "reference") {
            self.references.extend(reference(r, identifier, value));
        }
        match root.optional("extreme") {
            Some(value) if !value.is_array() => r.wrong_type(value, "extremes in tables `[[extreme]]`"),
            extremes => {
                let extremes = extremes.map(|v| r.array(v)).unwrap_or_default();
                self.extremes = extremes.into_iter().filter_map(|value| extreme(r, value)).collect();
            }
        }
        self.read_run(r, &mut root);
        root.finish(r);
    }

    fn read_initial(&mut self, r: &mut Reader, root: &mut Table) {
        let has_links = root.is_there("links");
        let value = if has_links { root.optional("initial") } else { root.required(r, "initial") };
        let Some(value) = value else { return };
        let Some(initial) = r.table("[initial]", value) else { return };
        self.given_span = value.span();
        if let Some(given) = initial.optional("given") {
            self.given_span = given.span();
            self.given = values(r, "given", given);
        }
        if let Some(solve) = initial.optional("solve") {
            self.solve = values(r, "solve", solve);
        }
        initial.finish(r);
    }

    fn read_run(&mut self, r: &mut Reader, root: &mut Table) {
        let Some(value) = root.required(r, "run") else { return };
        self.run.span = value.span();
        let before = r.findings.len();
        let Some(run) = r.table("[run]", value) else { return };
        self.run.step = run.required(r, "step").map(|v| r.quantity(v, "s"));
        self.run.until = run.optional("until").and_then(|v| r.condition(v));
        self.run.max_time = run.optional("max_time").map(|v| r.quantity(v, "s"));
        self.run.end_time = run.optional("end_time").map(|v| r.quantity(v, "s"));
        let mut asked = |key: &str| run.optional(key).and_then(|v| r.boolean(v).then(|| v.span()));
        (self.run.stiff, self.run.inverse) = (asked("stiff"), asked("inverse"));
        self.run.elimination = run.optional("elimination").and_then(|v| elimination(r, v));
        run.finish(r);
        self.run.is_well_formed = r.findings.len() == before;
    }
}

fn elimination(r: &mut Reader, value: reader::Value) -> Option<(EliminationForm, Span)> {
    let Identifier { name, span } = r.text(value)?;
    let found = EliminationForm::ALL.into_iter().find(|form| form.name() == name);
    if found.is_none() {
        let forms = EliminationForm::ALL.map(EliminationForm::name);
        let help = suggestion(&name, forms, || format!("forms: {}", forms.join(", ")));
        let title = format!("there is no elimination `{name}`");
        r.findings.push(Diagnostic::error(title, span.clone(), "not known").help(help));
    }
    found.map(|form| (form, span))
}

fn coordinate(r: &mut Reader, value: reader::Value) -> Option<CoordinateSyntax> {
    let syntax = if value.is_table() {
        let table = r.table("a coordinate", value)?;
        let identifier = table.required(r, "name").and_then(|v| r.text(v));
        let ((unit, _), doc) = (table.unit(r), table.string(r, "doc"));
        table.finish(r);
        CoordinateSyntax { identifier: identifier?, unit, doc }
    } else {
        CoordinateSyntax { identifier: r.text(value)?, unit: String::new(), doc: String::new() }
    };
    r.check_name(&syntax.identifier, "coordinate");
    Some(syntax)
}

fn parameter(r: &mut Reader, identifier: Identifier, value: reader::Value) -> Option<ParameterSyntax> {
    if !value.is_table() {
        let value = r.formula(value);
        return Some(ParameterSyntax { identifier, value, unit: String::new(), doc: String::new(), runtime: false });
    }
    let table = r.table(&format!("parameter `{}`", identifier.name), value)?;
    let (text, unit) = table.unit(r);
    let value = table.required(r, "value").map_or_else(reader::placeholder, |v| r.number_in(v, unit.as_ref()));
    let doc = table.string(r, "doc");
    let runtime = table.optional("runtime").is_some_and(|v| r.boolean(v));
    table.finish(r);
    Some(ParameterSyntax { identifier, value, unit: text, doc, runtime })
}

fn body(r: &mut Reader, identifier: Identifier, value: reader::Value) -> Option<BodySyntax> {
    let table = r.table(&format!("body `{}`", identifier.name), value)?;
    let syntax = BodySyntax {
        mass: table.optional("mass").map(|v| r.quantity(v, "kg")),
        com: table.optional("com").and_then(|v| position(r, v)),
        angle: table.optional("angle").map(|v| r.quantity(v, "rad")),
        inertia: table.optional("inertia").map(|v| r.quantity(v, "kg m^2")),
        identifier,
    };
    table.string(r, "doc");
    table.finish(r);
    Some(syntax)
}

fn constraint(r: &mut Reader, identifier: Identifier, value: reader::Value) -> Option<ConstraintSyntax> {
    let table = r.table(&format!("constraint `{}`", identifier.name), value)?;
    let residual = table.required(r, "residual").map_or_else(reader::placeholder, |v| r.formula(v));
    let ((unit, _), doc) = (table.unit(r), table.string(r, "doc"));
    let one_sided = table.optional("one_sided").and_then(|v| r.text(v)).and_then(|text| side(r, &text));
    table.finish(r);
    Some(ConstraintSyntax { identifier, residual, unit, one_sided, is_drive: false, doc })
}

impl Reader<'_> {
    /// Reports a name that cannot occur in a formula.
    pub(super) fn check_name(&mut self, identifier: &Identifier, what: &str) {
        if !is_identifier(&identifier.name) {
            self.has_unread_declarations = true;
            self.findings.push(
                Diagnostic::error(
                    format!("`{}` cannot be the name of {} {what}", identifier.name, article(what)),
                    identifier.span.clone(),
                    "not a name",
                )
                .help("use letters, digits and `_`, beginning with a letter"),
            );
        }
    }
}

/// The indefinite article for a word.
fn article(word: &str) -> &'static str {
    if word.starts_with(['a', 'e', 'i', 'o', 'u']) { "an" } else { "a" }
}
