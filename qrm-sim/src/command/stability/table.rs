//! Samples and cases as tables.

use super::super::setup::Setup;
use super::super::words;
use super::cases::{Case, Verdict};
use super::survey::Survey;

/// `stability.csv`; what is infinite stays empty.
pub(super) fn samples(setup: &Setup, survey: &Survey) -> Result<Vec<u8>, csv::Error> {
    let mut writer = csv::Writer::from_writer(Vec::new());
    let mut header = vec!["t".to_owned()];
    header.extend(setup.text.coordinates.iter().map(|c| c.name.clone()));
    let numbers = ["rate", "frequency", "growth", "longest_step", "condition_mass", "condition_loops"];
    header.extend(numbers.map(str::to_owned));
    header.push("smallest_singular_value".to_owned());
    writer.write_record(header)?;
    for sample in &survey.samples {
        let s = &sample.spectrum;
        let numbers = [s.rate, s.frequency, s.growth, s.longest_step, s.condition_mass, s.condition_loops];
        let row = std::iter::once(sample.t).chain(sample.q.iter().copied()).chain(numbers);
        writer.write_record(row.chain([s.smallest_singular_value]).map(finite))?;
    }
    super::super::table_of(writer)
}

/// `extremes.csv`
pub(super) fn cases(cases: &[Case]) -> Result<Vec<u8>, csv::Error> {
    let mut writer = csv::Writer::from_writer(Vec::new());
    writer.write_record([
        "case",
        "set",
        "reference",
        "method",
        "steps",
        "run_seconds",
        "error",
        "verdict",
        "reason",
    ])?;
    for case in cases {
        for tried in &case.trials {
            let (verdict, reason) = verdict_words(&tried.verdict);
            let [seconds, error] = [tried.seconds, tried.error].map(|n| n.map_or(String::new(), finite));
            let steps = tried.steps.to_string();
            let row = [&case.name, &case.set, &case.origin, tried.method, &steps, &seconds, &error, verdict, reason];
            writer.write_record(row)?;
        }
    }
    super::super::table_of(writer)
}

fn finite(number: f64) -> String {
    if number.is_finite() { format!("{number:?}") } else { String::new() }
}

fn verdict_words(verdict: &Verdict) -> (&'static str, &str) {
    match verdict {
        Verdict::Right => ("right", ""),
        Verdict::Refused(reason) => ("refused", reason),
        Verdict::Unnoticed => ("wrong and unnoticed", ""),
        Verdict::Unknown => ("not known", ""),
    }
}

/// The cases for a terminal.
pub(super) fn printed(cases: &[Case]) -> String {
    let mut text = String::from(
        "Extreme cases: the error at the end, relative to values above one, and the verdict of each run on itself\n",
    );
    for case in cases {
        text += &format!("\n  {} ({}); exact: {}\n", case.name, case.set, case.origin);
        for tried in &case.trials {
            let seconds = tried.seconds.map_or("-".to_owned(), words::milliseconds);
            let error = tried.error.map_or("-".to_owned(), |error| format!("{error:.1e}"));
            let (verdict, reason) = verdict_words(&tried.verdict);
            let reason = reason.strip_prefix("error: ").unwrap_or(reason);
            let reason = if reason.is_empty() { String::new() } else { format!(": {reason}") };
            text += &format!(
                "  {:8} {:>8} steps {seconds:>12} {error:>9}  {verdict}{}\n",
                tried.method,
                tried.steps,
                words::shortened(&reason, 90)
            );
        }
    }
    text
}

/// How the methods fared.
pub(super) fn verdict(cases: &[Case]) -> String {
    let mut text = String::from("Of the extreme cases\n");
    let trials = || cases.iter().flat_map(|case| &case.trials);
    let mut methods: Vec<&str> = trials().map(|tried| tried.method).collect();
    methods.sort_unstable();
    methods.dedup();
    for method in methods {
        let count =
            |is: fn(&Verdict) -> bool| trials().filter(|tried| tried.method == method && is(&tried.verdict)).count();
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
