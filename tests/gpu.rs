//! `qrm sweep --device gpu` and `qrm tolerance --device gpu`: designs of a GPU are those of the cores.
//!
//! In place of a GPU stands `tests/gpu/driver.cpp`, whose kernels are compiled by g++ and run on a core.

#[cfg(feature = "gpu")]
use std::fs;
use std::path::Path;
#[cfg(feature = "gpu")]
use std::process::Command;
use std::process::Output;

use crate::common::qrm;
#[cfg(feature = "gpu")]
use crate::common::{Table, model};

/// Some of these designs cannot be assembled at the start.
const VARY: [&str; 4] = ["--vary", "O2A=0.12:0.28:40", "--vary", "BC=0.3,0.6,0.9"];

/// A folder with the driver.
#[cfg(feature = "gpu")]
fn driver() -> tempfile::TempDir {
    let folder = tempfile::tempdir().expect("a folder");
    let source = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/gpu/driver.cpp");
    let library = folder.path().join("libcuda.so.1");
    let arguments = ["-std=c++17", "-Wall", "-Wextra", "-Werror", "-shared", "-fPIC", source, "-o"];
    let output = Command::new("g++").args(arguments).arg(&library).arg("-ldl").output().expect("g++");
    assert!(output.status.success(), "{}", said(&output));
    fs::copy(&library, folder.path().join("libnvrtc.so.12")).expect("copied");
    folder
}

/// Runs a command on the driver, of which one function may fail.
fn on_gpu(driver: &Path, fails: &str, arguments: &[&str], out: &Path) -> Output {
    let mut command = qrm(arguments);
    command.args(["--device", "gpu", "--out"]).arg(out).env("LD_LIBRARY_PATH", driver).env("FAILS", fails);
    command.output().expect("the command starts")
}

fn said(output: &Output) -> String {
    String::from_utf8_lossy(&[&output.stdout[..], &output.stderr[..]].concat()).into_owned()
}

#[test]
#[cfg(not(feature = "gpu"))]
fn a_program_without_gpus_says_so() {
    let folder = tempfile::tempdir().expect("a folder");
    let output = on_gpu(folder.path(), "", &[&["sweep", "quick-return"], &VARY[..]].concat(), Path::new("never.csv"));
    assert_eq!(output.status.code(), Some(2));
    assert!(said(&output).contains("built without GPUs") && said(&output).contains("--features gpu"));
}

#[test]
#[cfg(feature = "gpu")]
fn designs_are_those_of_the_cores() {
    let (driver, folder) = (driver(), tempfile::tempdir().expect("a folder"));
    let file = |name: &str| folder.path().join(name);
    let slow = ["sweep", "slider-crank", "--vary", "a=0.1:0.2:30", "--until", "q >= 4"];
    for (scene, arguments) in [
        ("quick-return", &[&["sweep", "quick-return"], &VARY[..]].concat()[..]),
        ("quick-return", &[&["sweep", "quick-return", "--end-time", "1", "--tolerance", "1e-11"], &VARY[..]].concat()),
        ("slider-crank", &slow),
        ("andrews", &["sweep", "andrews", "--vary", "m1=0.03:0.05:20"]),
        ("double-pendulum", &["sweep", "double-pendulum", "--vary", "l=0.9:1.1:20", "--method", "auto"]),
    ] {
        let mut of_cores = qrm(arguments);
        let of_cores = of_cores.arg("--out").arg(file("cores.csv")).output().expect("it starts");
        let of_gpu = on_gpu(driver.path(), "", arguments, &file("gpu.csv"));
        assert_eq!(of_gpu.status.code(), of_cores.status.code(), "{}", said(&of_gpu));
        assert!(said(&of_gpu).contains(", on a core") && said(&of_gpu).contains("self-check: "), "{}", said(&of_gpu));
        assert!(!said(&of_gpu).contains("warning"), "{}", said(&of_gpu));
        compare(scene, &Table::read(&file("gpu.csv")), &Table::read(&file("cores.csv")));
        // Whatever the number of cores.
        on_gpu(driver.path(), "", &[arguments, &["--threads", "1"]].concat(), &file("again.csv"));
        assert_eq!(fs::read(file("gpu.csv")).expect("a table"), fs::read(file("again.csv")).expect("a table"));
    }
}

/// Compares two tables: numbers within their errors, texts by letters.
#[cfg(feature = "gpu")]
fn compare(scene: &str, of_gpu: &Table, of_cores: &Table) {
    assert_eq!(of_gpu.columns, of_cores.columns);
    assert_eq!(of_gpu.rows.len(), of_cores.rows.len());
    let place = |name: &str| of_cores.columns.iter().position(|column| column == name);
    let coordinates = model(scene).description.coordinates.iter().map(|coordinate| coordinate.name);
    let outputs = model(scene).description.outputs.iter();
    let extremes = outputs.flat_map(|output| ["min", "max"].map(|end| format!("{}_{end}", output.name)));
    let columns = coordinates.map(|name| (name.to_owned(), "estimated_error".to_owned()));
    let columns = columns.chain(extremes.map(|name| (name.clone(), name + "_error")));
    for (name, error) in columns {
        let (Some(value), Some(error)) = (place(&name), place(&error)) else { continue };
        for (own, other) in of_gpu.rows.iter().zip(&of_cores.rows) {
            let [own, other] = [own, other].map(|row| [value, error].map(|place| row[place].parse::<f64>().ok()));
            let (Some(a), Some(b)) = (own[0], other[0]) else {
                assert_eq!(own[0], other[0], "{scene}: {name}");
                continue;
            };
            let stated = own[1].unwrap_or(0.0) + other[1].unwrap_or(0.0) + 1e-13 * b.abs().max(1.0);
            assert!((a - b).abs() <= stated, "{scene}: {name} {a} {b}, stated {stated:e}");
        }
    }
    for name in ["status", "reason"] {
        let place = place(name).expect("a column");
        assert!(of_gpu.rows.iter().zip(&of_cores.rows).all(|(own, other)| own[place] == other[place]), "{scene}");
    }
}

