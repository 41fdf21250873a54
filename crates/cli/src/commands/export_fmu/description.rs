//! `modelDescription.xml`: the description of an FMU for importers.

use std::collections::BTreeSet;
use std::io;

use qrm_core::Description;
use qrm_fmu::{InstantiationToken, variables};
use qrm_scene::unit::{BASE, Unit};
use qrm_sim::columns::{Column, Kind};
use quick_xml::Writer;
use quick_xml::events::{BytesDecl, Event};

use super::roles::{Role, Roles};

/// Creates the text of the file.
pub(super) fn xml(
    description: &Description,
    identifier: &str,
    token: &InstantiationToken,
    roles: &Roles,
    values: &[f64],
    end: f64,
) -> io::Result<String> {
    let variables = variables(description);
    let mut xml = Writer::new_with_indent(Vec::new(), b' ', 2);
    xml.write_event(Event::Decl(BytesDecl::new("1.0", Some("UTF-8"), None)))?;
    let token_text = token.to_string();
    let tool = concat!("qrm ", env!("CARGO_PKG_VERSION"));
    let of_model = [
        ("fmiVersion", "3.0"),
        ("modelName", description.name),
        ("instantiationToken", &token_text),
        ("description", description.doc),
        ("generationTool", tool),
        ("variableNamingConvention", "flat"),
    ];
    let interface = [("modelIdentifier", identifier), ("canGetAndSetFMUState", "true")];
    xml.create_element("fmiModelDescription").with_attributes(of_model).write_inner_content(|xml| {
        let model_exchange = xml.create_element("ModelExchange").with_attributes(interface);
        // After each of the importer's steps the FMU checks whether the loops are still closed.
        model_exchange.with_attribute(("needsCompletedIntegratorStep", "true")).write_empty()?;
        let co_simulation = xml.create_element("CoSimulation").with_attributes(interface);
        co_simulation.with_attribute(("canHandleVariableCommunicationStepSize", "true")).write_empty()?;
        unit_definitions(xml, &variables)?;
        xml.create_element("LogCategories").write_inner_content(|xml| {
            let category = |name, text| [("name", name), ("description", text)];
            let error = category("error", "what could not be done, and why");
            xml.create_element("Category").with_attributes(error).write_empty()?;
            let fatal = category("fatal", "mistakes of the unit itself");
            xml.create_element("Category").with_attributes(fatal).write_empty()?;
            Ok(())
        })?;
        let (stop, step) = (number(end), number(token.step));
        let experiment = [("startTime", "0"), ("stopTime", &stop), ("stepSize", &step)];
        xml.create_element("DefaultExperiment").with_attributes(experiment).write_empty()?;
        xml.create_element("ModelVariables").write_inner_content(|xml| {
            for (reference, variable) in variables.iter().enumerate() {
                write_variable(xml, reference, variable, roles, values)?;
            }
            Ok(())
        })?;
        structure(xml, &variables, roles)
    })?;
    let text = String::from_utf8(xml.into_inner()).map_err(io::Error::other)?;
    Ok(text.chars().filter(|character| is_allowed(*character)).collect())
}

/// Whether XML 1.0 allows a character; a scene's texts may contain others, which no escape can represent.
fn is_allowed(character: char) -> bool {
    matches!(character, '\t' | '\n' | '\r' | ' '..='\u{d7ff}' | '\u{e000}'..='\u{fffd}' | '\u{10000}'..)
}

/// A double in the shortest decimal that reads back exactly.
fn number(value: f64) -> String {
    format!("{value:?}")
}

fn unit_definitions(xml: &mut Writer<Vec<u8>>, variables: &[Column]) -> io::Result<()> {
    let units: BTreeSet<&str> = variables.iter().map(|v| v.unit.as_str()).filter(|unit| !unit.is_empty()).collect();
    xml.create_element("UnitDefinitions").write_inner_content(|xml| {
        for unit in units {
            let element = xml.create_element("Unit").with_attribute(("name", unit));
            let Some(base) = Unit::parse(unit) else {
                element.write_empty()?;
                continue;
            };
            element.write_inner_content(|xml| {
                let mut element = xml.create_element("BaseUnit");
                for (name, exponent) in BASE.iter().zip(base.exponents).filter(|(_, exponent)| *exponent != 0) {
                    element = element.with_attribute((*name, exponent.to_string().as_str()));
                }
                if base.is_scaled() {
                    element = element.with_attribute(("factor", number(base.factor()).as_str()));
                }
                element.write_empty().map(|_| ())
            })?;
        }
        Ok(())
    })?;
    Ok(())
}

fn write_variable(
    xml: &mut Writer<Vec<u8>>,
    reference: usize,
    variable: &Column,
    roles: &Roles,
    values: &[f64],
) -> io::Result<()> {
    let mut element = xml
        .create_element("Float64")
        .with_attributes([("name", variable.name.as_str()), ("valueReference", reference.to_string().as_str())]);
    if !variable.doc.is_empty() {
        element = element.with_attribute(("description", variable.doc.as_str()));
    }
    if !variable.unit.is_empty() {
        element = element.with_attribute(("unit", variable.unit.as_str()));
    }
    let (causality, variability, initial) = match variable.kind {
        Kind::Time => ("independent", "continuous", None),
        Kind::Parameter(i) => match roles.roles[i].1 {
            Role::Input => ("input", "continuous", None),
            Role::Tunable => ("parameter", "tunable", Some("exact")),
            Role::Fixed => ("parameter", "fixed", Some("exact")),
            Role::Computed { is_tunable: true } => ("calculatedParameter", "tunable", Some("calculated")),
            Role::Computed { is_tunable: false } => ("calculatedParameter", "fixed", Some("calculated")),
        },
        _ => ("output", "continuous", Some("calculated")),
    };
    element = element.with_attributes([("causality", causality), ("variability", variability)]);
    if let Some(initial) = initial {
        element = element.with_attribute(("initial", initial));
    }
    match variable.kind {
        Kind::Parameter(i) => {
            // A start value below the minimum would be invalid.
            if roles.is_mass(i) && !(values[i] < 0.0) {
                element = element.with_attribute(("min", "0"));
            }
            if initial == Some("exact") || causality == "input" {
                element = element.with_attribute(("start", number(values[i]).as_str()));
            }
        }
        // The variable before a rate is its integral.
        Kind::Rate(_) | Kind::Acceleration(_) => {
            element = element.with_attribute(("derivative", (reference - 1).to_string().as_str()));
        }
        _ => {}
    }
    element.write_empty().map(|_| ())
}

