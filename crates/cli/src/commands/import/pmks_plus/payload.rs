//! The content of a link of PMKS+: records between dots, tokens between commas.

mod integrity;

use std::ops::Range;

use super::super::source::Source;
use crate::error::Error;

/// A mechanism, in SI units.
pub(in super::super) struct Payload {
    pub(super) joints: Vec<Joint>,
    pub(super) links: Vec<Link>,
    pub(super) forces: Vec<Force>,
    pub(super) has_gravity: bool,
    pub(super) units: &'static str,
}

/// A joint.
pub(super) struct Joint {
    pub(super) id: String,
    pub(super) name: String,
    pub(super) place: [f64; 2],
    pub(super) angle: f64,
    pub(super) is_slider: bool,
    pub(super) is_input: bool,
    pub(super) is_grounded: bool,
    pub(super) is_welded: bool,
    pub(super) is_traced: bool,
    /// The link with a slot, and two joints on its line.
    pub(super) slot: Option<[String; 3]>,
    /// The speed as an input: turns a minute of a pin, m/s of a slider.
    pub(super) speed: f64,
    pub(super) span: Range<usize>,
}

/// A link.
pub(super) struct Link {
    pub(super) id: String,
    pub(super) name: String,
    pub(super) is_root: bool,
    /// A block between a pin and a slider.
    pub(super) is_block: bool,
    pub(super) mass: f64,
    pub(super) inertia: f64,
    pub(super) com: [f64; 2],
    pub(super) joints: Vec<String>,
    pub(super) parts: Vec<String>,
    pub(super) span: Range<usize>,
}

/// A force at a place of a link.
pub(super) struct Force {
    pub(super) name: String,
    pub(super) link: String,
    pub(super) at: [f64; 2],
    pub(super) components: [f64; 2],
    pub(super) is_local: bool,
    pub(super) span: Range<usize>,
}

/// The help for a link that is not whole.
const COPY_AGAIN: &str = "copy the whole link again, from PMKS+";

/// The largest number of records.
const MAX_RECORDS: usize = 1000;

/// The range of the records in a text.
fn bounds(text: &str) -> Range<usize> {
    // A link in a text may be in brackets or quotes.
    let line = text.trim().trim_end_matches([')', ']', '>', '"', '\'']);
    let begin = text.len() - text.trim_start().len();
    let own = line.rfind(['?', '=']).map_or(0, |at| at + 1);
    begin + own..begin + line.len()
}

/// Whether a text is a link of PMKS+.
pub(in super::super) fn recognizes(text: &str) -> bool {
    let records: Vec<&str> = text[bounds(text)].split('.').take(5).collect();
    let is_number = |text: &str| !text.is_empty() && text.chars().all(|c| digit(c).is_some() || c == ',');
    let is_one_line = !text.trim().contains('\n');
    is_one_line
        && records.len() == 5
        && records[..4].iter().all(|record| is_number(record))
        && records[4].matches(',').count() >= 4
}

impl Payload {
    pub(super) fn read(source: &Source) -> Result<Self, Error> {
        let bounds = bounds(&source.text);
        integrity::check_length(source, bounds.clone())?;
        let mut records = Vec::new();
        let mut at = bounds.start;
        for text in source.text[bounds].split('.') {
            records.push(Record { source, text, span: at..at + text.len() });
            at += text.len() + 1;
        }
        if records.len() > MAX_RECORDS {
            return Err(source.whole("the mechanism has more than 1000 parts", "split the mechanism"));
        }
        let flags = records[0].number_of(records[0].text, true)?;
        let settings = [1, 2].map(|number| records[number].clone());
        let speed = settings[1].token(0).map_or(Ok(20.0), |token| settings[1].number_of(token, false))?;
        let linear = settings[0].token(1).map_or(Ok(5000.0), |token| settings[0].number_of(token, false))? / 1000.0;
        let units = Units::read(&records[3])?;
        let sense = if flags as u64 & 1 == 1 { -1.0 } else { 1.0 };
        let linear = if linear == 0.0 { 5.0 } else { linear };
        let mut rest = records[4..].iter();
        let mut section = || -> Vec<&Record> { rest.by_ref().take_while(|record| !record.text.is_empty()).collect() };
        let joints = section()
            .into_iter()
            .map(|record| record.joint(&units, sense * speed, linear))
            .collect::<Result<_, _>>()?;
        let links = section().into_iter().map(|record| record.link(&units)).collect::<Result<_, _>>()?;
        let forces = section().into_iter().map(|record| record.force(&units)).collect::<Result<_, _>>()?;
        let own = Self { joints, links, forces, has_gravity: flags as u64 >> 8 & 1 == 0, units: units.text };
        own.check_identifiers(source)?;
        Ok(own)
    }

