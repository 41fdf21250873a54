//! Writes the functions of a mechanism as code, in Rust, C and MATLAB.
//!
//! A [tape](qrm_core::NamedTape) holds the functions: names, formulae and the order of operations are the same in all
//! languages.

mod c;
mod constants;
pub mod identifier;
pub mod ir;
mod lines;
mod lower;
mod matlab;
mod names;
mod precedence;
pub mod rust;
pub mod source_excerpts;
mod sparsity;
mod texts;
mod untranslated;

use qrm_core::lane_layout::BatchLayout;
use qrm_core::{BatchRequest, NamedTape, named_tape};
use qrm_scene::names::module_name;
use qrm_scene::scene::Scene;

use ir::{Function, Program};
pub use untranslated::Untranslated;

/// The functions of a scene and its texts, for printers.
#[derive(Clone, Copy, Debug)]
pub struct Code<'c> {
    /// The file of the scene.
    pub path: &'c str,
    /// The scene.
    pub scene: &'c Scene,
    /// The text of the scene file.
    pub source: &'c str,
    /// The functions of the scene.
    pub tape: &'c NamedTape,
}

impl Code<'_> {
    /// The prefix of the names of the scene's files and functions: `quick_return` for `quick-return`.
    pub fn name(&self) -> String {
        module_name(&self.scene.name)
    }

    /// The program from which C and MATLAB are written.
    pub fn program(&self) -> Program {
        lower::program(self.scene, self.tape, self.source)
    }

    /// A function of the program by its name or its symbol.
    fn function<'p>(&self, program: &'p Program, name: &str) -> Option<&'p Function> {
        let has_symbol = |own: &&named_tape::Function| own.aliases.iter().any(|alias| alias == name);
        let own = self.tape.functions.iter().find(has_symbol);
        program.function(own.map_or(name, |own| &own.name))
    }
}

/// A language of generated code.
#[derive(Clone, Copy, Debug)]
pub struct Language {
    /// The name of the language on the command line.
    pub name: &'static str,
    /// The official name of the language.
    pub title: &'static str,
    /// The description of the generated code, in a few words.
    pub doc: &'static str,
    /// The characters that begin a comment.
    pub comment: &'static str,
    /// Whether steps support redundant constraints; in Rust, a solver does.
    pub takes_repeated_constraints: bool,
    /// Writes all functions.
    pub write: fn(&Code) -> Result<Vec<File>, Untranslated>,
    /// Writes a part by its name or its symbol; `None` if the part cannot be written separately.
    pub write_part: fn(&Code, &str) -> Result<Option<String>, Untranslated>,
}

/// The languages of generated code.
pub const LANGUAGES: [Language; 4] = [
    Language {
        name: "rust",
        title: "Rust",
        doc: "As it is generated and compiled",
        comment: "//",
        takes_repeated_constraints: true,
        write: |code| Ok(vec![File { name: format!("{}.rs", code.name()), text: rust::text(code) }]),
        write_part: |code, name| Ok(rust::part(code, name)),
    },
    Language {
        name: "c",
        title: "C",
        doc: "C99, a header and a source file that need libm alone",
        comment: "//",
        takes_repeated_constraints: false,
        write: |code| c(&code.program()),
        write_part: |code, name| {
            let program = code.program();
            code.function(&program, name).map(|function| c::write_function(&program, function)).transpose()
        },
    },
    Language {
        name: "cuda",
        title: "CUDA",
        doc: "CUDA, a header with the functions and steps of the C for a device",
        comment: "//",
        takes_repeated_constraints: false,
        write: |code| c::write_cuda(&code.program()),
        write_part: |code, name| {
            let program = code.program();
            code.function(&program, name).map(|function| c::write_function(&program, function)).transpose()
        },
    },
    Language {
        name: "matlab",
        title: "MATLAB",
        doc: "MATLAB and Octave, a file for each function",
        comment: "%",
        takes_repeated_constraints: true,
        write: |code| matlab(&code.program()),
        write_part: |code, name| {
            let program = code.program();
            code.function(&program, name).map(|function| matlab::write_function(&program, function)).transpose()
        },
    },
];

/// A file of generated code.
#[derive(Clone, Debug, PartialEq)]
pub struct File {
    /// The name of the file, without a folder.
    pub name: String,
    /// The text of the file.
    pub text: String,
}

/// Writes a module in C99, as a header and a source file. The code needs `libm` and no allocator.
///
/// # Errors
/// A name cannot be expressed in C.
pub fn c(program: &Program) -> Result<Vec<File>, Untranslated> {
    c::write(program)
}

/// Writes a module in MATLAB, as a file for each function, and a script that simulates the motion. The code also runs
/// in Octave.
///
/// # Errors
/// A name cannot be expressed in MATLAB.
pub fn matlab(program: &Program) -> Result<Vec<File>, Untranslated> {
    matlab::write(program)
}

/// Writes steps of lanes for a device, in CUDA: the function `advance(numbers, lanes)`, with the numbers of each lane
/// at the places of the layout. Steps count as reliable up to this residual; `parameters` are the names of the
/// parameters in the order of the layout.
///
/// # Errors
/// A name cannot be expressed in C.
pub fn lane_steps(
    code: &Code,
    (layout, request): (&BatchLayout, &BatchRequest),
    residual: f64,
    parameters: &[&str],
) -> Result<String, Untranslated> {
    c::write_lane_steps(&code.program(), (layout, request), residual, parameters)
}
