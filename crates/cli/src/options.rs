//! Options that several subcommands share, and the reading of their values.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use clap::Args;
use qrm_core::Description;
use qrm_scene::declarations::Declarations;
use qrm_scene::diagnostic::Report;
use qrm_scene::evaluate::evaluate;
use qrm_scene::names::suggestion;
use qrm_scene::parser::parse_quantity;
use qrm_scene::unit::Unit;
use qrm_sim::integrate::Method;
use qrm_sim::solve::{Projection, ProjectionTolerance};

use crate::error::Error;
use crate::methods::{method_parser, projection_parser};

/// A scene by its name.
#[derive(Args, Clone, Debug)]
pub(crate) struct SceneName {
    /// Name of the scene, `qrm list` shows them; or path of a scene file
    #[arg(value_name = "SCENE or FILE", default_value = "quick-return")]
    pub(crate) scene: String,
}

/// A scene with parameters, step and end.
#[derive(Args, Clone, Debug)]
pub(crate) struct SceneOptions {
    #[command(flatten)]
    pub(crate) name: SceneName,
    /// Give a parameter another value, such as `O2A=0.25` or `w0=3*pi`
    #[arg(long = "set", value_name = "NAME=VALUE", allow_hyphen_values = true)]
    pub(crate) set: Vec<String>,
    /// Step of the integration in seconds; of the rows, if the method chooses its steps [default: the scene's]
    #[arg(long, value_name = "H", allow_hyphen_values = true)]
    pub(crate) step: Option<String>,
    /// End at this time in seconds, whatever the scene says
    #[arg(long, value_name = "T", conflicts_with = "until", allow_hyphen_values = true)]
    pub(crate) end_time: Option<String>,
    /// End when a condition becomes true, such as `phi2 >= 2*pi` or `N6 >= 1000`; at the scene's latest end at the
    /// latest
    #[arg(long, value_name = "EXPR", allow_hyphen_values = true)]
    pub(crate) until: Option<String>,
}

/// Where a motion starts.
#[derive(Args, Clone, Debug)]
pub(crate) struct StartOptions {
    /// Give a coordinate or a rate another value at the start, such as `phi2=0.5` or `phi2_dot=2*pi`
    #[arg(long = "start", value_name = "NAME=VALUE", allow_hyphen_values = true)]
    pub(crate) start: Vec<String>,
}

/// An integration method with its projection.
#[derive(Args, Clone, Debug)]
pub(crate) struct MethodOptions {
    /// Integration method [default: rk4; dop853 of sweeps, auto of steady motions]
    #[arg(long, value_parser = method_parser())]
    pub(crate) method: Option<&'static Method>,
    /// Largest error of a step of a method that chooses its steps, in the unit of each coordinate and rate
    /// [default: 1e-9; 1e-12 of steady motions]
    #[arg(long, value_name = "TOLERANCE", allow_hyphen_values = true)]
    pub(crate) tolerance: Option<String>,
    /// Longest step of a method that chooses its steps [default: a quarter of the shortest period of a load]
    #[arg(long, value_name = "H", allow_hyphen_values = true)]
    pub(crate) max_step: Option<String>,
    /// What is smallest in the correction after each step: nothing is corrected, the change of the coordinates, or
    /// the mass-weighted change [default: mass]
    #[arg(long, value_parser = projection_parser())]
    pub(crate) projection: Option<Projection>,
    /// Largest residual of a constraint that needs no further correction
    #[arg(long, value_name = "TOLERANCE", allow_hyphen_values = true)]
    pub(crate) closure_tolerance: Option<String>,
    /// Most corrections of position after a step
    #[arg(long, value_name = "N", default_value_t = 10, allow_negative_numbers = true)]
    pub(crate) closure_iterations: u32,
}

impl Default for MethodOptions {
    fn default() -> Self {
        Self {
            method: None,
            tolerance: None,
            max_step: None,
            projection: None,
            closure_tolerance: None,
            closure_iterations: ProjectionTolerance::default().iterations,
        }
    }
}

/// Plots beside the usual figures.
#[derive(Args, Clone, Debug)]
pub(crate) struct PlotOptions {
    /// Plot columns of the trajectory or components of points over one another, such as `N3,N6:phi2` or `C.y:C.x`;
    /// over time without `:X`
    #[arg(long = "plot", value_name = "Y,..:X")]
    pub(crate) plot: Vec<String>,
}

/// The folder of a command's files.
#[derive(Args, Clone, Debug)]
pub(crate) struct OutFolder {
    /// Folder for the files [default: out/SCENE, after the file of the scene]
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
}

impl OutFolder {
    /// The requested folder, or the default for the scene at `path`.
    pub(crate) fn folder(&self, path: &str) -> PathBuf {
        self.out.clone().unwrap_or_else(|| default_folder(path))
    }

    /// The requested folder, or one of this name in the default for the scene at `path`.
    pub(crate) fn subfolder(&self, path: &str, name: &str) -> PathBuf {
        self.out.clone().unwrap_or_else(|| default_folder(path).join(name))
    }
}

