//! Refuses elements, attributes and classes that MuJoCo does not know.

mod table;

use super::attributes::Attributes;
use super::xml::{Element, Xml};
use crate::error::Error;
use table::KNOWN;

/// The part of a model in which an element is.
#[derive(Clone, Copy, PartialEq)]
enum Section {
    Root,
    Compiler,
    Option,
    Default,
    Body,
    Equality,
    Actuator,
    /// A part whose elements are not read.
    Other,
}

/// Sections without attributes that matter.
const SECTIONS: [&str; 13] = [
    "size",
    "equality",
    "actuator",
    "statistic",
    "visual",
    "extension",
    "asset",
    "deformable",
    "contact",
    "tendon",
    "sensor",
    "custom",
    "keyframe",
];

/// Elements in bodies whose content is not read.
const IN_BODIES: [&str; 6] = ["plugin", "composite", "flexcomp", "replicate", "attach", "include"];

/// Checks the elements of a model, with their attributes and classes.
pub(super) fn check(attributes: &Attributes, xml: &Xml) -> Result<(), Error> {
    let root = xml.root();
    element(xml, root, Section::Root)?;
    for item in xml.children(root) {
        let inner = match item.name.as_str() {
            "compiler" => Section::Compiler,
            "option" => Section::Option,
            "default" => Section::Default,
            "worldbody" => Section::Body,
            "equality" => Section::Equality,
            "actuator" => Section::Actuator,
            _ => Section::Other,
        };
        element(xml, item, Section::Root)?;
        content(attributes, xml, item, inner)?;
    }
    Ok(())
}

/// Checks the elements in an element.
fn content(attributes: &Attributes, xml: &Xml, parent: &Element, section: Section) -> Result<(), Error> {
    for item in xml.children(parent) {
        element(xml, item, section)?;
        if section != Section::Default {
            for name in ["class", "childclass"] {
                if let Some(class) = item.get(name).filter(|class| !attributes.has_class(class)) {
                    let title = format!("the class `{class}` is not in the defaults of the model");
                    return Err(xml.error(item, name, &title, "write the name of a class that is there"));
                }
            }
        }
        let inner = match (section, item.name.as_str()) {
            (Section::Body, "body" | "frame") => Section::Body,
            (Section::Default, "default") => Section::Default,
            _ => Section::Other,
        };
        content(attributes, xml, item, inner)?;
    }
    Ok(())
}

/// Checks the name of an element, and those of its attributes.
fn element(xml: &Xml, item: &Element, section: Section) -> Result<(), Error> {
    let name = item.name.as_str();
    let is_unread = match section {
        Section::Root => SECTIONS.contains(&name),
        Section::Body => IN_BODIES.contains(&name),
        Section::Other => true,
        _ => false,
    };
    if is_unread {
        return Ok(());
    }
    // Defaults have the attributes of their elements.
    let places: &[Section] = match section {
        Section::Default => &[Section::Default, Section::Body, Section::Actuator],
        _ => &[section],
    };
    let in_default = ["joint", "geom", "site", "camera", "light"];
    let is_place = |place: Section| section == place || place != Section::Body || in_default.contains(&name);
    let find = |place: &Section| KNOWN.iter().find(|(own, known, ..)| own == place && *known == name);
    let found = places.iter().filter(|place| is_place(**place)).find_map(find);
    let is_class = section == Section::Default && name == "default";
    let known = match found {
        Some((.., shared, own)) => [*shared, *own],
        None if is_class => ["class", ""],
        None => {
            let title = format!("MuJoCo has no element `<{name}>` here");
            return Err(xml.error(item, "", &title, &near(name, elements(section))));
        }
    };
    let words = || known.into_iter().flat_map(str::split_whitespace);
    match item.attributes.iter().find(|(key, _)| !words().any(|word| word == key)) {
        Some((key, _)) => {
            let title = format!("MuJoCo has no attribute `{key}` of `<{name}>`");
            Err(xml.error(item, key, &title, &near(key, words().collect())))
        }
        None => Ok(()),
    }
}

