//! `qrm export-fmu`

mod description;
mod roles;
mod units;

use std::io::{Cursor, Write};
use std::path::{Path, PathBuf};

use zip::write::SimpleFileOptions;
use zip::{CompressionMethod, ZipWriter};

use super::arguments::ExportFmuArguments;
use super::progress::Progress;
use super::setup::Setup;
use super::{Failure, account};
use crate::album::Album;
use crate::motion::Scheme;
use crate::scenes::Scenes;
use crate::unit::{Settings, fingerprint};

/// Packs a scene as a unit of FMI 3.0.
pub(super) fn export_fmu(scenes: &Scenes, arguments: &ExportFmuArguments) -> Result<(), Failure> {
    let setup = Setup::new(scenes, &arguments.scene, &arguments.method)?;
    if setup.method.scheme == Scheme::Document {
        return Err(Failure::Use(
            "error: the method `document` derives its rows late or by differences, which no unit can do\n  \
             = help: leave `--method` away"
                .to_owned(),
        ));
    }
    let roles = roles::roles(&setup, &arguments.input)?;
    // What does not run here would not run elsewhere.
    let mut observer = (Progress::new(), Album::new(&setup.description));
    let outcome = setup.simulate(true, &mut observer)?;
    let summary = account::summary(&setup, &outcome, &observer.1);
    if let Some(problem) = account::problem(&outcome, &summary) {
        return Err(Failure::Run(problem));
    }
    let settings = Settings {
        scene: setup.description.name.to_owned(),
        text: fingerprint(&setup.description),
        method: setup.method,
        step: outcome.step,
        fixed: roles.fixed().into_iter().map(str::to_owned).collect(),
        computed: roles.computed().into_iter().map(str::to_owned).collect(),
        set: setup.set.clone().into_iter().collect(),
    };
    let identifier = setup.description.name.replace('-', "_");
    let values = setup.scene.parameters(&setup.replace());
    let text = description::xml(&setup.description, &identifier, &settings, &roles, &values, outcome.end_time)
        .map_err(|e| Failure::Run(format!("error: the description of the unit cannot be written: {e}")))?;
    let library = library(&setup)?;
    let files = [
        ("modelDescription.xml".to_owned(), text.into_bytes()),
        (format!("binaries/{}/{identifier}{}", platform(), std::env::consts::DLL_SUFFIX), library),
        (format!("resources/{}.toml", setup.description.name), setup.description.source.as_bytes().to_vec()),
    ];
    let packed = pack(&files).map_err(|e| Failure::Run(format!("error: the unit cannot be packed: {e}")))?;
    let path = setup.folder(arguments.out.as_deref()).join(format!("{identifier}.fmu"));
    super::save(&path, &packed)?;
    super::say(&said(&setup, &roles, &path, outcome.end_time));
    Ok(())
}

fn said(setup: &Setup, roles: &roles::Roles, path: &Path, end: f64) -> String {
    let name = setup.description.name;
    let list = |names: Vec<&str>| if names.is_empty() { "none".to_owned() } else { names.join(", ") };
    format!(
        "{name}: FMI 3.0, co-simulation ({} inside) and model exchange, to t = {end} s unless the tool says otherwise\n\n  \
         inputs             {}\n  tunable            {}\n  before the start   {}\n\nwrote {}",
        super::words::method(setup.method_name, setup.method.scheme.tolerance(), setup.step()),
        list(roles.inputs()),
        list(roles.tunable()),
        list(roles.fixed()),
        path.display(),
    )
}

/// The library that was built beside this command.
fn library(setup: &Setup) -> Result<Vec<u8>, Failure> {
    use std::env::consts::{DLL_PREFIX, DLL_SUFFIX};
    let command = std::env::current_exe().unwrap_or_default();
    let stem = command.file_stem().unwrap_or_default().to_string_lossy().into_owned();
    let path: PathBuf = command.with_file_name(format!("{DLL_PREFIX}{stem}{DLL_SUFFIX}"));
    let wrong = |why: String| {
        Failure::Use(format!(
            "error: the library that belongs into the unit {why}: {}\n  \
             = help: `cargo build --release` makes it beside the command; keep both in one folder",
            path.display()
        ))
    };
    let library = std::fs::read(&path).map_err(|e| wrong(format!("cannot be read ({e})")))?;
    let holds = |text: &str| library.windows(text.len()).any(|window| window == text.as_bytes());
    if holds("fmi3InstantiateCoSimulation") && holds(setup.description.source) {
        return Ok(library);
    }
    Err(wrong(format!("does not hold scene `{}` as this command does", setup.description.name)))
}

/// The folder of a unit in which the library of this system stands.
fn platform() -> String {
    let system = match std::env::consts::OS {
        "macos" => "darwin",
        other => other,
    };
    format!("{}-{system}", std::env::consts::ARCH)
}

/// The same files give the same bytes: no times, no owners.
fn pack(files: &[(String, Vec<u8>)]) -> zip::result::ZipResult<Vec<u8>> {
    let mut packed = ZipWriter::new(Cursor::new(Vec::new()));
    let options = SimpleFileOptions::default().compression_method(CompressionMethod::Deflated).unix_permissions(0o644);
    for (name, bytes) in files {
        packed.start_file(name.as_str(), options)?;
        packed.write_all(bytes)?;
    }
    Ok(packed.finish()?.into_inner())
}
