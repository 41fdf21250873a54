//! `qrm stability`

mod cases;
mod diagram;
mod limit;
mod report_lines;
mod survey;
mod table;

use clap::Args;
use qrm_core::Model;
use qrm_sim::integrate::AUTO;
use qrm_sim::position::{Start, assemble};

use crate::error::Error;
use crate::options::{MethodOptions, OutFolder, SceneOptions};
use crate::output::{print, save, save_json, written};
use crate::progress::interrupted;
use crate::setup::Setup;
use limit::Limit;
use survey::Survey;

#[derive(Args)]
pub(crate) struct Options {
    #[command(flatten)]
    scene: SceneOptions,
    /// Leave out the scene's `[[extreme]]` cases
    #[arg(long)]
    no_extremes: bool,
    #[command(flatten)]
    out: OutFolder,
}

/// The tolerance for the motion and its variants.
const TOLERANCE: &str = "1e-9";

/// Prints the eigenvalues of a mechanism along its motion, the resulting limits for methods, and the results of all
/// methods in extreme cases.
pub(crate) fn run(models: &'static [Model], options: &Options) -> Result<(), Error> {
    let how = MethodOptions { method: Some(AUTO), tolerance: Some(TOLERANCE.to_owned()), ..MethodOptions::default() };
    let setup = Setup::new(models, &options.scene, &how)?;
    let mechanism = setup.mechanism();
    let (q, _) = assemble(&*mechanism, Start::new(&*mechanism)).map_err(|reason| setup.not_assembled(&reason))?;
    setup.refuse_redundant(&q)?;
    if q.len() == setup.description.constraints.len() {
        return Err(Error::usage(
            "the mechanism has no degree of freedom: its motion follows from the constraints alone, and nothing in it \
             can decay or oscillate",
        )
        .help("`qrm run` has its forces; leave out what drives it to see how it moves freely"));
    }
    let out = options.out.folder(&setup.path);
    let survey = Survey::until(&setup, None)?;
    let limit = Limit::find(&setup, &survey)?;
    print(&report_lines::text(&setup, &survey, &limit));
    save(&out.join("stability.csv"), &table::samples(&setup, &survey)?)?;
    save_json(&out.join("stability.json"), &report_lines::numbers(&setup, &survey, &limit))?;
    let mut files = vec!["stability.csv", "stability.json"];
    let mut warning = String::new();
    match diagram::figure(&setup, &survey, &limit).svg() {
        Ok(drawn) => {
            save(&out.join("stability.svg"), drawn.as_bytes())?;
            files.push("stability.svg");
        }
        Err(reason) => warning = format!("\n\nwarning: no picture: {reason}"),
    }
    if !options.no_extremes && !setup.scene.extremes.is_empty() {
        let cases = cases::cases(models, &options.scene, &setup)?;
        if !cases.is_empty() {
            print(&table::text(&cases));
            save(&out.join("extremes.csv"), &table::cases(&cases)?)?;
            files.push("extremes.csv");
            print(&table::verdicts(&cases));
        }
    }
    let files: Vec<String> = files.iter().map(|file| out.join(file).display().to_string()).collect();
    print(&(written(&files) + &warning));
    if interrupted() {
        return Err(Error::run("interrupted: the cases that were finished are written"));
    }
    survey.problem.map_or(Ok(()), Err)
}
