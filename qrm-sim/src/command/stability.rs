//! `qrm stability`

mod cases;
mod facts;
mod limit;
mod picture;
mod survey;
mod table;

use super::Failure;
use super::arguments::{MethodArguments, MethodName, StabilityArguments};
use super::setup::Setup;
use crate::scenes::Scenes;
use limit::Limit;
use survey::Survey;

/// What the motion is followed with, and variants are tried with.
const TOLERANCE: &str = "1e-9";

/// Says how fast a mechanism reacts along its motion, what that asks of methods, and what becomes of them in extreme cases.
pub(super) fn stability(scenes: &Scenes, arguments: &StabilityArguments) -> Result<(), Failure> {
    let how = MethodArguments {
        method: MethodName::Auto,
        tolerance: Some(TOLERANCE.to_owned()),
        ..MethodArguments::default()
    };
    let setup = Setup::new(scenes, &arguments.scene, &how)?;
    if setup.description.coordinates.len() == setup.description.constraints.len() {
        return Err(Failure::Use(
            "error: the mechanism has no freedom: its motion follows from the constraints alone, and nothing in it can decay or \
             oscillate\n  = help: `qrm run` has its forces; leave out what drives it to see how it moves by itself"
                .to_owned(),
        ));
    }
    let out = setup.folder(arguments.out.as_deref());
    let survey = Survey::until(&setup, None)?;
    let limit = Limit::find(&setup, &survey)?;
    super::say(&facts::facts(&setup, &survey, &limit));
    let mut written = Vec::new();
    let mut save = |name: &str, bytes: &[u8]| {
        let path = out.join(name);
        written.push(path.display().to_string());
        super::save(&path, bytes)
    };
    let failed = |e: csv::Error| Failure::Run(format!("error: {e}"));
    save("stability.csv", &table::samples(&setup, &survey).map_err(failed)?)?;
    let mut text = serde_json::to_string_pretty(&facts::numbers(&setup, &survey, &limit))
        .map_err(|e| Failure::Run(format!("error: {e}")))?;
    text.push('\n');
    save("stability.json", text.as_bytes())?;
    let mut warning = None;
    match picture::figure(&setup, &survey, &limit).svg() {
        Ok(drawn) => save("stability.svg", drawn.as_bytes())?,
        Err(reason) => warning = Some(format!("\n\nwarning: no picture: {reason}")),
    }
    if !arguments.no_extremes && !setup.text.extremes.is_empty() {
        let cases = cases::cases(scenes, &arguments.scene, &setup)?;
        super::say(&table::printed(&cases));
        save("extremes.csv", &table::cases(&cases).map_err(failed)?)?;
        super::say(&table::verdict(&cases));
    }
    super::say(&format!("wrote {}{}", written.join("\n      "), warning.unwrap_or_default()));
    survey.problem.map_or(Ok(()), |problem| Err(Failure::Run(problem)))
}