    pub(super) fn joint(&self, id: &str) -> Option<&Joint> {
        self.joints.iter().find(|joint| joint.id == id)
    }
}

/// The units of a mechanism.
struct Units {
    length: f64,
    mass: f64,
    inertia: f64,
    force: f64,
    text: &'static str,
}

impl Units {
    fn read(record: &Record) -> Result<Self, Error> {
        let choice = |at: usize| record.text.chars().nth(at).and_then(digit);
        let force = if choice(2) == Some(0) { 4.448_221_615_260_5 } else { 1.0 };
        let pound = 0.453_592_37;
        Ok(match choice(0) {
            Some(0) => {
                let inertia = pound * 0.0254 * 0.0254;
                Self { length: 0.0254, mass: pound, inertia, force, text: "in, lb and lb in^2" }
            }
            Some(1) => Self { length: 0.01, mass: 1e-3, inertia: 1e-4, force, text: "cm, g and kg cm^2" },
            Some(2) => Self { length: 1.0, mass: 1.0, inertia: 1.0, force, text: "m, kg and kg m^2" },
            _ => return Err(record.error("the unit of length is not known")),
        })
    }
}

/// The value of a digit in the base 64.
fn digit(c: char) -> Option<u32> {
    match c {
        '0'..='9' => Some(c as u32 - '0' as u32),
        'A'..='Z' => Some(c as u32 - 'A' as u32 + 10),
        'a'..='z' => Some(c as u32 - 'a' as u32 + 36),
        '_' => Some(62),
        '-' => Some(63),
        _ => None,
    }
}

/// A record: a text between dots.
#[derive(Clone)]
struct Record<'s> {
    source: &'s Source,
    text: &'s str,
    span: Range<usize>,
}