#[test]
#[cfg(feature = "gpu")]
fn what_a_gpu_cannot_do_the_cores_do() {
    let (driver, folder) = (driver(), tempfile::tempdir().expect("a folder"));
    let file = |name: &str| folder.path().join(name);
    let arguments = &[&["sweep", "quick-return"], &VARY[..]].concat();
    qrm(arguments).arg("--out").arg(file("cores.csv")).output().expect("it starts");
    for (fails, reason) in [
        ("nvrtcCompileProgram", "a line of its log"),
        ("cuLaunchKernel", "unspecified launch failure"),
        ("cuMemAlloc", "the CUDA driver says"),
    ] {
        let output = on_gpu(driver.path(), fails, arguments, &file("gpu.csv"));
        assert!(output.status.success(), "{}", said(&output));
        assert!(
            said(&output).contains("warning: the GPU failed, and the cores ran the remaining designs"),
            "{}",
            said(&output)
        );
        assert!(said(&output).contains(reason), "{}", said(&output));
        assert_eq!(fs::read(file("gpu.csv")).expect("a table"), fs::read(file("cores.csv")).expect("a table"));
    }
    // Loads with corners are for the cores.
    let shaper = ["sweep", "shaper", "--vary", "O2A=0.15,0.16"];
    let output = on_gpu(driver.path(), "", &shaper, &file("shaper.csv"));
    assert!(said(&output).contains("on a core; 2 designs left it for the cores"), "{}", said(&output));
}

/// Where `QRM_NVRTC` is the folder of the run-time compiler of CUDA, which needs no GPU. The driver takes none of its
/// code.
#[test]
#[cfg(feature = "gpu")]
fn steps_compile_for_a_gpu() {
    let Ok(compiler) = std::env::var("QRM_NVRTC") else { return };
    let (driver, folder) = (driver(), tempfile::tempdir().expect("a folder"));
    let libraries = format!("{compiler}:{}", driver.path().display());
    for (scene, vary) in [("quick-return", "O2A=0.2,0.21"), ("andrews", "m1=0.04,0.05"), ("pendulum", "m=1,2")] {
        let arguments = ["sweep", scene, "--vary", vary, "--until", "t >= 0.01"];
        for arguments in [&arguments[..4], &arguments] {
            let output = on_gpu(Path::new(&libraries), "", arguments, &folder.path().join("gpu.csv"));
            assert!(said(&output).contains("the CUDA driver says: DriverError"), "{}", said(&output));
        }
    }
}

#[test]
#[cfg(feature = "gpu")]
fn no_gpu_is_one_line() {
    let (driver, empty) = (driver(), tempfile::tempdir().expect("a folder"));
    let sweep = [&["sweep", "quick-return"], &VARY[..]].concat();
    let tolerance = ["tolerance", "quick-return", "--vary", "O2A=+-0.001"];
    for (folder, fails, arguments, reason) in [
        (empty.path(), "", &sweep[..], "no CUDA driver is installed"),
        (driver.path(), "cuInit", &sweep, "no CUDA-capable device is detected"),
        (driver.path(), "cuInit", &tolerance, "no CUDA-capable device is detected"),
        (driver.path(), "", &[&sweep[..], &["--method", "rk4"]].concat(), "a GPU makes no steps of the method `rk4`"),
        (driver.path(), "", &[&sweep[..], &["--lanes", "one"]].concat(), "`--lanes` is for the cores"),
    ] {
        let output = on_gpu(folder, fails, arguments, &empty.path().join("never.csv"));
        assert_eq!(output.status.code(), Some(2), "{}", said(&output));
        assert!(said(&output).contains(reason), "{}", said(&output));
    }
    assert!(!empty.path().join("never.csv").exists());
}

#[test]
#[cfg(feature = "gpu")]
fn samples_are_those_of_the_cores() {
    let (driver, folder) = (driver(), tempfile::tempdir().expect("a folder"));
    let arguments = ["tolerance", "quick-return", "--vary", "O2A=+-0.001", "--vary", "J2=+-2", "--samples", "2000"];
    let output = on_gpu(driver.path(), "", &arguments, &folder.path().join("gpu"));
    assert!(said(&output).contains("samples on a core"), "{}", said(&output));
    let mut of_cores = qrm(&arguments);
    let of_cores = of_cores.arg("--out").arg(folder.path().join("cores")).output().expect("it starts");
    let table = |output: &Output| {
        said(output).split("samples on").next().map(|text| text.split("wrote").next().map(str::to_owned))
    };
    assert_eq!(table(&output), table(&of_cores));
}
