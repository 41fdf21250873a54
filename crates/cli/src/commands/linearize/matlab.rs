//! `linear.m`

use super::report::{LinearReport, Quantity};
use crate::format::full;

/// The script that has the matrices, and the system where `ss` is there.
pub(super) fn script(report: &LinearReport) -> String {
    let mut text = format!(
        "% {}: linear model about an equilibrium, by `qrm linearize`.\n\
         % States, inputs and outputs are deviations from the values given below.\n",
        report.scene
    );
    for (name, rows) in [("A", &report.a), ("B", &report.b), ("C", &report.c), ("D", &report.d)] {
        let row = |row: &Vec<f64>| row.iter().map(|entry| full(*entry)).collect::<Vec<_>>().join(", ");
        let rows: Vec<String> = rows.iter().map(row).collect();
        text += &format!("{name} = [{}];\n", rows.join("; ...\n     "));
    }
    for (name, all) in [("state", &report.states), ("input", &report.inputs), ("output", &report.outputs)] {
        let list = |part: fn(&Quantity) -> &str| {
            all.iter().map(|own| format!("'{}'", part(own))).collect::<Vec<_>>().join(", ")
        };
        let values: Vec<String> = all.iter().map(|own| full(own.value)).collect();
        text += &format!("{name}_names = {{{}}};\n", list(|own| &own.name));
        text += &format!("{name}_units = {{{}}};\n", list(|own| &own.unit));
        text += &format!("{name}_values = [{}];\n", values.join(", "));
    }
    text + "if exist('OCTAVE_VERSION', 'builtin') && ~isempty(pkg('list', 'control'))\n    \
            pkg('load', 'control');\n\
            end\n\
            if exist('ss') > 0\n    \
            sys = ss(A, B, C, D);\n\
            end\n"
}
