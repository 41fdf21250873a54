//! Numerical values of constant formulae, where the kind of a drawing depends on them.

use crate::document::Document;
use crate::evaluate::evaluate;
use crate::parser::Formula;

/// The values of the parameters of a scene.
pub(super) struct Constants<'d>(Vec<(&'d str, f64)>);

impl<'d> Constants<'d> {
    pub(super) fn new(document: &'d Document) -> Self {
        let mut constants = Self(Vec::new());
        for parameter in &document.parameters {
            let value = constants.value(&parameter.value);
            constants.0.push((&parameter.identifier.name, value));
        }
        constants
    }

    /// The value of a formula; not a number if it contains a name other than a parameter.
    pub(super) fn value(&self, formula: &Formula) -> f64 {
        evaluate(formula, |name| match name.as_str() {
            "pi" => std::f64::consts::PI,
            name => self.0.iter().find(|(own, _)| *own == name).map_or(f64::NAN, |(_, value)| *value),
        })
    }

    /// Whether two positions are equal up to rounding errors.
    pub(super) fn are_same(&self, a: &[Formula; 2], b: &[Formula; 2]) -> bool {
        let [a, b] = [a, b].map(|place| [self.value(&place[0]), self.value(&place[1])]);
        let size = a.iter().chain(&b).fold(0.0, |most: f64, component| most.max(component.abs()));
        (a[0] - b[0]).hypot(a[1] - b[1]) <= 1e-9 * size
    }
}
