//! Runs random mechanisms through the generator, which rejects functions that do not match the scene.
//!
//! ```text
//! cargo run --release --manifest-path crates/engine/Cargo.toml --target-dir target/engine --example random -- SEED COUNT FOLDER [all]
//! ```
//!
//! Each seed gives one scene: a tree of links with rods, guides, drives and pins that close loops, some of them
//! redundant, with loads and outputs of every kind. Printed functions, kernel, linearization and tape are compared with
//! automatic differentiation. A scene that fails is written to the folder. With `all` every scene is written, to be
//! compiled (`.ci/random-mechanisms`).

use std::error::Error;
use std::path::Path;

use fastrand::Rng;
use qrm_codegen::{functions, verify};
use qrm_language::{Code, rust};
use qrm_scene::resolve;
use qrm_scene::scene::Scene;

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [seed, count, folder, rest @ ..] = &arguments[..] else {
        return Err("give a seed, a count and a folder".into());
    };
    let keeps_all = match rest {
        [] => false,
        [all] if all == "all" => true,
        _ => return Err("give a seed, a count, a folder, and `all` or nothing".into()),
    };
    let (first, count): (u64, u64) = (seed.parse()?, count.parse()?);
    let texts: Vec<(u64, String)> = (first..first + count).map(|seed| (seed, scene(seed))).collect();
    let mut scenes: Vec<(u64, &str, Scene)> = Vec::new();
    for (seed, text) in &texts {
        match resolve::read(&format!("random-{seed}.toml"), text) {
            Ok((scene, _)) => scenes.push((*seed, text, scene)),
            Err(report) => {
                println!("{seed}: refused: {}", report.diagnostics.first().map_or("", |finding| &finding.title));
            }
        }
    }
    // The engine can be called once in a process.
    let list: Vec<&Scene> = scenes.iter().map(|(_, _, scene)| scene).collect();
    let equations = qrm_engine::derive(&list, &|_| ())?;
    let mut failed = 0;
    for ((seed, text, scene), equations) in scenes.iter().zip(&equations) {
        let tape = functions::tape(scene, equations).expect("a possible form");
        let printed = rust::check(&tape, &rust::text(&Code { path: "random.toml", scene, source: text, tape: &tape }));
        let write = || std::fs::write(Path::new(folder).join(format!("random-{seed}.toml")), text);
        if keeps_all {
            write()?;
        }
        let verified = verify::verify(scene, equations, &tape, &tape.placed());
        if let Err(reason) = verified.map_err(|e| e.to_string()).and(printed) {
            failed += 1;
            println!("{seed}: {reason}");
            write()?;
        }
    }
    println!("{} agree, {} refused, {failed} differ", scenes.len() - failed, texts.len() - scenes.len());
    if failed > 0 { Err(format!("{failed} scenes differ; they are in {folder}").into()) } else { Ok(()) }
}

/// A number in an interval, distributed over orders of magnitude.
fn size(random: &mut Rng, low: f64, high: f64) -> String {
    format!("{:.3e}", low * (high / low).powf(random.f64()))
}

/// A random element of some texts.
fn one<'t>(random: &mut Rng, texts: &[&'t str]) -> &'t str {
    texts[random.usize(..texts.len())]
}

