//! Translations of the golden modules, compared with the modules themselves.

mod compiler;
mod driver;
mod interpret;
mod libm;
mod octave;
mod states;

use std::fs;
use std::path::{Path, PathBuf};
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};

use compiler::COMPILERS;
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

/// The files of the golden modules.
fn paths() -> Vec<PathBuf> {
    let files = fs::read_dir(golden()).expect("the golden copy").map(|entry| entry.expect("a file").path());
    let mut files: Vec<PathBuf> = files.filter(|path| path.extension().is_some_and(|e| e == "rs")).collect();
    files.retain(|path| !path.ends_with("scenes.rs"));
    files.sort();
    files
}

/// The name and the syntax of a golden module.
fn module(path: &Path) -> (String, syn::File) {
    let name = path.file_stem().expect("a name").to_string_lossy().into_owned();
    (name, syntax(&fs::read_to_string(path).expect("a module")).expect("Rust"))
}

#[test]
#[ignore = "full tier: languages"]
fn c_gives_the_same_numbers() {
    for path in paths() {
        let (name, module) = module(&path);
        compare(&name, &module, STATES);
    }
}

#[test]
#[ignore = "full tier: languages"]
fn names_that_mean_something_in_c_are_changed() {
    let text = fs::read_to_string(golden().join("pendulum.rs")).expect("a module");
    let renamed = [("half_m", "INLINE"), ("rod_x", "double"), ("inv_rod", "fabs"), ("rod_residual", "residuals")];
    let text = renamed.into_iter().fold(text, |text, (from, to)| text.replace(from, to));
    compare("pendulum", &syntax(&text).expect("Rust"), 10);
}

#[test]
#[ignore = "full tier: languages"]
fn matlab_gives_the_same_numbers() {
    let paths = Mutex::new(paths());
    let next = || paths.lock().expect("no other thread has failed").pop();
    std::thread::scope(|scope| {
        for _ in 0..2 {
            scope.spawn(|| {
                while let Some(path) = next() {
                    let (name, module) = module(&path);
                    compare_matlab(&name, &module, STATES);
                }
            });
        }
    });
}

#[test]
#[ignore = "full tier: languages"]
fn names_that_mean_something_in_matlab_are_changed() {
    let text = fs::read_to_string(golden().join("pendulum.rs")).expect("a module");
    let renamed = [("half_m", "end"), ("rod_x", "until"), ("inv_rod", "sin"), ("rod_residual", "residuals")];
    let text = renamed.into_iter().fold(text, |text, (from, to)| text.replace(from, to));
    compare_matlab("pendulum", &syntax(&text).expect("Rust"), 10);
}

/// Compares a module with its translation into C, by each compiler.
fn compare(name: &str, module: &syn::File, states: usize) {
    let program = qrm_language::lower(name, module).expect("an intermediate representation");
    let files = qrm_language::c(&program).expect("a translation");
    assert_eq!(qrm_language::c(&program).as_ref(), Ok(&files), "{name}: the same module, other code");
    let states = State::random(&program, states);
    let wanted = expected(&program, module, &states);
    for compiler in &COMPILERS {
        let given = compiler.run(name, &files, &driver(&program), &states);
        agree(&format!("{name} by {}", compiler.name), &wanted, &given);
    }
}

/// Compares a module with its translation into MATLAB.
fn compare_matlab(name: &str, module: &syn::File, states: usize) {
    let program = qrm_language::lower(name, module).expect("an intermediate representation");
    let files = qrm_language::matlab(&program).expect("a translation");
    assert_eq!(qrm_language::matlab(&program).as_ref(), Ok(&files), "{name}: the same module, other code");
    let states = State::random(&program, states);
    agree(name, &expected(&program, module, &states), &octave::run(&program, &files, &states));
}

/// Compares results, wanted ones with their functions.
fn agree(what: &str, wanted: &[(&str, f64)], given: &[f64]) {
    assert_eq!(given.len(), wanted.len(), "{what}: results");
    for ((function, wanted), given) in wanted.iter().zip(given) {
        let is_same = wanted == given || wanted.is_nan() && given.is_nan();
        let is_near = (wanted - given).abs() <= TOLERANCE * wanted.abs();
        assert!(is_same || is_near, "{function} of {what}: {given:e}, not {wanted:e}");
    }
}

/// A new folder.
fn folder() -> PathBuf {
    // Tests run side by side.
    static FOLDERS: AtomicUsize = AtomicUsize::new(0);
    let folder = FOLDERS.fetch_add(1, Ordering::Relaxed);
    let folder = std::env::temp_dir().join(format!("qrm-translations-{}-{folder}", std::process::id()));
    fs::create_dir_all(&folder).expect("a folder");
    folder
}

#[test]
#[ignore = "full tier: languages"]
fn all_functions_of_numbers_are_translated() {
    let text = fs::read_to_string(golden().join("pendulum.rs")).expect("a module");
    let residual = "-(k.k1 * (k.half_l_sq - R::from_f64(0.5) * (x * x + y * y)))";
    let sum = "k.k1 + x.tanh().asin() + y.tanh().acos() + x.atan() + x.sinh() * y.cosh() + x.exp().ln() + x.abs().sqrt() \
               + y.floor() + x.sign() + x.tan() + x.sin() + y.cos() + x.atan2(y) + x.hypot(y) + x.min(y) + x.max(y) \
               + R::powi(x, 2) + R::pow(R::abs(x), y) + x.abs().powf(1.5) + R::pi() - (x - (y - x)) / (x / y) - -x";
    assert!(text.contains(residual), "{residual}");
    let module = syntax(&text.replace(residual, sum)).expect("Rust");
    compare("pendulum", &module, 100);
    compare_matlab("pendulum", &module, 100);
}

#[test]
fn what_has_no_translation_is_named() {
    let pendulum = fs::read_to_string(golden().join("pendulum.rs")).expect("a module");
    let said = |from: &str, to: &str| {
        assert!(pendulum.contains(from), "{from}");
        let module = syntax(&pendulum.replace(from, to)).expect("Rust");
        qrm_language::lower("pendulum", &module).expect_err(to).to_string()
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
