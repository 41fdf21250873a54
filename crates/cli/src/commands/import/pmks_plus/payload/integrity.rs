//! Checks that a link of PMKS+ is whole.

use std::collections::BTreeSet;
use std::ops::Range;

use super::super::super::source::Source;
use super::{COPY_AGAIN, Payload, Record, digit};
use crate::error::Error;

/// The number of characters that the last character of a link may be.
const CHECKSUMS: usize = 62;

/// Checks the last character of a link: it is the length of the others.
pub(super) fn check_length(source: &Source, bounds: Range<usize>) -> Result<(), Error> {
    let text = &source.text[bounds.clone()];
    let shown = text.replace("%20", " ");
    // The link may have been written with or without signs for blanks.
    let is_whole = [text, &shown].into_iter().any(|text| {
        let count = text.encode_utf16().count();
        let last = text.chars().last().and_then(digit);
        last.and_then(|value| usize::try_from(value).ok()).is_some_and(|value| value == (count - 1) % CHECKSUMS)
    });
    if is_whole {
        return Ok(());
    }
    let end = bounds.end.saturating_sub(1)..bounds.end;
    let label = "this character does not fit the length of the link";
    Err(source.error("this link is not whole", end, label, COPY_AGAIN))
}

impl Record<'_> {
    /// Checks that the record has these fields.
    pub(super) fn check_fields(&self, mut fields: Range<usize>) -> Result<(), Error> {
        match fields.find(|field| self.token(*field).is_none()) {
            Some(_) => Err(self.error("this record has a number that is missing")),
            None => Ok(()),
        }
    }
}

impl Payload {
    /// Checks that identifiers are there once, and that the joints of links exist.
    pub(super) fn check_identifiers(&self, source: &Source) -> Result<(), Error> {
        let refuse = |title: String, span: &Range<usize>| Err(source.error(title, span.clone(), "", COPY_AGAIN));
        let mut joints = BTreeSet::new();
        for joint in &self.joints {
            if !joints.insert(joint.id.as_str()) {
                return refuse(format!("the joint `{}` is there twice", joint.id), &joint.span);
            }
        }
        let mut links = BTreeSet::new();
        for link in &self.links {
            if !links.insert(link.id.as_str()) {
                return refuse(format!("the link `{}` is there twice", link.id), &link.span);
            }
            if let Some(joint) = link.joints.iter().find(|joint| !joints.contains(joint.as_str())) {
                return refuse(format!("the link `{}` has a joint `{joint}`, which is missing", link.id), &link.span);
            }
        }
        Ok(())
    }
}
