//! How large the errors of numbers are that are compared.

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

/// Rounding errors of 32 digits for each of 16 digits: where terms cancel, the latter tell how large the terms were.
const ROUNDING: f64 = 1e-13;
/// Rounding errors of numbers in the text of a module for those of a computation in doubles.
pub(super) const CONSTANTS: f64 = 4.0;
/// Where inputs that differ by a few units in the last place change a value by more than this fraction of a difference,
/// the difference says nothing.
const CONDITION: f64 = 0.1;

/// Products of numbers with more digits than this have more than those of a double.
const LONG: usize = 7;

/// The number of digits that are written of a number.
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

/// The errors of numbers at a state, computed when they are asked for.
pub(super) struct Errors<'a> {
    scene: &'a Scene,
    equations: &'a Equations,
    tape: &'a NamedTape,
    sample: &'a Sample,
    has_rounded_constants: bool,
    /// The expected numbers in doubles, and with 32 digits at a state nearby.
    known: OnceCell<[Option<Expected<f64>>; 2]>,
    nearby: OnceCell<Option<Expected<Wide>>>,
    force_sizes: OnceCell<Vec<Wide>>,
    /// The tape in doubles.
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

    /// The rounding errors of one number: those of doubles show how large the terms are that cancel in it.
    pub(super) fn rounding_error(&self, place: usize, i: usize, expected: Wide, got: DoubleDouble) -> f64 {
        let samples = || [self.sample.clone(), self.sample.nearby()].map(|s| s.expected(self.scene, self.equations));
        let [here, near] = self.known.get_or_init(samples);
        let error = |rounded: &Option<Expected<f64>>, exact: Option<Wide>| match (rounded, exact) {
            (Some(rounded), Some(exact)) => size(Wide::from(rounded[place].1[i]) - exact),
            _ => 0.0,
        };
        let of_expected = error(here, Some(expected)) + error(near, self.nearby().map(|n| n[place].1[i]));
        let of_got = self.rounded(place, i).map_or(0.0, |rounded| size(Wide::from(rounded) - Wide(got)));
        // Numbers in the text of a module have 16 digits: where terms cancel, no more of the sum is known.
        let constant_error = if self.has_rounded_constants { CONSTANTS * of_expected } else { 0.0 };
        (ROUNDING * (of_expected + of_got) + SMALLEST * self.terms(place, i)).max(constant_error)
    }

    /// The errors that rounded numbers of the module leave in another number: rounding errors of doubles tell them.
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

    /// The sum of the sizes of a number's terms, where it is known.
    fn terms(&self, place: usize, i: usize) -> f64 {
        let names = self.nearby().map(|nearby| nearby[place].0);
        if !names.is_some_and(|name| name.ends_with("generalized_forces")) {
            return 0.0;
        }
        let sizes = || self.sample.on::<Wide>().force_sizes(self.scene, self.equations);
        size(self.force_sizes.get_or_init(sizes)[i])
    }

    /// A number of the tape in doubles.
    fn rounded(&self, place: usize, i: usize) -> Option<f64> {
        let (name, _) = self.known.get()?.first()?.as_ref()?[place];
        let rounded = || self.sample.evaluation(self.scene, self.tape, &[]);
        self.rounded.get_or_init(rounded).results(name).get(i).copied()
    }

    /// Whether a difference may come from numbers that are rounded to 16 digits in the module.
    pub(super) fn hide(&self, place: usize, i: usize, expected: Wide, got: DoubleDouble) -> bool {
        let spread = self.nearby().map_or(f64::INFINITY, |nearby| size(nearby[place].1[i] - expected));
        spread > CONDITION * size(Wide(got) - expected)
    }
}
