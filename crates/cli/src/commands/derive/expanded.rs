//! Expands a scene in links and joints into an ordinary one.

use super::point_names;
use qrm_scene::document::{
    Along, BodySyntax, CoordinateSyntax, DisplacementSyntax, Document, DrawnSyntax, FrictionSyntax, Identifier,
    LoadSyntax, OutputSyntax, OutputValue, Position, Side, Target,
};
use qrm_scene::linkage;
use qrm_scene::parser::Formula;
use qrm_scene::printer::print_formula;
use qrm_scene::unit::Unit;
use toml_edit::{Array, ArrayOfTables, DocumentMut, InlineTable, Item, Table, Value};

/// The sections of a scene, in the order in which they are written.
const SECTIONS: [&str; 12] = [
    "parameters",
    "tables",
    "points",
    "bodies",
    "constraints",
    "loads",
    "initial",
    "outputs",
    "drawing",
    "reference",
    "extreme",
    "run",
];

/// The text of a scene without links and joints; everything else is unchanged.
pub(super) fn expanded(source: &str) -> Result<String, String> {
    let mut text: DocumentMut = source.parse().map_err(|e| format!("{e}"))?;
    let (own, _) = Document::parse(source);
    let (mut whole, mut findings) = Document::parse(source);
    // The formulae of the expanded scene are in SI units.
    let is_scaled = |unit: &str| Unit::parse(unit).is_some_and(|unit| unit.is_scaled());
    if let Some(own) = whole.parameters.iter().find(|own| is_scaled(&own.unit)) {
        return Err(format!(
            "parameter `{}` has the unit `{}`: give it in SI units first",
            own.identifier.name, own.unit
        ));
    }
    linkage::expand(&mut whole, &mut findings);
    text.remove("links");
    text.remove("joints");
    for section in ["loads", "outputs", "drawing"] {
        if let Some(section) = text.get_mut(section) {
            point_names::replace(section, &whole.point_names);
        }
    }
    let new = |before: usize, after: usize| after - before;
    let coordinates = &whole.coordinates[..new(own.coordinates.len(), whole.coordinates.len())];
    let mut list = Array::new();
    list.extend(coordinates.iter().map(coordinate));
    if let Some(others) = text.get("coordinates").and_then(Item::as_array) {
        list.extend(others.iter().cloned());
    }
    for value in list.iter_mut() {
        value.decor_mut().set_prefix("\n    ");
    }
    list.set_trailing("\n");
    list.set_trailing_comma(true);
    text.insert("coordinates", Item::Value(Value::Array(list)));
    let points = &whole.points[..new(own.points.len(), whole.points.len())];
    put(&mut text, "points", points.iter().map(|(name, place)| (name, pair(place))));
    let bodies = &whole.bodies[..new(own.bodies.len(), whole.bodies.len())];
    put(&mut text, "bodies", bodies.iter().map(|own| (&own.identifier, body(own))));
    let constraints = &whole.constraints[..new(own.constraints.len(), whole.constraints.len())];
    put(
        &mut text,
        "constraints",
        constraints.iter().map(|own| {
            let residual = ("residual", formula(&own.residual));
            let side = own.one_sided.map_or("", |side| if side == Side::Below { "<= 0" } else { ">= 0" });
            let (unit, doc) = (("unit", own.unit.as_str().into()), ("doc", own.doc.as_str().into()));
            (&own.identifier, table([residual, unit, ("one_sided", side.into()), doc]))
        }),
    );
    // Loads of joints follow the scene's own.
    let written = text.remove("loads");
    put(&mut text, "loads", whole.loads[own.loads.len()..].iter().map(|(name, own)| (name, load(own))));
    put_first(&mut text, "loads", written);
    put_outputs(&mut text, &own, &whole);
    let drawing = &whole.drawing[own.drawing.len()..];
    put(&mut text, "drawing", drawing.iter().map(|(name, own)| (name, drawn(own))));
    let starts = [("given", &whole.given), ("solve", &whole.solve)].map(|(key, values)| {
        let mut table = InlineTable::new();
        table.extend(values.iter().map(|(name, value)| (name.name.as_str(), formula(value))));
        (key, table)
    });
    let initial = text.entry("initial").or_insert_with(|| Item::Table(Table::new()));
    for (key, table) in starts.into_iter().filter(|(_, table)| !table.is_empty()) {
        if let Some(initial) = initial.as_table_like_mut() {
            initial.insert(key, Item::Value(Value::InlineTable(table)));
        }
    }
    order(&mut text);
    Ok(text.to_string())
}