/// Creates the scene of a seed.
fn scene(seed: u64) -> String {
    let mut random = Rng::with_seed(seed);
    let r = &mut random;
    let links = r.usize(1..=5);
    let mut text = format!("name = \"random-{seed}\"\n");
    let slides: Vec<bool> = (0..links).map(|_| r.u8(..5) == 0).collect();
    let unit = |slide: bool| if slide { "m" } else { "rad" };
    let coordinates = slides.iter().enumerate().map(|(i, s)| format!("{{ name = \"q{i}\", unit = \"{}\" }}", unit(*s)));
    text += &format!("coordinates = [{}]\n\n[parameters]\n", coordinates.collect::<Vec<_>>().join(", "));
    for i in 0..links {
        let inertia = if r.u8(..4) == 0 { "1e-6".to_owned() } else { size(r, 1e-4, 1e2) };
        text += &format!("l{i} = {}\nm{i} = {}\nJ{i} = {inertia}\n", size(r, 0.05, 5.0), size(r, 1e-3, 1e3));
    }
    text += &format!(
        "g = {}\nk = {}\nc = {}\nw = {}\nF = {}\n",
        one(r, &["9.81", "0", "1.6"]),
        size(r, 1.0, 1e7),
        size(r, 1e-3, 1e3),
        size(r, 0.1, 1e3),
        size(r, 1e-2, 1e4)
    );
    text += "\n[points]\nO = ['0', '0']\n";
    // The direction of each link, by relative or absolute angles.
    let mut angles: Vec<String> = Vec::new();
    let mut parents = Vec::new();
    for i in 0..links {
        let parent = if i == 0 || r.u8(..4) == 0 { None } else { Some(r.usize(..i)) };
        let before = parent.map_or("0".to_owned(), |parent: usize| angles[parent].clone());
        let at = parent.map_or("O".to_owned(), |parent| format!("P{parent}"));
        let angle = match (slides[i], r.bool()) {
            (true, _) => format!("{before} + {:.2}", r.f64() * 6.0),
            (false, true) => format!("{before} + q{i}"),
            (false, false) => format!("q{i}"),
        };
        let length = if slides[i] { format!("(l{i} + q{i})") } else { format!("l{i}") };
        text += &format!("P{i} = ['{at}.x + {length}*cos({angle})', '{at}.y + {length}*sin({angle})']\n");
        text += &format!("G{i} = ['({at}.x + P{i}.x)/2', '({at}.y + P{i}.y)/2']\n");
        angles.push(angle);
        parents.push(parent);
    }
    text += "\n[bodies]\n";
    for (i, angle) in angles.iter().enumerate() {
        text += &format!("b{i} = {{ mass = 'm{i}', com = \"G{i}\", angle = '{angle}', inertia = 'J{i}' }}\n");
    }
    let mut constraints: Vec<String> = Vec::new();
    let most = r.usize(0..links);
    while constraints.len() < most {
        let (i, j) = (r.usize(..links), r.usize(..links));
        let formula = match r.u8(..7) {
            0 => format!("hypot(P{i}.x - 0.7, P{i}.y + 0.2) - l{j}"),
            1 => format!("(P{i}.x - 0.3)^2 + (P{i}.y - 0.4)^2 - l{j}^2"),
            2 => format!("P{i}.y - 0.1*P{i}.x - 0.2"),
            3 => format!("P{i}.x*sin(0.3) - P{i}.y*cos(0.3) + 0.1"),
            4 if i != j => format!("P{i}.x - P{j}.x - 0.2"),
            5 if constraints.is_empty() => format!("q{i} - 0.3 - 0.1*sin(w*t)"),
            6 if !constraints.is_empty() => format!("2*({})", constraints[0]),
            _ => continue,
        };
        constraints.push(formula);
    }
    if !constraints.is_empty() {
        text += "\n[constraints]\n";
        for (i, formula) in constraints.iter().enumerate() {
            text += &format!("C{i} = {{ residual = '{formula}', unit = \"m\" }}\n");
        }
    }
    text += "\n[loads]\nweight = { gravity = ['0', '-g'] }\n";
    for i in 0..r.usize(0..4) {
        let j = r.usize(..links);
        text += &match r.u8(..8) {
            0 => format!("L{i} = {{ along = 'q{j}', spring = 'k', rest = '0.1', damper = 'c' }}\n"),
            1 => format!("L{i} = {{ between = [\"P{j}\", \"O\"], spring = 'k', rest = '0.5' }}\n"),
            2 => format!("L{i} = {{ along = 'q{j}', potential = 'k/2*s^2 + F*s^4' }}\n"),
            3 => format!("L{i} = {{ force = ['F*sin(w*t)', '-c*P{j}.y_dot'], at = \"P{j}\" }}\n"),
            4 => format!("L{i} = {{ torque = 'F*tanh(1 - q{j}_dot/w)', on = \"b{j}\" }}\n"),
            5 => format!("L{i} = {{ force = ['-F*exp(-((t - 0.5)/0.1)^2)', '0'], at = \"G{j}\" }}\n"),
            6 => format!("L{i} = {{ along = 'P{j}.x', spring = 'k/2', damper = 'c' }}\n"),
            _ => format!("L{i} = {{ along = 'q{j}', force = '-c*abs(s_dot)*s_dot' }}\n"),
        };
    }
    text += "\n[initial]\n";
    let freedoms = links - constraints.len();
    let given = (0..freedoms).flat_map(|i| [format!("q{i} = {:.2}", 0.1 * (i + 1) as f64), format!("q{i}_dot = 0.5")]);
    text += &format!("given = {{ {} }}\n", given.collect::<Vec<_>>().join(", "));
    let solved: Vec<String> = (freedoms..links).map(|i| format!("q{i} = 0.4")).collect();
    if !solved.is_empty() {
        text += &format!("solve = {{ {} }}\n", solved.join(", "));
    }
    text += "\n[outputs]\n";
    for i in 0..r.usize(1..4) {
        let j = r.usize(..links);
        text += &match r.u8(..5) {
            0 => format!("o{i} = {{ value = 'P{j}.x*P{j}.y', unit = \"m^2\" }}\n"),
            1 => format!("o{i} = {{ rate = 'hypot(P{j}.x, P{j}.y + 9)', unit = \"m/s\" }}\n"),
            2 => format!("o{i} = {{ second_rate = 'P{j}.x', unit = \"m/s^2\" }}\n"),
            3 if !constraints.is_empty() => {
                format!("o{i} = {{ reaction = \"C0\", at = \"P{j}\", along = ['1', '0'], unit = \"N\" }}\n")
            }
            _ => format!("o{i} = {{ value = 'atan(P{j}.y - P{j}.x)', unit = \"rad\" }}\n"),
        };
    }
    // A scene with unused parameters is refused.
    let all: Vec<String> = (0..links).flat_map(|i| ["l", "m", "J"].map(|name| format!("{name}{i}"))).collect();
    text += &format!("all = {{ value = 'g + k + c + w + F + {}' }}\n", all.join(" + "));
    text += &format!("\n[run]\nstep = 1e-3\nend_time = 1\nstiff = {}\n", r.bool());
    text
}
