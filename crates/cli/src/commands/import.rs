//! `qrm import`

mod asmt;
mod independent_coordinates;
mod linkage;
mod mjcf;
mod movable;
mod names;
mod numbers;
mod plane;
mod pmks;
mod pmks_plus;
mod scene_text;
mod source;

use std::path::{Path, PathBuf};

use clap::Args;
use qrm_core::Model;
use qrm_scene::resolve;

use crate::error::Error;
use crate::output::{print, protect, save};
use linkage::ImportedLinkage;
use scene_text::scene_text;
use source::Source;

#[derive(Args)]
pub(crate) struct Options {
    /// The model: a mechanism of PMKS or PMKS+ (text or link), an Ondsel assembly (.asmt), or MJCF (.xml)
    #[arg(value_name = "FILE")]
    file: PathBuf,
    /// The scene file, which ends with `.toml` [default: NAME.toml]
    #[arg(long, value_name = "FILE")]
    out: Option<PathBuf>,
    /// Name of the scene, as `my-crank` [default: that of the file]
    #[arg(long, value_name = "NAME")]
    name: Option<String>,
}

/// Imports a model of another program: writes its scene.
pub(crate) fn run(_models: &'static [Model], options: &Options) -> Result<(), Error> {
    let Options { file, out, name } = options;
    let stem = file.file_stem().unwrap_or_default().to_string_lossy();
    let name = match name {
        Some(name) if names::scene_name(name) != *name => {
            return Err(Error::usage(format!("`{name}` cannot be the name of a scene"))
                .help("use small letters, digits and `-`, beginning with a letter, as in `my-crank`"));
        }
        Some(name) => name.clone(),
        None => names::scene_name(&stem),
    };
    let path = out.clone().unwrap_or_else(|| Path::new(&name).with_extension("toml"));
    if path.extension().is_none_or(|extension| extension != "toml") {
        return Err(Error::usage(format!("{} is not the name of a scene file", path.display()))
            .help("write a name that ends with `.toml`"));
    }
    if path.exists() {
        return Err(Error::usage(format!("{} is there already", path.display()))
            .help("choose another name by --name, or another file by --out"));
    }
    let source = Source::read(file)?;
    protect(file);
    let linkage = read(&source)?.tidied();
    let own = file.file_name().unwrap_or_default().to_string_lossy();
    let text = scene_text(&linkage, &name, &own);
    // An error in the new text is reported, and nothing written.
    resolve::read(&path.display().to_string(), &text).map_err(|report| {
        let title = format!("{}: the scene of this model has an error, and is not written", file.display());
        Error::from(report).behind(title, "mend the model where the scene has its error")
    })?;
    save(&path, text.as_bytes())?;
    print(&summary(&linkage, &path));
    Ok(())
}

/// Reads a model in the format that its text shows.
fn read(source: &Source) -> Result<ImportedLinkage, Error> {
    let text = &source.text;
    let linkage = if asmt::recognizes(text) {
        asmt::read(source)
    } else if mjcf::recognizes(text) {
        mjcf::read(source)
    } else if pmks_plus::recognizes(text) {
        pmks_plus::read(source)
    } else if pmks::recognizes(text) {
        pmks::read(source)
    } else {
        Err(source.whole(
            "this is not a model that can be imported",
            "import a mechanism of PMKS or PMKS+, an assembly of the Ondsel solver (.asmt), or MJCF (.xml)",
        ))
    }?;
    movable::check(source, &linkage)?;
    Ok(linkage)
}

/// The text that tells what was written and what was left out.
fn summary(linkage: &ImportedLinkage, path: &Path) -> String {
    let count = |number: usize, what: &str| format!("{number} {what}{}", if number == 1 { "" } else { "s" });
    let mut text = format!(
        "wrote {0}, {1} and {2} of {3}\n",
        path.display(),
        count(linkage.links.len() - 1, "link"),
        count(linkage.joints.len(), "joint"),
        linkage.format
    );
    if !linkage.left_out.is_empty() {
        text.push_str("\nLeft out:\n");
        for item in &linkage.left_out {
            // Names of the model may contain escape sequences of terminals.
            let shown: String = item.chars().filter(|c| !c.is_control()).collect();
            text.push_str(&format!("  - {shown}\n"));
        }
    }
    text + &format!("\nSee it move, and run it:\n\n    qrm live {0}\n    qrm run {0}", path.display())
}

/// Imports a text, and returns the text of the scene or of the error.
#[cfg(test)]
fn imported(text: &str) -> Result<String, String> {
    let source = Source { path: "model".to_owned(), text: text.to_owned() };
    let linkage = read(&source).map_err(|e| e.to_string())?.tidied();
    let text = scene_text(&linkage, "model", "model");
    match resolve::read("model.toml", &text) {
        Ok(_) => Ok(text),
        Err(report) => Err(format!("{report}\n{text}")),
    }
}
