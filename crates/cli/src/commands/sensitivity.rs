//! `qrm sensitivity`

mod check;
mod quantities;
mod table;

use std::collections::BTreeMap;

use clap::Args;
use qrm_core::{Model, ParameterOverrides};
use qrm_scene::names::suggestion;
use qrm_sim::analysis::{Sensitivity, SensitivityError, SensitivityRequest, sensitivity};

use crate::error::{Error, Message};
use crate::format::counted;
use crate::options::{MethodOptions, OutFolder, SceneOptions, assignments, check_parameter};
use crate::output::{check_target, print, save};
use crate::progress::{Progress, interrupted};
use crate::setup::Setup;
use check::Check;
pub(crate) use quantities::Quantity;
use quantities::quantities;

#[derive(Args)]
pub(crate) struct Options {
    #[command(flatten)]
    scene: SceneOptions,
    /// By this parameter; may be repeated [default: by all]
    #[arg(long, value_name = "NAME")]
    by: Vec<String>,
    /// Of this output, or `end` for the state at the end; may be repeated [default: of all]
    #[arg(long, value_name = "NAME")]
    of: Vec<String>,
    /// Also the products of the Hessians with the vector that has this entry and is zero elsewhere; may be repeated for
    /// more entries
    #[arg(long, value_name = "NAME=VALUE")]
    hessian_vector: Vec<String>,
    /// Skip the motions by steps half as long, which estimate errors, and those at other values of the parameters,
    /// which check the derivatives
    #[arg(long)]
    no_check: bool,
    #[command(flatten)]
    how: MethodOptions,
    #[command(flatten)]
    out: OutFolder,
}

/// Computes derivatives of a motion with respect to parameters, checks them, prints and writes them.
pub(crate) fn run(models: &'static [Model], options: &Options) -> Result<(), Error> {
    let setup = Setup::new(models, &options.scene, &options.how)?;
    let vector = assignments("--hessian-vector", &options.hessian_vector, &|_| "")?;
    let request = DerivativeRequest::new(&setup, &options.by, &options.of, vector, !options.no_check)?;
    let path = options.out.folder(&setup.path).join("sensitivity.csv");
    check_target(&path)?;
    // An old table could be mistaken for the new one. If it cannot be removed, writing will fail too.
    let _ = std::fs::remove_file(&path);
    let found = request.compute(&setup)?;
    let rows = found.quantities(&setup);
    save(&path, &table::csv(&rows, &found.by)?)?;
    let text = table::text(&setup, &rows, &found.by) + &check::text(&found.checks);
    print(&format!("{text}\nwrote {} ({})", path.display(), counted(rows.len() as u64, "row")));
    if interrupted() {
        return Err(Error::run("interrupted: the derivatives are written, but not all of them are checked"));
    }
    found.verdict()
}

/// The requested derivatives.
pub(crate) struct DerivativeRequest {
    by: Vec<&'static str>,
    of: Vec<String>,
    /// The entries of the vector for Hessian products.
    vector: BTreeMap<String, f64>,
    /// Whether errors are estimated and derivatives compared with difference quotients.
    is_checked: bool,
}

/// Derivatives of a motion, and their checks.
pub(crate) struct CheckedDerivatives {
    /// The parameters, in the order of the derivatives.
    pub(crate) by: Vec<&'static str>,
    of: Vec<String>,
    derivatives: Sensitivity,
    checks: Vec<Check>,
}

impl DerivativeRequest {
    /// Creates the request; an empty `by` means all parameters, an empty `of` all quantities.
    pub(crate) fn new(
        setup: &Setup,
        by: &[String],
        of: &[String],
        vector: BTreeMap<String, f64>,
        is_checked: bool,
    ) -> Result<Self, Error> {
        let q = setup.assembled()?;
        setup.refuse_redundant(&q)?;
        let by = parameters(setup, by)?;
        check_outputs(setup, of)?;
        vector.keys().try_for_each(|name| check_parameter(setup.description, name))?;
        Ok(Self { by, of: of.to_vec(), vector, is_checked })
    }

    /// Computes the derivatives and checks them.
    pub(crate) fn compute(self, setup: &Setup) -> Result<CheckedDerivatives, Error> {
        let Self { by, of, vector, is_checked } = self;
        let direction: Vec<(&str, f64)> = vector.iter().map(|(name, entry)| (name.as_str(), *entry)).collect();
        let checking = if is_checked { check::motions(by.len()) } else { 0 };
        let progress = Progress::motions(SensitivityRequest::motions(by.len()) + checking);
        let outputs = outputs(setup, &of);
        let request = SensitivityRequest {
            by: &by,
            settings: setup.settings,
            outputs: outputs.as_deref(),
            direction: &direction,
            estimate_errors: is_checked,
            ..SensitivityRequest::default()
        };
        let derivatives = derive((setup, &progress), &setup.replace(), request)?;
        if let Some(reason) = setup.passed_over(derivatives.end_time.value) {
            return Err(Error::run(reason).help("use a shorter --step"));
        }
        let rows = quantities(setup, &derivatives, &of);
        let checks = if is_checked { check::check((setup, &progress), &by, &rows, &of) } else { Vec::new() };
        Ok(CheckedDerivatives { by, of, derivatives, checks })
    }
}

