//! Compares the C and MATLAB code of the golden tapes with the tapes themselves.

mod compiler;
mod driver;
mod libm;
mod octave;
mod states;

use std::fs;
use std::path::PathBuf;
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};

use compiler::COMPILERS;
use driver::driver;
use qrm_core::{NamedTape, Operation};
use qrm_language::Code;
use qrm_language::ir::Program;
use qrm_scene::resolve;
use qrm_scene::scene::Scene;
use states::{State, expected};

/// The number of states for each mechanism.
const STATES: usize = 1000;
/// The largest relative difference.
const TOLERANCE: f64 = 1e-14;

fn golden() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../qrm-model/golden")
}

/// A golden copy.
struct Golden {
    scene: Scene,
    source: String,
    tape: NamedTape,
}

impl Golden {
    fn read(name: &str) -> Self {
        let tape = fs::read(golden().join(format!("{}.tape", name.replace('-', "_")))).expect("a tape");
        let path = format!("{}/../scenes/{name}.toml", env!("CARGO_MANIFEST_DIR"));
        let source = fs::read_to_string(path).expect("a scene");
        let (scene, _) = resolve::read(name, &source).unwrap_or_else(|report| panic!("{report}"));
        Self { scene, source, tape: NamedTape::from_bytes(&tape).expect("whole") }
    }

    fn program(&self) -> Program {
        Code { path: "", scene: &self.scene, source: &self.source, tape: &self.tape }.program()
    }

    /// Renames some values of the functions.
    fn renamed(mut self, names: &[(&str, &str)]) -> Self {
        let other = |name: &mut String| {
            if let Some((_, to)) = names.iter().find(|(from, _)| name == from) {
                *name = (*to).to_owned();
            }
        };
        for function in &mut self.tape.functions {
            function.statements.iter_mut().flat_map(|statement| &mut statement.names).for_each(other);
            function.parts.iter_mut().for_each(|part| other(&mut part.name));
        }
        self
    }
}

/// All golden copies.
fn all() -> Vec<Golden> {
    let files = fs::read_dir(golden()).expect("the golden copy").map(|entry| entry.expect("a file").path());
    let tapes = files.filter(|path| path.extension().is_some_and(|e| e == "tape"));
    let mut names: Vec<String> =
        tapes.map(|path| path.file_stem().expect("a name").to_string_lossy().replace('_', "-")).collect();
    names.sort();
    assert!(names.len() > 10, "{names:?}");
    names.iter().map(|name| Golden::read(name)).collect()
}

#[test]
#[ignore = "full tier: languages"]
fn c_gives_the_same_numbers() {
    all().iter().for_each(|golden| compare(golden, STATES));
}

#[test]
#[ignore = "full tier: languages"]
fn names_that_mean_something_in_c_are_changed() {
    let renamed = [("half_m", "INLINE"), ("rod_x", "double"), ("inv_rod", "fabs"), ("rod_residual", "residuals")];
    compare(&Golden::read("pendulum").renamed(&renamed), 10);
}

#[test]
#[ignore = "full tier: languages"]
fn matlab_gives_the_same_numbers() {
    let all = Mutex::new(all());
    let next = || all.lock().expect("no other thread has failed").pop();
    std::thread::scope(|scope| {
        for _ in 0..2 {
            scope.spawn(|| {
                while let Some(golden) = next() {
                    compare_matlab(&golden, STATES);
                }
            });
        }
    });
}

#[test]
#[ignore = "full tier: languages"]
fn names_that_mean_something_in_matlab_are_changed() {
    let renamed = [("half_m", "end"), ("rod_x", "until"), ("inv_rod", "sin"), ("rod_residual", "residuals")];
    compare_matlab(&Golden::read("pendulum").renamed(&renamed), 10);
}

/// Compares a tape with its code in C, by each compiler.
fn compare(golden: &Golden, states: usize) {
    let program = golden.program();
    let files = qrm_language::c(&program).expect("code");
    assert_eq!(qrm_language::c(&golden.program()).as_ref(), Ok(&files), "{}: the same tape, other code", program.name);
    let states = State::random(&program, states);
    let wanted = expected(&program, &golden.tape, &states);
    for compiler in &COMPILERS {
        let given = compiler.run(&program.name, &files, &driver(&program), &states);
        agree(&format!("{} by {}", program.name, compiler.name), &wanted, &given);
    }
}

