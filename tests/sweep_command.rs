//! `qrm sweep`, `qrm merge` and `qrm explain` as a user calls them.

use std::fs;
use std::path::Path;
use std::process::Output;

use crate::common::{Table, qrm};

const VARY: [&str; 4] = ["--vary", "O2A=0.12:0.28:40", "--vary", "BC=0.3,0.6,0.9"];

fn sweep(arguments: &[&str], folder: &Path, out: &str) -> Output {
    let mut command = qrm(&["sweep", "quick-return"]);
    command.args(arguments).arg("--out").arg(folder.join(out));
    command.output().expect("the command starts")
}

fn said(output: &Output) -> String {
    String::from_utf8_lossy(&[&output.stdout[..], &output.stderr[..]].concat()).into_owned()
}

fn read(folder: &Path, file: &str) -> Vec<u8> {
    fs::read(folder.join(file)).unwrap_or_else(|e| panic!("{file}: {e}"))
}

#[test]
fn rows_do_not_depend_on_cores_lanes_or_parts() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    let whole = sweep(&VARY, folder, "whole.csv");
    assert!(whole.status.success(), "{}", said(&whole));
    sweep(&[&VARY[..], &["--threads", "1", "--lanes", "four"]].concat(), folder, "four.csv");
    assert_eq!(read(folder, "whole.csv"), read(folder, "four.csv"));
    for part in ["1/3", "2/3", "3/3"] {
        sweep(&[&VARY[..], &["--shard", part]].concat(), folder, &format!("{}.csv", &part[..1]));
    }
    let endings: &[&str] = if cfg!(feature = "parquet") { &["csv", "parquet"] } else { &["csv"] };
    for ending in endings {
        assert!(sweep(&VARY, folder, &format!("whole.{ending}")).status.success());
        let mut merge = qrm(&["merge"]);
        merge.arg(folder.join(format!("merged.{ending}")));
        let output =
            merge.args(["1", "2", "3"].map(|part| folder.join(format!("{part}.csv")))).output().expect("starts");
        assert!(output.status.success(), "{}", said(&output));
        assert_eq!(read(folder, &format!("merged.{ending}")), read(folder, &format!("whole.{ending}")));
    }
    let table = Table::read(&folder.join("whole.csv"));
    assert_eq!(table.rows.len(), 120);
    // A rod of 0.3 m reaches the guide in every position only of short cranks.
    let status = table.columns.iter().position(|name| name == "status").expect("a column");
    let failed = table.rows.iter().filter(|row| row[status] == "failed").count();
    assert!((20..60).contains(&failed), "{failed} failed");
    assert!(table.rows.iter().all(|row| (row[status] == "failed") != row[status + 1].is_empty()));
}

#[test]
fn an_interrupted_sweep_goes_on_where_it_was() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    sweep(&VARY, folder, "whole.csv");
    let whole = String::from_utf8(read(folder, "whole.csv")).expect("text");
    let journal = folder.join("again.csv.under-way");
    fs::write(&journal, "# another sweep\ndesign\n0,done,\n").expect("written");
    let refused = sweep(&VARY, folder, "again.csv");
    assert_eq!(refused.status.code(), Some(2));
    assert!(said(&refused).contains("another sweep"), "{}", said(&refused));
    // Wherever a sweep was killed: what stands behind the last whole block is computed again.
    let rows = under_way(folder);
    let marks: Vec<usize> = rows.match_indices("\n# ").map(|(place, _)| place + 1).collect();
    let mid = (marks[0] + rows.len()) / 2;
    for cut in [0, 5, rows.find('\n').expect("a line") + 9, mid, rows.len() - 1, rows.len()] {
        fs::write(&journal, &rows[..cut]).expect("written");
        let resumed = sweep(&VARY, folder, "again.csv");
        assert!(resumed.status.success(), "cut at {cut}: {}", said(&resumed));
        assert_eq!(said(&resumed).contains("continues after"), cut == rows.len(), "{}", said(&resumed));
        assert_eq!(read(folder, "again.csv"), whole.as_bytes(), "cut at {cut}");
        assert!(!journal.exists());
    }
    // Rows that were changed meanwhile are no rows of it.
    for (from, to) in [("\n1,", "\n7,"), ("\n1,", "\n1,1,"), ("done", "gone"), (",0.1", ",0.2")] {
        fs::write(&journal, rows.replacen(from, to, 1)).expect("written");
        let refused = sweep(&VARY, folder, "again.csv");
        assert_eq!(refused.status.code(), Some(2), "{to}");
        assert!(said(&refused).contains("was changed in or before line "), "{}", said(&refused));
    }
}

