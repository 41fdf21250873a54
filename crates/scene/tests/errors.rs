//! Every error that a scene can contain, with the complete report for the user.
//!
//! `errors/NAME.toml` is a scene with one error (or several that interact), `errors/NAME.txt` its report, byte for
//! byte. `QRM_REFRESH=1 cargo test -p qrm-scene --test integration errors` rewrites the reports: read the difference
//! before keeping it.

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use qrm_scene::diagnostic::{Report, Severity};
use qrm_scene::resolve::read;
use qrm_scene::source::read_text;

/// Scenes that are usable, with warnings.
const ACCEPTED: [&str; 5] = [
    "joint-angle-held-twice",
    "joint-cam-negative",
    "joint-cam-profile-open",
    "joint-cam-undercut",
    "parameter-unused",
];

#[test]
fn reports_are_as_written() {
    let refresh = std::env::var_os("QRM_REFRESH").is_some();
    let mut wrong = Vec::new();
    for name in names("toml") {
        let path = file(&name, "txt");
        let actual = report(&name).to_string() + "\n";
        let accepted = !report(&name).has_errors();
        if accepted != ACCEPTED.contains(&name.as_str()) {
            wrong.push(format!("{name} is {}accepted\n{actual}", if accepted { "" } else { "not " }));
        } else if refresh {
            fs::write(&path, &actual).expect("the report can be written");
        } else if fs::read_to_string(&path).ok().as_deref() != Some(actual.as_str()) {
            wrong.push(format!("{}\n{actual}", path.display()));
        }
    }
    let (scenes, reports) = (names("toml"), names("txt"));
    let alone: Vec<&String> = scenes.symmetric_difference(&reports).collect();
    assert!(alone.is_empty() && !scenes.is_empty(), "without partner: {alone:?}");
    assert!(wrong.is_empty(), "scenes with other reports than written:\n\n{}", wrong.join("\n"));
}

#[test]
fn every_error_points_at_its_place_and_reports_are_in_the_order_of_lines() {
    for name in names("toml") {
        let report = report(&name);
        let starts: Vec<usize> = report.diagnostics.iter().map(|d| d.span.as_ref().map_or(0, |s| s.start)).collect();
        assert!(starts.is_sorted(), "{name}: {starts:?}");
        for diagnostic in &report.diagnostics {
            let span = diagnostic.span.clone().unwrap_or(0..0);
            assert!(report.source.get(span.clone()).is_some(), "{name}: {span:?} cuts a character or leaves the file");
            assert!(!diagnostic.title.is_empty(), "{name}");
            let mended = diagnostic.help.is_some()
                || diagnostic.title.starts_with("expected ")
                || diagnostic.severity == Severity::Warning;
            assert!(mended, "{name}: `{}` does not say how to mend it", diagnostic.title);
        }
    }
}

#[test]
fn line_ends_of_other_systems_change_no_report() {
    for name in names("toml") {
        let source = scene(&name);
        let (unix, dos) = (places(&name, &source), places(&name, &source.replace('\n', "\r\n")));
        assert_eq!(unix, dos, "{name}");
    }
}

#[test]
fn files_that_are_missing_or_no_text() {
    let missing = read_text(Path::new("no-such-folder/scene.toml")).expect_err("there is no such file");
    assert_eq!(
        missing.to_string(),
        "error: the scene cannot be read: there is no such file\n\
         --> no-such-folder/scene.toml\n\
         \u{20}= help: check its name and its folder"
    );
    let path = std::env::temp_dir().join(format!("qrm-not-text-{}.toml", std::process::id()));
    fs::write(&path, b"name = \"a\"\ndoc = \"m\xe4ssig\"\n").expect("a file");
    let report = read_text(&path).expect_err("no text");
    fs::remove_file(&path).expect("the file is there");
    assert_eq!(
        report.to_string().replace(&path.display().to_string(), "scene.toml"),
        "error: the scene is not UTF-8 text\n\
         \u{20}--> scene.toml:2:9\n\
         \u{20} |\n\
         2 | doc = \"m\u{fffd}ssig\"\n\
         \u{20} |         ^ this byte begins no character\n\
         \u{20} |\n\
         \u{20} = help: save the file as UTF-8"
    );
}

#[test]
fn a_formula_nested_too_deeply_is_an_error_at_its_place() {
    let levels = 100_000;
    let nested = [
        format!("{}1{}", "(".repeat(levels), ")".repeat(levels)),
        format!("{}1", "-".repeat(levels)),
        format!("{}1", "+-".repeat(levels)),
        format!("2{}", "^2".repeat(levels)),
        format!("2{}", "^-2".repeat(levels)),
        format!("{}1{}", "sin(".repeat(levels), ")".repeat(levels)),
        format!("{}1", "(".repeat(levels)),
    ];
    for formula in nested {
        let start: String = formula.chars().take(9).collect();
        let report = read("deep.toml", &with_parameter(&formula)).expect_err("nested too deeply");
        let [only] = &report.diagnostics[..] else { panic!("{start}: {} errors", report.diagnostics.len()) };
        assert_eq!(only.title, "formula nested too deeply", "{start}");
        let text = report.to_string();
        assert!(text.contains(" --> deep.toml:3:"), "{start}: {text}");
        assert!(text.len() < 2_000, "{start}: a report of {} bytes", text.len());
        let column = only.span.as_ref().map_or(0, |s| s.start) - report.source.find("'").expect("a formula") - 1;
        // 200 levels, each of one to four characters.
        assert!((200..=800).contains(&column), "{start}: the level that is too many was found at {column}");
    }
}

