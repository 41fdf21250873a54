//! Samples and cases as tables.

use super::cases::{Case, CaseResult, Verdict};
use super::survey::{Sample, Survey};
use crate::error::Error;
use crate::format::{full, milliseconds, shortened};
use crate::output::csv;
use crate::setup::Setup;

/// `stability.csv`; infinite values are left empty.
pub(super) fn samples(setup: &Setup, survey: &Survey) -> Result<Vec<u8>, Error> {
    let mut header = vec!["t".to_owned()];
    header.extend(setup.scene.coordinates.iter().map(|c| c.name.clone()));
    let numbers = ["rate", "frequency", "growth", "longest_step", "condition_mass", "condition_loops"];
    header.extend(numbers.map(str::to_owned));
    header.push("smallest_singular_value".to_owned());
    let record = |sample: &Sample| {
        let s = &sample.spectrum;
        let numbers = [s.rate, s.frequency, s.growth, s.longest_step, s.condition_mass, s.condition_loops];
        let row = std::iter::once(sample.t).chain(sample.q.iter().copied()).chain(numbers);
        row.chain([s.smallest_singular_value]).map(full).collect::<Vec<String>>()
    };
    csv(header, survey.samples.iter().map(record))
}

/// `extremes.csv`
pub(super) fn cases(cases: &[Case]) -> Result<Vec<u8>, Error> {
    let header = ["case", "set", "reference", "method", "steps", "run_seconds", "error", "verdict", "reason"];
    let record = |(case, result): (&Case, &CaseResult)| {
        let (verdict, reason) = verdict_texts(&result.verdict);
        let [seconds, error] = [result.seconds, result.error].map(|n| n.map_or(String::new(), full));
        let steps = result.steps.to_string();
        let record = [&case.name, &case.set, &case.origin, result.method, &steps, &seconds, &error, verdict, reason];
        record.map(str::to_owned)
    };
    let results = cases.iter().flat_map(|case| case.results.iter().map(move |result| (case, result)));
    csv(header, results.map(record))
}

fn verdict_texts(verdict: &Verdict) -> (&'static str, &str) {
    match verdict {
        Verdict::Right => ("right", ""),
        Verdict::Refused(reason) => ("refused", reason),
        Verdict::Unnoticed => ("wrong and unnoticed", ""),
        Verdict::Unknown => ("not known", ""),
    }
}

/// The cases for a terminal.
pub(super) fn text(cases: &[Case]) -> String {
    let mut text = String::from(
        "Extreme cases: the error at the end, relative to values above one, and the verdict of each run on itself\n",
    );
    for case in cases {
        text += &format!("\n  {} ({}); exact: {}\n", case.name, case.set, case.origin);
        for result in &case.results {
            let seconds = result.seconds.map_or("-".to_owned(), milliseconds);
            let error = result.error.map_or("-".to_owned(), |error| format!("{error:.1e}"));
            let (verdict, reason) = verdict_texts(&result.verdict);
            let reason = if reason.is_empty() { String::new() } else { format!(": {reason}") };
            text += &format!(
                "  {:8} {:>8} steps {seconds:>12} {error:>9}  {verdict}{}\n",
                result.method,
                result.steps,
                shortened(&reason, 90)
            );
        }
    }
    text
}

/// The number of each verdict, by method.
pub(super) fn verdicts(cases: &[Case]) -> String {
    let mut text = String::from("Of the extreme cases\n");
    let results = || cases.iter().flat_map(|case| &case.results);
    let mut methods: Vec<&str> = results().map(|result| result.method).collect();
    methods.sort_unstable();
    methods.dedup();
    for method in methods {
        let count = |is: fn(&Verdict) -> bool| results().filter(|r| r.method == method && is(&r.verdict)).count();
        let right = count(|v| *v == Verdict::Right);
        let refused = count(|v| matches!(v, Verdict::Refused(_)));
        let unnoticed = count(|v| *v == Verdict::Unnoticed);
        let unknown = count(|v| *v == Verdict::Unknown);
        text += &format!(
            "  {method:8} {right} right, {refused} refused by the run itself, {unnoticed} wrong and unnoticed"
        );
        text += &if unknown > 0 { format!(", {unknown} not known\n") } else { "\n".to_owned() };
    }
    text
}
