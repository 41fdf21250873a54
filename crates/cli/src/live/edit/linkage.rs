//! The links and joints in the text of a scene.

use qrm_scene::unit::Unit;
use toml_edit::{Array, DocumentMut, Item, Table, TableLike, Value};

use super::number;
use super::toml_text::change_table;

/// The link that does not move.
pub(super) const GROUND: &str = "ground";

/// The byte-order mark with which some editors begin a file.
const MARK: char = '\u{feff}';

/// A point of a link.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct LinkPoint {
    pub(super) link: String,
    pub(super) point: String,
}

/// A joint of two or more links.
#[derive(Clone, Debug)]
pub(super) struct Joint {
    pub(super) name: String,
    /// The key of the list of its links, such as `revolute`.
    pub(super) kind: &'static str,
    pub(super) members: Vec<LinkPoint>,
    pub(super) is_driven: bool,
}

/// The kinds of joints that hold points of links.
const KINDS: [&str; 10] =
    ["revolute", "weld", "prismatic", "pin_in_slot", "rod", "cylinder", "gear", "belt", "rack", "cam"];

/// The keys of joints with links whose angles the joint ties.
const TIES: [&str; 8] = ["weld", "prismatic", "pin_in_slot", "gear", "belt", "rack", "cam", "carrier"];

/// The text of a scene with its links and joints. Comments and formatting stay.
pub(super) struct Linkage {
    pub(super) document: DocumentMut,
    has_carriage_returns: bool,
    has_mark: bool,
    has_last_end: bool,
}

impl Linkage {
    pub(super) fn parse(text: &str) -> Result<Self, String> {
        let document = text.parse().map_err(|_| "the file is not valid TOML at present".to_owned())?;
        let ends = text.matches('\n').count();
        Ok(Self {
            document,
            has_carriage_returns: 2 * text.matches("\r\n").count() > ends,
            has_mark: text.starts_with(MARK),
            has_last_end: text.ends_with('\n'),
        })
    }

    /// The text of the scene, with the line ends of most lines of the file.
    pub(super) fn text(&self) -> String {
        let text = self.document.to_string().replace("\r\n", "\n");
        let text = if self.has_last_end { &text } else { text.trim_end_matches('\n') };
        let text = if self.has_carriage_returns { text.replace('\n', "\r\n") } else { text.to_owned() };
        if self.has_mark && !text.starts_with(MARK) { format!("{MARK}{text}") } else { text }
    }

    /// The entries of a section.
    pub(super) fn entries(&self, section: &str) -> impl Iterator<Item = (&str, &Item)> {
        self.document.get(section).and_then(Item::as_table_like).into_iter().flat_map(TableLike::iter)
    }

    /// Changes an entry of a section.
    pub(super) fn change_entry<T>(
        &mut self,
        section: &str,
        name: &str,
        change: impl FnOnce(&mut dyn TableLike) -> T,
    ) -> Result<T, String> {
        let entry = self.document.get_mut(section).and_then(|section| section.get_mut(name));
        entry.and_then(|entry| change_table(entry, change)).ok_or_else(|| format!("[{section}] has no table `{name}`"))
    }

    /// The section with this name, added if it is missing.
    pub(super) fn section(&mut self, name: &str) -> Result<&mut dyn TableLike, String> {
        let item = self.document.entry(name).or_insert_with(|| Item::Table(Table::new()));
        item.as_table_like_mut().ok_or_else(|| format!("`{name}` is no table"))
    }

    /// A key of an entry.
    pub(super) fn key(&self, section: &str, entry: &str, key: &str) -> Option<&Item> {
        self.document.get(section)?.get(entry)?.get(key)
    }

    /// The number of corners of a bar or a triangle; 0 for another link.
    pub(super) fn corner_count(&self, link: &str) -> usize {
        let has = |key| self.key("links", link, key).is_some();
        if has("bar") {
            2
        } else if has("triangle") {
            3
        } else {
            0
        }
    }

    /// The names of the points of a link, those of its bar or triangle first.
    pub(super) fn points_of(&self, link: &str) -> Vec<String> {
        let shape = ["bar", "triangle"].into_iter().find_map(|key| self.key("links", link, key));
        let corners = shape.and_then(Item::as_array).into_iter().flat_map(Array::iter).filter_map(Value::as_str);
        let points = self.key("links", link, "points").and_then(Item::as_table_like);
        let own = points.into_iter().flat_map(TableLike::iter).map(|(name, _)| name);
        corners.chain(own).map(str::to_owned).collect()
    }

    /// The coordinates of a point in the frame of its link; `None` if they are formulae.
    pub(super) fn own_place(&self, link: &str, point: &str) -> Option<[f64; 2]> {
        let keys = ["links", link, "points", point];
        let at = |axis| number::get(&self.document, (&keys, Some(axis)));
        at(0).zip(at(1)).map(|(x, y)| [x, y])
    }

