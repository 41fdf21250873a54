//! `qrm list`

use qrm_core::QuantityDescription;

use crate::scenes::{Scene, Scenes};

/// Every scene with what can be set and what it gives.
pub(super) fn list(scenes: &Scenes) -> String {
    scenes.iter().map(entry).collect::<Vec<_>>().join("\n\n")
}

fn entry(scene: &dyn Scene) -> String {
    let description = scene.description();
    let names = |quantities: &[QuantityDescription]| quantities.iter().map(|q| q.name).collect::<Vec<_>>().join(", ");
    let facts = [
        ("coordinates", names(description.coordinates)),
        ("constraints", names(description.constraints)),
        ("outputs", names(description.outputs)),
        ("until", description.until.to_owned()),
        ("left out", description.left_out.join(", ")),
    ];
    let mut lines = vec![format!("{}: {}", description.name, description.doc)];
    for (what, fact) in facts.iter().filter(|(_, fact)| !fact.is_empty()) {
        lines.push(format!("  {what:12} {fact}"));
    }
    lines.push("  parameters   (--set NAME=VALUE)".to_owned());
    for (parameter, value) in description.parameters.iter().zip(scene.parameters(&|_| None)) {
        lines.push(
            format!("    {:8} {value:>20} {:8} {}", parameter.name, parameter.unit, parameter.doc)
                .trim_end()
                .to_owned(),
        );
    }
    lines.join("\n")
}
