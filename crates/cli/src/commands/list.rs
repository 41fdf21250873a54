//! `qrm list`

use clap::Args;
use qrm_core::{Model, QuantityDescription};

use crate::error::Error;
use crate::format::heading;
use crate::output::print;

#[derive(Args)]
pub(crate) struct Options {}

/// Prints every scene with its parameters and outputs.
pub(crate) fn run(models: &'static [Model], _options: &Options) -> Result<(), Error> {
    let entries = models.iter().map(entry).chain(compiled(models));
    print(&entries.collect::<Vec<_>>().join("\n\n"));
    Ok(())
}

/// A line with the compiled scenes; `None` if all are compiled.
fn compiled(models: &[Model]) -> Option<String> {
    let names = |is_interpreted: bool| {
        let chosen = models.iter().filter(|model| model.is_interpreted() == is_interpreted);
        chosen.map(|model| model.description.name).collect::<Vec<_>>().join(", ")
    };
    models.iter().any(Model::is_interpreted).then(|| {
        format!(
            "compiled: {}; interpreted, with the same numbers: {} (QRM_SCENES=all before the build command compiles \
             all)",
            names(false),
            names(true)
        )
    })
}

fn entry(model: &Model) -> String {
    let description = model.description;
    let names = |quantities: &[QuantityDescription]| quantities.iter().map(|q| q.name).collect::<Vec<_>>().join(", ");
    let topics = [
        ("coordinates", names(description.coordinates)),
        ("constraints", names(description.constraints)),
        ("outputs", names(description.outputs)),
        ("until", description.until.to_owned()),
        ("left out", description.left_out.join(", ")),
    ];
    let mut lines = vec![heading(description)];
    for (topic, text) in topics.iter().filter(|(_, text)| !text.is_empty()) {
        lines.push(format!("  {topic:12} {text}"));
    }
    lines.push("  parameters   (--set NAME=VALUE)".to_owned());
    for (parameter, value) in description.parameters.iter().zip(model.parameter_values(&|_| None)) {
        let line = format!("    {:8} {value:>20} {:8} {}", parameter.name, parameter.unit, parameter.doc);
        lines.push(line.trim_end().to_owned());
    }
    lines.join("\n")
}
