//! `qrm code`

use anstyle::{AnsiColor, Style};
use clap::Args;
use qrm_scene::names::suggestion;
use qrm_core::Model;
use ra_ap_rustc_lexer::{FrontmatterAllowed, LiteralKind, TokenKind, tokenize};
use syn::spanned::Spanned;

use crate::error::Error;
use crate::options::SceneName;
use crate::output::print;

#[derive(Args)]
pub(crate) struct Options {
    #[command(flatten)]
    scene: SceneName,
    /// A function such as `com_jacobian`, or its symbol: `T`, `C_q`, `Mbar`
    function: Option<String>,
}

/// Prints the generated code of a scene, or a part of it.
pub(crate) fn run(models: &'static [Model], options: &Options) -> Result<(), Error> {
    let code = options.scene.find(models)?.description.code;
    let shown = match &options.function {
        None => code.to_owned(),
        Some(name) => {
            let items = items(code)?;
            let wanted = items.iter().filter(|item| item.name == *name || item.aliases.contains(name));
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

/// An item of a module.
struct Item<'c> {
    /// Its name, or that of the type that it implements something for.
    name: String,
    /// Its symbols in the literature.
    aliases: Vec<String>,
    is_public: bool,
    /// Its lines, from its documentation on.
    text: &'c str,
}

/// The items of a module that have names.
fn items(code: &str) -> Result<Vec<Item<'_>>, Error> {
    let file = syn::parse_file(code).map_err(|e| Error::run(format!("the generated code cannot be parsed: {e}")))?;
    let item = |item: &syn::Item| {
        let (name, attributes, visibility) = match item {
            syn::Item::Fn(item) => (item.sig.ident.to_string(), &item.attrs, Some(&item.vis)),
            syn::Item::Struct(item) => (item.ident.to_string(), &item.attrs, Some(&item.vis)),
            syn::Item::Const(item) => (item.ident.to_string(), &item.attrs, Some(&item.vis)),
            syn::Item::Static(item) => (item.ident.to_string(), &item.attrs, Some(&item.vis)),
            syn::Item::Impl(item) => match &*item.self_ty {
                syn::Type::Path(path) => (path.path.segments.last()?.ident.to_string(), &item.attrs, None),
                _ => return None,
            },
            _ => return None,
        };
        Some(Item {
            name,
            aliases: attributes.iter().filter_map(alias).collect(),
            is_public: matches!(visibility, Some(syn::Visibility::Public(_))),
            text: &code[item.span().byte_range()],
        })
    };
    Ok(file.items.iter().filter_map(item).collect())
}

/// The symbol in `#[doc(alias = "...")]`.
fn alias(attribute: &syn::Attribute) -> Option<String> {
    let syn::Meta::List(list) = &attribute.meta else { return None };
    let pair: syn::MetaNameValue = list.parse_args().ok().filter(|_| attribute.path().is_ident("doc"))?;
    match (pair.path.is_ident("alias"), pair.value) {
        (true, syn::Expr::Lit(syn::ExprLit { lit: syn::Lit::Str(text), .. })) => Some(text.value()),
        _ => None,
    }
}

fn unknown(items: &[Item], scene: &str, name: &str) -> Error {
    let names: Vec<&str> = items.iter().filter(|item| item.is_public).map(|item| item.name.as_str()).collect();
    let symbols = items.iter().flat_map(|item| &item.aliases).map(String::as_str);
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
