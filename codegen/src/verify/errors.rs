//! Error estimates of compared numbers.

use std::cell::OnceCell;

use qrm_core::{DoubleDouble, NamedTape};

use super::evaluation::Evaluation;
use super::expected::Expected;
use super::sample::Sample;
use super::size::{SMALLEST, size};
use super::wide::Wide;
use crate::term::Equations;
use qrm_scene::expression::Node;
use qrm_scene::resolve::all_values;
use qrm_scene::scene::{Quantity, Scene, Value};

/// The ratio of rounding errors with 32 digits to those with 16: where terms cancel, the latter show the size of the
/// terms.
const ROUNDING: f64 = 1e-13;
/// The ratio of errors of constants in a module's text to rounding errors of double precision.
pub(super) const CONSTANTS: f64 = 4.0;
/// The largest change of a value, relative to a difference, caused by a few units in the last place of the inputs, for
/// which the difference is significant.
const CONDITION: f64 = 0.1;

/// The largest number of digits of factors whose product is exact in double precision.
const LONG: usize = 7;

/// The number of digits in a number's decimal.
fn digits(number: f64) -> usize {
    format!("{number:e}").split('e').next().unwrap_or_default().chars().filter(char::is_ascii_digit).count()
}

/// Whether numbers of a module are rounded: slopes of tables, coefficients of splines, and products of numbers with
/// many digits.
pub(super) fn has_rounded_constants(scene: &Scene) -> bool {
    let is_long = |node: &Node<Quantity>| {
        matches!(node, Node::Number(number) if digits(number.value) > LONG) || matches!(node, Node::Spline(..))
    };
    let has_long = |value: &&Value| value.nodes().iter().any(is_long);
    all_values(scene).iter().any(has_long)
}

/// The errors of numbers at a state, computed on demand.
pub(super) struct Errors<'a> {
    scene: &'a Scene,
    equations: &'a Equations,
    tape: &'a NamedTape,
    sample: &'a Sample,
    has_rounded_constants: bool,
    /// The expected numbers in double precision, and with 32 digits at a nearby state.
    known: OnceCell<[Option<Expected<f64>>; 2]>,
    nearby: OnceCell<Option<Expected<Wide>>>,
    force_sizes: OnceCell<Vec<Wide>>,
    /// The tape in double precision.
    rounded: OnceCell<Evaluation<'a, f64>>,
}

impl<'a> Errors<'a> {
    pub(super) fn new(scene: &'a Scene, equations: &'a Equations, tape: &'a NamedTape, sample: &'a Sample) -> Self {
        let (known, nearby, force_sizes, rounded) = Default::default();
        let has_rounded_constants = has_rounded_constants(scene);
        Self { scene, equations, tape, sample, has_rounded_constants, known, nearby, force_sizes, rounded }
    }

    fn nearby(&self) -> Option<&Expected<Wide>> {
        let nearby = || self.sample.nearby().on::<Wide>().expected(self.scene, self.equations);
        self.nearby.get_or_init(nearby).as_ref()
    }

    /// The rounding error of one number: double-precision results show how large its cancelling terms are.
    pub(super) fn rounding_error(&self, place: usize, i: usize, expected: Wide, got: DoubleDouble) -> f64 {
        let samples = || [self.sample.clone(), self.sample.nearby()].map(|s| s.expected(self.scene, self.equations));
        let [here, near] = self.known.get_or_init(samples);
        let error = |rounded: &Option<Expected<f64>>, exact: Option<Wide>| match (rounded, exact) {
            (Some(rounded), Some(exact)) => size(Wide::from(rounded[place].1[i]) - exact),
            _ => 0.0,
        };
        let of_expected = error(here, Some(expected)) + error(near, self.nearby().map(|n| n[place].1[i]));
        let of_got = self.rounded(place, i).map_or(0.0, |rounded| size(Wide::from(rounded) - Wide(got)));
        // Numbers in the text of a module have 16 digits, which limits the accuracy where terms cancel.
        let constant_error = if self.has_rounded_constants { CONSTANTS * of_expected } else { 0.0 };
        (ROUNDING * (of_expected + of_got) + SMALLEST * self.terms(place, i)).max(constant_error)
    }

    /// The error of a number caused by rounded constants in the module, estimated from double-precision results.
    pub(super) fn constant_error(&self, name: &str, i: usize) -> f64 {
        if !self.has_rounded_constants {
            return 0.0;
        }
        let errors = [self.sample.clone(), self.sample.nearby()].map(|sample| {
            let rounded = sample.expected(self.scene, self.equations)?;
            let exact = sample.on::<Wide>().expected(self.scene, self.equations)?;
            let place = exact.iter().position(|(own, _)| *own == name)?;
            Some(size(Wide::from(rounded[place].1[i]) - exact[place].1[i]))
        });
        CONSTANTS * errors.into_iter().flatten().sum::<f64>()
    }

    /// The sum of the absolute values of a number's terms, if known.
    fn terms(&self, place: usize, i: usize) -> f64 {
        let names = self.nearby().map(|nearby| nearby[place].0);
        if !names.is_some_and(|name| name.ends_with("generalized_forces")) {
            return 0.0;
        }
        let sizes = || self.sample.on::<Wide>().force_sizes(self.scene, self.equations);
        size(self.force_sizes.get_or_init(sizes)[i])
    }

    /// A number of the tape in double precision.
    fn rounded(&self, place: usize, i: usize) -> Option<f64> {
        let (name, _) = self.known.get()?.first()?.as_ref()?[place];
        let rounded = || self.sample.evaluation(self.scene, self.tape, &[]);
        self.rounded.get_or_init(rounded).results(name).get(i).copied()
    }

    /// Whether a difference may be caused by numbers that are rounded to 16 digits in the module.
    pub(super) fn may_be_rounding(&self, place: usize, i: usize, expected: Wide, got: DoubleDouble) -> bool {
        let spread = self.nearby().map_or(f64::INFINITY, |nearby| size(nearby[place].1[i] - expected));
        spread > CONDITION * size(Wide(got) - expected)
    }
}
