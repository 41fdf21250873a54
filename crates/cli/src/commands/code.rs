//! `qrm code`

use std::path::PathBuf;

use anstyle::{AnsiColor, Style};
use clap::Args;
use clap::builder::{PossibleValue, PossibleValuesParser, TypedValueParser};
use qrm_core::Model;
use qrm_language::{Code, File, LANGUAGES, Language, Untranslated, rust};
use qrm_scene::names::suggestion;
use qrm_scene::resolve;
use qrm_sim::position::{Start, assemble};
use qrm_sim::solve::constraint_rank;
use ra_ap_rustc_lexer::{FrontmatterAllowed, LiteralKind, TokenKind, tokenize};

use crate::error::{Error, Message};
use crate::options::SceneName;
use crate::output::{print, save_all, written};

#[derive(Args)]
pub(crate) struct Options {
    #[command(flatten)]
    scene: SceneName,
    /// A function such as `com_jacobian`, or its symbol: `T`, `C_q`, `Mbar`
    function: Option<String>,
    /// Language of the code
    #[arg(long, value_parser = language_parser(), default_value = "rust")]
    language: &'static Language,
    /// Folder for the files, which are printed without it
    #[arg(long, value_name = "DIR", conflicts_with = "function")]
    out: Option<PathBuf>,
}

/// Reads the name of a language.
fn language_parser() -> impl TypedValueParser<Value = &'static Language> {
    let names = LANGUAGES.iter().map(|language| PossibleValue::new(language.name).help(language.doc));
    PossibleValuesParser::new(names).map(|name| {
        LANGUAGES.iter().find(|language| language.name == name).unwrap_or_else(|| unreachable!("one of the names"))
    })
}

/// Prints the generated code of a scene, or a part of it, or writes it into files.
pub(crate) fn run(models: &'static [Model], options: &Options) -> Result<(), Error> {
    let Options { scene, function, language, out } = options;
    let found = scene.find(models)?;
    let (model, source) = (found.model, found.model.description.source);
    let (resolved, _) = resolve::read(&found.path, source)?;
    let code = Code { path: &found.path, scene: &resolved, source, tape: model.named_tape() };
    let untranslated = |e: Untranslated| {
        Error::run(format!("scene `{}` cannot be written in {}: {e}", code.scene.name, language.title))
            .help("another name in the scene may do; `--language rust` always works")
    };
    if let Some(name) = function {
        if let Some(text) = (language.write_part)(&code, name).map_err(untranslated)? {
            show(language, &text);
            return Ok(());
        }
        let files = (language.write)(&code).map_err(untranslated)?;
        let call = format!("{}_{name}(", code.name());
        let is_called = language.name != "rust" && files.iter().any(|file| file.text.contains(&call));
        return Err(match is_called || rust::part(&code, name).is_some() {
            true => not_by_itself(&scene.scene, name, language),
            false => unknown(&code, &scene.scene, name),
        });
    }
    let files = (language.write)(&code).map_err(untranslated)?;
    match out {
        Some(folder) => {
            let files: Vec<(PathBuf, String)> =
                files.into_iter().map(|file| (folder.join(file.name), file.text)).collect();
            save_all(&files)?;
            let paths: Vec<String> = files.iter().map(|(path, _)| path.display().to_string()).collect();
            let mut text = written(&paths);
            if !language.takes_repeated_constraints
                && let Some(warning) = repeated(model)
            {
                text += &format!("\n\n{}", warning.warning());
            }
            print(&text);
        }
        None => show(language, &listing(language, &files)),
    }
    Ok(())
}

/// All files in one text, each after a line with its name if there are several.
fn listing(language: &Language, files: &[File]) -> String {
    let file = |file: &File| match files.len() {
        1 => file.text.clone(),
        _ => format!("{} {}\n\n{}", language.comment, file.name, file.text),
    };
    files.iter().map(file).collect::<Vec<_>>().join("\n")
}

