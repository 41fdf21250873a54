//! `qrm report`

mod peers;

use std::time::{Duration, Instant};

use clap::Args;
use qrm_core::Model;
use qrm_core::ParameterDescription;
use qrm_view::report::{Content, Report, Section, page};

use super::accuracy::Study;
use super::check;
use crate::error::{Error, Message};
use crate::options::{MethodOptions, OutFolder, PlotOptions, SceneOptions};
use crate::output::{print, save_and_print};
use crate::pictures::figures;
use crate::plots::Plots;
use crate::progress::{Progress, interrupted};
use crate::run_report::RunReport;
use crate::setup::Setup;
use qrm_pictures::{Recording, motion};

#[derive(Args)]
pub(crate) struct Options {
    #[command(flatten)]
    scene: SceneOptions,
    #[command(flatten)]
    method: MethodOptions,
    /// Measure no run times and errors, which takes a few seconds
    #[arg(long)]
    no_accuracy: bool,
    #[command(flatten)]
    plots: PlotOptions,
    #[command(flatten)]
    out: OutFolder,
}

/// Runs a scene and writes a page with all results.
pub(crate) fn run(models: &'static [Model], options: &Options) -> Result<(), Error> {
    let setup = Setup::new(models, &options.scene, &options.method)?;
    let path = options.out.folder(&setup.path).join("report.html");
    let plots = Plots::new(&setup, &options.plots)?;
    let mut observer = (Progress::new(), (Recording::new(setup.description), plots));
    let outcome = setup.simulate(true, &mut observer)?;
    let (recording, plots) = observer.1;
    let report = RunReport::new(&setup, &outcome, &recording);
    let mut sections = vec![section("Run", summary(&report))];
    let motion = (recording.frames.len() > 1).then(|| motion(&setup.scene, &setup.parameters(), &recording));
    if let Some(motion) = &motion {
        let shown = match motion {
            Ok((motion, _)) => Content::Animation(motion),
            Err(reason) => Content::Warning(Message::from(reason.clone()).to_string()),
        };
        sections.push(section("Motion", vec![shown]));
        let all = figures(&setup, &outcome, &recording).into_iter().chain(plots.figures(&recording));
        let figures = all.map(|(name, figure)| match figure.svg() {
            Ok(svg) => Content::Figure(svg),
            Err(reason) => Content::Warning(format!("{name} cannot be drawn: {reason}")),
        });
        sections.push(section("Figures", figures.collect()));
    }
    let (topics, _) = check::report_lines(&setup)?;
    let topics = topics.into_iter().map(|topic| (topic.name, topic.lines)).collect();
    sections.push(section("Mechanism", vec![Content::Facts(topics)]));
    if !options.no_accuracy {
        sections.push(section("Error against run time", accuracy(&setup)));
    }
    let peers = if setup.is_changed() { Vec::new() } else { peers::tables(setup.description.name) };
    if !peers.is_empty() {
        sections.push(section("Beside other programs", peers));
    }
    sections.push(section("Parameters", vec![parameters(&setup, &report)]));
    let mut derivation = Vec::new();
    if setup.is_changed() {
        let note = "The table below shows the values of the scene; those of this run stand under Parameters.";
        derivation.push(Content::Warning(note.to_owned()));
    }
    derivation.push(Content::Markdown(setup.description.derivation));
    sections.push(section("Derivation", derivation));
    let (title, doc) = (setup.description.name.to_owned(), setup.description.doc.to_owned());
    print(&format!("{title}: {}\n", report.message));
    save_and_print(&path, page(&Report { title, doc, sections }).as_bytes())?;
    if interrupted() {
        return Err(Error::run("interrupted: the page holds what was found until then"));
    }
    report.problem().map_or(Ok(()), Err)
}

fn section<'c>(heading: &str, contents: Vec<Content<'c>>) -> Section<'c> {
    Section { heading: heading.to_owned(), contents }
}

/// The report of the run, its warnings and the extremes of the outputs.
fn summary(report: &RunReport) -> Vec<Content<'static>> {
    let lines = report.report_lines().into_iter().map(|(topic, line)| (topic.to_owned(), vec![line]));
    let mut contents = vec![Content::Facts(lines.collect())];
    contents.extend(report.warnings.iter().map(|warning| Content::Warning(warning.to_string())));
    let rows: Vec<Vec<String>> = report.output_extremes().into_iter().map(Vec::from).collect();
    if !rows.is_empty() {
        contents.push(table(["output", "minimum", "at t (s)", "maximum", "at t (s)", "unit"], rows));
    }
    contents
}

/// Error against run time.
fn accuracy(setup: &Setup) -> Vec<Content<'static>> {
    let study = match Study::new(setup, &[], None, None, Instant::now() + BUDGET) {
        Err(error) => return vec![Content::Warning(error.to_string())],
        Ok(study) => study,
    };
    let mut lines = vec![("against".to_owned(), vec![study.origin()])];
    lines.extend(study.recommendations().into_iter().map(|(goal, line)| (format!("error {goal}"), vec![line])));
    let picture = study.figure(setup).svg();
    let picture = picture.map_or_else(|reason| Content::Warning(reason.to_string()), Content::Figure);
    vec![picture, Content::Facts(lines)]
}

/// The time limit for the measurements of a report.
const BUDGET: Duration = Duration::from_secs(10);

fn parameters(setup: &Setup, report: &RunReport) -> Content<'static> {
    let described = setup.description.parameters.iter().zip(&report.parameters.0);
    let row = |(p, (name, value)): (&ParameterDescription, &(String, f64))| {
        vec![name.clone(), format!("{value}"), p.unit.to_owned(), p.doc.to_owned()]
    };
    table(["parameter", "value", "unit", "meaning"], described.map(row).collect())
}

fn table<const COLUMNS: usize>(head: [&str; COLUMNS], rows: Vec<Vec<String>>) -> Content<'static> {
    Content::Table { head: head.map(str::to_owned).to_vec(), rows }
}
