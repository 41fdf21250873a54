//! Tests of wrong use of the command line and its messages, and of interrupted and impossible runs.

use std::io::{BufRead, BufReader};
use std::path::Path;
use std::process::{Output, Stdio};
use std::time::{Duration, Instant};

use snapbox::{Assert, IntoData, Redactions, str};

use crate::common;
use crate::common::{near, qrm, run};

fn text(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).into_owned()
}

/// Asserts exit status and error output of `qrm ARGUMENTS`.
#[track_caller]
fn wrong_use(arguments: &[&str], expected: impl IntoData) {
    let Output { status, stdout, stderr } = qrm(arguments).output().expect("the command starts");
    assert_eq!((status.code(), text(&stdout)), (Some(2), String::new()), "{}", text(&stderr));
    Assert::new().eq(text(&stderr), expected);
}

#[test]
fn parameters_that_cannot_be_set() {
    wrong_use(
        &["run", "--set", "O2B=0.3"],
        str![[r#"
error: scene `quick-return` has no parameter `O2B`
  = help: did you mean `O2A`?

"#]],
    );
    wrong_use(
        &["run", "--set", "J3=0.1"],
        str![[r#"
error: parameter `J3` is exactly zero in scene `quick-return`, so the generated code does without it
  = help: add `runtime = true` to `J3` in the scene, or give it a value there; build again if it is compiled

"#]],
    );
    wrong_use(
        &["run", "--set", "O2A"],
        str![[r#"
error: `--set O2A` has no `=`
  = help: write `--set NAME=VALUE`

"#]],
    );
    wrong_use(
        &["run", "--set", "O2A=two"],
        str![[r#"
error: `--set O2A` needs a number, but `two` contains the name `two`
  = help: only numbers, `pi` and functions can stand here

"#]],
    );
    wrong_use(
        &["run", "--set", "O2A=0/0"],
        str![[r#"
error: `--set O2A` needs a number, but `0/0` gives NaN

"#]],
    );
    wrong_use(
        &["run", "--set", "m3=-1"],
        str![[r#"
error: body `block` has a negative mass
  --> scenes/quick-return.toml:42:20
   |
42 | block  = { mass = 'm3', com = 'A', angle = 'phi4', inertia = 'J3' }
   |                    ^^ its value is -1
   |
   = help: a mass must be zero or positive

"#]],
    );
}

#[test]
fn steps_and_ends_that_make_no_sense() {
    for (step, said) in [("0", "0"), ("-1e-3", "-0.001")] {
        let expected = format!("error: `--step` must be above zero, but is {said}\n");
        wrong_use(&["run", "--step", step], expected);
    }
    wrong_use(
        &["run", "--step", "nan"],
        str![[r#"
error: `--step` needs a number, but `nan` contains the name `nan`
  = help: only numbers, `pi` and functions can stand here

"#]],
    );
    wrong_use(
        &["run", "--step", "1e-300"],
        str![[r#"
error: a step of 1e-300 s is too short for a run of 10 s: it is below the resolution of the time
  = help: use a longer step or an earlier end

"#]],
    );
    wrong_use(
        &["run", "--end-time", "-1"],
        str![[r#"
error: `--end-time` must be above zero, but is -1

"#]],
    );
    wrong_use(
        &["run", "--until", "phi2 >= phi6"],
        str![[r#"
error: unknown name `phi6`
 --> --until:1:9
  |
1 | phi2 >= phi6
  |         ^^^^ not known
  |
  = help: did you mean `phi2`?

"#]],
    );
}

#[test]
fn plots_that_cannot_be_made() {
    for (plot, said) in [
        ("x7:phi2", "scene `quick-return` has no column `x7`\n  = help: did you mean `x6`?"),
        (
            "x6:2*phi2",
            "scene `quick-return` has no column `2*phi2`\n  = help: write a formula as an output under [outputs], and \
             plot that",
        ),
        ("Z.y:C.x", "scene `quick-return` has no point `Z`\n  = help: its points: O2, O4, A, B, C"),
        (
            "C.x_dot",
            "there is no column `C.x_dot`\n  = help: components of points are `C.x` and `C.y`; their rates become \
             columns under [outputs], such as `C_x_dot = { rate = 'C.x', unit = \"m/s\" }`",
        ),
    ] {
        wrong_use(&["run", "--plot", plot], format!("error: {said}\n"));
        wrong_use(&["report", "--plot", plot], format!("error: {said}\n"));
    }
    let usage = "\n  = help: write `--plot Y:X`, or `--plot Y1,Y2:X` for two curves\n";
    for (plot, said) in [
        ("x6:", "lacks a name"),
        ("x6,:phi2", "lacks a name"),
        ("", "lacks a name"),
        ("x6:phi2:phi4", "has two `:`"),
        ("x6:phi2,phi4", "has two abscissae"),
        ("x6,x6:phi2", "has `x6` twice"),
        ("x6:x6", "has `x6` twice"),
    ] {
        wrong_use(&["run", "--plot", plot], format!("error: `--plot {plot}` {said}{usage}"));
    }
    wrong_use(
        &["run", "--plot", "x6:phi2", "--plot", "x6: phi2"],
        "error: `--plot x6: phi2` is given twice\n  = help: keep one of the two\n",
    );
    wrong_use(
        &["run", "--plot", "phi2,phi4,phi5,x6,N3,N6,energy"],
        "error: `--plot phi2,phi4,phi5,x6,N3,N6,energy` has 7 curves, and more than 6 cannot be told apart\n  = help: \
         make several plots of them\n",
    );
}

#[test]
fn a_scene_that_is_not_there() {
    wrong_use(
        &["run", "quick-retrun"],
        str![[r#"
error: there is no scene `quick-retrun`
  = help: did you mean `quick-return`?

"#]],
    );
}

#[test]
fn a_mechanism_that_cannot_be_assembled() {
    wrong_use(
        &["run", "--set", "yC=1.3"],
        str![[r#"
error: the mechanism cannot be assembled: constraint `guide` stays 0.117565 m from closed
  --> scenes/quick-return.toml:49:23
   |
49 | guide = { residual = 'C.y - yC', unit = "m", doc = "the ram stays on its guide" }
   |                       ^^^^^^^^ not zero anywhere near the first guesses; nearest at phi2 = 0.000000, phi4 = 0.982794, phi5 = 1.570796
   |
   = help: check the lengths that occur here, or choose other guesses in [initial]; give no more positions than there are degrees of freedom, and the others as guesses in `solve`

"#]],
    );
}

#[test]
fn a_crank_that_never_turns_twice() {
    let run = run(&["--set", "w0=3.0"]);
    assert_eq!(run.status(), 1);
    let expected = "error: `abs(phi2) >= 4*pi` did not become true by the latest end, t = 10 s: it was nearest at t = \
                    8.016 s, 10.9496043 short, and has moved away since\n";
    Assert::new().eq(run.stderr(), expected);
    assert_eq!(run.summary()["status"], "stop_not_reached");
    near("end", run.summary()["end_time"].as_f64().expect("a number"), 10.0, 0.0);
    assert_eq!(run.trajectory().rows.len(), 10_001);
}

#[test]
fn a_run_that_breaks_off_keeps_its_rows() {
    let run = run(&["quick-return-loaded", "--set", "cd=1e7", "--end-time", "0.05"]);
    assert_eq!(run.status(), 1);
    assert!(run.stderr().starts_with("error: broke off after t = "), "{}", run.stderr());
    assert!(run.stderr().contains("constraint `guide` could not be closed again"), "{}", run.stderr());
    assert_eq!(run.summary()["status"], "failed");
    let trajectory = run.trajectory();
    let broken_at = run.summary()["end_time"].as_f64().expect("a number");
    near("last row", trajectory.number(trajectory.last(), "t"), broken_at, 0.0);
    for row in 0..trajectory.rows.len() {
        assert!(trajectory.columns.iter().all(|c| trajectory.number(row, c).is_finite()));
    }
}

#[test]
fn a_motion_that_is_too_fast_to_follow_comes_to_an_end() {
    let run = run(&["--set", "w0=1e10", "--method", "dop853", "--no-error-estimate", "--no-figures"]);
    assert_eq!(run.status(), 1);
    assert!(run.stderr().contains("the motion is too fast, too stiff"), "{}", run.stderr());
}

#[test]
fn a_step_that_is_far_too_long_is_said_to_be() {
    let run = run(&["--step", "0.1", "--no-error-estimate"]);
    let reasons = run.summary()["distrust"].to_string();
    assert!(reasons.contains("although every load has a potential"), "{reasons}");
    assert_eq!(run.status(), 1);
    assert!(run.stderr().starts_with("error: do not trust the numbers: the energy changed by"), "{}", run.stderr());
}

#[test]
fn nobody_listens() {
    let mut child = qrm(&["list"]).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().expect("the command starts");
    drop(child.stdout.take());
    let output = child.wait_with_output().expect("the command ends");
    assert_eq!((output.status.code(), text(&output.stderr)), (Some(0), String::new()));
}

#[test]
fn folders_that_cannot_be_written() {
    let file = tempfile::NamedTempFile::new().expect("a temporary file");
    let folder = file.path().join("below");
    let path = folder.to_str().expect("a path in UTF-8");
    let mut redactions = Redactions::new();
    redactions.insert("[PATH]", file.path().to_path_buf()).expect("a redaction");
    let output = qrm(&["run", "--out", path]).output().expect("the command starts");
    assert_eq!(output.status.code(), Some(2));
    Assert::new().redact_with(redactions).eq(
        text(&output.stderr),
        str![[r#"
error: cannot write [PATH]/below/trajectory.csv: [PATH] is not a folder
  = help: choose another folder with --out DIR

"#]],
    );
}

#[cfg(target_os = "linux")]
#[test]
fn a_full_disk() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    std::os::unix::fs::symlink("/dev/full", folder.path().join("trajectory.csv.under-way")).expect("a link");
    let output = qrm(&["run", "--out"]).arg(folder.path()).output().expect("the command starts");
    let said = text(&output.stderr);
    assert!(said.contains("No space left on device"), "{said}");
    assert!(!said.contains("panicked"), "{said}");
    assert_ne!(output.status.code(), Some(0));
}

/// Waits until a run has written rows into its folder.
fn wait_for_rows(folder: &Path) {
    let path = folder.join("trajectory.csv.under-way");
    let patience = Instant::now();
    while std::fs::metadata(&path).map_or(0, |m| m.len()) < 100_000 {
        assert!(patience.elapsed() < Duration::from_secs(30), "no rows appear");
        std::thread::sleep(Duration::from_millis(20));
    }
}

#[cfg(unix)]
#[test]
fn a_result_stays_until_the_next_one_is_complete() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let files = || {
        let names = ["trajectory.csv", "summary.json", "trajectory.units.json", "figures/x6.svg"];
        names.map(|name| std::fs::read(folder.path().join(name)).expect("a file"))
    };
    assert!(qrm(&["run", "--out"]).arg(folder.path()).output().expect("the command starts").status.success());
    let first = files();
    let mut long = qrm(&["run", "--end-time", "1e6", "--out"]);
    let mut child = long.arg(folder.path()).stdout(Stdio::null()).stderr(Stdio::null()).spawn().expect("starts");
    wait_for_rows(folder.path());
    // Two runs do not mix their rows.
    let second = qrm(&["run", "--out"]).arg(folder.path()).output().expect("the command starts");
    assert_eq!(second.status.code(), Some(2));
    assert!(text(&second.stderr).starts_with("error: another command is writing "), "{}", text(&second.stderr));
    child.kill().expect("killed");
    child.wait().expect("ended");
    assert_eq!(files(), first);
    assert!(qrm(&["run", "--out"]).arg(folder.path()).output().expect("the command starts").status.success());
    assert_eq!(files()[0], first[0]);
    assert!(!folder.path().join("trajectory.csv.under-way").exists());
}

#[cfg(unix)]
#[test]
fn an_interrupted_run_keeps_its_rows() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let mut command = qrm(&["run", "--end-time", "1e6", "--out"]);
    let mut child = command.arg(folder.path()).stdout(Stdio::null()).stderr(Stdio::piped()).spawn().expect("starts");
    let path = folder.path().join("trajectory.csv");
    wait_for_rows(folder.path());
    let interrupted = std::process::Command::new("kill").args(["-INT", &child.id().to_string()]).status();
    assert!(interrupted.expect("kill runs").success());
    assert_eq!(child.wait().expect("the run ends").code(), Some(1));
    let said: Vec<String> = BufReader::new(child.stderr.take().expect("piped")).lines().map_while(Result::ok).collect();
    assert!(said[0].starts_with("error: interrupted at t = "), "{said:?}");
    let table = common::Table::read(&path);
    let summary = std::fs::read_to_string(folder.path().join("summary.json")).expect("a summary");
    let summary: serde_json::Value = serde_json::from_str(&summary).expect("JSON");
    assert_eq!(summary["status"], "interrupted");
    near("last row", table.number(table.last(), "t"), summary["end_time"].as_f64().expect("a number"), 0.0);
    // A pipe gets no progress bar.
    assert_eq!(said.len(), 1, "{said:?}");
}

#[test]
fn conditions_and_formulae_on_the_command_line() {
    let one = run(&["--until", "phi2 >= 2*pi"]).summary();
    near("one revolution", one["end_time"].as_f64().expect("a number"), 0.877_997_139_511_224_4, 1e-9);
    let at_point = run(&["--until", "C.x <= -0.5"]).summary();
    near("x6", at_point["extremes"]["x6"]["min"].as_f64().expect("a number"), -0.5, 1e-9);
    let timed = run(&["--until", "t >= 0.25"]).summary();
    near("t", timed["end_time"].as_f64().expect("a number"), 0.25, 1e-15);
    let set = run(&["--set", "w0=2*pi+1", "--end-time", "0.01"]).summary();
    near("w0", set["parameters"]["w0"].as_f64().expect("a number"), std::f64::consts::TAU + 1.0, 1e-15);
}

#[test]
fn a_condition_that_loses_its_value_ends_the_run() {
    let run = run(&["--until", "sqrt(0.5 - t) <= -1"]);
    assert_eq!(run.status(), 1);
    near("last row", run.summary()["end_time"].as_f64().expect("a number"), 0.5, 1e-12);
    assert_eq!(run.trajectory().rows.len(), 501);
}

#[test]
fn a_method_that_needs_jacobians_is_refused_without_them() {
    wrong_use(
        &["run", "quick-return", "--method", "rodas"],
        str![[r#"
error: the run cannot start: the method needs the Jacobians of forces and constraints, and scene `quick-return` does not ask for them
  = help: write `stiff = true` under [run] in scenes/quick-return.toml, and build again

"#]],
    );
}

#[test]
fn a_condition_of_a_moment_ends_a_run() {
    // It is true for 3e-10 s around a corner of its value.
    for arguments in [&["--step", "0.01"][..], &["--method", "dop853", "--tolerance", "1e-10", "--step", "0.01"]] {
        let end = |condition: &str| {
            let run = run(&[&["--until", condition, "--no-figures"], arguments].concat());
            assert_eq!(run.status(), 0, "{}", run.stderr());
            run.summary()["end_time"].as_f64().expect("a number")
        };
        let [moment, passed] = ["abs(phi2 - 3) <= 1e-9", "phi2 >= 3 - 1e-9"].map(end);
        near("end", moment, passed, 1e-11);
    }
}

#[test]
fn a_condition_that_is_true_between_rows_only_is_met_there() {
    // The ram goes 6e-8 m beyond this, for 80 us.
    for arguments in [
        &["--step", "1e-2"][..],
        &["--step", "1e-3"],
        &["--step", "1e-5"],
        &["--method", "dop853", "--step", "0.1"],
        &["--method", "auto", "--step", "10"],
    ] {
        let summary = run(&[&["--until", "C.x >= 0.0009131"], arguments].concat()).summary();
        let t = summary["end_time"].as_f64().expect("a number");
        near(&format!("{arguments:?}"), t, 0.786_506_784_8, 1e-7);
    }
}

#[test]
fn a_condition_that_holds_at_the_start_is_refused_by_every_command() {
    let folder = tempfile::tempdir().expect("a folder");
    for command in ["run", "report", "stability", "animate", "accuracy", "sensitivity", "export-fmu"] {
        let mut given = qrm(&[command, "quick-return", "--until", "phi2 >= 0"]);
        if command != "stability" {
            given.arg("--out").arg(folder.path());
        }
        let output = given.output().expect("the command starts");
        assert_eq!(output.status.code(), Some(2), "{command}: {}", text(&output.stderr));
        let expected = "error: `phi2 >= 0` holds at the start: there is no motion to compute\n  = help: begin \
                        elsewhere, or end with another --until or --end-time\n";
        assert_eq!(text(&output.stderr), expected, "{command}");
    }
    assert_eq!(std::fs::read_dir(folder.path()).expect("a folder").count(), 0);
}

#[test]
fn thinned_rows_and_uneven_ends() {
    let run = run(&["--end-time", "0.0105", "--every", "4"]);
    let table = run.trajectory();
    let times: Vec<f64> = (0..table.rows.len()).map(|row| table.number(row, "t")).collect();
    assert_eq!(times, [0.0, 0.004, 0.008, 0.0105]);
    assert_eq!(run.summary()["steps"], 11);
}

#[test]
fn without_arguments_the_document_s_scene_is_run() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let output = qrm(&[]).current_dir(folder.path()).output().expect("the command starts");
    assert_eq!(output.status.code(), Some(0));
    let said = text(&output.stdout);
    let files = "wrote out/quick-return/trajectory.csv (1757 rows; units in trajectory.units.json)
      out/quick-return/summary.json
      out/quick-return/figures (rates, x6, x6_dot, x6_ddot, v_slide, reactions, health)
";
    assert!(said.contains(files), "{said}");
    assert!(folder.path().join("out/quick-return/trajectory.csv").exists());
    assert!(folder.path().join("out/quick-return/figures/reactions.svg").exists());
}

#[test]
fn list_shows_scenes_and_parameters() {
    let output = qrm(&["list"]).output().expect("the command starts");
    let said = text(&output.stdout);
    for expected in ["quick-return: ", "quick-return-loaded: ", "left out     J3, T2, g", "rad/s"] {
        assert!(said.contains(expected), "{said}");
    }
}

#[test]
fn the_same_input_gives_the_same_bytes() {
    let bytes = || std::fs::read(run(&["--end-time", "0.2"]).path("trajectory.csv")).expect("a trajectory");
    assert_eq!(bytes(), bytes());
}

#[test]
fn new_scenes_begin_with_others_that_can_be_read() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let new = |arguments: &[&str]| {
        let output =
            qrm(&[&["new"], arguments].concat()).current_dir(folder.path()).output().expect("the command starts");
        (output.status.code(), String::from_utf8_lossy(&output.stderr).into_owned())
    };
    let linkages = ["blank", "four-bar", "slider-crank", "cylinder", "quick-return", "cam", "gears", "empty"];
    let formulae = qrm_model::MODELS.iter().map(|model| (model.description.name, &["--formulae"][..]));
    let templates = linkages.into_iter().map(|name| (name, &[][..])).chain(formulae);
    for (k, (from, option)) in templates.enumerate() {
        let name = format!("own-{k}");
        assert_eq!(new(&[&[name.as_str(), "--from", from], option].concat()).0, Some(0), "{from}");
        let path = folder.path().join(&name).with_extension("toml");
        let text = std::fs::read_to_string(path).expect("a scene");
        let (scene, _) = qrm_scene::resolve::read("own", &text).expect("a scene that can be read");
        assert_eq!(scene.name, name);
        assert!(scene.references.is_empty() && scene.extremes.is_empty(), "{from}");
        assert_eq!(scene.has_links, option.is_empty() && from != "empty", "{from}");
    }
    assert_eq!(new(&["own-0"]).0, Some(2), "a file is replaced");
    let (status, said) = new(&["other", "--from", "slider-crnak"]);
    assert!(status == Some(2) && said.contains("did you mean `slider-crank`?"), "{said}");
    let (status, said) = new(&["../x"]);
    assert!(status == Some(2) && said.contains("cannot be the name of a scene"), "{said}");
}