/// A warning if some constraints are redundant.
fn repeated(model: &Model) -> Option<Message> {
    let mechanism = model.mechanism(&|_| None);
    let (q, _) = assemble(&*mechanism, Start::new(&*mechanism)).ok()?;
    let (rank, count) = (constraint_rank(&*mechanism, 0.0, &q), model.description.constraints.len());
    (rank < count).then(|| {
        Message::new(format!(
            "C_q has rank {rank} with {count} constraints: their multipliers are NAN, and no step is good"
        ))
        .help(
            "take the constraints out that follow from the others, or translate to MATLAB, which has the multipliers \
             of least norm",
        )
    })
}

fn not_by_itself(scene: &str, name: &str, language: &Language) -> Error {
    let text = format!("`{name}` of scene `{scene}` is not printed alone in {}", language.title);
    Error::usage(text).help(format!("`qrm code {scene} --language {}` prints all of it", language.name))
}

/// Prints code, with colours if it is Rust on a terminal.
fn show(language: &Language, code: &str) {
    let code = code.trim_end();
    print(&match anstream::AutoStream::choice(&std::io::stdout()) {
        anstream::ColorChoice::Always | anstream::ColorChoice::AlwaysAnsi if language.name == "rust" => {
            highlighted(code)
        }
        _ => code.to_owned(),
    });
}

/// The names of matrices that large trees do not have, and the functions for their products with the rates.
const IN_LARGE_TREES: [(&[&str], &str); 2] =
    [(&["T", "com_jacobian"], "com_velocities"), (&["Mbar", "mass_matrix", "dynamics"], "momenta")];

fn unknown(code: &Code, scene: &str, name: &str) -> Error {
    let [names, symbols] = rust::names(code);
    let all = names.iter().chain(&symbols).map(String::as_str);
    // A name may be abbreviated to its beginning.
    let begins = names.iter().find(|other| name.len() > 2 && other.starts_with(name));
    let instead =
        IN_LARGE_TREES.iter().find(|(matrix, instead)| matrix.contains(&name) && code.tape.function(instead).is_some());
    let help = match begins {
        _ if let Some((_, instead)) = instead => format!("a large tree has the function `{instead}` in its place"),
        Some(other) => format!("did you mean `{other}`?"),
        None => suggestion(name, all, || format!("there are: {}", names.join(", "))),
    };
    Error::usage(format!("the code of scene `{scene}` has no part `{name}`")).help(help)
}

/// The code with colours for a terminal.
fn highlighted(code: &str) -> String {
    let mut text = String::new();
    let mut place = 0;
    for token in tokenize(code, FrontmatterAllowed::No) {
        let end = place + token.len as usize;
        let word = &code[place..end];
        let style = style(token.kind, word, &code[end..]);
        text += &format!("{style}{word}{style:#}");
        place = end;
    }
    text
}

const KEYWORDS: [&str; 15] =
    ["as", "const", "fn", "for", "impl", "in", "let", "mut", "pub", "ref", "return", "self", "Self", "struct", "use"];

fn style(kind: TokenKind, word: &str, rest: &str) -> Style {
    let colour = |colour: AnsiColor| Style::new().fg_color(Some(colour.into()));
    match kind {
        TokenKind::LineComment { .. } | TokenKind::BlockComment { .. } => colour(AnsiColor::BrightBlack),
        TokenKind::Literal { kind: LiteralKind::Int { .. } | LiteralKind::Float { .. }, .. } => colour(AnsiColor::Cyan),
        TokenKind::Literal { .. } => colour(AnsiColor::Green),
        TokenKind::Lifetime { .. } => colour(AnsiColor::Yellow),
        TokenKind::Ident if KEYWORDS.contains(&word) => colour(AnsiColor::Magenta),
        TokenKind::Ident if word.starts_with(|c: char| c.is_uppercase()) && word.len() == 1 => {
            colour(AnsiColor::Yellow)
        }
        TokenKind::Ident if word.starts_with(|c: char| c.is_uppercase()) && word.chars().any(char::is_lowercase) => {
            colour(AnsiColor::Yellow)
        }
        TokenKind::Ident if rest.starts_with(['(', '!']) => colour(AnsiColor::Blue),
        TokenKind::Ident if rest.starts_with('<') => colour(AnsiColor::Blue),
        _ => Style::new(),
    }
}
