//! Forces and paths that are shown.

use toml_edit::{InlineTable, Item};

use super::linkage::{Joint, Linkage};

/// Adds the force in the joint at a point to the outputs, or removes it.
pub(super) fn force(linkage: &mut Linkage, node: &str) -> Result<(), String> {
    let points = linkage.points_at(node)?;
    let joints = linkage.joints();
    let is_here = |joint: &&Joint| {
        !["gear", "belt", "rack"].contains(&joint.kind) && joint.members.iter().any(|each| points.contains(each))
    };
    let Some(joint) = joints.iter().find(is_here) else {
        return Err(format!("there is no joint at `{node}`"));
    };
    toggle(linkage, "outputs", "joint", &joint.name, &format!("F_{}", joint.name))
}

/// Adds the path of a point to the drawing, or removes it.
pub(super) fn path(linkage: &mut Linkage, node: &str) -> Result<(), String> {
    toggle(linkage, "drawing", "path", node, &format!("path_{node}"))
}

/// Removes the entry of a section with this value of a key, or adds one.
fn toggle(linkage: &mut Linkage, section: &str, key: &str, value: &str, name: &str) -> Result<(), String> {
    let has_value = |item: &Item| item.get(key).and_then(Item::as_str) == Some(value);
    let own = linkage.entries(section).find(|(_, item)| has_value(item)).map(|(name, _)| name.to_owned());
    if let Some(own) = own {
        linkage.section(section)?.remove(&own);
        return Ok(());
    }
    let mut entry = InlineTable::new();
    entry.insert(key, value.into());
    let name = linkage.free_name(name);
    linkage.section(section)?.insert(&name, Item::Value(entry.into()));
    Ok(())
}
