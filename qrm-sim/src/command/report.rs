//! `qrm report`

use std::time::{Duration, Instant};

use qrm_view::report::{Content, Report, Section, page};

use super::accuracy::Study;
use super::arguments::ReportArguments;
use super::progress::Progress;
use super::setup::Setup;
use super::{Failure, account, check, digest};
use crate::album::Album;
use crate::animation::motion;
use crate::scenes::Scenes;
use crate::summary::Summary;

/// Runs a scene and writes everything that is known of it on one page.
pub(super) fn report(scenes: &Scenes, arguments: &ReportArguments) -> Result<(), Failure> {
    let setup = Setup::new(scenes, &arguments.scene, &arguments.method)?;
    let path = setup.folder(arguments.out.as_deref()).join("report.html");
    let mut observer = (Progress::new(), Album::new(&setup.description));
    let outcome = setup.simulate(true, &mut observer)?;
    let album = observer.1;
    let summary = account::summary(&setup, &outcome, &album);
    let mut sections = vec![run(&setup, &summary)];
    let motion = (album.frames.len() > 1).then(|| motion(&setup.text, &setup.parameters(), &album));
    if let Some(motion) = &motion {
        let shown = match motion {
            Ok(motion) => Content::Animation(motion),
            Err(reason) => Content::Warning(reason.clone()),
        };
        sections.push(Section { heading: "Motion".to_owned(), contents: vec![shown] });
        let figures = account::figures(&setup, &outcome, &album).into_iter().map(|(name, figure)| match figure.svg() {
            Ok(svg) => Content::Figure(svg),
            Err(reason) => Content::Warning(format!("{name} cannot be drawn: {reason}")),
        });
        sections.push(Section { heading: "Figures".to_owned(), contents: figures.collect() });
    }
    let (facts, _) = check::facts(&setup)?;
    let facts = facts.into_iter().map(|fact| (fact.topic, fact.lines)).collect();
    sections.push(Section { heading: "Mechanism".to_owned(), contents: vec![Content::Facts(facts)] });
    if !arguments.no_accuracy {
        sections.push(accuracy(&setup));
    }
    sections.push(parameters(&setup, &summary));
    let mut derivation = Vec::new();
    if !arguments.scene.set.is_empty() {
        let note = "The table below shows the values of the scene; those of this run stand under Parameters.";
        derivation.push(Content::Warning(note.to_owned()));
    }
    derivation.push(Content::Markdown(setup.description.derivation));
    sections.push(Section { heading: "Derivation".to_owned(), contents: derivation });
    let (title, doc) = (setup.description.name.to_owned(), setup.description.doc.to_owned());
    let html = page(&Report { title, doc, sections });
    super::save(&path, html.as_bytes())?;
    super::say(&format!("{}: {}\n", summary.scene, summary.message));
    super::say(&format!("wrote {} ({} kB)", path.display(), html.len().div_ceil(1000)));
    account::problem(&outcome, &summary).map_or(Ok(()), |problem| Err(Failure::Run(problem)))
}

fn run(setup: &Setup, summary: &Summary) -> Section<'static> {
    let facts = digest::facts(summary).into_iter().map(|(topic, line)| (topic.to_owned(), vec![line]));
    let mut contents = vec![Content::Facts(facts.collect())];
    contents.extend(summary.warnings.iter().cloned().map(Content::Warning));
    let extremes = |name: &str| summary.extremes.0.iter().find(|(column, _)| column == name).map(|(_, e)| e);
    let rows = setup.description.outputs.iter().filter_map(|output| {
        let e = extremes(output.name)?;
        let [low, high] = [e.min, e.max].map(digest::number);
        let [at_low, at_high] = [e.min_time, e.max_time].map(|t| format!("{t:.6}"));
        Some(vec![output.name.to_owned(), low, at_low, high, at_high, output.unit.to_owned()])
    });
    let rows: Vec<Vec<String>> = rows.collect();
    if !rows.is_empty() {
        contents.push(table(["output", "minimum", "at t (s)", "maximum", "at t (s)", "unit"], rows));
    }
    Section { heading: "Run".to_owned(), contents }
}

/// Error against run time.
fn accuracy(setup: &Setup) -> Section<'static> {
    let contents = match Study::new(setup, &[], None, Instant::now() + BUDGET) {
        Err(Failure::Run(reason) | Failure::Use(reason)) => vec![Content::Warning(reason)],
        Ok(study) => {
            let mut facts = vec![("against".to_owned(), vec![study.origin()])];
            facts.extend(study.verdict().into_iter().map(|(goal, way)| (format!("error {goal}"), vec![way])));
            let picture = study.figure(setup).svg();
            let picture = picture.map_or_else(|reason| Content::Warning(reason.to_string()), Content::Figure);
            vec![picture, Content::Facts(facts)]
        }
    };
    Section { heading: "Error against run time".to_owned(), contents }
}

/// A report takes not much longer than this for its measurements.
const BUDGET: Duration = Duration::from_secs(10);

fn parameters(setup: &Setup, summary: &Summary) -> Section<'static> {
    let described = setup.description.parameters.iter().zip(&summary.parameters.0);
    let row = |(p, (name, value)): (&qrm_core::ParameterDescription, &(String, f64))| {
        vec![name.clone(), format!("{value}"), p.unit.to_owned(), p.doc.to_owned()]
    };
    let rows = described.map(row).collect();
    let contents = vec![table(["parameter", "value", "unit", "meaning"], rows)];
    Section { heading: "Parameters".to_owned(), contents }
}

fn table<const COLUMNS: usize>(head: [&str; COLUMNS], rows: Vec<Vec<String>>) -> Content<'static> {
    Content::Table { head: head.map(str::to_owned).to_vec(), rows }
}
