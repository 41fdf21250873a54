//! The items of a generated module, by its tokens. They are written by the generator: visibility is `pub` or none, an
//! attribute has one alias.

use ra_ap_rustc_lexer::{DocStyle, FrontmatterAllowed, LiteralKind, TokenKind, tokenize};

/// An item of a module.
#[derive(Default)]
pub(super) struct Item<'c> {
    /// Its name, or that of the type that it implements something for.
    pub(super) name: &'c str,
    /// Its symbols in the literature, from `#[doc(alias = "...")]`.
    pub(super) aliases: Vec<&'c str>,
    pub(super) is_public: bool,
    /// Its lines, from its documentation on.
    pub(super) text: &'c str,
}

/// The items of a module that have names.
pub(super) fn items(code: &str) -> Vec<Item<'_>> {
    let mut items = Vec::new();
    let mut open = Open::default();
    let mut start = 0;
    let mut end = 0;
    for token in tokenize(code, FrontmatterAllowed::No) {
        let place = end;
        end += token.len as usize;
        if matches!(
            token.kind,
            TokenKind::Whitespace
                | TokenKind::LineComment { doc_style: None | Some(DocStyle::Inner) }
                | TokenKind::BlockComment { doc_style: None | Some(DocStyle::Inner), .. }
        ) {
            continue;
        }
        if open.is_new() {
            start = place;
        }
        if open.ends_with(token.kind, &code[place..end]) {
            let mut item = std::mem::take(&mut open).item;
            item.text = &code[start..end];
            items.extend(Some(item).filter(|item| !item.name.is_empty()));
        }
    }
    items
}

/// An item up to the token that is read.
#[derive(Default)]
struct Open<'c> {
    item: Item<'c>,
    /// `fn`, `struct`, `impl` and so on.
    keyword: &'c str,
    /// How many parentheses, brackets and braces are open.
    depth: usize,
    /// How many angle brackets are open in the head of an implementation.
    angles: usize,
    has_tokens: bool,
    follows_alias: bool,
    has_head: bool,
}

impl<'c> Open<'c> {
    fn is_new(&self) -> bool {
        !self.has_tokens
    }

    /// Takes the next token; `true` if it is the last of the item.
    fn ends_with(&mut self, kind: TokenKind, word: &'c str) -> bool {
        self.has_tokens = true;
        match kind {
            TokenKind::OpenBrace | TokenKind::OpenBracket | TokenKind::OpenParen => {
                self.has_head |= kind == TokenKind::OpenBrace;
                self.depth += 1;
            }
            TokenKind::CloseBrace | TokenKind::CloseBracket | TokenKind::CloseParen => {
                self.depth = self.depth.saturating_sub(1);
                // The value of a constant may end with a brace; what follows is a semicolon.
                let is_block = kind == TokenKind::CloseBrace && !matches!(self.keyword, "const" | "static" | "use");
                return self.depth == 0 && is_block;
            }
            TokenKind::Semi => return self.depth == 0,
            TokenKind::Ident if self.keyword.is_empty() && self.depth > 0 => self.follows_alias |= word == "alias",
            TokenKind::Literal { kind: LiteralKind::Str { .. }, .. } if std::mem::take(&mut self.follows_alias) => {
                self.item.aliases.push(word.trim_matches('"'));
            }
            TokenKind::Ident if !self.has_head && self.depth == 0 => self.head(word),
            TokenKind::Lt => self.angles += 1,
            TokenKind::Gt => self.angles = self.angles.saturating_sub(1),
            _ => (),
        }
        false
    }

    /// Takes a word between the attributes and the body of the item.
    fn head(&mut self, word: &'c str) {
        match (self.keyword, word) {
            ("", "pub") => self.item.is_public = true,
            ("" | "const", "fn") | ("", "const" | "static" | "struct" | "impl" | "use") => self.keyword = word,
            // The type stands last in the head of an implementation.
            ("impl", "where") => self.has_head = true,
            ("impl", _) if self.angles == 0 => self.item.name = word,
            ("fn" | "struct" | "const" | "static", _) if self.item.name.is_empty() => self.item.name = word,
            _ => (),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::items;

    #[test]
    fn items_are_found_with_names_aliases_and_lines() {
        let code = r##"// A file.
//! Its text.
use a::{b, c};

/// A matrix `{`.
#[doc(alias = "T")]
pub fn matrix<R: Scalar>(
    m: &[R; 2],
) -> [R; 2] {
    if a < b { x } else { "}" }
}

impl<R: Scalar> Kernel<R, 2> for Model<R>
where
    R: Copy,
{
    const fn name() {}
}

pub const D: D = D {
    code: "a;",
};

struct Model<R>(R);
"##;
        let found = items(code);
        let names: Vec<&str> = found.iter().map(|item| item.name).collect();
        assert_eq!(names, ["matrix", "Model", "D", "Model"]);
        assert_eq!(found[0].aliases, ["T"]);
        assert_eq!(found.iter().map(|item| item.is_public).collect::<Vec<_>>(), [true, false, true, false]);
        assert!(found[0].text.starts_with("/// A matrix") && found[0].text.ends_with("}\n}"));
        assert!(found[2].text.ends_with("};") && found[3].text.ends_with("(R);"));
        let rest = found.iter().fold(code.to_owned(), |rest, item| rest.replacen(item.text, "", 1));
        assert_eq!(rest.split_whitespace().collect::<Vec<_>>().join(" "), "// A file. //! Its text. use a::{b, c};");
    }
}
