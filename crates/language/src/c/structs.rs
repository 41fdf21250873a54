//! Structs.

use super::Writer;
use super::comment::comment;
use super::reserved_words::is_keyword;
use crate::ir::{Struct, StructKind};

impl Writer<'_> {
    /// The type of a struct.
    pub(super) fn structure(&self, kind: StructKind) -> String {
        let name = &self.program.name;
        match kind {
            StructKind::Mechanism if is_keyword(name) => format!("struct {name}_"),
            StructKind::Mechanism => format!("struct {name}"),
            kind => format!("struct {name}_{}", kind.name()),
        }
    }

    pub(super) fn structs(&self) -> String {
        let mut text: String = self.program.structs.iter().map(|structure| self.definition(structure)).collect();
        let n = self.program.coordinates.len().max(1);
        text += &format!(
            "\n// Sines and cosines of the coordinates that are angles.\n{} {{\n    double sin[{n}];\n    double \
             cos[{n}];\n}};\n",
            self.structure(StructKind::Angles)
        );
        text += &format!("\n{}{} {{\n", comment(&self.program.doc), self.structure(StructKind::Mechanism));
        for kind in [StructKind::Parameters, StructKind::Constants] {
            if self.program.has(kind) {
                text += &format!("    {} {};\n", self.structure(kind), kind.name());
            }
        }
        text + "};\n"
    }

    fn definition(&self, structure: &Struct) -> String {
        let mut text = format!("\n{}{} {{\n", comment(&structure.doc), self.structure(structure.kind));
        for field in &structure.fields {
            for line in comment(&field.doc).lines() {
                text += &format!("    {line}\n");
            }
            text += &format!("    double {};\n", self.fields.get(&field.name));
        }
        if structure.fields.is_empty() {
            text += "    // C has no struct without a field.\n    double nothing;\n";
        }
        text + "};\n"
    }
}
