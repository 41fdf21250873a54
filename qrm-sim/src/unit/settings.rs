//! How a unit's motion is made, in one line of text that a tool hands back when it makes an instance.

use std::fmt;
use std::str::FromStr;

use qrm_core::Description;

use crate::motion::{Method, Scheme};
use crate::projection::{Projection, Tolerance};

/// A scene, how it is run, and its parameters that differ from the text's.
#[derive(Clone, Debug, PartialEq)]
pub struct Settings {
    /// The scene's name.
    pub scene: String,
    /// A number that stands for its text.
    pub text: u64,
    /// How steps are made.
    pub method: Method,
    /// Their length in seconds, or the time between rows.
    pub step: f64,
    /// Parameters that can be set before the start only.
    pub fixed: Vec<String>,
    /// Parameters that follow from others.
    pub computed: Vec<String>,
    /// Parameters with other values.
    pub set: Vec<(String, f64)>,
}

/// A number that stands for a scene's text: a unit must not run with the equations of another.
pub fn fingerprint(description: &Description) -> u64 {
    digest(description.source.bytes())
}

/// A number that differs where bytes do (FNV-1a).
pub(crate) fn digest(bytes: impl Iterator<Item = u8>) -> u64 {
    bytes.fold(0xcbf2_9ce4_8422_2325, |hash: u64, byte| (hash ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3))
}

impl Settings {
    /// The value that is set for a parameter.
    pub fn value(&self, name: &str) -> Option<f64> {
        self.set.iter().find(|(set, _)| set == name).map(|(_, value)| *value)
    }

    /// Whether they were made for the text that a mechanism was generated from.
    pub fn is_of(&self, description: &Description) -> bool {
        self.scene == description.name && self.text == fingerprint(description)
    }
}

impl fmt::Display for Settings {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        let scheme = match self.method.scheme {
            Scheme::Rk4 => "rk4".to_owned(),
            Scheme::Document => "document".to_owned(),
            Scheme::Dopri5 { tolerance } => format!("dopri5 {tolerance:?}"),
            Scheme::Dop853 { tolerance } => format!("dop853 {tolerance:?}"),
            Scheme::Auto { tolerance } => format!("auto {tolerance:?}"),
            Scheme::Rodas { tolerance } => format!("rodas {tolerance:?}"),
        };
        let projection = match self.method.projection {
            Projection::None => "none",
            Projection::Euclidean => "euclidean",
            Projection::Mass => "mass",
        };
        let Tolerance { residual, iterations } = self.method.tolerance;
        write!(f, "qrm {};{:016x};{scheme};{projection};{residual:?};{iterations};", self.scene, self.text)?;
        write!(f, "{:?};{};{}", self.step, self.fixed.join(","), self.computed.join(","))?;
        self.set.iter().try_for_each(|(name, value)| write!(f, ";{name}={value:?}"))
    }
}

impl FromStr for Settings {
    type Err = ();

    fn from_str(text: &str) -> Result<Self, ()> {
        let number = |text: Option<&str>| text.and_then(|text| text.parse::<f64>().ok()).ok_or(());
        let mut parts = text.split(';');
        let scene = parts.next().and_then(|part| part.strip_prefix("qrm ")).ok_or(())?.to_owned();
        let text = parts.next().and_then(|part| u64::from_str_radix(part, 16).ok()).ok_or(())?;
        let (name, rest) = parts.next().map(|part| part.split_once(' ').unwrap_or((part, ""))).ok_or(())?;
        let tolerance = || number(Some(rest));
        let scheme = match name {
            "rk4" => Scheme::Rk4,
            "document" => Scheme::Document,
            "dopri5" => Scheme::Dopri5 { tolerance: tolerance()? },
            "dop853" => Scheme::Dop853 { tolerance: tolerance()? },
            "auto" => Scheme::Auto { tolerance: tolerance()? },
            "rodas" => Scheme::Rodas { tolerance: tolerance()? },
            _ => return Err(()),
        };
        let projection = match parts.next() {
            Some("none") => Projection::None,
            Some("euclidean") => Projection::Euclidean,
            Some("mass") => Projection::Mass,
            _ => return Err(()),
        };
        let residual = number(parts.next())?;
        let iterations = parts.next().and_then(|part| part.parse().ok()).ok_or(())?;
        let step = number(parts.next())?;
        let mut names = || {
            let list = parts.next().ok_or(())?;
            Ok(list.split(',').filter(|name| !name.is_empty()).map(str::to_owned).collect())
        };
        let (fixed, computed) = (names()?, names()?);
        let pair =
            |part: &str| part.split_once('=').and_then(|(name, value)| Some((name.to_owned(), value.parse().ok()?)));
        let set = parts.map(|part| pair(part).ok_or(())).collect::<Result<_, _>>()?;
        let method = Method { scheme, projection, tolerance: Tolerance { residual, iterations } };
        Ok(Self { scene, text, method, step, fixed, computed, set })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_line_says_all() {
        let tolerance = Tolerance { residual: 3e-11, iterations: 7 };
        for scheme in [Scheme::Rk4, Scheme::Dop853 { tolerance: 0.1 }, Scheme::Auto { tolerance: 1e-300 }] {
            for projection in [Projection::None, Projection::Euclidean, Projection::Mass] {
                let settings = Settings {
                    scene: "quick-return".to_owned(),
                    text: 0xab,
                    method: Method { scheme, projection, tolerance },
                    step: 1e-3,
                    fixed: vec!["O2A".to_owned(), "w0".to_owned()],
                    computed: Vec::new(),
                    set: vec![("O2A".to_owned(), 0.1 + 0.2), ("g".to_owned(), -1e308)],
                };
                assert_eq!(settings.to_string().parse(), Ok(settings));
            }
        }
        let short = "qrm a;0;rk4;mass;1e-12;10";
        for wrong in ["", "qrm", "{8c4e810f-3df3-4a00-8276-176fa3c9f9e0}", short, &format!("{short};1;;;x")] {
            assert_eq!(wrong.parse::<Settings>(), Err(()), "{wrong}");
        }
    }
}
