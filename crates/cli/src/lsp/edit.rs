//! Definitions, references and renaming.

use std::ops::Range;

use qrm_scene::document::Document;
use qrm_scene::resolve;
use serde_json::{Value, json};

use super::declaration::{Declaration, declarations, stem};
use super::place::Within;
use super::text::Text;
use crate::keys::section;

/// The places where the name at a byte is declared.
pub(super) fn definitions(text: &Text, byte: usize) -> Vec<Range<usize>> {
    let declarations = declarations(&text.source);
    let Some(name) = stem(&text.source[text.word(byte)], &declarations) else { return Vec::new() };
    declarations
        .iter()
        .filter(|declaration| declaration.name == name)
        .map(|declaration| declaration.span.clone())
        .collect()
}

/// The places where the name at a byte occurs, alone or in a longer word.
pub(super) fn references(text: &Text, byte: usize) -> Vec<Range<usize>> {
    let declarations = declarations(&text.source);
    let Some(name) = stem(&text.source[text.word(byte)], &declarations) else { return Vec::new() };
    let values = values(&text.source);
    let is_name = |word: &Range<usize>| !is_key(text, word, &declarations, &values);
    let words = text.identifiers().into_iter().filter(is_name);
    words.filter_map(|word| occurrence(&text.source, word, name, &declarations)).collect()
}

/// The part of a word that is the name.
fn occurrence(source: &str, word: Range<usize>, name: &str, declarations: &[Declaration]) -> Option<Range<usize>> {
    if stem(&source[word.clone()], declarations)? != name {
        return None;
    }
    let begin = word.start + source[word].find(name)?;
    Some(begin..begin + name.len())
}

/// Whether a word is a key and not a name.
fn is_key(text: &Text, word: &Range<usize>, declarations: &[Declaration], values: &[Range<usize>]) -> bool {
    let place = text.place(word.start);
    let is_name = |span: &Range<usize>| span.start <= word.start && word.end <= span.end;
    match place.within {
        Within::Header => true,
        Within::LineKey | Within::InlineKey => {
            let is_known = section(place.section)
                .is_some_and(|section| section.keys.iter().any(|key| key.name == &text.source[word.clone()]));
            let is_declared = declarations.iter().any(|declaration| is_name(&declaration.span));
            !is_declared && !values.iter().any(is_name) && is_known
        }
        _ => false,
    }
}

/// Names that stand as keys in `given`, `solve` and the like.
fn values(source: &str) -> Vec<Range<usize>> {
    let (document, _) = Document::parse(source);
    document.given.iter().chain(&document.solve).map(|(name, _)| name.span.clone()).collect()
}

/// The edits that give the name at a byte another name.
///
/// # Errors
/// There is no name, or the scene would have mistakes with the new one.
pub(super) fn rename(text: &Text, path: &str, byte: usize, new: &str) -> Result<Vec<Value>, String> {
    let places = references(text, byte);
    if places.is_empty() {
        return Err("no name of the scene stands here".to_owned());
    }
    let mut source = text.source.clone();
    for place in places.iter().rev() {
        source.replace_range(place.clone(), new);
    }
    let mistakes = |source: &str| match resolve::read(path, source) {
        Ok(_) => Vec::new(),
        Err(report) => report.diagnostics.iter().map(|found| found.title.clone()).collect(),
    };
    let before = mistakes(&text.source).len();
    match &mistakes(&source)[..] {
        [first, ..] if before == 0 => Err(format!("`{new}` does not fit: {first}")),
        after if after.len() > before => Err(format!("`{new}` adds mistakes to the scene")),
        _ => Ok(places.iter().map(|place| json!({ "range": text.range(place), "newText": new })).collect()),
    }
}
