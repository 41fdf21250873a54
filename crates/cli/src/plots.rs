//! Plots requested by the user: columns of a run, or components of points, plotted against each other.

mod path;
mod quantity;

use std::io;

use qrm_pictures::{MAX_CURVES, Recording, printed_unit};
use qrm_scene::evaluate::State;
use qrm_sim::columns::{Kind, columns};
use qrm_sim::run::{Observer, Row};
use qrm_view::figure::{Abscissa, Curve, Figure, Panel, Scale};

use crate::error::Error;
use crate::options::PlotOptions;
use crate::pictures::extremes;
use crate::setup::Setup;
use path::Path;
use quantity::{Quantity, Source};

/// Units for which both axes of a path have the same scale.
const LENGTHS: [&str; 6] = ["m", "mm", "cm", "km", "in", "ft"];

/// The requested plots, and an observer that keeps their data.
pub(crate) struct Plots<'s> {
    setup: &'s Setup,
    parameters: Vec<f64>,
    plots: Vec<Plot>,
    /// Whether a plot shows a component of a point.
    has_points: bool,
}

/// Quantities plotted against another one.
struct Plot {
    /// The name of its file, without its extension.
    file: String,
    ordinates: Vec<Quantity>,
    abscissa: Quantity,
    /// The path of each ordinate.
    paths: Vec<Path>,
}

impl<'s> Plots<'s> {
    /// Creates the plots requested on the command line.
    pub(crate) fn new(setup: &'s Setup, options: &PlotOptions) -> Result<Self, Error> {
        let mut plots: Vec<Plot> = Vec::new();
        for text in &options.plot {
            let plot = Plot::new(setup, text)?;
            // Some file systems do not distinguish upper and lower case.
            if let Some(other) = plots.iter().find(|other| other.file.eq_ignore_ascii_case(&plot.file)) {
                let (same, file) = (other.file == plot.file, &plot.file);
                return Err(if same {
                    Error::given_twice(&format!("--plot {text}"))
                } else {
                    Error::usage(format!("`{file}.svg` and `{}.svg` may be the same file", other.file))
                        .help("make one of the two plots in another run")
                });
            }
            plots.push(plot);
        }
        let quantities = || plots.iter().flat_map(|plot| plot.ordinates.iter().chain([&plot.abscissa]));
        let has_points = quantities().any(|quantity| matches!(quantity.source, Source::Point(..)));
        Ok(Self { parameters: setup.parameters(), setup, has_points, plots })
    }

    /// The figures, with file names without extensions.
    pub(crate) fn figures(&self, recording: &Recording) -> Vec<(String, Figure)> {
        self.plots.iter().map(|plot| (plot.file.clone(), plot.figure(recording))).collect()
    }
}

impl Plot {
    /// Reads `Y,..:X`, or `Y,..` for a plot over time.
    fn new(setup: &Setup, text: &str) -> Result<Self, Error> {
        let wrong = |why: &str| {
            Error::usage(format!("`--plot {text}` {why}"))
                .help("write `--plot Y:X`, or `--plot Y1,Y2:X` for two curves")
        };
        let (ordinates, abscissa) = text.split_once(':').unwrap_or((text, "t"));
        if abscissa.contains(':') {
            return Err(wrong("has two `:`"));
        }
        if abscissa.contains(',') {
            return Err(wrong("has two abscissae"));
        }
        let names: Vec<&str> = ordinates.split(',').chain([abscissa]).map(str::trim).collect();
        if names.contains(&"") {
            return Err(wrong("lacks a name"));
        }
        if let Some((_, twice)) = names.iter().enumerate().find(|(i, name)| names[..*i].contains(name)) {
            return Err(wrong(&format!("has `{twice}` twice")));
        }
        if names.len() - 1 > MAX_CURVES {
            let text = format!("`--plot {text}` has {} curves, and more than {MAX_CURVES}", names.len() - 1);
            return Err(Error::usage(format!("{text} cannot be told apart")).help("make several plots of them"));
        }
        let columns = columns(setup.description);
        let quantities: Result<Vec<Quantity>, Error> =
            names.iter().map(|name| Quantity::new(setup, &columns, name)).collect();
        let mut ordinates = quantities?;
        let abscissa = ordinates.remove(names.len() - 1);
        let paths = ordinates.iter().map(|_| Path::default()).collect();
        Ok(Self { file: format!("plot-{}", names.join("-")), ordinates, abscissa, paths })
    }

    /// Draws the figure.
    fn figure(&self, recording: &Recording) -> Figure {
        let curve = |(quantity, path): (&Quantity, &Path)| {
            let (points, extremes) = match (&self.abscissa.source, &quantity.source) {
                (Source::Column(_, Kind::Time), Source::Column(_, kind)) => {
                    (recording.series(*kind), extremes(recording, *kind))
                }
                _ => (path.points(), None),
            };
            Curve { name: quantity.name.clone(), doc: quantity.doc.clone(), points, extremes, has_dots: false }
        };
        let mut panels: Vec<Panel> = Vec::new();
        for (quantity, curve) in self.ordinates.iter().zip(self.ordinates.iter().zip(&self.paths).map(curve)) {
            let unit = printed_unit(&quantity.unit);
            if let Some(panel) = panels.iter_mut().find(|panel| panel.unit == unit) {
                panel.quantity += &format!(", {}", quantity.name);
                panel.curves.push(curve);
                continue;
            }
            let (quantity, scale) = (quantity.name.clone(), Scale::Linear);
            panels.push(Panel { quantity, unit, scale, curves: vec![curve], floor: None });
        }
        let (quantity, unit) = (self.abscissa.name.clone(), printed_unit(&self.abscissa.unit));
        let is_isometric = LENGTHS.contains(&unit.as_str()) && panels.iter().all(|panel| panel.unit == unit);
        let names: Vec<&str> = self.ordinates.iter().map(|ordinate| ordinate.name.as_str()).collect();
        let ordinates = match &self.ordinates[..] {
            [alone] => alone.title(),
            _ => names.join(", "),
        };
        let over = match self.abscissa.source {
            Source::Column(_, Kind::Time) => "time".to_owned(),
            _ => self.abscissa.title(),
        };
        let title = format!("{ordinates} over {over}");
        Figure {
            title,
            abscissa: Abscissa { quantity, unit, scale: Scale::Linear, is_isometric, has_origin: false },
            panels,
        }
    }
}

impl Observer for Plots<'_> {
    fn row(&mut self, row: &Row) -> io::Result<()> {
        let state = self.has_points.then(|| State::plain(&self.setup.scene, &self.parameters, row.t, row.q, row.qd));
        let number = |quantity: &Quantity| match quantity.source {
            Source::Column(place, _) => row.columns[place],
            Source::Point(point, axis) => state.as_ref().map_or(f64::NAN, |state| state.point(point)[axis]),
        };
        for plot in &mut self.plots {
            let x = number(&plot.abscissa);
            for (quantity, path) in plot.ordinates.iter().zip(&mut plot.paths) {
                path.push((x, number(quantity)));
            }
        }
        Ok(())
    }

    fn needs_outputs(&self) -> bool {
        !self.plots.is_empty()
    }
}