#[test]
fn reports_of_very_many_mistakes_are_short() {
    let rest = "name = \"a\"\ncoordinates = [\"q\"]\ninitial.given = {}\nrun = { step = 1, end_time = 1 }\n";
    let keys: String = (0..50_000).map(|i| format!("key{i} = 1\n")).collect();
    let points: String = (0..1_000).map(|i| format!("a{i} = ['b{i}', 'c{i} + d{i}']\n")).collect();
    let coordinates: Vec<String> = (0..50_000).map(|i| format!("'q{i}'")).collect();
    for source in [
        "abc = 1\n".repeat(100_000),
        "= \n".repeat(100_000),
        "= ".repeat(300_000),
        keys,
        format!("{rest}[points]\n{points}"),
        format!("name = 'a'\ncoordinates = [{}]\n", coordinates.join(",")),
        format!("name = 'a'\ncoordinates = ['q']\n[constraints]\n{}", "a.b = 1\n".repeat(10_000)),
    ] {
        let report = read("noise.toml", &source).expect_err("noise");
        assert!(report.has_errors());
        assert!(report.to_string().len() < 10_000, "{} errors", report.diagnostics.len());
    }
}

#[test]
fn values_nested_too_deeply_are_errors_too() {
    let levels = 100_000;
    for (open, close) in [("[", "]"), ("{ a = ", " }"), ("[{ a = ", " }]")] {
        let value = format!("{}1{}", open.repeat(levels), close.repeat(levels));
        let report = read("deep.toml", &format!("name = \"pendulum\"\ncoordinates = {value}\n")).expect_err("too deep");
        assert!(report.has_errors());
        assert!(report.to_string().len() < 2_000, "{open}: {} errors", report.diagnostics.len());
    }
}

#[test]
fn a_long_flat_formula_is_read_quickly() {
    let begin = Instant::now();
    for (term, sum) in [(" + 1", 601.0), (" + 2*(1 - 3)", -2399.0), (" + 2^2", 2401.0)] {
        let formula = format!("1{}", term.repeat(600));
        let (scene, _) = read("long.toml", &with_parameter(&formula)).expect("a long formula is a formula");
        assert_eq!(scene.parameters[0].value, sum);
        let formula = format!("1{}", term.repeat(100_000));
        let report = read("long.toml", &with_parameter(&formula)).expect_err("a formula beyond the limit");
        assert_eq!(report.diagnostics.len(), 1, "{report}");
        assert_eq!(report.diagnostics[0].title, "a formula is too long");
    }
    assert!(begin.elapsed() < Duration::from_secs(20), "took {:?}", begin.elapsed());
}

#[test]
fn scenes_cut_short_or_with_a_character_lost_give_reports() {
    let whole = fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenes/quick-return.toml"));
    let whole = whole.expect("the scene is there");
    for (at, lost) in whole.char_indices().step_by(3) {
        let without = format!("{}{}", &whole[..at], &whole[at + lost.len_utf8()..]);
        for source in [&whole[..at], &without] {
            match read("cut.toml", source) {
                Ok((_, report)) | Err(report) => drop(report.to_string()),
            }
        }
    }
}

/// A scene with a single parameter, whose formula stands in the third line.
fn with_parameter(formula: &str) -> String {
    format!(
        "name = \"pendulum\"\ncoordinates = [\"phi\"]\nparameters = {{ J = '{formula}' }}\n\
         bodies = {{ bob = {{ angle = 'phi', inertia = 'J^2' }} }}\n\
         initial = {{ given = {{ phi = 0, phi_dot = 1 }} }}\nrun = {{ step = 0.01, end_time = 1 }}\n"
    )
}

/// The titles of the findings about a source, with their lines and columns.
fn places(name: &str, source: &str) -> Vec<(String, Option<(usize, usize)>)> {
    let (Ok((_, report)) | Err(report)) = read(name, source);
    let place = |at: usize| {
        let before = report.source[..at].trim_end_matches('\r');
        (before.matches('\n').count() + 1, before.len() - before.rfind('\n').map_or(0, |end| end + 1) + 1)
    };
    report.diagnostics.iter().map(|d| (d.title.clone(), d.span.as_ref().map(|s| place(s.start)))).collect()
}

fn report(name: &str) -> Report {
    let (Ok((_, report)) | Err(report)) = read(&format!("{name}.toml"), &scene(name));
    report
}

fn scene(name: &str) -> String {
    fs::read_to_string(file(name, "toml")).expect("the scene can be read")
}

fn file(name: &str, extension: &str) -> PathBuf {
    folder().join(format!("{name}.{extension}"))
}

fn folder() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/errors")
}

/// The names of the files with this extension.
fn names(extension: &str) -> BTreeSet<String> {
    let entries = fs::read_dir(folder()).expect("the folder of scenes").map(|entry| entry.expect("an entry").path());
    entries
        .filter(|path| path.extension().is_some_and(|e| e == extension))
        .filter_map(|path| path.file_stem()?.to_str().map(str::to_owned))
        .collect()
}