fn structure(xml: &mut Writer<Vec<u8>>, variables: &[Column], roles: &Roles) -> io::Result<()> {
    let references = |is_wanted: &dyn Fn(Kind) -> bool| -> Vec<String> {
        let wanted = variables.iter().enumerate().filter(|(_, variable)| is_wanted(variable.kind));
        wanted.map(|(reference, _)| reference.to_string()).collect()
    };
    let is_output = |kind: Kind| !matches!(kind, Kind::Time | Kind::Parameter(_));
    let is_computed =
        |kind: Kind| matches!(kind, Kind::Parameter(i) if matches!(roles.roles[i].1, Role::Computed { .. }));
    let is_rate = |kind: Kind| matches!(kind, Kind::Rate(_));
    let is_acceleration = |kind: Kind| matches!(kind, Kind::Acceleration(_));
    let parts = [
        ("Output", references(&is_output)),
        // In the order of the states: coordinates, then rates.
        ("ContinuousStateDerivative", [references(&is_rate), references(&is_acceleration)].concat()),
        ("InitialUnknown", references(&|kind| is_output(kind) || is_computed(kind))),
    ];
    xml.create_element("ModelStructure").write_inner_content(|xml| {
        for (name, references) in &parts {
            for reference in references {
                xml.create_element(*name).with_attribute(("valueReference", reference.as_str())).write_empty()?;
            }
        }
        Ok(())
    })?;
    Ok(())
}

#[cfg(test)]
mod tests {
    use qrm_core::{ParameterDescription, QuantityDescription};
    use qrm_sim::integrate::MethodSettings;
    use quick_xml::Reader;

    use super::super::roles::{Role, Roles};
    use super::*;

    const UGLY: &str = "a\0b\u{1}c\u{8}\u{b}\u{c}\u{1f}d\u{fffe}\u{ffff}e <&>\"' \u{7f}\u{e9}\u{1f527}";
    const CLEAN: &str = "abcde <&>\"' \u{7f}\u{e9}\u{1f527}";

    fn written() -> String {
        let quantity = QuantityDescription { name: "x", unit: "m\u{2}", doc: UGLY };
        let description = Description {
            name: "ugly",
            doc: UGLY,
            source: "",
            derivation: "",
            coordinates: Vec::leak(vec![quantity]),
            constraints: &[],
            outputs: &[],
            parameters: &[ParameterDescription { name: "m", unit: "kg", doc: UGLY, formula: "1" }],
            left_out: &[],
            has_corners: false,
            friction: &[],
            until: "",
        };
        let roles = Roles::new(vec![("m", Role::Tunable)], vec!["m"]);
        let token = InstantiationToken::new(&description, MethodSettings::default(), 1e-3);
        xml(&description, "ugly", &token, &roles, &[1.0], 1.0).expect("a text")
    }

    /// Parses the attributes of all elements.
    fn attributes(text: &str) -> Vec<(String, String)> {
        let mut reader = Reader::from_str(text);
        reader.config_mut().check_end_names = true;
        let mut found = Vec::new();
        loop {
            match reader.read_event().expect("well-formed") {
                Event::Start(element) | Event::Empty(element) => {
                    for attribute in element.attributes() {
                        let attribute = attribute.expect("an attribute");
                        let name = attribute.key.as_ref().to_owned();
                        let value = attribute.normalized_value(quick_xml::XmlVersion::Implicit1_0).expect("a value");
                        found.push((name, value.into_owned()));
                    }
                }
                Event::Eof => return found,
                _ => {}
            }
        }
    }

    #[test]
    fn characters_that_no_xml_can_hold_are_left_out() {
        let text = written();
        assert!(text.chars().all(is_allowed), "{text:?}");
        let attributes = attributes(&text);
        let values = |name: &str| -> Vec<&str> {
            attributes.iter().filter(|(own, _)| own == name).map(|(_, value)| &**value).collect()
        };
        assert_eq!(values("description").iter().filter(|text| **text == CLEAN).count(), 3, "{attributes:?}");
        // A unit has the same name in its definition and in its uses.
        assert!(values("name").contains(&"m") && values("unit").contains(&"m"), "{attributes:?}");
        assert_eq!(values("min"), ["0"]);
    }

    #[test]
    fn allowed_characters_are_those_of_the_standard() {
        let is = |code: u32| char::from_u32(code).is_some_and(is_allowed);
        for code in [0x9, 0xa, 0xd, 0x20, 0x7f, 0xd7ff, 0xe000, 0xfffd, 0x1_0000, 0x1f_ffff >> 1, 0x10_ffff] {
            assert!(is(code), "{code:x}");
        }
        for code in (0..9).chain([0xb, 0xc]).chain(0xe..0x20).chain([0xfffe, 0xffff]) {
            assert!(!is(code), "{code:x}");
        }
    }
}
