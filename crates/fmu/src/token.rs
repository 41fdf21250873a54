//! The instantiation token: the scene of an FMU and the settings of its motion in one line of text.

use std::fmt;
use std::str::FromStr;

use qrm_core::{Description, digest};
use qrm_sim::integrate::{MethodSettings, method_named};
use qrm_sim::solve::{Projection, ProjectionTolerance};

/// The scene of an FMU, the settings of its motion, and the parameters that differ from those of the scene.
///
/// The text form is a single line, which an importer passes to the FMU when it creates an instance:
///
/// ```text
/// qrm SCENE;DIGEST;METHOD[ TOLERANCE];PROJECTION;RESIDUAL;ITERATIONS;STEP;FIXED,...;COMPUTED,...;MASS,...;NAME=VALUE;...
/// ```
///
/// Numbers are the shortest decimals that read back exactly; the digest has 16 hexadecimal digits. `TOLERANCE` is
/// present for methods that choose their steps.
#[derive(Clone, Debug, PartialEq)]
pub struct InstantiationToken {
    /// The name of the scene.
    pub scene: String,
    /// The digest of the scene's text: an FMU must not run with the equations of another text.
    pub digest: u64,
    /// The method.
    pub settings: MethodSettings,
    /// Length of the steps in s, or the time between rows of a method that chooses its steps.
    pub step: f64,
    /// Parameters that can be set only before the start.
    pub fixed: Vec<String>,
    /// Parameters that follow from others.
    pub computed: Vec<String>,
    /// Parameters that must not be negative: masses and moments of inertia.
    pub masses: Vec<String>,
    /// Parameters with other values than in the scene.
    pub replaced: Vec<(String, f64)>,
}

/// The error of a text that is not an instantiation token.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct NotAToken;

impl std::error::Error for NotAToken {}

impl fmt::Display for NotAToken {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str("the instantiation token is not one of qrm's")
    }
}

impl InstantiationToken {
    /// Creates the token of a scene with its own parameters, none of them fixed.
    pub fn new(description: &Description, settings: MethodSettings, step: f64) -> Self {
        Self {
            scene: description.name.to_owned(),
            digest: digest(description.source.bytes()),
            settings,
            step,
            fixed: Vec::new(),
            computed: Vec::new(),
            masses: Vec::new(),
            replaced: Vec::new(),
        }
    }

    /// The replaced value of a parameter; `None` if it is not replaced.
    pub fn value(&self, name: &str) -> Option<f64> {
        self.replaced.iter().find(|(replaced, _)| replaced == name).map(|(_, value)| *value)
    }

    /// Whether the token belongs to the text from which a mechanism was generated.
    pub fn is_of(&self, description: &Description) -> bool {
        self.scene == description.name && self.digest == digest(description.source.bytes())
    }
}

impl fmt::Display for InstantiationToken {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        let settings = &self.settings;
        write!(f, "qrm {};{:016x};{}", self.scene, self.digest, settings.method.name)?;
        if let Some(tolerance) = settings.tolerance() {
            write!(f, " {tolerance:?}")?;
        }
        let ProjectionTolerance { residual, iterations } = settings.projection_tolerance;
        write!(f, ";{};{residual:?};{iterations}", settings.projection.name())?;
        write!(f, ";{:?}", self.step)?;
        [&self.fixed, &self.computed, &self.masses].iter().try_for_each(|names| write!(f, ";{}", names.join(",")))?;
        self.replaced.iter().try_for_each(|(name, value)| write!(f, ";{name}={value:?}"))
    }
}

impl FromStr for InstantiationToken {
    type Err = NotAToken;

    fn from_str(text: &str) -> Result<Self, NotAToken> {
        parse(text).ok_or(NotAToken)
    }
}

fn parse(text: &str) -> Option<InstantiationToken> {
    let mut parts = text.split(';');
    let scene = parts.next()?.strip_prefix("qrm ")?.to_owned();
    let digest = u64::from_str_radix(parts.next()?, 16).ok()?;
    let mut settings = method(parts.next()?)?;
    let projection = parts.next()?;
    settings.projection = Projection::named(projection)?;
    settings.projection_tolerance =
        ProjectionTolerance { residual: number(parts.next()?)?, iterations: parts.next()?.parse().ok()? };
    let step = number(parts.next()?)?;
    let (fixed, computed, masses) = (names(parts.next()?), names(parts.next()?), names(parts.next()?));
    let replaced = parts.map(|part| {
        let (name, value) = part.split_once('=')?;
        Some((name.to_owned(), number(value)?))
    });
    let replaced = replaced.collect::<Option<_>>()?;
    Some(InstantiationToken { scene, digest, settings, step, fixed, computed, masses, replaced })
}

/// Reads the name of a method, followed by a space and the tolerance if the method chooses its steps.
fn method(text: &str) -> Option<MethodSettings> {
    let (name, tolerance) = text.split_once(' ').unwrap_or((text, ""));
    let method = method_named(name)?;
    let mut settings = MethodSettings { method, ..MethodSettings::default() };
    if method.is_adaptive() {
        settings.tolerance = number(tolerance)?;
    }
    Some(settings)
}

fn number(text: &str) -> Option<f64> {
    text.parse().ok()
}

fn names(text: &str) -> Vec<String> {
    text.split(',').filter(|name| !name.is_empty()).map(str::to_owned).collect()
}

#[cfg(test)]
mod tests {
    use qrm_sim::integrate::METHODS;

    use super::*;

    fn token(settings: MethodSettings) -> InstantiationToken {
        InstantiationToken {
            scene: "quick-return".to_owned(),
            digest: 0xab,
            settings,
            step: 1e-3,
            fixed: vec!["O2A".to_owned(), "w0".to_owned()],
            computed: Vec::new(),
            masses: vec!["m3".to_owned()],
            replaced: vec![("O2A".to_owned(), 0.1 + 0.2), ("g".to_owned(), -1e308)],
        }
    }

    #[test]
    fn a_line_reads_back_as_the_same_token() {
        let projection_tolerance = ProjectionTolerance { residual: 3e-11, iterations: 7 };
        for method in METHODS {
            for (_, projection) in Projection::ALL {
                let tolerance = if method.is_adaptive() { 1e-300 } else { MethodSettings::default().tolerance };
                let token = token(MethodSettings {
                    method,
                    tolerance,
                    projection,
                    projection_tolerance,
                    ..MethodSettings::default()
                });
                assert_eq!(token.to_string().parse(), Ok(token));
            }
        }
    }

    #[test]
    fn a_line_has_these_bytes() {
        let mut token = token(MethodSettings::default());
        let rest = "0.001;O2A,w0;;m3;O2A=0.30000000000000004;g=-1e308";
        assert_eq!(token.to_string(), format!("qrm quick-return;00000000000000ab;rk4;mass;1e-12;10;{rest}"));
        token.settings = MethodSettings::new(method_named("auto").expect("a method"), 0.1);
        assert_eq!(token.to_string(), format!("qrm quick-return;00000000000000ab;auto 0.1;mass;1e-12;10;{rest}"));
    }

    #[test]
    fn other_texts_are_refused() {
        let short = "qrm a;0;rk4;mass;1e-12;10";
        let no_tolerance = "qrm a;0;dopri5;mass;1e-12;10;1;;;";
        let unknown = "{8c4e810f-3df3-4a00-8276-176fa3c9f9e0}";
        for wrong in ["", "qrm", unknown, short, no_tolerance, &format!("{short};1;;"), &format!("{short};1;;;;x")] {
            assert_eq!(wrong.parse::<InstantiationToken>(), Err(NotAToken), "{wrong}");
        }
    }
}
