//! Scene files that the program was not built with: derived by the engine once, kept, interpreted.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use tempfile::TempDir;

/// A folder with a scene of its own, the cache of its commands, and the program where it is asked for.
struct Workplace(TempDir);

impl Workplace {
    fn new() -> Self {
        // Where files of the build can be linked to.
        Self(tempfile::tempdir_in(env!("CARGO_TARGET_TMPDIR")).expect("a temporary folder"))
    }

    fn path(&self, file: &str) -> PathBuf {
        self.0.path().join(file)
    }

    /// Writes a copy of a scene of the program under another name.
    fn copy(&self, scene: &str, name: &str) -> PathBuf {
        let text = fs::read_to_string(format!("{}/scenes/{scene}.toml", env!("CARGO_MANIFEST_DIR"))).expect("a scene");
        let path = self.path(&format!("{name}.toml"));
        fs::write(&path, text.replacen(&format!("\"{scene}\""), &format!("\"{name}\""), 1)).expect("written");
        path
    }

    /// The command in this folder.
    fn qrm(&self, program: &Path, arguments: &[&str]) -> Output {
        let mut command = Command::new(program);
        command.current_dir(self.0.path()).env("QRM_CACHE", self.path("cache")).args(arguments);
        command.output().expect("the command starts")
    }

    /// The command where there is no engine.
    fn without_engine(&self, arguments: &[&str]) -> Output {
        let mut command = Command::new(program());
        command
            .current_dir(self.0.path())
            .env("QRM_CACHE", self.path("cache"))
            .env("QRM_ENGINE", "/nowhere/qrm-engine");
        command.args(arguments).output().expect("the command starts")
    }

    fn cached(&self) -> Vec<PathBuf> {
        let entries = fs::read_dir(self.path("cache")).expect("the cache");
        entries.map(|entry| entry.expect("an entry").path()).collect()
    }
}

fn program() -> PathBuf {
    PathBuf::from(env!("CARGO_BIN_EXE_qrm"))
}

fn stdout(output: &Output) -> String {
    assert!(output.status.success(), "{}", stderr(output));
    String::from_utf8_lossy(&output.stdout).into_owned()
}

