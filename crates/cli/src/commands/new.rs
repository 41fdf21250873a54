//! `qrm new`

use std::path::{Path, PathBuf};

use clap::Args;
use qrm_core::Model;
use qrm_scene::resolve;
use qrm_scene::source::read_text;

use crate::error::Error;
use crate::output::{print, save};
use crate::scenes::{is_path, model_named};

#[derive(Args)]
pub(crate) struct Options {
    /// Name of the scene, as `my-crank`
    name: String,
    /// Begin with a linkage (`four-bar`, `slider-crank`, `cylinder`, `quick-return`, `cam` or `gears`), with `blank` (to
    /// draw links with the mouse), with `empty` (a block on a spring), or with a copy of a scene or a scene file
    #[arg(long, value_name = "NAME or FILE", default_value = EMPTY)]
    from: String,
    /// Copy the scene in formulae, where a linkage has the same name
    #[arg(long)]
    formulae: bool,
    /// The file [default: NAME.toml, in `scenes` if there is such a folder]
    #[arg(long, value_name = "FILE")]
    out: Option<PathBuf>,
}

const EMPTY: &str = "empty";

/// Linkages to begin with: names and scenes.
const LINKAGES: [(&str, &str); 7] = [
    ("blank", include_str!("new/blank.toml")),
    ("four-bar", include_str!("new/four-bar.toml")),
    ("slider-crank", include_str!("new/slider-crank.toml")),
    ("cylinder", include_str!("new/cylinder.toml")),
    ("quick-return", include_str!("new/quick-return.toml")),
    ("cam", include_str!("new/cam.toml")),
    ("gears", include_str!("new/gears.toml")),
];

/// Writes a new scene as a starting point.
pub(crate) fn run(models: &'static [Model], options: &Options) -> Result<(), Error> {
    let Options { name, from, formulae, out } = options;
    let is_name = name.starts_with(|c: char| c.is_ascii_lowercase())
        && name.chars().all(|c| c.is_ascii_lowercase() || c.is_ascii_digit() || c == '-');
    if !is_name {
        return Err(Error::usage(format!("`{name}` cannot be the name of a scene"))
            .help("use small letters, digits and `-`, beginning with a letter, as in `my-crank`"));
    }
    if from == EMPTY && models.iter().any(|model| model.description.name == name) {
        return Err(Error::usage(format!("`{name}` is a scene of the program"))
            .help(format!("choose another name; `qrm new my-{name} --from {name}` begins with a copy of it")));
    }
    let path = out.clone().unwrap_or_else(|| {
        let folder = if Path::new("scenes").is_dir() { Path::new("scenes") } else { Path::new("") };
        folder.join(name).with_extension("toml")
    });
    if path.exists() {
        return Err(Error::usage(format!("{} is there already", path.display()))
            .help("choose another name, or another file by --out"));
    }
    let (text, own) = template(models, from, *formulae)?;
    let text = renamed(&text, &own, name);
    // An error in the new text is reported, and nothing written.
    resolve::read(&path.display().to_string(), &text)?;
    save(&path, text.as_bytes())?;
    print(&format!(
        "wrote {0}, {1}\n\nSee it move while you change it, and run it:\n\n    qrm live {0}\n    qrm run {0}",
        path.display(),
        if from == EMPTY { "a block on a spring".to_owned() } else { format!("a copy of `{from}`") }
    ));
    Ok(())
}

/// The template of a new scene, and its name in it.
fn template(models: &'static [Model], from: &str, formulae: bool) -> Result<(String, String), Error> {
    if from == EMPTY {
        return Ok((include_str!("new/empty.toml").to_owned(), EMPTY.to_owned()));
    }
    if let Some((_, text)) = LINKAGES.iter().find(|(name, _)| *name == from && !formulae) {
        return Ok(((*text).to_owned(), from.to_owned()));
    }
    if is_path(models, from) {
        let text = read_text(Path::new(from))?;
        let (scene, _) = resolve::read(from, &text)?;
        return Ok((text, scene.name));
    }
    let others: Vec<&str> = LINKAGES.iter().map(|(name, _)| *name).chain([EMPTY]).collect();
    Ok((model_named(models, from, &others)?.description.source.to_owned(), from.to_owned()))
}

/// Renames a scene, and removes the values and cases that are specific to the original.
fn renamed(text: &str, from: &str, name: &str) -> String {
    let text = text.replacen(&format!("name = \"{from}\""), &format!("name = \"{name}\""), 1);
    let mut lines: Vec<String> = Vec::new();
    let mut is_kept = true;
    for line in text.lines() {
        if line.starts_with('[') {
            is_kept = !line.starts_with("[reference") && !line.starts_with("[[extreme");
            // Comments directly before a table belong to it.
            while !is_kept && lines.last().is_some_and(|line| line.is_empty() || line.starts_with('#')) {
                lines.pop();
            }
            if is_kept && lines.last().is_some_and(|line| !line.is_empty() && !line.starts_with('#')) {
                lines.push(String::new());
            }
        }
        if is_kept {
            lines.push(line.to_owned());
        }
    }
    lines.join("\n") + "\n"
}
