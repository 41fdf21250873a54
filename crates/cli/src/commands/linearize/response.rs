//! The frequency response: gain and phase.

use std::f64::consts::TAU;

use qrm_sim::analysis::{LinearModel, ModeKind, Modes};

use super::report::LinearReport;
use crate::error::Error;
use crate::format::{full, number};
use crate::output::csv;

/// The frequency response of a linear model.
pub(super) struct FrequencyResponse {
    /// In Hz.
    pub(super) frequencies: Vec<f64>,
    /// From each input to each output, output by output.
    pub(super) curves: Vec<ResponseCurve>,
    inputs: usize,
}

/// The response of an output to an input.
pub(super) struct ResponseCurve {
    parts: Vec<[f64; 2]>,
    pub(super) gains: Vec<f64>,
    /// In degrees, without jumps by whole turns.
    pub(super) phases: Vec<f64>,
}

/// The ratio of the default frequencies to the nearest natural frequency.
const BEYOND: f64 = 10.0;
/// The default frequencies of a mechanism that does not oscillate, in Hz.
const WITHOUT_OSCILLATION: [f64; 2] = [0.1, 10.0];

impl FrequencyResponse {
    /// The response at a number of frequencies. The first and the last may be given, in Hz.
    pub(super) fn new(
        model: &LinearModel,
        modes: &Modes,
        [from, to]: [Option<f64>; 2],
        points: u32,
    ) -> Result<Self, Error> {
        let oscillations = modes.undamped.iter().filter(|mode| mode.kind() == ModeKind::Oscillation);
        let natural: Vec<f64> = oscillations.map(|mode| mode.rate().0 / TAU).collect();
        let lowest = natural.iter().copied().reduce(f64::min).map_or(WITHOUT_OSCILLATION[0], |low| low / BEYOND);
        let highest = natural.iter().copied().reduce(f64::max).map_or(WITHOUT_OSCILLATION[1], |high| high * BEYOND);
        let low = from.unwrap_or_else(|| lowest.min(to.map_or(f64::INFINITY, |to| to / (BEYOND * BEYOND))));
        let high = to.unwrap_or_else(|| highest.max(low * BEYOND * BEYOND));
        if low >= high {
            return Err(Error::usage(format!("`--from {}` is not below `--to {}`", number(low), number(high)))
                .help("leave one of them out, or exchange them"));
        }
        let step = (high / low).ln() / f64::from(points - 1);
        let mut frequencies: Vec<f64> = (0..points).map(|i| low * (step * f64::from(i)).exp()).collect();
        if let Some(last) = frequencies.last_mut() {
            *last = high;
        }
        let rates: Vec<f64> = frequencies.iter().map(|frequency| TAU * frequency).collect();
        let responses = model.frequency_response(&rates);
        let (outputs, inputs) =
            responses.first().map_or((0, 0), |first| (first.len(), first.first().map_or(0, Vec::len)));
        let curve = |output: usize, input: usize| {
            let parts: Vec<[f64; 2]> =
                responses.iter().map(|at| [at[output][input].re, at[output][input].im]).collect();
            ResponseCurve { gains: parts.iter().map(|[re, im]| re.hypot(*im)).collect(), phases: phases(&parts), parts }
        };
        let curves = (0..outputs).flat_map(|output| (0..inputs).map(move |input| (output, input)));
        Ok(Self { curves: curves.map(|(output, input)| curve(output, input)).collect(), frequencies, inputs })
    }

    /// The number of frequencies.
    pub(super) fn len(&self) -> usize {
        self.frequencies.len()
    }

    /// The names of output and input of a curve.
    pub(super) fn names<'r>(&self, report: &'r LinearReport, curve: usize) -> [&'r str; 2] {
        [&report.outputs[curve / self.inputs].name, &report.inputs[curve % self.inputs].name]
    }

    /// `frequency_response.csv`
    pub(super) fn csv(&self, report: &LinearReport) -> Result<Vec<u8>, Error> {
        let mut header = vec!["frequency".to_owned(), "rate".to_owned()];
        for curve in 0..self.curves.len() {
            let [output, input] = self.names(report, curve);
            header.extend(["re", "im", "gain", "gain_dB", "phase_deg"].map(|part| format!("{output}/{input}_{part}")));
        }
        let rows = self.frequencies.iter().enumerate().map(|(place, frequency)| {
            let mut row = vec![full(*frequency), full(TAU * frequency)];
            for curve in &self.curves {
                let ([re, im], gain) = (curve.parts[place], curve.gains[place]);
                row.extend([re, im, gain, 20.0 * gain.log10(), curve.phases[place]].map(full));
            }
            row
        });
        csv(header, rows)
    }

    /// The range and the largest gains, for a terminal.
    pub(super) fn text(&self, report: &LinearReport) -> String {
        let ends = [self.frequencies.first(), self.frequencies.last()].map(|end| number(end.copied().unwrap_or(0.0)));
        let mut text = format!("\n  response    {} frequencies from {} to {} Hz\n", self.len(), ends[0], ends[1]);
        for (place, curve) in self.curves.iter().enumerate() {
            let finite = (0..self.len()).filter(|&i| curve.gains[i].is_finite());
            let Some(peak) = finite.max_by(|&a, &b| curve.gains[a].total_cmp(&curve.gains[b])) else { continue };
            let [output, input] = self.names(report, place);
            text += &format!(
                "              {output} by {input}: largest gain {} at {} Hz\n",
                number(curve.gains[peak]),
                number(self.frequencies[peak])
            );
        }
        text
    }
}

/// The phases in degrees, continued from frequency to frequency.
fn phases(parts: &[[f64; 2]]) -> Vec<f64> {
    let mut last = 0.0;
    let phase = |[re, im]: &[f64; 2]| {
        let own = im.atan2(*re).to_degrees();
        let turns = ((last - own) / 360.0_f64).round();
        if own.is_finite() {
            last = own + 360.0 * turns;
            return last;
        }
        own
    };
    parts.iter().map(phase).collect()
}
