//! A branch of steady motions over a parameter: `branch.csv`, `branch.json`, `branch.svg`.

use std::path::Path;

use qrm_core::{Interval, Model};
use qrm_pictures::Recording;
use qrm_sim::analysis::{BranchEnd, BranchPoint, BranchRequest, SteadyRequest, steady_branch};
use qrm_sim::columns::Kind;

use super::branch_report::BranchReport;
use super::branch_table::BranchTable;
use super::columns::{Columns, record_period};
use super::failure;
use super::period::Rates;
use crate::error::Error;
use crate::options::{MethodOptions, SceneOptions, check_parameter, check_units, number, unit_of_parameter};
use crate::output::{Named, check_target, print, save, save_json, written};
use crate::progress::Progress;
use crate::regular_forms::DesignSpace;
use crate::setup::Setup;

/// A parameter and the range of its values.
#[derive(Clone, Debug)]
pub(super) struct Vary {
    pub(super) name: String,
    pub(super) range: [f64; 2],
}

impl Vary {
    /// Reads `NAME=FROM:TO` and prepares the scene with the first value.
    pub(super) fn setup(
        models: &'static [Model],
        text: &str,
        scene: &SceneOptions,
        how: &MethodOptions,
    ) -> Result<(Self, Setup), Error> {
        let found = scene.name.find(models)?;
        let wrong = |why: &str| Error::usage(format!("`--vary {text}` {why}")).help("write `--vary NAME=FROM:TO`");
        let (name, values) = text.split_once('=').ok_or_else(|| wrong("has no `=`"))?;
        let name = name.trim();
        check_parameter(found.model.description, name)?;
        let (from, to) = values.split_once(':').ok_or_else(|| wrong("has no `:`"))?;
        let option = format!("--vary {name}");
        check_units(&option, &[from, to])?;
        let unit = unit_of_parameter(found.model.description, name);
        let range = [number(&option, from, unit)?, number(&option, to, unit)?];
        if range[0] == range[1] {
            return Err(wrong("varies nothing"));
        }
        let is_set = |text: &String| text.split_once('=').is_some_and(|(other, _)| other.trim() == name);
        if scene.set.iter().any(is_set) {
            return Err(Error::usage(format!("`--set` and `--vary` both give `{name}`")).help("take one of them out"));
        }
        let mut setup = Setup::without_rewrites(found, scene, how)?;
        setup.set_parameter(name, range[0]);
        let setup = setup.with_regular_forms(&DesignSpace {
            count: 2,
            value: &|design, other| (other == name).then_some(range[design]),
            range: &|other| {
                (other == name).then(|| Interval::hull(Interval::point(range[0]), Interval::point(range[1])))
            },
        })?;
        setup.print_notes();
        Ok((Self { name: name.to_owned(), range }, setup))
    }
}

/// A point with what moves over its period.
pub(super) struct Point {
    pub(super) at: BranchPoint,
    pub(super) columns: Columns,
    /// The smallest and the largest value of each coordinate.
    pub(super) ranges: Vec<[f64; 2]>,
}

/// Follows the branch of a request, prints what happens on it, and writes its files.
pub(super) fn run(
    mut setup: Setup,
    vary: &Vary,
    steady: SteadyRequest,
    most_points: usize,
    folder: &Path,
) -> Result<(), Error> {
    let [table_path, json_path, figure_path] =
        ["branch.csv", "branch.json", "branch.svg"].map(|name| folder.join(name));
    [&table_path, &json_path, &figure_path].into_iter().try_for_each(|path| check_target(path))?;
    let place = setup.description.parameters.iter().position(|parameter| parameter.name == vary.name);
    let (phase, cycles) = (steady.phase, steady.cycles);
    let rates = Rates::new(&setup);
    let given = steady.period;
    let own = |value: f64| rates.period(&vary.name, value);
    let constant = |_: f64| given;
    // A period that was given does not depend on the parameter.
    let period: Option<&dyn Fn(f64) -> Option<f64>> = match given {
        None => None,
        Some(_) if rates.is_own(given, &vary.name, vary.range[0]) => Some(&own),
        Some(_) => Some(&constant),
    };
    let request = BranchRequest { steady, parameter: place.unwrap_or(0), to: vary.range[1], period, most_points };
    let (model, set) = (setup.model, setup.set.clone());
    let replace = |name: &str| set.get(name).copied();
    let progress = Progress::points();
    let mut points: Vec<Point> = Vec::new();
    let mut problem: Option<Error> = None;
    let end = steady_branch(model, &replace, &request, &mut |point| {
        progress.add(1);
        // A point whose run fails keeps its place.
        points.push(with_columns(&mut setup, vary, phase, point, &mut problem));
    });
    drop(progress);
    let (end, interrupted) = match end {
        Ok(end) => (end, None),
        // The points so far are written.
        Err(reason) if !points.is_empty() => {
            let error = failure::error(&setup, cycles, reason.clone());
            (BranchEnd::Lost(reason), Some(error))
        }
        Err(reason) => return Err(failure::error(&setup, cycles, reason)),
    };
    let table = BranchTable { setup: &setup, vary, points: &points, phase };
    let report = BranchReport::new(&table, &end, cycles);
    save(&table_path, &table.csv()?)?;
    save_json(&json_path, &report)?;
    let mut files = vec![json_path, table_path];
    let mut problems: Vec<Error> = interrupted.into_iter().chain(problem).collect();
    match table.figure().svg() {
        Ok(drawn) => match save(&figure_path, drawn.as_bytes()) {
            Ok(()) => files.push(figure_path),
            Err(error) => problems.push(error),
        },
        Err(reason) => problems.push(Error::run(format!("branch.svg cannot be drawn: {reason}"))),
    }
    let files: Vec<String> = files.iter().map(|path| path.display().to_string()).collect();
    print(&format!("{}\n{}", report.text(), written(&files)));
    Error::all(problems)
}

/// A point with its columns, by a run over its period; without them if that fails, which is the first problem.
fn with_columns(
    setup: &mut Setup,
    vary: &Vary,
    phase: Option<usize>,
    point: BranchPoint,
    problem: &mut Option<Error>,
) -> Point {
    let motion = &point.motion;
    setup.set_parameter(&vary.name, point.parameter);
    let mut recording = Recording::new(setup.description);
    let columns = record_period(setup, motion, phase, &mut recording).unwrap_or_else(|error| {
        problem.get_or_insert(error);
        Columns(Named(Vec::new()))
    });
    let range = |i: usize| {
        let extremes = recording.extremes(Kind::Coordinate(i));
        extremes.map_or([f64::NAN; 2], |e| [e.minimum.0, e.maximum.0])
    };
    let ranges = (0..setup.description.coordinates.len()).map(range).collect();
    Point { at: point, columns, ranges }
}