impl Record<'_> {
    fn error(&self, title: &str) -> Error {
        self.source.error(title, self.span.clone(), "", COPY_AGAIN)
    }

    fn token(&self, number: usize) -> Option<&str> {
        self.text.split(',').nth(number).filter(|token| !token.is_empty())
    }

    /// Reads a whole number. A zero before other digits is a minus sign.
    fn number_of(&self, text: &str, is_positive: bool) -> Result<f64, Error> {
        let (sign, digits) = match text.strip_prefix('0') {
            Some(digits) if !is_positive => (-1.0, digits),
            _ => (1.0, text),
        };
        if digits.len() > 8 {
            return Err(self.error("this record has a number that is too large"));
        }
        let value = digits.chars().try_fold(0.0, |value, c| Some(64.0 * value + f64::from(digit(c)?)));
        value
            .map(|value| if value == 0.0 { 0.0 } else { sign * value })
            .ok_or_else(|| self.error("this record has a number that cannot be read"))
    }

    /// Reads a number that is given in thousandths.
    fn decimal(&self, number: usize) -> Result<f64, Error> {
        Ok(self.token(number).map_or(Ok(0.0), |token| self.number_of(token, false))? / 1000.0)
    }

    fn place(&self, first: usize, units: &Units) -> Result<[f64; 2], Error> {
        Ok([self.decimal(first)? * units.length, self.decimal(first + 1)? * units.length])
    }

    /// The flags at the begin of the record, of this length, and the identifier behind them.
    fn head(&self, length: usize) -> Result<(&str, String), Error> {
        let token = self.token(0).ok_or_else(|| self.error("this record is empty"))?;
        match token.get(..length).zip(token.get(length..)) {
            Some((flags, id)) if !id.is_empty() => Ok((flags, id.to_owned())),
            _ => Err(self.error("this record has no identifier")),
        }
    }

    fn name(&self, id: &str) -> String {
        self.token(1).unwrap_or(id).replace("%20", " ")
    }

    fn joint(&self, units: &Units, speed: f64, linear: f64) -> Result<Joint, Error> {
        self.check_fields(2..5)?;
        let (flags, id) = self.head(1)?;
        let flags =
            flags.chars().next().and_then(digit).ok_or_else(|| self.error("the flags of this joint cannot be read"))?;
        let is = |bit: u32| flags >> bit & 1 == 1;
        let slot = [5, 6, 7].map(|number| self.token(number).map(str::to_owned));
        let slot = match slot {
            [Some(carrier), Some(a), Some(b)] => Some([carrier, a, b]),
            [None, None, None] => None,
            _ => return Err(self.error("the slot of this joint needs a link and two joints")),
        };
        let (general, scale) = if is(0) { (linear, units.length) } else { (speed, 1.0) };
        let own = self.decimal(8)?;
        let speed = if own == 0.0 { general } else { own } * scale;
        Ok(Joint {
            name: self.name(&id),
            id,
            place: self.place(2, units)?,
            angle: self.decimal(4)?,
            is_slider: is(0),
            is_input: is(1),
            is_grounded: is(2),
            is_welded: is(3),
            is_traced: is(4),
            slot,
            speed,
            span: self.span.clone(),
        })
    }

    fn link(&self, units: &Units) -> Result<Link, Error> {
        self.check_fields(2..6)?;
        let (flags, id) = self.head(2)?;
        let (root, kind) = flags.split_at(1);
        if !"YAMGNamg01234567".contains(root) || !["R", "P"].contains(&kind) {
            return Err(self.error("the kind of this link is not known"));
        }
        let [mass, inertia] = [self.decimal(2)? * units.mass, self.decimal(3)? * units.inertia];
        if mass < 0.0 || inertia < 0.0 {
            return Err(self.error("the mass of this link is negative"));
        }
        let tokens: Vec<String> = self.text.split(',').skip(7).map(str::to_owned).collect();
        if !tokens.contains(&String::new()) {
            return Err(self.error("the list of joints of this link has no end"));
        }
        let mut lists = tokens.split(String::is_empty);
        let mut list = || lists.next().unwrap_or_default().to_vec();
        let name = self.name(&id);
        let (joints, parts) = (list(), list());
        let is_root = "YAMG0123".contains(root);
        let (com, span) = (self.place(4, units)?, self.span.clone());
        Ok(Link { id, name, is_root, is_block: kind == "P", mass, inertia, com, joints, parts, span })
    }

    fn force(&self, units: &Units) -> Result<Force, Error> {
        self.check_fields(3..8)?;
        let (flags, id) = self.head(1)?;
        let flags =
            flags.chars().next().and_then(digit).ok_or_else(|| self.error("the flags of this force cannot be read"))?;
        let link = self.token(1).ok_or_else(|| self.error("this force has no link"))?.to_owned();
        let name = self.token(2).unwrap_or(&id).to_owned();
        let [start, end] = [self.place(3, units)?, self.place(5, units)?];
        let [x, y] = [end[0] - start[0], end[1] - start[1]];
        let length = x.hypot(y);
        if length == 0.0 {
            return Err(self.error("this force has no direction"));
        }
        // An arrow outward points away from its place.
        let sign = if flags >> 1 & 1 == 1 { 1.0 } else { -1.0 };
        let size = sign * self.decimal(7)? * units.force / length;
        let components = [x * size, y * size];
        Ok(Force { name, link, at: start, components, is_local: flags & 1 == 1, span: self.span.clone() })
    }
}