/// Compares a tape with its code in MATLAB.
fn compare_matlab(golden: &Golden, states: usize) {
    let program = golden.program();
    let files = qrm_language::matlab(&program).expect("code");
    assert_eq!(qrm_language::matlab(&golden.program()).as_ref(), Ok(&files), "{}: other code", program.name);
    let states = State::random(&program, states);
    agree(&program.name, &expected(&program, &golden.tape, &states), &octave::run(&program, &files, &states));
}

/// Compares results with expected ones, which carry the names of their functions.
fn agree(what: &str, wanted: &[(&str, f64)], given: &[f64]) {
    assert_eq!(given.len(), wanted.len(), "{what}: results");
    for ((function, wanted), given) in wanted.iter().zip(given) {
        let is_same = wanted == given || wanted.is_nan() && given.is_nan();
        let is_near = (wanted - given).abs() <= TOLERANCE * wanted.abs();
        assert!(is_same || is_near, "{function} of {what}: {given:e}, not {wanted:e}");
    }
}

/// Creates a new folder.
fn folder() -> PathBuf {
    // Tests run in parallel.
    static FOLDERS: AtomicUsize = AtomicUsize::new(0);
    let folder = FOLDERS.fetch_add(1, Ordering::Relaxed);
    let folder = std::env::temp_dir().join(format!("qrm-translations-{}-{folder}", std::process::id()));
    fs::create_dir_all(&folder).expect("a folder");
    folder
}

#[test]
#[ignore = "full tier: languages"]
fn all_operations_are_written() {
    use Operation as Op;
    let mut golden = Golden::read("pendulum");
    let tape = &mut golden.tape;
    let [x, y] = [0, 1].map(|i| tape.input(qrm_core::named_tape::Argument::Coordinates) + i);
    let unary =
        [Op::Tanh, Op::Atan, Op::Sinh, Op::Cosh, Op::Exp, Op::Abs, Op::Floor, Op::Sign, Op::Tan, Op::Recip, Op::Neg];
    let mut values: Vec<u32> = unary.iter().flat_map(|own| [x, y].map(own)).map(|own| tape.operation(own)).collect();
    let binary = [Op::Atan2, Op::Hypot, Op::Min, Op::Max, Op::Add, Op::Sub, Op::Mul, Op::Div];
    values.extend(
        binary.iter().flat_map(|own| [own(x, y), own(y, x)]).map(|own| tape.operation(own)).collect::<Vec<_>>(),
    );
    let [tanh, absolute] = [Op::Tanh(x), Op::Abs(x)].map(|own| tape.operation(own));
    let more = [Op::Asin(tanh), Op::Acos(tanh), Op::Ln(absolute), Op::Sqrt(absolute), Op::Sin(x), Op::Cos(y)];
    values.extend(more.map(|own| tape.operation(own)));
    let powers = [Op::PowI(x, 2), Op::Pow(absolute, y), Op::PowF(absolute, 1.5), Op::PowF(absolute, -0.5), Op::Pi];
    values.extend(powers.map(|own| tape.operation(own)));
    values
        .extend([Op::MulAdd(x, y, tanh), Op::NegMulAdd(x, y, tanh), Op::Number(-0.25)].map(|own| tape.operation(own)));
    // Operands in all positions that need parentheses.
    let [sum, product, negative] = [Op::Sub(x, y), Op::Mul(x, y), Op::Neg(x)].map(|own| tape.operation(own));
    for a in [sum, product, negative] {
        for b in [sum, product, negative] {
            values.extend([Op::Sub(a, b), Op::Div(a, b), Op::Mul(a, b)].map(|own| tape.operation(own)));
        }
    }
    let function = tape.functions.iter_mut().find(|own| own.name == "com_positions").expect("a function");
    function.statements.clear();
    function.parts[0].values = qrm_core::named_tape::Shape::Vector(values);
    compare(&golden, 100);
    compare_matlab(&golden, 100);
}

#[test]
fn names_that_no_language_has_are_named() {
    let golden = Golden::read("pendulum").renamed(&[("rod_x", "größe")]);
    let said = qrm_language::c(&golden.program()).expect_err("a name").to_string();
    assert_eq!(said, "no translation of the name `größe`");
    let long = "x".repeat(64);
    let golden = Golden::read("pendulum").renamed(&[("rod_x", &long)]);
    let said = qrm_language::matlab(&golden.program()).expect_err("a name").to_string();
    assert_eq!(said, format!("no translation of the name `{long}`, which is longer than 63 letters"));
}
