//! The lines of an assembly as a tree. A line belongs to the last line before it that has fewer tabs.

use std::ops::Range;

use super::super::numbers::finite;
use super::super::plane::Vector;
use super::super::source::Source;
use crate::error::Error;

/// The lines of an assembly.
pub(in super::super) struct Tree<'t> {
    lines: Vec<Line<'t>>,
}

struct Line<'t> {
    text: &'t str,
    span: Range<usize>,
    depth: usize,
    /// The number of the first line that no longer belongs to this one.
    end: usize,
}

/// A line, with the lines that belong to it.
#[derive(Clone, Copy)]
pub(in super::super) struct Node<'t> {
    tree: &'t Tree<'t>,
    number: usize,
}

impl<'t> Tree<'t> {
    pub(super) fn read(text: &'t str) -> Self {
        let mut lines: Vec<Line> = Vec::new();
        let mut open: Vec<usize> = Vec::new();
        let mut at = 0;
        for line in text.split('\n') {
            let depth = line.chars().take_while(|c| *c == '\t').count();
            let own = line[depth..].trim_end();
            if !own.trim().is_empty() {
                let number = lines.len();
                while open.last().is_some_and(|above| lines[*above].depth >= depth) {
                    open.pop().into_iter().for_each(|above| lines[above].end = number);
                }
                lines.push(Line { text: own, span: at + depth..at + depth + own.len(), depth, end: 0 });
                open.push(number);
            }
            at += line.len() + 1;
        }
        let end = lines.len();
        open.into_iter().for_each(|above| lines[above].end = end);
        Self { lines }
    }

    pub(super) fn roots(&'t self) -> impl Iterator<Item = Node<'t>> {
        self.siblings(0, self.lines.len())
    }

    /// The last line.
    pub(super) fn last(&'t self) -> Option<Node<'t>> {
        self.lines.len().checked_sub(1).map(|number| Node { tree: self, number })
    }

    fn siblings(&'t self, from: usize, to: usize) -> impl Iterator<Item = Node<'t>> {
        let first = (from < to).then_some(from);
        let next = move |number: &usize| Some(self.lines[*number].end).filter(|end| *end < to);
        std::iter::successors(first, next).map(|number| Node { tree: self, number })
    }
}

impl<'t> Node<'t> {
    fn line(&self) -> &'t Line<'t> {
        &self.tree.lines[self.number]
    }

    pub(super) fn text(&self) -> &'t str {
        self.line().text
    }

    pub(super) fn span(&self) -> Range<usize> {
        self.line().span.clone()
    }

    pub(super) fn children(&self) -> impl Iterator<Item = Node<'t>> + use<'t> {
        self.tree.siblings(self.number + 1, self.line().end)
    }

    pub(super) fn child(&self, text: &str) -> Option<Node<'t>> {
        self.children().find(|node| node.text() == text)
    }

    pub(super) fn first(&self) -> Option<Node<'t>> {
        self.children().next()
    }

    /// The first text below a key.
    pub(super) fn value(&self, key: &str) -> Option<&'t str> {
        self.child(key).and_then(|node| node.first()).map(|node| node.text().trim())
    }

    pub(super) fn name(&self) -> &'t str {
        self.value("Name").unwrap_or_default()
    }

    /// The numbers of a line.
    fn numbers(&self, source: &Source, count: usize) -> Result<Vec<f64>, Error> {
        let read = |word: &str| smalltalk_number(word).filter(|value| value.abs() < 1e100);
        let numbers: Option<Vec<f64>> = self.text().split_whitespace().map(read).collect();
        numbers.filter(|numbers| numbers.len() == count).ok_or_else(|| {
            let many = if count == 1 { "one finite number".to_owned() } else { format!("{count} finite numbers") };
            let title = format!("this line should have {many}");
            source.error(title, self.span(), "cannot be read", "export the assembly again")
        })
    }

    pub(super) fn number(&self, source: &Source) -> Result<f64, Error> {
        Ok(self.numbers(source, 1)?[0])
    }

    pub(super) fn vector(&self, source: &Source) -> Result<Vector, Error> {
        let numbers = self.numbers(source, 3)?;
        Ok([numbers[0], numbers[1], numbers[2]])
    }
}

/// Reads a number of Smalltalk, which may end with `d`, or have this letter before its exponent.
pub(super) fn smalltalk_number(text: &str) -> Option<f64> {
    match text.strip_suffix('d') {
        Some(plain) if !plain.contains('d') => finite(plain),
        Some(_) => None,
        None => finite(&text.replacen('d', "e", 1)),
    }
}