#[test]
fn parts_that_are_not_those_of_one_sweep_are_refused() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = |name: &str| folder.path().join(name);
    for part in ["1/3", "2/3", "3/3"] {
        sweep(&[&VARY[..], &["--shard", part]].concat(), folder.path(), &format!("{}.csv", &part[..1]));
    }
    let merge = |parts: &[&str]| {
        let mut command = std::process::Command::new(env!("CARGO_BIN_EXE_qrm"));
        command.arg("merge").arg(path("all.csv")).args(parts.iter().map(|part| path(part)));
        command.output().expect("the command ends")
    };
    assert!(merge(&["1.csv", "2.csv", "3.csv"]).status.success());
    let units = |name: &str| fs::read_to_string(path(name)).expect("units");
    assert_eq!(units("all.units.json"), units("1.units.json"));
    let second = fs::read_to_string(path("2.csv")).expect("a part");
    let of_second = fs::read_to_string(path("2.part.json")).expect("its identity");
    let put = |name: &str, table: &str, part: &str| {
        fs::write(path(&format!("{name}.csv")), table).expect("written");
        fs::write(path(&format!("{name}.part.json")), part).expect("written");
    };
    put("cut", &second[..second.len() - 1], &of_second);
    put("changed", &second.replacen("done", "gone", 1), &of_second);
    put("noise", &second, "{}");
    fs::write(path("alone.csv"), &second).expect("written");
    for (vary, name) in [("O2A=0.12:0.28:40", "same"), ("O2A=0.12:0.29:40", "values"), ("O2A=0.12:0.28:41", "count")] {
        let others = ["--vary", vary, "--vary", "BC=0.3,0.6,0.9", "--shard", "2/3"];
        sweep(&others, folder.path(), &format!("{name}.csv"));
    }
    sweep(&[&VARY[..], &["--shard", "2/3", "--set", "J2=50"]].concat(), folder.path(), "set.csv");
    assert!(merge(&["1.csv", "same.csv", "3.csv"]).status.success());
    let all = read(folder.path(), "all.csv");
    for (parts, words) in [
        (&["2.csv", "3.csv"][..], "begins with design 40 instead of 0"),
        (&["1.csv", "3.csv"], "begins with design 80 instead of 40"),
        (&["1.csv", "1.csv"], "begins with design 0 instead of 40"),
        (&["1.csv", "2.csv"], "2.csv is not the last part"),
        (&["1.csv", "cut.csv"], "changed or cut off"),
        (&["1.csv", "changed.csv"], "changed or cut off"),
        (&["1.csv", "noise.csv"], "no part of a sweep"),
        (&["1.csv", "alone.csv"], "keep both together"),
        (&["1.csv", "values.csv"], "different sweeps"),
        (&["1.csv", "count.csv"], "different sweeps"),
        (&["1.csv", "set.csv"], "different sweeps"),
        (&["1.csv", "2.csv", "all.csv"], "both a part and the table to write"),
        (&["1.csv", "2.csv", "./all.csv"], "both a part and the table to write"),
    ] {
        let output = merge(parts);
        assert_eq!(output.status.code(), Some(2), "{parts:?}: {}", said(&output));
        assert!(said(&output).contains(words), "{parts:?}: {}", said(&output));
        assert_eq!(read(folder.path(), "all.csv"), all, "{parts:?}");
    }
}

