//! C99.

mod builtins;
mod comment;
mod cuda;
mod expression;
mod function;
mod lane_steps;
mod reserved_words;
mod structs;
mod templates;

use super::File;
use super::ir::{Function, Program, StructKind};
use super::lines::summary;
use super::names::Names;
use crate::untranslated::Untranslated;
use comment::comment;
pub(super) use cuda::write_cuda;
pub(super) use lane_steps::write_lane_steps;
use reserved_words::{is_header, is_keyword};

/// Writes the header and the source of a program.
pub(super) fn write(program: &Program) -> Result<Vec<File>, Untranslated> {
    let writer = Writer::new(program)?;
    let file = |extension: &str, text| File { name: format!("{}.{extension}", writer.stem()), text };
    Ok(vec![file("h", writer.header()?), file("c", writer.source()?)])
}

/// The source of a function.
pub(super) fn write_function(program: &Program, function: &Function) -> Result<String, Untranslated> {
    Writer::new(program)?.function(function, false)
}

/// The functions of the kernel that steps call.
const KERNEL: [&str; 6] =
    ["position", "residuals", "velocity_residual", "correction", "accelerations", "growth_factor"];
/// The largest number of statements of a kernel that is inlined into the steps; above it, a call costs little.
const MOST_INLINE: usize = 400;

struct Writer<'p> {
    program: &'p Program,
    fields: Names,
}

impl<'p> Writer<'p> {
    fn new(program: &'p Program) -> Result<Self, Untranslated> {
        let fields = program.structs.iter().flat_map(|structure| &structure.fields).map(|field| field.name.as_str());
        let fields = Names::new(fields, |name| is_keyword(name) || is_own_macro(program, name))?;
        Ok(Self { program, fields })
    }

    /// The base name of the files, which must differ from headers of the C library.
    fn stem(&self) -> String {
        let name = &self.program.name;
        if is_header(name) { format!("{name}_") } else { name.clone() }
    }

    fn header(&self) -> Result<String, Untranslated> {
        let guard = self.program.name.to_uppercase();
        let mut text = self.introduction(USE);
        text += &format!("\n#ifndef {guard}_H\n#define {guard}_H\n\n");
        text += "#ifdef __cplusplus\nextern \"C\" {\n#endif\n\n";
        text += &self.declarations()?;
        Ok(text + "\n#ifdef __cplusplus\n}\n#endif\n\n#endif\n")
    }

    /// The first comment of a file, with an example.
    fn introduction(&self, example: &str) -> String {
        origin() + "//\n" + &comment(&self.program.notes) + &self.named(example)
    }

    /// The sizes, the structs and the signatures of all functions.
    fn declarations(&self) -> Result<String, Untranslated> {
        let mut text = self.sizes_and_structs();
        text += &format!("\n// The mechanism with these parameters.\n{};\n", self.constructor());
        for function in &self.program.functions {
            text += &format!("\n{}{};\n", comment(summary(&function.doc)), self.signature(function)?);
        }
        Ok(text + &self.states() + &self.step_header())
    }

    fn sizes_and_structs(&self) -> String {
        let Program { name, coordinates, constraints, outputs, .. } = self.program;
        let (guard, mut text) = (name.to_uppercase(), String::new());
        for (size, count) in SIZES.into_iter().zip([coordinates, constraints, outputs]) {
            text += &format!("#define {guard}_{size} {}\n", count.len());
        }
        text + "\n// An array of no numbers has one place: C has none of size 0.\n" + &self.structs()
    }

    fn source(&self) -> Result<String, Untranslated> {
        let stem = self.stem();
        let mut text = origin() + &format!("\n#include \"{stem}.h\"\n\n#include <float.h>\n#include <math.h>\n");
        text += self.inlining();
        Ok(text + &self.definitions()?)
    }

    /// All functions.
    fn definitions(&self) -> Result<String, Untranslated> {
        Ok(self.functions(|_| true)? + &self.construction() + &self.step_source())
    }

    /// The functions whose names are chosen.
    fn functions(&self, is_chosen: impl Fn(&str) -> bool) -> Result<String, Untranslated> {
        let mut text = builtins::helpers(self.program);
        for function in self.program.functions.iter().filter(|function| is_chosen(&function.name)) {
            text += &format!("\n{}", self.function(function, KERNEL.contains(&&*function.name))?);
        }
        Ok(text)
    }

    /// The attributes that control how functions are inlined.
    fn inlining(&self) -> &'static str {
        let kernel = KERNEL.iter().filter_map(|name| self.program.function(name));
        match kernel.map(|function| function.body.len()).sum::<usize>() <= MOST_INLINE {
            true => INLINE,
            false => "\n#define INLINE\n",
        }
    }

    /// The signature of the function that creates a mechanism.
    fn constructor(&self) -> String {
        let [parameters, mechanism] = [StructKind::Parameters, StructKind::Mechanism].map(|kind| self.structure(kind));
        format!("void {}_new(const {parameters} *p, {mechanism} *m)", self.program.name)
    }

    fn construction(&self) -> String {
        let constants = match self.program.has(StructKind::Constants) {
            true => format!("    {}_constants(p, &m->constants);\n", self.program.name),
            false => String::new(),
        };
        format!("\n{}\n{{\n    m->parameters = *p;\n{constants}}}\n", self.constructor())
    }
}

/// The suffixes of the size macros in the header.
const SIZES: [&str; 3] = ["COORDINATES", "CONSTRAINTS", "OUTPUTS"];

/// Whether a name is a macro of the header.
fn is_own_macro(program: &Program, name: &str) -> bool {
    let end = name.strip_prefix(&program.name.to_uppercase()).and_then(|end| end.strip_prefix('_'));
    end.is_some_and(|end| SIZES.contains(&end) || ["H", "PLACES"].contains(&end))
}

/// The macro for functions that are inlined into their callers.
const INLINE: &str = "
#if defined(__clang__)
#define INLINE __attribute__((always_inline))
#elif defined(__GNUC__)
#define INLINE inline __attribute__((always_inline))
#else
#define INLINE
#endif
";

/// A usage example of the functions.
const USE: &str = "
// Two steps from the start:
//
//     struct scene_parameters parameters;
//     struct scene mechanism;
//     struct scene_step step;
//     scene_default_parameters(&parameters);
//     scene_new(&parameters, &mechanism);
//     if (!scene_initial_state(&mechanism, &step.end)) { the loops cannot be closed }
//     scene_rk4_step(&mechanism, 0.0, 1e-3, &step.end, &step);
//     scene_rk4_step(&mechanism, 1e-3, 1e-3, &step.end, &step);
//     if (!scene_is_good(&step, 1e-12)) { choose a shorter step }
";

/// The first line of both files.
fn origin() -> String {
    format!("// Generated by qrm-codegen {}. Do not edit: change the scene.\n", env!("CARGO_PKG_VERSION"))
}