/// Adds entries to a section, before the existing ones.
fn put<'d>(text: &mut DocumentMut, section: &str, entries: impl Iterator<Item = (&'d Identifier, Value)>) {
    let mut entries = entries.peekable();
    if entries.peek().is_none() {
        return;
    }
    let mut table = Table::new();
    for (name, value) in entries {
        // Parts of one body share a base name.
        let numbers = (2..).map(|number| format!("{}_{number}", name.name));
        let mut names = std::iter::once(name.name.clone()).chain(numbers);
        let free = names.find(|name| !table.contains_key(name)).unwrap_or_default();
        table.insert(&free, Item::Value(value));
    }
    if let Some(others) = text.remove(section).as_ref().and_then(Item::as_table_like) {
        table.extend(others.iter().map(|(name, item)| (name.to_owned(), item.clone())));
    }
    text.insert(section, Item::Table(table));
}

/// Moves the previous entries of a section to its beginning.
fn put_first(text: &mut DocumentMut, section: &str, written: Option<Item>) {
    let Some(mut written) = written else { return };
    if let (Some(own), Some(others)) = (written.as_table_like_mut(), text.remove(section)) {
        for (name, item) in others.as_table_like().into_iter().flat_map(|others| others.iter()) {
            own.insert(name, item.clone());
        }
    }
    text.insert(section, written);
}

/// Replaces the outputs of joints by their expansions, in place.
fn put_outputs(text: &mut DocumentMut, own: &Document, whole: &Document) {
    let power = |output: &OutputSyntax| match &output.value {
        OutputValue::Power(of) => Some((output.identifier.name.clone(), of.name.clone())),
        _ => None,
    };
    let powers: Vec<_> = whole.outputs.iter().filter_map(power).collect();
    let written_out = |output: &OutputSyntax| match &output.value {
        OutputValue::Joint { .. } => true,
        _ => power(output).is_some_and(|power| !powers.contains(&power)),
    };
    let has_new = whole.outputs.len() > own.outputs.len();
    if !has_new && !own.outputs.iter().any(written_out) {
        return;
    }
    let written = text.remove("outputs").unwrap_or_default();
    let mut table = Table::new();
    for output in &whole.outputs {
        let name = &output.identifier.name;
        let is_own = own.outputs.iter().any(|own| !written_out(own) && own.identifier.name == *name);
        let item = written.get(name).filter(|_| is_own).cloned();
        table.insert(name, item.unwrap_or_else(|| Item::Value(joint_output(output))));
    }
    text.insert("outputs", Item::Table(table));
}

/// An output of a joint.
fn joint_output(own: &OutputSyntax) -> Value {
    let names = |names: &[Identifier]| Value::Array(names.iter().map(|name| name.name.as_str()).collect());
    let text = |text: &str| Value::from(text);
    let (unit, doc) = (("unit", text(&own.unit)), ("doc", text(&own.doc)));
    match &own.value {
        OutputValue::FreeBody { displacements, multipliers, loads } => {
            let displacements = displacements.iter().map(displacement).collect();
            let factors = |own: &[(Identifier, Formula)]| match own.is_empty() {
                true => text(""),
                false => Value::InlineTable(own.iter().map(|(name, own)| (name.name.clone(), formula(own))).collect()),
            };
            let (multipliers, loads) = (("multipliers", factors(multipliers)), ("loads", factors(loads)));
            table([("free_body", Value::Array(displacements)), multipliers, loads, unit, doc])
        }
        OutputValue::Reaction { constraint, target: Target::Point(point), along: Some(along) } => {
            let (constraint, point) = (text(&constraint.name), text(&point.name));
            table([("reaction", constraint), ("at", point), ("along", pair(along)), unit, doc])
        }
        OutputValue::Norm { components, at } => {
            let at = text(at.as_ref().map_or("", |at| &at.name));
            table([("norm", names(components)), ("at", at), unit, doc])
        }
        OutputValue::Power(name) => table([("power", text(&name.name)), unit, doc]),
        _ => table([unit, doc]),
    }
}

/// The friction of a joint.
fn load(own: &LoadSyntax) -> Value {
    let LoadSyntax::Spring(spring) = own else { return Value::InlineTable(InlineTable::new()) };
    let along = match &spring.along {
        Along::Formula(along) => formula(along),
        Along::Between(..) => Value::from(""),
    };
    let Some(FrictionSyntax { size, slip, normal }) = &spring.friction else { return table([("along", along)]) };
    let normal = Value::from(normal.as_ref().map_or("", |normal| &normal.name));
    table([("along", along), ("friction", formula(size)), ("slip", formula(slip)), ("normal", normal)])
}

fn displacement(own: &DisplacementSyntax) -> Value {
    let mut table = InlineTable::new();
    for (key, names) in [("bodies", &own.bodies), ("points", &own.points)] {
        if !names.is_empty() {
            table.insert(key, names.iter().map(|name| name.name.as_str()).collect());
        }
    }
    if let Some(along) = &own.along {
        table.insert("along", pair(along));
    }
    if let Some((size, about, angle)) = &own.turn {
        table.insert("turn", formula(size));
        table.insert("about", about.name.as_str().into());
        if let Some(angle) = angle {
            table.insert("angle", angle.name.as_str().into());
        }
    }
    if let Some((size, coordinate)) = &own.slide {
        table.insert("slide", formula(size));
        table.insert("coordinate", coordinate.name.as_str().into());
    }
    Value::InlineTable(table)
}