#[test]
#[ignore = "full tier: compiled"]
fn parts_that_are_cut_off_at_any_byte_are_refused() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = |name: &str| folder.path().join(name);
    let vary = ["--vary", "O2A=0.12:0.28:4", "--end-time", "0.05"];
    for part in ["1/2", "2/2"] {
        sweep(&[&vary[..], &["--shard", part]].concat(), folder.path(), &format!("{}.csv", &part[..1]));
    }
    let merge = || {
        let mut command = std::process::Command::new(env!("CARGO_BIN_EXE_qrm"));
        command.arg("merge").args(["all.csv", "1.csv", "2.csv"].map(path)).output().expect("the command ends")
    };
    assert!(merge().status.success());
    let all = read(folder.path(), "all.csv");
    for name in ["2.csv", "2.part.json"] {
        let whole = read(folder.path(), name);
        for cut in 0..whole.len() {
            fs::write(path(name), &whole[..cut]).expect("written");
            let output = merge();
            // A line break at the end of a description says nothing.
            let is_whole = name.ends_with(".json") && whole[cut..].trim_ascii().is_empty();
            assert_eq!(output.status.success(), is_whole, "{name} cut at {cut}: {}", said(&output));
            assert_eq!(read(folder.path(), "all.csv"), all, "{name} cut at {cut}");
        }
        fs::write(path(name), &whole).expect("written");
    }
}

#[test]
fn designs_that_cannot_be_are_rows_with_their_reason() {
    let folder = tempfile::tempdir().expect("a folder");
    let output = sweep(&["--vary", "m3=-1,0.5", "--end-time", "1e-12"], folder.path(), "a.csv");
    assert!(output.status.success(), "{}", said(&output));
    let table = String::from_utf8(read(folder.path(), "a.csv")).expect("text");
    let rows: Vec<&str> = table.lines().collect();
    assert!(rows[1].starts_with("0,-1.0,failed,body `block` has a negative mass: -1,,"), "{}", rows[1]);
    assert!(rows[2].starts_with("1,0.5,done,,1e-12,1,"), "{}", rows[2]);
}

#[test]
fn a_design_that_a_run_would_refuse_is_refused() {
    let folder = tempfile::tempdir().expect("a folder");
    for (arguments, good, reason) in [
        (
            &["quick-return-loaded", "--method", "rk4", "--vary", "J2=0,100", "--end-time", "0.5"][..],
            1,
            "the energy changed by ",
        ),
        (&["double-pendulum", "--vary", "a0=2.1,0.1", "--end-time", "30"], 1, "the estimated error of `"),
    ] {
        let mut command = qrm(&["sweep"]);
        command.args(arguments).arg("--out").arg(folder.path().join("a.csv"));
        let output = command.output().expect("the command starts");
        assert!(output.status.success(), "{}", said(&output));
        let table = Table::read(&folder.path().join("a.csv"));
        assert_eq!([table.text(0, "status"), table.text(good, "status")], ["failed", "done"], "{arguments:?}");
        assert!(table.text(0, "reason").starts_with(reason), "{arguments:?}: {}", table.text(0, "reason"));
    }
}

/// A table under way with all its rows, seen while it cannot be finished: file systems have no names so long that the
/// table could be written beside its place first.
fn under_way(folder: &Path) -> String {
    let name = format!("{}.csv", "s".repeat(241));
    assert!(!sweep(&VARY, folder, &name).status.success());
    fs::read_to_string(folder.join(format!("{name}.under-way"))).expect("a table under way")
}

#[test]
fn wrong_use_is_refused_in_words() {
    let folder = tempfile::tempdir().expect("a folder");
    for (arguments, out, words) in [
        (&["--vary", "O2B=1,2"][..], "a.csv", "did you mean"),
        (&["--vary", "O2A"], "a.csv", "has no `=`"),
        (&["--vary", "O2A=1:2"], "a.csv", "neither one `:` list nor three parts"),
        (&["--vary", "O2A=0.1:0.2:0"], "a.csv", "asks for `0` values"),
        (&["--vary", "O2A=0.1:x:3"], "a.csv", "contains the name `x`"),
        (&["--vary", "O2A=0.1,0.2", "--vary", "O2A=0.3"], "a.csv", "for the second time"),
        (&["--vary", "O2A=0.1,0.2", "--set", "O2A=0.3"], "a.csv", "both set and varied"),
        (&["--vary", "g=1,2"], "a.csv", "exactly zero"),
        (&["--vary", "O2A=0:1:1000000", "--vary", "J2=1:2:1000000"], "a.csv", "more than"),
        (&["--vary", "O2A=0.1,0.2", "--shard", "3/2"], "a.csv", "is not a part of a whole"),
        (&["--vary", "O2A=0.1,0.2", "--shard", "1/2"], "a.parquet", "is written as CSV"),
        (&["--vary", "O2A=0.1,0.2", "--step", "0.01"], "a.csv", "needs a method of fixed steps"),
        (&["--vary", "O2A=0.1,0.2", "--method", "rk4", "--tolerance", "1e-9"], "a.csv", "needs a method that chooses"),
        (&["--vary", "O2A=0.1,0.2", "--tolerance", "0"], "a.csv", "--tolerance"),
        (&["--vary", "O2A=0.1,0.2"], "a.csv/", "is a folder"),
        (&["--vary", "O2A=0.1,0.2"], "a.txt", "neither `.csv` nor `.parquet`"),
        (&["--vary", "O2A=0.1,0.2", "--until", "phi9 > 1"], "a.csv", "phi9"),
    ] {
        let output = sweep(arguments, folder.path(), out);
        assert_eq!(output.status.code(), Some(2), "{arguments:?}: {}", said(&output));
        assert!(said(&output).contains(words), "{arguments:?}: {}", said(&output));
        assert!(!folder.path().join(out).exists());
    }
    let none = sweep(&["--vary", "BC=0.1,0.2"], folder.path(), "none.csv");
    assert_eq!(none.status.code(), Some(1), "{}", said(&none));
    assert!(folder.path().join("none.csv").exists());
}

