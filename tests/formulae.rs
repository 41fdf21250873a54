//! The formulae that people read, in the documentation of generated functions, against the functions themselves.

use qrm_model::quick_return::{self, QuickReturn};
use qrm_scene::declarations::Declarations;
use qrm_scene::evaluate::evaluate;
use qrm_scene::parser::parse_formula;

use crate::common::model;

const Q: [f64; 3] = [0.7, 1.1, 2.7];
const QD: [f64; 3] = [7.7, 2.8, -1.5];
const QDD: [f64; 3] = [3.0, -2.0, 0.4];
const MULTIPLIERS: [f64; 2] = [120.0, -310.0];

/// The lines `name  formula` in the documentation of a function.
fn documented(function: &str) -> Vec<(String, String)> {
    let function = model("quick-return").named_tape().function(function).expect("a function of this name");
    let block = function.doc.split("```text\n").nth(1).expect("a block of formulae").split("```").next();
    let lines = block.expect("its end").lines().map(str::trim);
    lines
        .map(|line| line.split_once("  ").map_or(("", line), |(name, formula)| (name, formula.trim())))
        .map(|(name, formula)| (name.to_owned(), formula.to_owned()))
        .collect()
}

/// The value of a formula at the state above, with names for roots.
fn value(formula: &str, roots: &[(String, f64)]) -> f64 {
    let names = ["phi2", "phi4", "phi5"];
    let model = model("quick-return");
    let parameters = model.parameter_values(&|_| None);
    let described = model.description.parameters.iter().map(|p| p.name);
    let parameters: Vec<(&str, f64)> = described.zip(parameters).collect();
    let look_up = |name: &String| {
        let coordinate = |suffix: &str, values: [f64; 3]| {
            let base = name.strip_suffix(suffix)?;
            names.iter().position(|name| *name == base).map(|i| values[i])
        };
        let multiplier = match name.as_str() {
            "lambda_slot" => Some(MULTIPLIERS[0]),
            "lambda_guide" => Some(MULTIPLIERS[1]),
            _ => None,
        };
        let root = roots.iter().find(|(root, _)| root == name).map(|(_, value)| *value);
        let parameter = parameters.iter().find(|(parameter, _)| parameter == name).map(|(_, value)| *value);
        let known = coordinate("_ddot", QDD).or_else(|| coordinate("_dot", QD)).or_else(|| coordinate("", Q));
        known.or(multiplier).or(root).or(parameter).unwrap_or_else(|| panic!("what is `{name}`?"))
    };
    evaluate(
        &parse_formula(formula, 0, &Declarations::default()).unwrap_or_else(|e| panic!("{formula}: {}", e.title)),
        look_up,
    )
}

/// Compares a function's values, those that are not zero, with its documentation.
fn agree(function: &str, values: &[f64]) {
    let lines = documented(function);
    let names_of_roots = |line: &&(String, String)| line.0 == "r";
    let roots: Vec<(String, f64)> =
        lines.iter().filter(names_of_roots).map(|(name, formula)| (name.clone(), value(formula, &[]))).collect();
    let written: Vec<f64> =
        lines.iter().filter(|line| !names_of_roots(line)).map(|(_, formula)| value(formula, &roots)).collect();
    let computed: Vec<f64> = values.iter().copied().filter(|value| *value != 0.0).collect();
    assert_eq!(written.len(), computed.len(), "{function}: {lines:?}");
    for ((written, computed), (name, formula)) in
        written.iter().zip(&computed).zip(lines.iter().filter(|line| !names_of_roots(line)))
    {
        let allowed = 1e-12 * computed.abs().max(1.0);
        assert!((written - computed).abs() <= allowed, "{function}, {name}: {formula} is {written}, not {computed}");
    }
}

#[test]
fn documented_formulae_are_what_is_computed() {
    let m = QuickReturn::default();
    agree("com_positions", &quick_return::com_positions(&m, &Q));
    agree("com_jacobian", quick_return::com_jacobian(&m, &Q).as_flattened());
    agree("com_bias", &quick_return::com_bias(&m, &Q, &QD));
    agree("constraints", &quick_return::constraints(&m, &Q));
    agree("constraint_jacobian", quick_return::constraint_jacobian(&m, &Q).as_flattened());
    agree("constraint_bias", &quick_return::constraint_bias(&m, &Q, &QD));
    agree("mass_matrix", quick_return::mass_matrix(&m, &Q).as_flattened());
    agree("generalized_forces", &quick_return::generalized_forces(&m, 0.0, &Q, &QD));
    agree("energy", &quick_return::energy(&m, &Q, &QD));
    agree("outputs", &quick_return::outputs(&m, 0.0, &Q, &QD, &QDD, &MULTIPLIERS));
}