impl CheckedDerivatives {
    /// The quantities with their derivatives.
    pub(crate) fn quantities(&self, setup: &Setup) -> Vec<Quantity<'_>> {
        let mut rows = quantities(setup, &self.derivatives, &self.of);
        for (place, check) in self.checks.iter().enumerate() {
            check.widen_errors(place, &mut rows);
        }
        rows
    }

    /// Returns an error if the checks show that the derivatives are unreliable.
    pub(crate) fn verdict(&self) -> Result<(), Error> {
        check::verdict(&self.checks)
    }
}

/// The requested parameters in the order of the request, or all.
fn parameters(setup: &Setup, asked: &[String]) -> Result<Vec<&'static str>, Error> {
    asked.iter().try_for_each(|name| check_parameter(setup.description, name))?;
    if let Some((_, twice)) = asked.iter().enumerate().find(|(i, name)| asked[..*i].contains(name)) {
        return Err(Error::given_twice(&format!("--by {twice}")));
    }
    let all = setup.description.parameters.iter().map(|parameter| parameter.name);
    if !asked.is_empty() {
        return Ok(asked.iter().filter_map(|name| all.clone().find(|known| known == name)).collect());
    }
    let by: Vec<&str> = all.collect();
    if by.is_empty() {
        return Err(Error::usage(format!("scene `{}` has no parameter", setup.description.name))
            .help("give a number a name under [parameters]"));
    }
    Ok(by)
}

/// The numbers of the requested outputs; `None` for all.
fn outputs(setup: &Setup, of: &[String]) -> Option<Vec<usize>> {
    let is_asked = |i: &usize| of.iter().any(|of| of == setup.description.outputs[*i].name);
    (!of.is_empty()).then(|| (0..setup.description.outputs.len()).filter(is_asked).collect())
}

/// Returns an error if the scene lacks a requested output.
fn check_outputs(setup: &Setup, asked: &[String]) -> Result<(), Error> {
    let outputs = || setup.description.outputs.iter().map(|output| output.name).chain(["end"]);
    let Some(unknown) = asked.iter().find(|asked| !outputs().any(|output| output == asked.as_str())) else {
        return Ok(());
    };
    let help = suggestion(unknown, outputs(), || format!("outputs: {}", outputs().collect::<Vec<_>>().join(", ")));
    let name = setup.description.name;
    Err(Error::usage(format!("`--of {unknown}`: scene `{name}` has no output of this name")).help(help))
}

/// Computes the requested derivatives at other parameter values.
fn derive(
    (setup, progress): (&Setup, &Progress),
    replace: ParameterOverrides,
    asked: SensitivityRequest,
) -> Result<Sensitivity, Error> {
    let keep_running = |t, end_time| progress.keep_running(t, end_time);
    let request =
        SensitivityRequest { step: Some(setup.step()), end: setup.end(), keep_running: Some(&keep_running), ..asked };
    sensitivity(setup.model, replace, &request).map_err(|reason| no_sensitivity(setup, &reason))
}

/// The error of a motion that has no derivatives.
pub(crate) fn no_sensitivity(setup: &Setup, reason: &SensitivityError) -> Error {
    let name = setup.description.name;
    let message = match reason {
        SensitivityError::Start(reason) => return setup.no_start(reason),
        SensitivityError::Step { t, error } => {
            setup.step_error(error).after(&format!("the motion breaks off after t = {t} s: "))
        }
        SensitivityError::Singular { t } => Message::new(format!(
            "after t = {t} s the mechanism comes near a position at which its constraints are singular, or the step is \
             too long: the motion is carried on there by means that have no derivatives"
        ))
        .help(format!(
            "use a shorter --step, an earlier --end-time, or look with `qrm stability {name}` for singular positions"
        )),
        SensitivityError::ForcesNearSingular { t } => Message::new(format!(
            "at t = {t} s the mechanism is near a singular position, where forces and accelerations have too few \
             digits for derivatives"
        ))
        .help("ask by --of for outputs that take neither, or end earlier with --end-time"),
        SensitivityError::NotSmooth { t } => {
            Message::new(format!("at or after t = {t} s some formula has no value, or no derivative"))
                .help("look for roots of what becomes zero there, and for powers with exponents below one")
        }
        SensitivityError::Unresolved { t, output } => {
            let output = setup.description.outputs[*output].name;
            Message::new(format!("`{output}` changes so fast before t = {t} s that its integral is not known"))
                .help("use a shorter --step, or ask for other quantities by --of")
        }
        SensitivityError::EventNotReached { end_time } => {
            Message::new(format!("the stop condition did not become true up to t = {end_time} s"))
                .help(format!("`qrm run {name}` says how near it came"))
        }
        SensitivityError::GrazingEvent { t } => Message::new(format!(
            "the stop condition becomes true at t = {t} s without passing through zero there: the least change of a \
             parameter may move the end far, so it has no derivative"
        ))
        .help("end elsewhere with --until or --end-time"),
        SensitivityError::Interrupted { t } => Message::new(format!("interrupted at t = {t} s")),
        SensitivityError::NoParameter { name: parameter } => {
            Message::new(format!("scene `{name}` has no parameter `{parameter}`"))
        }
    };
    message.after("no derivatives: ").into()
}