#[test]
fn a_condition_of_the_command_line_knows_the_design() {
    let folder = tempfile::tempdir().expect("a folder");
    let output = sweep(&["--vary", "O2A=0.2,0.25", "--until", "x6 <= -3*O2A"], folder.path(), "a.csv");
    assert!(output.status.success(), "{}", said(&output));
    let table = Table::read(&folder.path().join("a.csv"));
    let x6 = [0, 1].map(|row| 0.7 * table.number(row, "phi4").cos() + 0.6 * table.number(row, "phi5").cos());
    assert!((x6[0] + 0.6).abs() < 1e-12 && (x6[1] + 0.75).abs() < 1e-12, "{x6:?}");
    let output = sweep(&["--vary", "O2A=0.1,0.2", "--until", "phi2 >= 10*O2A"], folder.path(), "a.csv");
    assert!(output.status.success(), "{}", said(&output));
    let table = Table::read(&folder.path().join("a.csv"));
    let phi2 = [0, 1].map(|row| table.number(row, "phi2"));
    assert!((phi2[0] - 1.0).abs() < 1e-12 && (phi2[1] - 2.0).abs() < 1e-12, "{phi2:?}");
}

#[test]
fn the_kernel_takes_few_operations_and_says_so() {
    let output = qrm(&["explain", "quick-return"]).output().expect("the command starts");
    let text = said(&output);
    let line = text.lines().find(|line| line.contains("by the kernel")).expect("a count");
    let count: usize = line.split_whitespace().next().and_then(|word| word.parse().ok()).expect("a number");
    assert!((90..=110).contains(&count), "{line}");
    for reason in ["J3 and all it multiplies: exactly zero", "zero by structure", "y of body `ram`: is constant"] {
        assert!(text.contains(reason), "{reason} is not in\n{text}");
    }
}

#[test]
#[ignore = "full tier: engine"]
fn a_form_that_does_not_serve_all_designs_is_not_taken() {
    let source = fs::read_to_string("scenes/quick-return-loaded.toml").expect("a scene");
    let source = source.replace("phi4 = 1.0", "phi4 = 'guess'");
    let source = source.replace("[parameters]", "[parameters]\nguess = { value = 1.0, unit = \"rad\" }");
    let folder = tempfile::tempdir().expect("a folder");
    let scene = folder.path().join("guess.toml");
    fs::write(&scene, source).expect("written");
    let last = |guesses: &str| {
        let out = folder.path().join("sweep.csv");
        let set = ["O2A=0.301", "BC=2", "BG5=1"].map(|set| ["--set", set]).concat();
        let output = qrm(&[&["sweep", "--end-time", "0.5", "--vary", guesses][..], &set].concat())
            .args([&scene, Path::new("--out"), &out])
            .output()
            .expect("the command starts");
        let said = String::from_utf8_lossy(&output.stderr);
        assert!(output.status.success(), "{said}");
        let table = Table::read(&out);
        (table.number(table.last(), "phi2"), said.contains("is taken as"))
    };
    // From the last guess the rocker is mirrored, and its motion is another one.
    let (regular, is_rewritten) = last("guess=1.0,1.1");
    let (mirrored, mirrored_is_rewritten) = last("guess=1.0,4.1");
    assert!(is_rewritten && !mirrored_is_rewritten && (regular - mirrored).abs() > 0.01, "{regular} {mirrored}");
}

