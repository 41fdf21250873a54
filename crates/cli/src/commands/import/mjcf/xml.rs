//! The elements of an XML text, with their places.

use std::ops::Range;

use quick_xml::events::{BytesStart, Event};
use quick_xml::{Reader, XmlVersion};

use super::super::source::Source;
use crate::error::Error;

/// The elements of a text.
pub(super) struct Xml<'s> {
    pub(super) source: &'s Source,
    elements: Vec<Element>,
}

/// An element: its attributes, and the elements in it.
pub(super) struct Element {
    pub(super) name: String,
    /// The place of its start tag.
    pub(super) span: Range<usize>,
    pub(super) attributes: Vec<(String, String)>,
    children: Vec<usize>,
}

/// The largest depth of elements; models have about 30.
const MAX_DEPTH: usize = 200;

/// The largest number of elements.
const MAX_ELEMENTS: usize = 200_000;

impl<'s> Xml<'s> {
    pub(super) fn read(source: &'s Source) -> Result<Self, Error> {
        let mut reader = Reader::from_str(&source.text);
        reader.config_mut().check_end_names = true;
        let mut xml = Self { source, elements: Vec::new() };
        let mut open: Vec<usize> = Vec::new();
        loop {
            let begin = position(&reader);
            let event = reader.read_event().map_err(|e| {
                let at = usize::try_from(reader.error_position()).unwrap_or(begin);
                source.error(
                    format!("this is not valid XML: {e}"),
                    at..at + 1,
                    "",
                    "close every element and every quote",
                )
            })?;
            let span = begin..position(&reader);
            match event {
                Event::Start(start) => {
                    let number = xml.add(&start, span.clone(), &open)?;
                    open.push(number);
                    if open.len() > MAX_DEPTH {
                        let help = format!("use at most {MAX_DEPTH} levels");
                        return Err(source.error("elements are nested too deeply", span, "", help));
                    }
                }
                Event::Empty(start) => {
                    xml.add(&start, span, &open)?;
                }
                Event::End(_) => {
                    open.pop();
                }
                Event::DocType(_) => {
                    return Err(source.error("a model has no document type", span, "", "leave this declaration out"));
                }
                Event::Eof => break,
                _ => {}
            }
        }
        match (open.last(), xml.elements.first()) {
            (Some(last), _) => {
                let Element { name, span, .. } = &xml.elements[*last];
                let title = format!("`<{name}>` is not closed");
                Err(source.error(title, span.clone(), "opened here", format!("write `</{name}>`")))
            }
            (None, None) => Err(source.whole("it has no elements", "choose the file of a model")),
            _ => Ok(xml),
        }
    }

    fn add(&mut self, start: &BytesStart, span: Range<usize>, open: &[usize]) -> Result<usize, Error> {
        let wrong = |e: &dyn std::fmt::Display| {
            let help = "write attributes as `name=\"value\"`, each once";
            self.source.error(format!("the attributes of this element cannot be read: {e}"), span.clone(), "", help)
        };
        let mut attributes = Vec::new();
        for attribute in start.attributes() {
            let attribute = attribute.map_err(|e| wrong(&e))?;
            let value = attribute.normalized_value(XmlVersion::Implicit1_0).map_err(|e| wrong(&e))?;
            attributes.push((attribute.key.as_ref().to_owned(), value.into_owned()));
        }
        let number = self.elements.len();
        let name = start.name().as_ref().to_owned();
        let is_first = open.is_empty() && number > 0;
        if is_first || number >= MAX_ELEMENTS {
            let title = if is_first {
                "a model has one element that contains all others"
            } else {
                "the model has too many elements"
            };
            return Err(self.source.error(title, span, "one too many", "write one `<mujoco>` of a moderate size"));
        }
        self.elements.push(Element { name, span, attributes, children: Vec::new() });
        if let Some(above) = open.last() {
            self.elements[*above].children.push(number);
        }
        Ok(number)
    }

    pub(super) fn root(&self) -> &Element {
        &self.elements[0]
    }

    pub(super) fn children<'x>(&'x self, element: &'x Element) -> impl Iterator<Item = &'x Element> {
        element.children.iter().map(|number| &self.elements[*number])
    }

    /// The elements of the sections of a name; a section may be there more than once.
    pub(super) fn section<'x>(&'x self, name: &'x str) -> impl Iterator<Item = &'x Element> {
        self.children(self.root())
            .filter(move |section| section.name == name)
            .flat_map(|section| self.children(section))
    }

    /// The place of an attribute, or of its element.
    pub(super) fn place(&self, element: &Element, name: &str) -> Range<usize> {
        let tag = &self.source.text[element.span.clone()];
        let found = tag.match_indices(name).map(|(at, _)| at).find(|at| {
            let is_begin = tag[..*at].ends_with(|c: char| c.is_whitespace());
            is_begin && tag[at + name.len()..].trim_start().starts_with('=')
        });
        let Some(at) = found else { return element.span.start..element.span.start + 1 + element.name.len() };
        let start = element.span.start + at;
        let quoted = tag[at..].find(['"', '\'']).and_then(|open| {
            let quote = tag[at + open..].chars().next()?;
            Some(open + 2 + tag[at + open + 1..].find(quote)?)
        });
        start..start + quoted.unwrap_or(name.len())
    }

    /// An error at an attribute of an element, or at the element.
    pub(super) fn error(&self, element: &Element, attribute: &str, title: &str, help: &str) -> Error {
        self.source.error(title, self.place(element, attribute), "", help)
    }
}

impl Element {
    pub(super) fn get(&self, name: &str) -> Option<&str> {
        self.attributes.iter().find(|(own, _)| own == name).map(|(_, value)| value.as_str())
    }
}

fn position(reader: &Reader<&[u8]>) -> usize {
    usize::try_from(reader.buffer_position()).unwrap_or(usize::MAX)
}