/// The names of the elements of a section.
fn elements(section: Section) -> Vec<&'static str> {
    let mut names: Vec<_> = KNOWN.iter().filter(|(own, ..)| *own == section).map(|(_, name, ..)| *name).collect();
    if section == Section::Root {
        names.retain(|name| *name != "mujoco");
        names.extend(SECTIONS);
    }
    names
}

/// The help that names what is meant: the name with the most of the same letters at its begin and its end.
fn near(wrong: &str, mut names: Vec<&str>) -> String {
    let lower = wrong.to_ascii_lowercase();
    let same = |name: &str| {
        let begin = name.bytes().zip(lower.bytes()).take_while(|(a, b)| a == b).count();
        let rest = name.len().min(lower.len()) - begin;
        begin + name.bytes().rev().zip(lower.bytes().rev()).take(rest).take_while(|(a, b)| a == b).count()
    };
    names.sort_unstable_by_key(|name| (std::cmp::Reverse(same(name)), name.len().abs_diff(lower.len()), *name));
    match names.first().filter(|name| same(name) >= 2) {
        Some(name) => format!("did you mean `{name}`? Capital letters count"),
        None => format!("leave it out, or write one of {}", names.into_iter().take(30).collect::<Vec<_>>().join(", ")),
    }
}

#[cfg(test)]
mod tests {
    use super::super::super::imported;

    /// A model with defaults, attributes of its joint, and sections.
    fn model(defaults: &str, joint: &str, rest: &str) -> String {
        format!(
            "<mujoco><default>{defaults}</default><worldbody><body name=\"a\">\
             <joint name=\"j\" axis=\"0 1 0\" {joint}/><geom size=\"0.1\"/></body></worldbody>{rest}</mujoco>"
        )
    }

    #[test]
    fn what_mujoco_does_not_know_is_refused() {
        for (text, said) in [
            (model("", "nam=\"x\"", ""), "MuJoCo has no attribute `nam` of `<joint>`"),
            (model("", "Stiffness=\"1\"", ""), "did you mean `stiffness`?"),
            (model("", "dampng=\"1\"", ""), "did you mean `damping`?"),
            (model("", "class=\"x\"", ""), "the class `x` is not in the defaults of the model"),
            (model("<joint postion=\"1\"/>", "", ""), "MuJoCo has no attribute `postion` of `<joint>`"),
            (model("<body/>", "", ""), "MuJoCo has no element `<body>` here"),
            (model("", "", "<Default/>"), "did you mean `default`?"),
            (model("", "", "<actuators/>"), "did you mean `actuator`?"),
            (model("", "", "<actuator><motor dampratio=\"1\"/></actuator>"), "no attribute `dampratio` of `<motor>`"),
            (model("", "", "<equality><conect/></equality>"), "did you mean `connect`?"),
            (model("", "", "<worldbody><bdy/></worldbody>"), "did you mean `body`?"),
        ] {
            let error = imported(&text).expect_err("no scene");
            assert!(error.contains(said) && error.contains("model:1:"), "{error}");
        }
    }

    #[test]
    fn what_mujoco_knows_is_read() {
        let defaults = "<geom material=\"m\" rgba=\"1 1 1 1\"/><equality solref=\"0.02 1\"/><position kp=\"2\"/>\
                        <default class=\"c\"><tendon width=\"1\"/></default>";
        let rest = "<asset><material name=\"m\"/></asset><visual><map znear=\"1\"/></visual><sensor>\
                    <jointpos joint=\"j\"/></sensor><custom><numeric name=\"n\" data=\"1\"/></custom><size/>\
                    <statistic/><contact><exclude body1=\"a\" body2=\"b\"/></contact>";
        let scene = imported(&model(defaults, "class=\"c\" user=\"1\"", rest)).expect("a scene");
        for item in ["the sensors", "the custom data"] {
            assert!(scene.contains(&format!("# - {item}")), "{item}: {scene}");
        }
    }
}