#[test]
#[ignore = "full tier: engine"]
fn one_form_of_a_constraint_serves_all_designs() {
    let folder = tempfile::tempdir().expect("a folder");
    let set = ["BC=2", "BG5=1"].map(|set| ["--set", set]).concat();
    let vary = ["sweep", "quick-return-loaded", "--vary", "O2A=0.28,0.32", "--end-time", "1"];
    let output = qrm(&[&vary[..], &set].concat()).current_dir(folder.path()).output().expect("the command starts");
    let said = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success() && said.contains("is taken as `A.x*sin(phi4) - A.y*cos(phi4)` instead"), "{said}");
    let said = String::from_utf8_lossy(&output.stdout);
    assert!(said.contains("2 done, 0 failed"), "{said}");
}

/// An oscillator with an output that has a narrow peak between the steps of a lane.
const NARROW: &str = r#"
name = "narrow"
coordinates = [{ name = "x", unit = "m" }]
[parameters]
k = { value = 4, unit = "N/m" }
w = { value = 0.01, unit = "s" }
[points]
P = ['x', '0']
[bodies]
b = { mass = '1', com = "P" }
[loads]
s = { along = 'x', spring = 'k' }
[initial]
given = { x = 1, x_dot = 0 }
[outputs]
peak = { value = 'PEAK' }
wide = { value = 'exp(-(t - 1)^2)' }
[run]
step = 1e-2
end_time = 2
"#;

#[test]
#[ignore = "full tier: engine"]
fn lanes_find_narrow_peaks() {
    let folder = tempfile::tempdir().expect("a folder");
    let scene = folder.path().join("narrow.toml");
    for (peak, width) in [("exp(-((t - 1.2345)/w)^2)", "w=0.01"), ("1/(1 + ((t - 1.2345)/w)^2)", "w=0.001")] {
        fs::write(&scene, NARROW.replace("PEAK", peak)).expect("a scene");
        let out = folder.path().join("sweep.csv");
        let mut command = qrm(&["sweep"]);
        command.arg(&scene).args(["--vary", "k=3:5:24", "--set", width, "--out"]).arg(&out);
        let output = command.output().expect("the command starts");
        assert!(output.status.success() && !said(&output).contains("warning"), "{}", said(&output));
        let table = Table::read(&out);
        for design in 0..24 {
            let off = (table.number(design, "peak_max") - 1.0).abs();
            let stated = table.number(design, "peak_max_error");
            assert!(off <= 3.0 * stated && stated < 1e-9, "{peak} of design {design}: off by {off:e}");
        }
    }
}

/// A pulse whose width is a formula of the varied parameter: a mass gains the speed `w sqrt(pi)`.
#[test]
#[ignore = "full tier: engine"]
fn steps_see_pulses_of_every_width() {
    let folder = tempfile::tempdir().expect("a folder");
    let scene = folder.path().join("pulse.toml");
    let text = r#"
name = "pulse"
coordinates = [{ name = "x", unit = "m" }]
parameters = { n = 1, w = '10^(-n)' }
points = { P = ['x', '0'] }
bodies = { b = { mass = 1, com = "P" } }
loads = { F = { force = ['exp(-((t - 1)/w)^2)', '0'], on = "b" } }
initial = { given = { x = 0, x_dot = 0 } }
run = { step = 0.1, end_time = 2 }
"#;
    fs::write(&scene, text).expect("a scene");
    let out = folder.path().join("sweep.csv");
    let mut command = qrm(&["sweep"]);
    command.arg(&scene).args(["--vary", "n=1,2,4,6", "--out"]).arg(&out);
    let output = command.output().expect("the command starts");
    assert!(output.status.success(), "{}", said(&output));
    let table = Table::read(&out);
    for (design, n) in [1, 2, 4, 6].into_iter().enumerate() {
        let exact = 10.0_f64.powi(-n) * std::f64::consts::PI.sqrt();
        let off = (table.number(design, "x_dot") - exact).abs();
        assert!(off < 1e-8, "n = {n}: off by {off:e}");
    }
}
