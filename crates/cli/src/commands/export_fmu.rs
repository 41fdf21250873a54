//! `qrm export-fmu`

mod description;
mod roles;

use std::io::{Cursor, Write};
use std::path::{Path, PathBuf};

use clap::Args;
use qrm_core::Model;
use qrm_fmu::InstantiationToken;
use zip::write::SimpleFileOptions;
use zip::{CompressionMethod, ZipWriter};

use crate::error::Error;
use crate::format;
use crate::options::{MethodOptions, OutFolder, SceneOptions};
use crate::output::{print, save};
use crate::progress::Progress;
use crate::run_report::RunReport;
use crate::setup::Setup;
use qrm_pictures::Recording;

/// The licences of the code in the library of an FMU.
const THIRD_PARTY: &str = include_str!("../../THIRD-PARTY.txt");

#[derive(Args)]
pub(crate) struct Options {
    #[command(flatten)]
    scene: SceneOptions,
    #[command(flatten)]
    method: MethodOptions,
    /// Make a parameter an input that the tool can connect, such as the torque of a motor; may be repeated
    #[arg(long, value_name = "NAME")]
    input: Vec<String>,
    #[command(flatten)]
    out: OutFolder,
}

/// Packs a scene as an FMU for FMI 3.0.
pub(crate) fn run(models: &'static [Model], options: &Options) -> Result<(), Error> {
    let setup = Setup::new(models, &options.scene, &options.method)?;
    // The library of an FMU contains the scenes of the program.
    if !models.iter().any(|model| std::ptr::eq(model.description, setup.model.description)) {
        return Err(Error::usage("FMUs need a compiled scene, and scene files are interpreted")
            .help("put the file into `scenes` of a clone of qrm, build, and export the scene by its name"));
    }
    let roles = roles::roles(&setup, &options.input)?;
    // A scene that fails here would also fail elsewhere.
    let mut observer = (Progress::new(), Recording::new(setup.description));
    let outcome = setup.simulate(true, &mut observer)?;
    RunReport::new(&setup, &outcome, &observer.1).problem().map_or(Ok(()), Err)?;
    let token = InstantiationToken {
        fixed: roles.fixed().into_iter().map(str::to_owned).collect(),
        computed: roles.computed().into_iter().map(str::to_owned).collect(),
        masses: roles.masses().into_iter().map(str::to_owned).collect(),
        replaced: setup.set.clone().into_iter().collect(),
        ..InstantiationToken::new(setup.description, setup.settings, outcome.step)
    };
    let identifier = setup.description.name.replace('-', "_");
    let values = setup.model.parameter_values(&setup.replace());
    let xml = description::xml(setup.description, &identifier, &token, &roles, &values, outcome.end_time)
        .map_err(|e| Error::run(format!("the description of the unit cannot be written: {e}")))?;
    let library = library(&setup)?;
    let files = [
        ("modelDescription.xml".to_owned(), xml.into_bytes()),
        (format!("binaries/{}/{identifier}{}", platform(), std::env::consts::DLL_SUFFIX), library),
        ("documentation/licenses/license.txt".to_owned(), THIRD_PARTY.as_bytes().to_vec()),
        (format!("resources/{}.toml", setup.description.name), setup.description.source.as_bytes().to_vec()),
    ];
    let packed = pack(&files).map_err(|e| Error::run(format!("the unit cannot be packed: {e}")))?;
    let path = options.out.folder(&setup.path).join(format!("{identifier}.fmu"));
    save(&path, &packed)?;
    print(&text(&setup, &roles, &path, outcome.end_time));
    Ok(())
}

fn text(setup: &Setup, roles: &roles::Roles, path: &Path, end: f64) -> String {
    let name = setup.description.name;
    let list = |names: Vec<&str>| if names.is_empty() { "none".to_owned() } else { names.join(", ") };
    format!(
        "{name}: FMI 3.0, co-simulation ({} inside) and model exchange, to t = {end} s unless the tool says \
         otherwise\n\n  inputs             {}\n  tunable            {}\n  before the start   {}\n\nwrote {}",
        format::method(setup.settings.method.name, setup.settings.tolerance(), setup.step()),
        list(roles.inputs()),
        list(roles.tunable()),
        list(roles.fixed()),
        path.display(),
    )
}

/// Reads the library that was built with this command.
fn library(setup: &Setup) -> Result<Vec<u8>, Error> {
    use std::env::consts::{DLL_PREFIX, DLL_SUFFIX};
    let command = std::env::current_exe().unwrap_or_default();
    let stem = command.file_stem().unwrap_or_default().to_string_lossy().into_owned();
    let file = format!("{DLL_PREFIX}{stem}{DLL_SUFFIX}");
    let library: PathBuf = command.with_file_name(&file);
    // If cargo builds the command alone, it leaves the library in a subfolder.
    let places = [library.with_file_name("deps").join(&file), library.clone()];
    let modified = |path: &PathBuf| std::fs::metadata(path).and_then(|m| m.modified()).ok();
    let newest = places.into_iter().filter(|path| path.is_file()).max_by_key(modified);
    let path = newest.unwrap_or(library);
    let wrong = |why: String| {
        Error::usage(format!("the shared library for the FMU {why}: {}", path.display())).help(
            "`cargo build --release` makes it next to the command; keep both in one folder (a command that pip \
                   installed has none)",
        )
    };
    let library = std::fs::read(&path).map_err(|e| wrong(format!("cannot be read ({e})")))?;
    let holds = |text: &str| library.windows(text.len()).any(|window| window == text.as_bytes());
    if holds("fmi3InstantiateCoSimulation") && holds(setup.description.source) {
        return Ok(library);
    }
    Err(wrong(format!("does not hold scene `{}` as this command does", setup.description.name)))
}

/// The folder for this system's library in an FMU.
fn platform() -> String {
    let system = match std::env::consts::OS {
        "macos" => "darwin",
        other => other,
    };
    format!("{}-{system}", std::env::consts::ARCH)
}

/// Packs files reproducibly: without times and owners.
fn pack(files: &[(String, Vec<u8>)]) -> zip::result::ZipResult<Vec<u8>> {
    let mut packed = ZipWriter::new(Cursor::new(Vec::new()));
    let options = SimpleFileOptions::default().compression_method(CompressionMethod::Deflated).unix_permissions(0o644);
    for (name, bytes) in files {
        packed.start_file(name.as_str(), options)?;
        packed.write_all(bytes)?;
    }
    Ok(packed.finish()?.into_inner())
}