    /// The joints that hold points of links.
    pub(super) fn joints(&self) -> Vec<Joint> {
        let joint = |(name, item): (&str, &Item)| {
            let kind = KINDS.into_iter().find(|kind| item.get(kind).is_some())?;
            let members = item.get(kind)?.as_array()?.iter().filter_map(Value::as_str);
            let member = |text: &str| {
                let (link, point) = text.split_once('.').unwrap_or((text, name));
                point_of(link, point)
            };
            let is_driven = item.get("drive").is_some();
            Some(Joint { name: name.to_owned(), kind, members: members.map(member).collect(), is_driven })
        };
        self.entries("joints").filter_map(joint).collect()
    }

    /// The joint other than pins and drives that ties the angle of a link to that of another one.
    pub(super) fn tie_of(&self, link: &str) -> Option<String> {
        let ties = |(_, item): &(&str, &Item)| {
            let names = |key: &&str| {
                let link_of = |value: &Value| value.as_str()?.split('.').next().map(str::to_owned);
                let value = item.get(key)?.as_value()?;
                let Some(list) = value.as_array() else { return Some(link_of(value).into_iter().collect()) };
                // The first link of a slot may turn.
                Some(list.iter().filter_map(link_of).skip(usize::from(*key == "pin_in_slot")).collect::<Vec<_>>())
            };
            TIES.iter().filter_map(names).flatten().any(|own| own == link)
        };
        self.entries("joints").find(ties).map(|(name, _)| name.to_owned())
    }

    /// The points of links that are at a point of the drawing, those of pins and welds included.
    pub(super) fn points_at(&self, node: &str) -> Result<Vec<LinkPoint>, String> {
        let links: Vec<&str> = self.entries("links").map(|(name, _)| name).collect();
        let has = |link: &str, point: &str| self.points_of(link).iter().any(|own| own == point);
        let is_named = |link: &&&str| has(link, node);
        let mut points: Vec<LinkPoint> = links.iter().filter(is_named).map(|link| point_of(link, node)).collect();
        // Of points with the same name in different places, each has the name of its link.
        let prefixed = |link: &&str| {
            let point = node.strip_prefix(link)?.strip_prefix('_')?;
            has(link, point).then(|| point_of(link, point))
        };
        if points.is_empty() {
            points.extend(links.iter().find_map(prefixed));
        }
        if points.is_empty() {
            return Err(format!("`{node}` is no point of a link: the mouse changes links and joints"));
        }
        let mut joints = self.joints();
        joints.retain(|joint| ["revolute", "weld"].contains(&joint.kind));
        while let Some(next) = joints.iter().position(|joint| joint.members.iter().any(|each| points.contains(each))) {
            for member in joints.swap_remove(next).members {
                if !points.contains(&member) {
                    points.push(member);
                }
            }
        }
        Ok(points)
    }

    /// The pins at some points.
    pub(super) fn pins_at(&self, points: &[LinkPoint]) -> Vec<Joint> {
        let mut pins = self.joints();
        pins.retain(|joint| joint.kind == "revolute" && joint.members.iter().any(|each| points.contains(each)));
        pins
    }

    /// Whether a name has a meaning in the scene.
    pub(super) fn is_used(&self, name: &str) -> bool {
        const SECTIONS: [&str; 10] = [
            "parameters",
            "tables",
            "links",
            "joints",
            "points",
            "bodies",
            "constraints",
            "loads",
            "outputs",
            "drawing",
        ];
        let is_point = || {
            let mut links = self.entries("links").map(|(link, _)| link);
            links.any(|link| self.points_of(link).iter().any(|point| point == name))
        };
        SECTIONS.into_iter().any(|section| self.entries(section).any(|(own, _)| own == name))
            || is_point()
            || Unit::parse(name).is_some()
    }

    /// A name for a point: the first free letter that is not `other`.
    pub(super) fn point_name(&self, other: &str) -> String {
        let letters = ('A'..='Z').map(String::from);
        let numbered = (1..).flat_map(|number| ('A'..='Z').map(move |letter| format!("{letter}{number}")));
        letters.chain(numbered).find(|name| name != other && !self.is_used(name)).unwrap_or_default()
    }

    /// The first free name of these: the name itself, and the name with a number.
    pub(super) fn free_name(&self, name: &str) -> String {
        let numbered = (2..).map(|number| format!("{name}{number}"));
        std::iter::once(name.to_owned()).chain(numbered).find(|name| !self.is_used(name)).unwrap_or_default()
    }
}

/// The point of a link.
pub(super) fn point_of(link: &str, point: &str) -> LinkPoint {
    LinkPoint { link: link.to_owned(), point: point.to_owned() }
}

/// A point of a link in the list of a joint.
pub(super) fn member(LinkPoint { link, point }: &LinkPoint, joint: &str) -> String {
    if point == joint { link.clone() } else { format!("{link}.{point}") }
}
