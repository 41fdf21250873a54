//! The scenes of the recipes, against other equations of the same mechanisms.

use std::collections::BTreeSet;
use std::f64::consts::PI;
use std::fs;
use std::path::Path;

use crate::common;
use crate::common::{Run, Table, near, run};

/// The path of a recipe.
fn path(scene: &str) -> String {
    format!("{}/scenes/recipes/{scene}.toml", env!("CARGO_MANIFEST_DIR"))
}

/// The value at the end of a run.
fn end(run: &Run, name: &str) -> f64 {
    assert_eq!(run.status(), 0, "{}", run.stderr());
    let summary = run.summary();
    summary["end_state"][name].as_f64().unwrap_or_else(|| panic!("no `{name}` in {summary}"))
}

/// The value that `tests/reference/recipes.py` finds.
fn expected(table: &Table, scene: &str, quantity: &str) -> f64 {
    let is_it = |row: &usize| table.text(*row, "scene") == scene && table.text(*row, "quantity") == quantity;
    table.number((0..table.rows.len()).find(is_it).expect("a row"), "value")
}

#[test]
#[ignore = "full tier: engine"]
fn recipes_move_as_other_equations_say() {
    let table = Table::reference("recipes.csv");
    for (scene, method, quantities, allowed) in [
        ("flexible-crank", "dop853", &["q1", "q2", "q1_dot"][..], 5e-12),
        ("governor", "auto", &["theta", "alpha", "s"], 5e-12),
        ("bricard", "dop853", &["a", "a_dot"], 1e-10),
    ] {
        let run = run(&[&path(scene), "--method", method, "--tolerance", "1e-13", "--no-figures"]);
        for name in quantities {
            near(&format!("{name} of {scene}"), end(&run, name), expected(&table, scene, name), allowed);
        }
    }
}

#[test]
#[ignore = "full tier: engine"]
fn every_recipe_is_shown_and_compared() {
    let top = Path::new(env!("CARGO_MANIFEST_DIR"));
    let page = fs::read_to_string(top.join("docs/recipes.md")).expect("the page");
    let table = Table::reference("recipes.csv");
    let compared: BTreeSet<&str> = (0..table.rows.len()).map(|row| table.text(row, "scene")).collect();
    let mut count = 0;
    for entry in fs::read_dir(top.join("scenes/recipes")).expect("the scenes") {
        let file = entry.expect("an entry").path();
        let scene = file.file_stem().expect("a name").to_string_lossy().into_owned();
        assert!(page.contains(&format!("{{{{#include ../scenes/recipes/{scene}.toml}}}}")), "{scene}");
        assert!(compared.contains(scene.as_str()), "{scene}");
        // The command as the page shows it.
        let shown = page.split("`qrm run scenes/recipes/").find_map(|rest| rest.strip_prefix(&format!("{scene}.toml")));
        let options = shown.and_then(|rest| rest.split('`').next()).unwrap_or_else(|| panic!("no command of {scene}"));
        let arguments: Vec<String> = std::iter::once(path(&scene)).chain(common::split(options)).collect();
        let arguments: Vec<&str> = arguments.iter().map(String::as_str).collect();
        assert_eq!(run(&arguments).status(), 0, "{scene}");
        count += 1;
    }
    assert_eq!(count, compared.len());
}

#[test]
#[ignore = "full tier: engine"]
fn a_rod_at_rest_vibrates_at_its_natural_frequency() {
    let run = run(&[
        &path("flexible-crank"),
        "--set",
        "w=0",
        "--start",
        "q1=1e-3",
        "--until",
        "q1 <= 0",
        "--method",
        "dop853",
        "--tolerance",
        "1e-13",
    ]);
    assert_eq!(run.status(), 0, "{}", run.stderr());
    let quarter = run.summary()["end_time"].as_f64().expect("a time");
    let (bending, mass_per_length) = (2e11 * PI * 0.006_f64.powi(4) / 64.0, 7870.0 * PI * 0.006 * 0.006 / 4.0);
    let unit = (bending / mass_per_length).sqrt() / (0.3 * 0.3);
    let frequency = (6144.0 / 125.0 * 7875.0 / 3968.0_f64).sqrt() * unit;
    near("a quarter of a period", quarter, PI / 2.0 / frequency, 1e-12);
    // The shape is not quite that of the exact mode, so the frequency is a little too high.
    let exact = PI * PI * unit;
    assert!(exact < frequency && frequency < 1.001 * exact, "{frequency} beside {exact}");
}

#[test]
#[ignore = "full tier: engine"]
fn the_governor_keeps_its_angular_momentum() {
    let run = run(&[&path("governor"), "--method", "auto", "--tolerance", "1e-13", "--no-figures"]);
    assert_eq!(run.status(), 0, "{}", run.stderr());
    let momentum = &run.summary()["extremes"]["H"];
    let [least, most] = ["min", "max"].map(|key| momentum[key].as_f64().expect("a number"));
    near("angular momentum", least, most, 1e-10);
}

#[test]
#[ignore = "full tier: engine"]
fn bricard_s_linkage_swings_as_deep_as_its_closed_form_says() {
    let run = run(&[&path("bricard"), "--no-figures"]);
    assert_eq!(run.status(), 0, "{}", run.stderr());
    let summary = run.summary();
    let depth = summary["extremes"]["y3"]["min"].as_f64().expect("a number");
    near("lowest place of P3", depth, -(3.0_f64.sqrt()), 1e-9);
    assert_eq!(summary["redundancy"]["rank"], 3);
    for row in [0, 2500, 7000] {
        let table = run.trajectory();
        let [a, b, c, d] = ["a", "b", "c", "d"].map(|name| table.number(row, name));
        near("the loop", a.sin() + c.sin() + a.sin() * c.sin(), 0.0, 1e-12);
        near("b", b, c, 1e-12);
        near("d", d, a, 1e-12);
    }
}