fn stderr(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

#[test]
#[ignore = "full tier: engine"]
fn a_file_gives_the_table_of_the_compiled_scene() {
    let place = Workplace::new();
    for scene in ["quick-return", "shaper", "andrews"] {
        place.copy(scene, "mine");
        let said = stdout(&place.qrm(&program(), &["run", "mine.toml", "--out", "file"]));
        assert!(said.contains("; interpreted: compiled, it would be about 5 times as fast"), "{said}");
        assert!(!said.contains("Symbolica"), "{said}");
        stdout(&place.qrm(&program(), &["run", scene, "--out", "built"]));
        let table = |folder: &str| fs::read(place.path(folder).join("trajectory.csv")).expect("a table");
        assert!(table("file") == table("built"), "{scene}");
        let summary = |folder: &str| -> serde_json::Value {
            let text = fs::read_to_string(place.path(folder).join("summary.json")).expect("a summary");
            serde_json::from_str(&text).expect("JSON")
        };
        assert_eq!(summary("file")["estimated_error"], summary("built")["estimated_error"]);
        assert_eq!(summary("file")["interpreted"], true);
    }
}

#[test]
#[ignore = "full tier: engine"]
fn a_derived_scene_needs_no_engine() {
    let place = Workplace::new();
    place.copy("four-bar", "mine");
    let lonely = |arguments: &[&str]| place.without_engine(arguments);
    let refused = lonely(&["run", "mine.toml"]);
    assert_eq!(refused.status.code(), Some(2));
    let said = stderr(&refused);
    assert!(said.starts_with("error: the symbolic engine /nowhere/qrm-engine cannot be started"), "{said}");
    stdout(&place.qrm(&program(), &["run", "mine.toml"]));
    stdout(&lonely(&["run", "mine.toml"]));
    // A scene of the program is compiled, whatever its file is called.
    let text = fs::read_to_string(format!("{}/scenes/quick-return.toml", env!("CARGO_MANIFEST_DIR"))).expect("a scene");
    fs::write(place.path("copy.toml"), text).expect("written");
    assert!(!stdout(&lonely(&["run", "./copy.toml"])).contains("interpreted"));
}

#[test]
#[ignore = "full tier: engine"]
fn a_damaged_cache_is_made_anew() {
    let place = Workplace::new();
    place.copy("pendulum", "mine");
    let first = stdout(&place.qrm(&program(), &["code", "mine.toml", "C_q"]));
    let cached = place.cached();
    let [cached] = &cached[..] else { panic!("one scene is kept: {cached:?}") };
    let whole = fs::read(cached).expect("bytes");
    let mut changed = whole.clone();
    changed[whole.len() / 2] ^= 1;
    for damaged in [&whole[..whole.len() / 2], &changed, b""] {
        fs::write(cached, damaged).expect("written");
        assert_eq!(stdout(&place.qrm(&program(), &["code", "mine.toml", "C_q"])), first);
        assert_eq!(fs::read(cached).expect("bytes"), whole);
    }
}

/// The folder of the cache is a file, or nothing can be written into it.
#[test]
#[ignore = "full tier: engine"]
#[cfg(target_os = "linux")]
fn a_scene_is_derived_without_a_cache() {
    let place = Workplace::new();
    place.copy("pendulum", "mine");
    let expected = stdout(&place.qrm(&program(), &["code", "mine.toml", "C_q"]));
    fs::write(place.path("file"), "").expect("written");
    fs::create_dir(place.path("temporary")).expect("a folder");
    let note = "note: there is no cache folder, so the derived scene is not kept: set QRM_CACHE to one that can be \
                created\n";
    for (cache, note) in [(place.path("file"), note), (place.path("file/below"), note), ("/proc/self".into(), "")] {
        let mut command = Command::new(program());
        command.current_dir(place.0.path()).args(["code", "mine.toml", "C_q"]);
        let output = command.env("QRM_CACHE", &cache).env("TMPDIR", place.path("temporary")).output();
        let output = output.expect("the command starts");
        assert_eq!(stdout(&output), expected, "{}", cache.display());
        assert_eq!(stderr(&output), note, "{}", cache.display());
        let left = fs::read_dir(place.path("temporary")).expect("a folder").count();
        assert_eq!(left, 0, "{}: the temporary folder is left", cache.display());
    }
}

#[test]
#[ignore = "full tier: engine"]
fn every_command_takes_a_file() {
    let place = Workplace::new();
    place.copy("quick-return-loaded", "mine");
    let commands: [&[&str]; 11] = [
        &["check"],
        &["explain"],
        &["code"],
        &["code", "--language", "c"],
        &["derive", "--out", "out"],
        &["animate", "--no-gif"],
        &["report"],
        &["accuracy"],
        &["stability", "--no-extremes"],
        &["sensitivity", "--by", "O2A"],
        &["sweep", "--vary", "O2A=0.18:0.22:5"],
    ];
    for command in commands {
        let arguments = [&command[..1], &["mine.toml"], &command[1..]].concat();
        stdout(&place.qrm(&program(), &arguments));
    }
    let refused = place.qrm(&program(), &["export-fmu", "mine.toml"]);
    let expected = "error: FMUs need a compiled scene, and scene files are interpreted\n";
    assert!(stderr(&refused).starts_with(expected), "{}", stderr(&refused));
}

/// Results never replace the scene that they are of, whatever its file is called.
#[test]
#[ignore = "full tier: engine"]
fn a_scene_file_outlives_its_results() {
    let place = Workplace::new();
    let text = fs::read(place.copy("quick-return", "mine")).expect("a scene");
    let cases: [(&str, &[&str]); 6] = [
        ("mine.html", &["page"]),
        ("table.csv", &["sweep", "--vary", "O2A=0.18:0.22:3", "--out", "table.csv"]),
        ("summary.json", &["run", "--out", "."]),
        ("trajectory.csv", &["run", "--out", "."]),
        ("derivation.md", &["derive", "--out", "."]),
        ("inverse.csv", &["inverse", "--out", "."]),
    ];
    for (file, command) in cases {
        fs::write(place.path(file), &text).expect("written");
        let refused = place.qrm(&program(), &[&command[..1], &[file], &command[1..]].concat());
        assert!(stderr(&refused).contains("the result would replace the scene file"), "{file}: {}", stderr(&refused));
        assert_eq!(refused.status.code(), Some(2), "{file}");
        assert!(fs::read(place.path(file)).expect("the scene") == text, "{file}");
    }
}

#[test]
fn a_scene_begins_as_a_copy_of_a_file() {
    let place = Workplace::new();
    place.copy("quick-return", "mine");
    stdout(&place.qrm(&program(), &["new", "other", "--from", "mine.toml"]));
    let text = fs::read_to_string(place.path("other.toml")).expect("a scene");
    assert!(text.starts_with("name = \"other\"\n"), "{text}");
}

#[test]
#[ignore = "full tier: engine"]
fn a_coordinate_without_mass_is_refused() {
    let place = Workplace::new();
    stdout(&place.qrm(&program(), &["new", "block", "--from", "empty"]));
    let text = fs::read_to_string(place.path("block.toml")).expect("a scene");
    let massless = text.replacen("m = { value = 1,", "m = { value = 0,", 1);
    assert_ne!(massless, text);
    // A mass of zero is left out of the functions, one that may become zero is not.
    for runtime in ["", " runtime = true,"] {
        let massless = massless.replacen("m = { value = 0,", &format!("m = {{ value = 0,{runtime}"), 1);
        fs::write(place.path("block.toml"), massless).expect("written");
        let output = place.qrm(&program(), &["run", "block.toml"]);
        assert!(stderr(&output).contains("no mass resists a motion of coordinate `x`"), "{}", stderr(&output));
    }
}

#[test]
fn what_is_no_scene_is_refused() {
    let place = Workplace::new();
    fs::create_dir(place.path("folder.toml")).expect("a folder");
    fs::write(place.path("large.toml"), "abc = 1\n".repeat(1_000_000)).expect("written");
    fs::write(place.path("noise.toml"), vec![0xa5; 1_000_000]).expect("written");
    let whole = fs::read_to_string(place.copy("quick-return", "mine")).expect("a scene");
    fs::write(place.path("half.toml"), &whole[..whole.len() / 2]).expect("written");
    let cases = [
        ("missing.toml", "error: the scene cannot be read: "),
        ("folder.toml", "error: the scene cannot be read: "),
        ("large.toml", "error: the scene cannot be read: it has more than 1000000 bytes"),
        ("noise.toml", "error: the scene is not UTF-8 text"),
        ("half.toml", "error: "),
        ("mime", "error: there is no scene `mime`"),
    ];
    for (file, expected) in cases {
        let refused = place.qrm(&program(), &["run", file]);
        assert_eq!(refused.status.code(), Some(2), "{file}: {}", stderr(&refused));
        assert!(stderr(&refused).starts_with(expected), "{file}: {}", stderr(&refused));
    }
    // Nothing of it started the engine.
    assert!(!place.path("cache").exists() || place.cached().is_empty());
}

#[test]
#[ignore = "full tier: engine"]
fn plots_whose_files_may_be_the_same_are_refused() {
    let place = Workplace::new();
    let scene = "name = \"caps\"\ncoordinates = [\"p\", \"P\"]\n\
                 [bodies]\na = { angle = 'p', inertia = 1 }\nb = { angle = 'P', inertia = 2 }\n\
                 [initial]\ngiven = { p = 0, P = 0, p_dot = 1, P_dot = 2 }\n[run]\nstep = 1e-2\nend_time = 1\n";
    fs::write(place.path("caps.toml"), scene).expect("written");
    let output = place.qrm(&program(), &["run", "caps.toml", "--plot", "p", "--plot", "P"]);
    assert_eq!(output.status.code(), Some(2));
    let expected = "error: `plot-P-t.svg` and `plot-p-t.svg` may be the same file\n  = help: make one of the two plots \
                    in another run\n";
    assert_eq!(String::from_utf8_lossy(&output.stderr), expected);
}