/// Sorts all sections, with an empty line before each.
fn order(text: &mut DocumentMut) {
    for (place, section) in SECTIONS.iter().enumerate() {
        let position = isize::try_from(place).ok();
        match text.get_mut(section) {
            Some(Item::Table(table)) => place_table(table, position),
            Some(Item::ArrayOfTables(tables)) => place_tables(tables, position),
            _ => {}
        }
    }
}

fn place_tables(tables: &mut ArrayOfTables, position: Option<isize>) {
    tables.iter_mut().for_each(|table| place_table(table, position));
}

fn place_table(table: &mut Table, position: Option<isize>) {
    table.set_position(position);
    for (_, item) in table.iter_mut() {
        if let Item::Table(inner) = item {
            place_table(inner, position);
        }
    }
    if table.decor().prefix().and_then(|prefix| prefix.as_str()).is_none_or(str::is_empty) {
        table.decor_mut().set_prefix("\n");
    }
}

fn coordinate(own: &CoordinateSyntax) -> Value {
    let text = |text: &str| text.into();
    table([("name", text(&own.identifier.name)), ("unit", text(&own.unit)), ("doc", text(&own.doc))])
}

fn body(own: &BodySyntax) -> Value {
    let optional = |formula_: &Option<Formula>| formula_.as_ref().map_or_else(|| Value::from(""), formula);
    let com = own.com.as_ref().map_or_else(|| Value::from(""), place);
    let (mass, angle, inertia) = (optional(&own.mass), optional(&own.angle), optional(&own.inertia));
    table([("mass", mass), ("com", com), ("angle", angle), ("inertia", inertia)])
}

fn drawn(own: &DrawnSyntax) -> Value {
    let list = |places: &[Position]| Value::Array(places.iter().map(place).collect());
    let optional = |value: &Option<Formula>| value.as_ref().map_or_else(|| Value::from(""), formula);
    // Flags that are false by default are omitted.
    let flag = |is_set: bool| if is_set { Value::from(true) } else { Value::from("") };
    match own {
        DrawnSyntax::Link(places) => table([("link", list(places))]),
        DrawnSyntax::Guide(places) => table([("guide", list(places))]),
        DrawnSyntax::Rod(ends) => table([("rod", list(ends))]),
        DrawnSyntax::ForceElement(kind, ends) => table([(kind.key(), list(ends))]),
        DrawnSyntax::Block { at, angle, on } => {
            let on = on.as_ref().map_or_else(|| Value::from(""), place);
            table([("block", place(at)), ("angle", optional(angle)), ("on", on)])
        }
        DrawnSyntax::Pivot(at) => table([("pivot", place(at))]),
        DrawnSyntax::Gear { at, radius, angle, is_internal } => {
            let (radius, angle) = (formula(radius), optional(angle));
            table([("gear", place(at)), ("radius", radius), ("angle", angle), ("internal", flag(*is_internal))])
        }
        DrawnSyntax::Rack { on, wheel, radius, angle } => {
            let ends = Value::Array([on, wheel].into_iter().map(place).collect());
            table([("rack", ends), ("radius", formula(radius)), ("angle", optional(angle))])
        }
        DrawnSyntax::Belt { at, radii, is_crossed, angle } => {
            let (radii, angle) = (pair(radii), optional(angle));
            table([("belt", list(at)), ("radii", radii), ("crossed", flag(*is_crossed)), ("angle", angle)])
        }
        DrawnSyntax::Cam { at, angle, profile, is_flat } => {
            let (profile, flat) = (formula(profile), flag(*is_flat));
            table([("cam", place(at)), ("angle", optional(angle)), ("profile", profile), ("flat", flat)])
        }
        DrawnSyntax::Path(point) => table([("path", point.name.as_str().into())]),
    }
}

fn place(position: &Position) -> Value {
    match position {
        Position::Point(point) => point.name.as_str().into(),
        Position::Pair(components) => pair(components),
    }
}

fn pair(components: &[Formula; 2]) -> Value {
    Value::Array(components.iter().map(formula).collect())
}

/// A formula, written as a plain number if possible.
fn formula(formula: &Formula) -> Value {
    let text = print_formula(formula);
    text.parse::<Value>()
        .ok()
        .filter(|value| value.is_integer() || value.is_float())
        .unwrap_or_else(|| format!("'{text}'").parse().unwrap_or_else(|_| Value::from(text)))
}

/// A table in one line, without entries that are empty texts.
fn table<const K: usize>(entries: [(&str, Value); K]) -> Value {
    let mut table = InlineTable::new();
    table.extend(entries.into_iter().filter(|(_, value)| value.as_str() != Some("")));
    Value::InlineTable(table)
}
