//! Translations of the golden modules, compared with the modules themselves.

mod compiler;
mod driver;
mod libm;
mod states;

use std::fs;
use std::path::PathBuf;

use compiler::compilers;
use driver::driver;
use qrm_language::syntax;
use states::{State, expected};

/// States of each mechanism.
const STATES: usize = 1000;
/// The largest relative difference.
const TOLERANCE: f64 = 1e-14;

fn golden() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../qrm-model/golden")
}

/// The golden modules, by their names.
fn modules() -> Vec<(String, syn::File)> {
    let files = fs::read_dir(golden()).expect("the golden copy").map(|entry| entry.expect("a file").path());
    let mut files: Vec<PathBuf> = files.filter(|path| path.extension().is_some_and(|e| e == "rs")).collect();
    files.retain(|path| !path.ends_with("scenes.rs"));
    files.sort();
    let module = |path: PathBuf| {
        let name = path.file_stem().expect("a name").to_string_lossy().into_owned();
        (name, syntax(&fs::read_to_string(path).expect("a module")).expect("Rust"))
    };
    files.into_iter().map(module).collect()
}

#[test]
fn c_gives_the_same_numbers() {
    for (name, module) in modules() {
        compare(&name, &module, STATES);
    }
}

#[test]
fn names_that_mean_something_in_c_are_changed() {
    let text = fs::read_to_string(golden().join("pendulum.rs")).expect("a module");
    let renamed = [("half_m", "register"), ("rod_x", "double"), ("inv_rod", "fabs"), ("rod_residual", "residuals")];
    let text = renamed.into_iter().fold(text, |text, (from, to)| text.replace(from, to));
    compare("pendulum", &syntax(&text).expect("Rust"), 10);
}

/// Compares a module with its translation, by each compiler that is there.
fn compare(name: &str, module: &syn::File, states: usize) {
    let program = qrm_language::program(name, module).expect("a plain form");
    let files = qrm_language::c(&program).expect("a translation");
    assert_eq!(qrm_language::c(&program).as_ref(), Ok(&files), "{name}: the same module, other code");
    let states = State::random(&program, states);
    let wanted = expected(&program, module, &states);
    for compiler in &compilers() {
        let given = compiler.run(name, &files, &driver(&program), &states);
        assert_eq!(given.len(), wanted.len(), "{name}: results by {}", compiler.name);
        for ((function, wanted), given) in wanted.iter().zip(given) {
            let is_same = *wanted == given || wanted.is_nan() && given.is_nan();
            let is_near = (wanted - given).abs() <= TOLERANCE * wanted.abs();
            assert!(is_same || is_near, "{name}_{function} by {}: {given:e}, not {wanted:e}", compiler.name);
        }
    }
}

#[test]
fn all_functions_of_numbers_are_translated() {
    let text = fs::read_to_string(golden().join("pendulum.rs")).expect("a module");
    let residual = "-(k.k1 * (k.half_l_sq - R::from_f64(0.5) * (x * x + y * y)))";
    let sum = "k.k1 + x.tanh().asin() + y.tanh().acos() + x.atan() + x.sinh() * y.cosh() + x.exp().ln() + x.abs().sqrt() \
               + y.floor() + x.sign() + x.tan() + x.sin() + y.cos() + x.atan2(y) + x.hypot(y) + x.min(y) + x.max(y) \
               + R::powi(x, 2) + R::pow(R::abs(x), y) + x.abs().powf(1.5) + R::pi() - (x - (y - x)) / (x / y) - -x";
    assert!(text.contains(residual), "{residual}");
    compare("pendulum", &syntax(&text.replace(residual, sum)).expect("Rust"), 100);
}

#[test]
fn what_has_no_translation_is_named() {
    let pendulum = fs::read_to_string(golden().join("pendulum.rs")).expect("a module");
    let said = |from: &str, to: &str| {
        assert!(pendulum.contains(from), "{from}");
        let module = syntax(&pendulum.replace(from, to)).expect("Rust");
        qrm_language::program("pendulum", &module).expect_err(to).to_string()
    };
    assert_eq!(said("rod_x.recip()", "rod_x.erf()"), "no translation of the call `rod_x . erf ()`");
    assert_eq!(
        said("rod_x.recip()", "if true { x } else { y }"),
        "no translation of the expression `if true { x } else { y }`"
    );
    assert_eq!(said("k.k1 * x;", "k.k1 % x;"), "no translation of the operator of `k . k1 % x`");
    assert_eq!(said("rod_x.recip()", "LENGTH"), "no translation of the name `LENGTH`");
    assert_eq!(said("let rod_y =", "let rod_x ="), "no translation of a name that is given twice, `rod_x`");
}
