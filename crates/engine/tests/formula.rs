//! Formatted formulae: plain ones can be read back, and those in LaTeX match the expected text.

use num_bigint::BigInt;
use num_rational::BigRational;
use qrm_codegen::formula::{Style, Writer};
use qrm_codegen::term::{Symbol, Term};
use qrm_scene::declarations::Declarations;
use qrm_scene::evaluate::evaluate;
use qrm_scene::function::Function;
use qrm_scene::parser::parse_formula;
use qrm_scene::resolve;
use qrm_scene::scene::Scene;

const SCENE: &str = r#"
name = "letters"
coordinates = ["phi2", { name = "s", unit = "m" }]
[parameters]
a = 2
b = 3
r1 = 5
r_1 = 7
[points]
P = ['s*cos(phi2)', 'a + b + r1 + r_1']
[bodies]
all = { mass = 1, com = "P" }
[initial]
given = { phi2 = 0, s = 1, phi2_dot = 1, s_dot = 1 }
[run]
step = 1
end_time = 2
"#;

fn scene() -> Scene {
    resolve::read("letters.toml", SCENE).expect("the scene is right").0
}

const A: Term = Term::Symbol(Symbol::Parameter(0));
const B: Term = Term::Symbol(Symbol::Parameter(1));
const PHI: Term = Term::Symbol(Symbol::Coordinate(0));
const S: Term = Term::Symbol(Symbol::Coordinate(1));

fn ratio(numerator: i64, denominator: i64) -> BigRational {
    BigRational::new(BigInt::from(numerator), BigInt::from(denominator))
}

fn number(numerator: i64, denominator: i64) -> Term {
    Term::Number(ratio(numerator, denominator))
}

fn power(base: Term, numerator: i64, denominator: i64) -> Term {
    Term::Power(Box::new(base), ratio(numerator, denominator))
}

fn product(factors: &[Term]) -> Term {
    Term::Product(factors.to_vec())
}

fn sum(terms: &[Term]) -> Term {
    Term::Sum(terms.to_vec())
}

fn cos(argument: Term) -> Term {
    Term::Call(Function::Cos, Box::new(argument))
}

/// Terms with their LaTeX; the engine would never return some of them in this form.
fn terms() -> Vec<(Term, &'static str)> {
    let minus = number(-1, 1);
    vec![
        (product(&[minus.clone(), sum(&[A, B])]), r"-\left(a + b\right)"),
        (product(&[number(2, 1), sum(&[A, B])]), r"2\,\left(a + b\right)"),
        (sum(&[product(&[minus.clone(), A]), B]), "b - a"),
        (power(product(&[A, B]), -1, 1), r"\frac{1}{a\,b}"),
        (product(&[A, power(sum(&[A, B]), -1, 1)]), r"\frac{a}{a + b}"),
        (power(power(S, -1, 2), -1, 1), r"\frac{1}{\left(\frac{1}{\sqrt{s}}\right)}"),
        (product(&[number(2, 1), power(number(3, 1), 1, 3)]), r"2 \cdot 3^{1/3}"),
        (product(&[number(1, 2), A, power(cos(PHI), 2, 1)]), r"\tfrac{1}{2}\,a\,\cos^{2} \varphi_{2}"),
        (product(&[number(1, 3), A]), r"\tfrac{1}{3}\,a"),
        (product(&[number(-7, 3), power(S, -2, 1)]), r"-\frac{7}{3\,s^{2}}"),
        (product(&[cos(sum(&[PHI, S])), A]), r"a\,\cos\left(\varphi_{2} + s\right)"),
        (power(sum(&[A, power(S, 2, 1)]), 1, 2), r"\sqrt{a + s^{2}}"),
        (power(sum(&[A, product(&[minus, S])]), 3, 1), r"\left(a - s\right)^{3}"),
        (Term::Call(Function::Exp, Box::new(product(&[number(-1, 1), S]))), r"\mathrm{e}^{-s}"),
        (
            sum(&[Term::Symbol(Symbol::Parameter(2)), Term::Symbol(Symbol::Parameter(3))]),
            r"{\mathtt{r1}} + {\mathtt{r\_1}}",
        ),
    ]
}

#[test]
fn latex_says_what_is_meant() {
    let scene = scene();
    let writer = Writer::new(&scene, Style::Latex, &[]);
    for (term, latex) in terms() {
        assert_eq!(writer.term(&term), latex);
    }
}

#[test]
fn plain_text_reads_back_as_the_same_number() {
    let scene = scene();
    let writer = Writer::new(&scene, Style::Plain, &[]);
    let value = |symbol: Symbol| match symbol {
        Symbol::Parameter(i) => [2.0, 3.0, 5.0, 7.0][i],
        Symbol::Coordinate(i) => [0.6, 1.3][i],
        other => panic!("{other:?}"),
    };
    let named = |name: &String| match name.as_str() {
        "a" => 2.0,
        "b" => 3.0,
        "r1" => 5.0,
        "r_1" => 7.0,
        "phi2" => 0.6,
        "s" => 1.3,
        other => panic!("{other}"),
    };
    for (term, _) in terms() {
        let text = writer.term(&term);
        let formula =
            parse_formula(&text, 0, &Declarations::default()).unwrap_or_else(|e| panic!("{text}: {}", e.title));
        let (read, meant): (f64, f64) = (evaluate(&formula, named), term.evaluate(&value));
        assert!((read - meant).abs() <= 1e-14 * meant.abs().max(1.0), "{text} is {read}, not {meant}");
    }
}

#[test]
fn names_of_roots_are_not_those_of_the_scene() {
    let scene = scene();
    let roots = [power(sum(&[A, power(S, 2, 1)]), 1, 2), power(sum(&[B, power(S, 2, 1)]), 1, 2)];
    let twice: Vec<Term> = roots.iter().chain(&roots).cloned().collect();
    let writer = Writer::new(&scene, Style::Plain, &[]).naming_roots(&twice);
    let names: Vec<String> = writer.roots().into_iter().map(|(name, _)| name).collect();
    // `r` could be confused with `r1`, and `s` is a coordinate.
    assert_eq!(names, ["u1", "u2"]);
    assert_eq!(writer.term(&power(sum(&[B, power(S, 2, 1)]), 3, 2)), "u2^3");
}