/// The default folder for results about the scene at `path`.
pub(crate) fn default_folder(path: &str) -> PathBuf {
    Path::new("out").join(Path::new(path).file_stem().unwrap_or_default())
}

/// The parameters changed by `--set`.
pub(crate) fn parameters(description: &Description, set: &[String]) -> Result<BTreeMap<String, f64>, Error> {
    let values = assignments("--set", set, &|name| unit_of_parameter(description, name))?;
    values.keys().try_for_each(|name| check_parameter(description, name))?;
    Ok(values)
}

/// The unit of a parameter; empty if it has none.
pub(crate) fn unit_of_parameter(description: &Description, name: &str) -> &'static str {
    description.parameters.iter().find(|parameter| parameter.name == name).map_or("", |parameter| parameter.unit)
}

/// The names and values of a repeatable option `NAME=VALUE`; `unit` gives the units of the names.
pub(crate) fn assignments(
    option: &str,
    texts: &[String],
    unit: &dyn Fn(&str) -> &'static str,
) -> Result<BTreeMap<String, f64>, Error> {
    let mut values = BTreeMap::new();
    for text in texts {
        let (name, value) = assignment(option, text, unit)?;
        if values.insert(name.to_owned(), value).is_some() {
            return Err(Error::given_twice(&format!("{option} {name}")));
        }
    }
    Ok(values)
}

/// The name and the value of `NAME=VALUE`.
fn assignment<'t>(option: &str, text: &'t str, unit: &dyn Fn(&str) -> &'static str) -> Result<(&'t str, f64), Error> {
    let Some((name, value)) = text.split_once('=') else {
        return Err(Error::usage(format!("`{option} {text}` has no `=`")).help(format!("write `{option} NAME=VALUE`")));
    };
    let name = name.trim();
    Ok((name, number(&format!("{option} {name}"), value, unit(name))?))
}

/// Returns an error if the generated code has no parameter with this name.
pub(crate) fn check_parameter(description: &Description, name: &str) -> Result<(), Error> {
    let scene = description.name;
    if description.parameters.iter().any(|p| p.name == name) {
        return Ok(());
    }
    if description.left_out.contains(&name) {
        let text =
            format!("parameter `{name}` is exactly zero in scene `{scene}`, so the generated code does without it");
        return Err(Error::usage(text).help(format!(
            "add `runtime = true` to `{name}` in the scene, or give it a value there; build again if it is compiled"
        )));
    }
    let names: Vec<&str> = description.parameters.iter().map(|p| p.name).collect();
    let help = suggestion(name, names.iter().copied(), || format!("its parameters: {}", names.join(", ")));
    Err(Error::usage(format!("scene `{scene}` has no parameter `{name}`")).help(help))
}

/// Reads a number in this unit: a formula of numbers and `pi`, in which numbers may have units. An empty unit stands
/// for that in SI units.
pub(crate) fn number(option: &str, text: &str, unit: &str) -> Result<f64, Error> {
    let report = |finding| Report::new(option, text, vec![finding]);
    let (formula, dimension) = parse_quantity(text, 0, &Declarations::default(), None).map_err(report)?;
    let wrong = |why: String| Error::usage(format!("`{option}` needs a number, but `{text}` {why}"));
    if let Some(name) = formula.names().find(|name| *name != "pi") {
        return Err(
            wrong(format!("contains the name `{name}`")).help("only numbers, `pi` and functions can stand here")
        );
    }
    let mut value = evaluate(&formula, |_| std::f64::consts::PI);
    if let Some(unit) = Unit::parse(unit).filter(|_| dimension.is_certain() && !unit.is_empty()) {
        if let Some(finding) = dimension.misfit(&unit, 0..text.len()) {
            return Err(report(finding).into());
        }
        value /= unit.factor();
    }
    if value.is_finite() { Ok(value) } else { Err(wrong(format!("gives {value}"))) }
}

/// Returns an error if some of these numbers have a unit and others, except zero, have none.
pub(crate) fn check_units(option: &str, texts: &[&str]) -> Result<(), Error> {
    let has_unit = |text: &&&str| {
        let parsed = parse_quantity(text, 0, &Declarations::default(), None);
        parsed.is_ok_and(|(_, dimension)| dimension.is_certain())
    };
    let count = texts.iter().filter(has_unit).count();
    let is_zero = |text: &&&str| text.trim().parse::<f64>() == Ok(0.0);
    if count == 0 || count + texts.iter().filter(is_zero).count() == texts.len() {
        return Ok(());
    }
    Err(Error::usage(format!("`{option}`: some of these numbers have a unit: {}", texts.join(", ")))
        .help("write the unit behind each of them, or none"))
}

/// Reads a positive number in this unit.
pub(crate) fn positive(option: &str, text: &str, unit: &str) -> Result<f64, Error> {
    let value = number(option, text, unit)?;
    if value > 0.0 { Ok(value) } else { Err(Error::usage(format!("`{option}` must be above zero, but is {value}"))) }
}

/// Reads an optional positive number in this unit.
pub(crate) fn optional_positive(option: &str, text: Option<&String>, unit: &str) -> Result<Option<f64>, Error> {
    text.map(|text| positive(option, text, unit)).transpose()
}
