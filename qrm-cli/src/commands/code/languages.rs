//! Generated code in a language of the user's choice.

use clap::builder::{PossibleValue, PossibleValuesParser, TypedValueParser};
use qrm_core::Description;
use qrm_language::ir::Program;
use qrm_language::{File, LANGUAGES, Language, Untranslated};

use super::items::Item;
use crate::error::Error;

/// A language of generated code: Rust, where there is no translation.
#[derive(Clone, Copy, Debug)]
pub(super) struct OutputLanguage(Option<&'static Language>);

/// The name of the language that is generated.
const RUST: &str = "rust";

/// Reads the name of a language.
pub(super) fn parser() -> impl TypedValueParser<Value = OutputLanguage> {
    let others = LANGUAGES.iter().map(|language| PossibleValue::new(language.name).help(language.doc));
    let names = std::iter::once(PossibleValue::new(RUST).help("As it is generated and compiled")).chain(others);
    PossibleValuesParser::new(names).map(|name| OutputLanguage(LANGUAGES.iter().find(|language| language.name == name)))
}

impl OutputLanguage {
    pub(super) fn is_rust(self) -> bool {
        self.0.is_none()
    }

    /// Whether steps take constraints that repeat others; in Rust a solver does.
    pub(super) fn takes_repeated_constraints(self) -> bool {
        self.0.is_none_or(|language| language.takes_repeated_constraints)
    }

    pub(super) fn name(self) -> &'static str {
        self.0.map_or(RUST, |language| language.name)
    }

    pub(super) fn title(self) -> &'static str {
        self.0.map_or("Rust", |language| language.title)
    }

    /// All code of a scene.
    pub(super) fn files(self, description: &Description) -> Result<Vec<File>, Error> {
        let Some(language) = self.0 else {
            let name = description.name.to_lowercase().replace('-', "_");
            return Ok(vec![File { name: format!("{name}.rs"), text: description.code.to_owned() }]);
        };
        let program = self.program(description)?;
        (language.write)(&program).map_err(|e| self.untranslated(description, &e))
    }

    /// Whether translated code has a function of this name, behind that of the scene.
    pub(super) fn has_function(self, description: &Description, name: &str) -> Result<bool, Error> {
        if self.is_rust() {
            return Ok(false);
        }
        let call = format!("{}_{name}(", self.program(description)?.name);
        Ok(self.files(description)?.iter().any(|file| file.text.contains(&call)))
    }

    fn program(self, description: &Description) -> Result<Program, Error> {
        qrm_language::parse(description.name, description.code).map_err(|e| self.untranslated(description, &e))
    }

    /// Some items of a scene's code; `None` if one of them is no function.
    pub(super) fn part(self, description: &Description, items: &[&Item]) -> Result<Option<String>, Error> {
        let Some(language) = self.0 else {
            let texts: Vec<&str> = items.iter().map(|item| item.text).collect();
            return Ok(Some(texts.join("\n\n")));
        };
        let untranslated = |e| self.untranslated(description, &e);
        let program = self.program(description)?;
        let functions: Option<Vec<_>> = items.iter().map(|item| program.function(item.name)).collect();
        let Some(functions) = functions else { return Ok(None) };
        let texts = functions.into_iter().map(|function| (language.write_function)(&program, function));
        let texts = texts.collect::<Result<Vec<String>, _>>().map_err(untranslated)?;
        Ok(Some(texts.join("\n")))
    }

    /// All files in one text, each behind a line with its name.
    pub(super) fn listing(self, files: &[File]) -> String {
        let file = |file: &File| match self.0 {
            Some(language) => format!("{} {}\n\n{}", language.comment, file.name, file.text),
            None => file.text.clone(),
        };
        files.iter().map(file).collect::<Vec<_>>().join("\n")
    }

    fn untranslated(self, description: &Description, e: &Untranslated) -> Error {
        Error::run(format!("scene `{}` cannot be written in {}: {e}", description.name, self.title()))
            .help("another name in the scene may do; `--language rust` always works")
    }
}
