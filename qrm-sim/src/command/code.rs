//! `qrm code`

use anstyle::{AnsiColor, Style};
use qrm_scene::names::suggestion;
use ra_ap_rustc_lexer::{FrontmatterAllowed, LiteralKind, TokenKind, tokenize};

use super::arguments::CodeArguments;
use super::{Failure, settings};
use crate::scenes::Scenes;

/// Prints the generated code of a scene, or a part of it.
pub(super) fn code(scenes: &Scenes, arguments: &CodeArguments) -> Result<(), Failure> {
    let scene = settings::scene(scenes, &arguments.scene)?;
    let code = scene.description().code;
    let shown = match &arguments.function {
        None => code.to_owned(),
        Some(name) => part(code, name).ok_or_else(|| unknown(code, &arguments.scene, name))?,
    };
    super::say(&match anstream::AutoStream::choice(&std::io::stdout()) {
        anstream::ColorChoice::Never => shown.trim_end().to_owned(),
        _ => highlighted(shown.trim_end()),
    });
    Ok(())
}

/// The items that have this name, or this symbol in the literature.
fn part(code: &str, name: &str) -> Option<String> {
    let alias = format!("#[doc(alias = \"{name}\")]");
    let is_wanted = |item: &&str| named(item) == Some(name) || item.lines().any(|line| line == alias);
    let found: Vec<&str> = items(code).into_iter().filter(is_wanted).collect();
    (!found.is_empty()).then(|| found.join("\n\n"))
}

/// The items of a module; each begins where a line begins, after an empty one.
fn items(code: &str) -> Vec<&str> {
    let mut items = Vec::new();
    let mut start = 0;
    for (end, _) in code.match_indices("\n\n") {
        let next = end + 2;
        let ends_here = !code[next..].starts_with([' ', '}', '\n']);
        if ends_here && !code[start..end].contains("pub const SOURCE") {
            items.push(&code[start..end]);
            start = next;
        }
    }
    items.push(&code[start..]);
    items
}

/// The name of an item, or of the type that it implements something for.
fn named(item: &str) -> Option<&str> {
    let line = item.lines().find(|line| !line.starts_with(['/', '#']))?;
    let after = ["pub fn ", "pub struct ", "pub const "].iter().find_map(|lead| line.strip_prefix(lead));
    let name = match after {
        Some(rest) => rest,
        None => {
            let target = line.strip_prefix("impl")?.trim_end_matches(" {");
            let target = target.rsplit_once(" for ").map_or(target, |(_, target)| target);
            target.rsplit_once("> ").map_or(target, |(_, target)| target).trim()
        }
    };
    name.split(|c: char| !c.is_alphanumeric() && c != '_').next()
}

fn unknown(code: &str, scene: &str, name: &str) -> Failure {
    let functions = items(code).into_iter().filter(|item| item.lines().any(|line| line.starts_with("pub ")));
    let names: Vec<&str> = functions.filter_map(named).collect();
    let symbols = code.lines().filter_map(|line| line.strip_prefix("#[doc(alias = \"")?.strip_suffix("\")]"));
    let all = names.iter().copied().chain(symbols);
    // A name may be remembered by its beginning.
    let begins = names.iter().find(|other| name.len() > 2 && other.starts_with(name));
    let help = match begins {
        Some(other) => format!("did you mean `{other}`?"),
        None => suggestion(name, all, || format!("there are: {}", names.join(", "))),
    };
    Failure::Use(format!("error: the code of scene `{scene}` has no part `{name}`\n  = help: {help}"))
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
