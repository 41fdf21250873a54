//! Converts the engine's expressions into plain [`Term`]s.

use std::collections::HashMap;
use std::sync::Arc;

use num_bigint::BigInt;
use num_rational::BigRational;
use num_traits::Zero;
use symbolica::atom::{AtomView, Symbol as EngineSymbol};
use symbolica::coefficient::CoefficientView;

use super::spline_names::parse_name;
use qrm_codegen::term::{Symbol, Term};
use qrm_scene::expression::to_f64;
use qrm_scene::function::Function;
use qrm_scene::spline::Spline;

/// Converts an expression.
///
/// # Panics
/// For a function or number that no scene can introduce; the build then fails with its name.
pub(super) fn term(view: AtomView, places: &HashMap<EngineSymbol, Symbol>, splines: &[Arc<Spline>]) -> Term {
    let each = |items: &mut dyn Iterator<Item = AtomView<'_>>| items.map(|item| term(item, places, splines)).collect();
    match view {
        AtomView::Num(number) => {
            let number = rational(number.get_coeff_view(), &view);
            let value = to_f64(&number);
            assert!(
                value.is_finite() && (value == 0.0) == number.is_zero(),
                "a number in it is beyond double precision"
            );
            Term::Number(number)
        }
        AtomView::Var(variable) => match places.get(&variable.get_symbol()) {
            Some(symbol) => Term::Symbol(*symbol),
            None if variable.get_symbol() == EngineSymbol::E => {
                Term::Call(Function::Exp, Box::new(Term::Number(BigRational::from_integer(1.into()))))
            }
            None => panic!("the engine made a symbol of its own: {view}"),
        },
        AtomView::Add(sum) => Term::Sum(each(&mut sum.iter())),
        AtomView::Mul(product) => Term::Product(each(&mut product.iter())),
        AtomView::Pow(power) => {
            let (base, exponent) = power.get_base_exp();
            if let AtomView::Var(variable) = base
                && variable.get_symbol() == EngineSymbol::E
            {
                return Term::Call(Function::Exp, Box::new(term(exponent, places, splines)));
            }
            match term(exponent, places, splines) {
                Term::Number(exponent) => Term::Power(Box::new(term(base, places, splines)), exponent),
                _ => panic!("the engine made a power with a variable exponent: {view}"),
            }
        }
        AtomView::Fun(call) => {
            let symbol = call.get_symbol();
            let mut arguments: Vec<Term> = each(&mut call.iter());
            let argument = match (arguments.pop(), arguments.is_empty()) {
                (Some(argument), true) => Box::new(argument),
                _ => panic!("the engine made a function of several arguments: {view}"),
            };
            let inverse =
                |f| Term::Power(Box::new(Term::Call(f, argument.clone())), BigRational::from_integer((-1).into()));
            match symbol.get_stripped_name() {
                "sec" => inverse(Function::Cos),
                "csc" => inverse(Function::Sin),
                "sech" => inverse(Function::Cosh),
                "csch" => inverse(Function::Sinh),
                name => match (Function::named(name), parse_name(name)) {
                    (Some(function), _) => Term::Call(function, argument),
                    (None, Some((place, order))) => Term::Spline(Arc::clone(&splines[place]), order, argument),
                    (None, None) => panic!("the engine made a function that has no meaning here: {view}"),
                },
            }
        }
    }
}

fn rational(coefficient: CoefficientView, view: &AtomView) -> BigRational {
    if let CoefficientView::Natural(numerator, denominator, 0, _) = coefficient {
        return BigRational::new(numerator.into(), denominator.into());
    }
    // The number exceeds a machine word; the engine prints quotients exactly.
    let text = view.to_string();
    let (numerator, denominator) = text.split_once('/').unwrap_or((&text, "1"));
    match (numerator.parse::<BigInt>(), denominator.parse::<BigInt>()) {
        (Ok(numerator), Ok(denominator)) => BigRational::new(numerator, denominator),
        _ => panic!("its value is not a finite number: {view}"),
    }
}
