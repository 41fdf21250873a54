//! `qrm code`

mod items;

use anstyle::{AnsiColor, Style};
use clap::Args;
use qrm_core::Model;
use qrm_scene::names::suggestion;
use ra_ap_rustc_lexer::{FrontmatterAllowed, LiteralKind, TokenKind, tokenize};

use crate::error::Error;
use crate::options::SceneName;
use crate::output::print;
use items::{Item, items};

#[derive(Args)]
pub(crate) struct Options {
    #[command(flatten)]
    scene: SceneName,
    /// A function such as `com_jacobian`, or its symbol: `T`, `C_q`, `Mbar`
    function: Option<String>,
}

/// Prints the generated code of a scene, or a part of it.
pub(crate) fn run(models: &'static [Model], options: &Options) -> Result<(), Error> {
    let code = options.scene.find(models)?.model.description.code;
    let shown = match &options.function {
        None => code.to_owned(),
        Some(name) => {
            let items = items(code);
            let wanted = items.iter().filter(|item| item.name == name || item.aliases.contains(&name.as_str()));
            let found: Vec<&str> = wanted.map(|item| item.text).collect();
            if found.is_empty() {
                return Err(unknown(&items, &options.scene.scene, name));
            }
            found.join("\n\n")
        }
    };
    print(&match anstream::AutoStream::choice(&std::io::stdout()) {
        anstream::ColorChoice::Never => shown.trim_end().to_owned(),
        _ => highlighted(shown.trim_end()),
    });
    Ok(())
}

fn unknown(items: &[Item], scene: &str, name: &str) -> Error {
    let names: Vec<&str> = items.iter().filter(|item| item.is_public).map(|item| item.name).collect();
    let symbols = items.iter().flat_map(|item| &item.aliases).copied();
    let all = names.iter().copied().chain(symbols);
    // A name may be remembered by its beginning.
    let begins = names.iter().find(|other| name.len() > 2 && other.starts_with(name));
    let help = match begins {
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
