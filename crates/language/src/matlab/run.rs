//! The script that simulates a motion and plots it.

use super::Writer;
use crate::ir::Quantity;

impl Writer<'_> {
    /// Writes the script.
    pub(super) fn run(&self) -> String {
        let name = &self.program.name;
        let title = self.program.doc.first().map_or("", String::as_str);
        let mut text = format!("%{}_RUN {title}\n%\n", name.to_uppercase());
        text += "%   Simulates the motion from the scene's start, and plots rates and outputs over time.\n\n";
        for line in &self.program.notes {
            text += format!("% {line}").trim_end();
            text += "\n";
        }
        text += "\n";
        text += &format!("p = {name}_parameters();\nmotion = {name}_motion(p);\n");
        text += "fprintf('%d steps, end at t = %.15g s, largest residual %.1e\\n', ...\n    numel(motion.t) - 1, \
                 motion.t(end), max([motion.residual; 0]));\n";
        for (unit, places) in by_unit(&self.program.coordinates) {
            let label = format!("rates ({unit}/s)");
            let names: Vec<String> =
                places.iter().map(|&i| quoted(&format!("{}_dot", self.program.coordinates[i].name))).collect();
            let columns: Vec<String> = places.iter().map(|i| (i + 1).to_string()).collect();
            text += &figure("rates", &format!("motion.qd(:, [{}])", columns.join(" ")), &label);
            text += &format!("legend({{{}}}, 'Interpreter', 'none');\n", names.join(", "));
        }
        for (i, output) in self.program.outputs.iter().enumerate() {
            let Quantity { name, unit, doc } = output;
            text += &figure(name, &format!("motion.outputs(:, {})", i + 1), &format!("{name} ({unit})"));
            let title = if doc.is_empty() { name.clone() } else { format!("{name}: {doc}") };
            text += &format!("title({}, 'Interpreter', 'none');\n", quoted(&title));
        }
        text
    }
}

/// A figure of columns over time.
fn figure(name: &str, columns: &str, label: &str) -> String {
    format!(
        "\nfigure('Name', {});\nplot(motion.t, {columns});\ngrid on;\nxlabel('t (s)');\nylabel({}, 'Interpreter', \
         'none');\n",
        quoted(name),
        quoted(label)
    )
}

/// The indices of quantities, grouped by unit.
fn by_unit(quantities: &[Quantity]) -> Vec<(&str, Vec<usize>)> {
    let mut groups: Vec<(&str, Vec<usize>)> = Vec::new();
    for (i, quantity) in quantities.iter().enumerate() {
        match groups.iter_mut().find(|(unit, _)| *unit == quantity.unit) {
            Some((_, places)) => places.push(i),
            None => groups.push((&quantity.unit, vec![i])),
        }
    }
    groups
}

/// A text between single quotes.
fn quoted(text: &str) -> String {
    format!("'{}'", text.replace('\'', "''"))
}
