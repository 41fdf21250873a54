//! Structs.

use super::Writer;
use super::comment::comment;
use super::routines::is_word;
use crate::program::{Part, Record};

impl Writer<'_> {
    /// The type of a struct.
    pub(super) fn structure(&self, part: Part) -> String {
        let name = &self.program.name;
        match part {
            Part::Mechanism if is_word(name) => format!("struct {name}_"),
            Part::Mechanism => format!("struct {name}"),
            part => format!("struct {name}_{}", part.name()),
        }
    }

    pub(super) fn records(&self) -> String {
        let mut text: String = self.program.records.iter().map(|record| self.record(record)).collect();
        let n = self.program.coordinates.len().max(1);
        text += &format!(
            "\n// Sines and cosines of the coordinates that are angles.\n{} {{\n    double sin[{n}];\n    double cos[{n}];\n}};\n",
            self.structure(Part::Angles)
        );
        text += &format!("\n{}{} {{\n", comment(&self.program.doc), self.structure(Part::Mechanism));
        for part in [Part::Parameters, Part::Constants] {
            if self.program.has(part) {
                text += &format!("    {} {};\n", self.structure(part), part.name());
            }
        }
        text + "};\n"
    }

    fn record(&self, record: &Record) -> String {
        let mut text = format!("\n{}{} {{\n", comment(&record.doc), self.structure(record.part));
        for field in &record.fields {
            for line in comment(&field.doc).lines() {
                text += &format!("    {line}\n");
            }
            text += &format!("    double {};\n", self.fields.get(&field.name));
        }
        if record.fields.is_empty() {
            text += "    // C has no struct without a field.\n    double nothing;\n";
        }
        text + "};\n"
    }
}
