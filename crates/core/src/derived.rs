//! A derived scene as data: the contents of a generated module without its compiled functions.

#[cfg(feature = "simd")]
use std::boxed::Box;
use std::string::String;
use std::vec::Vec;

#[cfg(feature = "simd")]
use crate::description::{Description, ParameterDescription, QuantityDescription};
use crate::digest::digest;
#[cfg(feature = "simd")]
use crate::model::Model;
use crate::named_tape::NamedTape;
#[cfg(feature = "simd")]
use crate::stored_tape::StoredTape;

/// The line that the deriving program prints while it waits for another derivation on this machine.
pub const WAITING: &str = "waiting for another derivation";
/// The line that the deriving program prints once it no longer waits.
pub const DERIVING: &str = "deriving";

/// A scene's names and functions as data.
#[derive(Clone, Debug, Default, serde::Serialize, serde::Deserialize)]
pub struct DerivedScene {
    /// Names, units and meanings.
    pub description: OwnedDescription,
    /// The functions.
    pub tape: NamedTape,
}

/// A [`Description`](crate::Description) that owns its texts.
#[derive(Clone, Debug, Default, PartialEq, serde::Serialize, serde::Deserialize)]
#[allow(missing_docs, reason = "the fields are those of a description")]
pub struct OwnedDescription {
    pub name: String,
    pub doc: String,
    pub source: String,
    pub derivation: String,
    pub coordinates: Vec<OwnedQuantity>,
    pub constraints: Vec<OwnedQuantity>,
    pub outputs: Vec<OwnedQuantity>,
    pub parameters: Vec<OwnedParameter>,
    pub left_out: Vec<String>,
    pub has_corners: bool,
    pub friction: Vec<String>,
    pub until: String,
}

/// A [`QuantityDescription`](crate::QuantityDescription) that owns its texts.
#[derive(Clone, Debug, Default, PartialEq, serde::Serialize, serde::Deserialize)]
#[allow(missing_docs, reason = "the fields are those of a quantity")]
pub struct OwnedQuantity {
    pub name: String,
    pub unit: String,
    pub doc: String,
}

/// A [`ParameterDescription`](crate::ParameterDescription) that owns its texts.
#[derive(Clone, Debug, Default, PartialEq, serde::Serialize, serde::Deserialize)]
#[allow(missing_docs, reason = "the fields are those of a parameter")]
pub struct OwnedParameter {
    pub name: String,
    pub unit: String,
    pub doc: String,
    pub formula: String,
}

impl DerivedScene {
    /// Encodes the scene as bytes, which end with their hash.
    ///
    /// # Panics
    /// Never: encoding needs nothing but memory.
    pub fn to_bytes(&self) -> Vec<u8> {
        let mut bytes = postcard::to_stdvec(self).unwrap_or_else(|e| unreachable!("memory takes all bytes: {e}"));
        let hash = digest(bytes.iter().copied());
        bytes.extend(hash.to_le_bytes());
        bytes
    }

    /// Decodes a scene; `None` if the bytes were truncated or changed.
    pub fn from_bytes(bytes: &[u8]) -> Option<Self> {
        let (bytes, hash) = bytes.split_last_chunk()?;
        (digest(bytes.iter().copied()) == u64::from_le_bytes(*hash)).then(|| postcard::from_bytes(bytes).ok())?
    }
}

#[cfg(feature = "simd")]
impl DerivedScene {
    /// Extracts the data of a model.
    pub fn from_model(model: &Model) -> Self {
        Self { description: OwnedDescription::from_description(model.description), tape: model.named_tape().clone() }
    }

    /// Turns the scene into an entry of a program's list. It lives as long as the program.
    pub fn into_model(self) -> Model {
        self.description.into_model(StoredTape::from(self.tape))
    }
}

#[cfg(feature = "simd")]
impl OwnedDescription {
    fn from_description(description: &Description) -> Self {
        let quantities = |list: &[QuantityDescription]| {
            let quantity =
                |q: &QuantityDescription| OwnedQuantity { name: q.name.into(), unit: q.unit.into(), doc: q.doc.into() };
            list.iter().map(quantity).collect()
        };
        let parameter = |p: &ParameterDescription| OwnedParameter {
            name: p.name.into(),
            unit: p.unit.into(),
            doc: p.doc.into(),
            formula: p.formula.into(),
        };
        Self {
            name: description.name.into(),
            doc: description.doc.into(),
            source: description.source.into(),
            derivation: description.derivation.into(),
            coordinates: quantities(description.coordinates),
            constraints: quantities(description.constraints),
            outputs: quantities(description.outputs),
            parameters: description.parameters.iter().map(parameter).collect(),
            left_out: description.left_out.iter().map(|&name| name.into()).collect(),
            has_corners: description.has_corners,
            friction: description.friction.iter().map(|&name| name.into()).collect(),
            until: description.until.into(),
        }
    }

    /// Turns the description and its tape into an entry of a program's list. It lives as long as the program.
    pub fn into_model(self, tape: StoredTape) -> Model {
        Model::interpreted(Box::leak(Box::new(self.leaked())), Box::leak(Box::new(tape)))
    }

    fn leaked(self) -> Description {
        let quantities = |list: Vec<OwnedQuantity>| -> &'static [QuantityDescription] {
            let quantity =
                |q: OwnedQuantity| QuantityDescription { name: text(q.name), unit: text(q.unit), doc: text(q.doc) };
            list.into_iter().map(quantity).collect::<Vec<_>>().leak()
        };
        let parameter = |p: OwnedParameter| ParameterDescription {
            name: text(p.name),
            unit: text(p.unit),
            doc: text(p.doc),
            formula: text(p.formula),
        };
        Description {
            name: text(self.name),
            doc: text(self.doc),
            source: text(self.source),
            derivation: text(self.derivation),
            coordinates: quantities(self.coordinates),
            constraints: quantities(self.constraints),
            outputs: quantities(self.outputs),
            parameters: self.parameters.into_iter().map(parameter).collect::<Vec<_>>().leak(),
            left_out: self.left_out.into_iter().map(text).collect::<Vec<_>>().leak(),
            has_corners: self.has_corners,
            friction: self.friction.into_iter().map(text).collect::<Vec<_>>().leak(),
            until: text(self.until),
        }
    }
}

#[cfg(feature = "simd")]
fn text(text: String) -> &'static str {
    text.leak()
}
