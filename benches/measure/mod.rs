//! Times that are measured in turn, and counted instructions.

use std::process::Command;
use std::time::Instant;

/// Rounds in which everything is measured once.
pub(crate) const ROUNDS: usize = 15;

/// Times of several things, each measured once a round, so that what disturbs the machine disturbs all of them.
pub(crate) fn in_turn(count: usize, mut measure: impl FnMut(usize) -> f64) -> Vec<Spread> {
    let mut times = vec![Vec::new(); count];
    for _ in 0..ROUNDS {
        for (i, times) in times.iter_mut().enumerate() {
            times.push(measure(i));
        }
    }
    times.into_iter().map(Spread).collect()
}

/// The measurements of several rounds.
pub(crate) struct Spread(pub(crate) Vec<f64>);

impl Spread {
    /// Each over another of the same round.
    pub(crate) fn over(&self, other: &Self) -> Self {
        Self(self.0.iter().zip(&other.0).map(|(a, b)| a / b).collect())
    }

    /// Median, smallest and largest.
    pub(crate) fn show(&self, digits: usize) -> String {
        let mut values = self.0.clone();
        values.sort_by(f64::total_cmp);
        let [least, most] = [values[0], values[values.len() - 1]];
        format!("{:.digits$} ({least:.digits$} to {most:.digits$})", values[values.len() / 2])
    }
}

/// Nanoseconds of one call.
#[allow(dead_code, reason = "not every bench has calls")]
pub(crate) fn time(calls: u64, run: impl Fn(u64)) -> f64 {
    let begun = Instant::now();
    run(calls);
    begun.elapsed().as_secs_f64() * 1e9 / calls as f64
}

/// The argument by which a bench runs one thing some times, for its instructions to be counted.
pub(crate) const COUNT: &str = "--count";

/// Instructions of one call of a thing, by valgrind; `None` where there is none.
pub(crate) fn instructions(thing: usize, calls: u64) -> Option<f64> {
    let total = |calls: u64| -> Option<f64> {
        let run = Command::new("valgrind")
            .args(["--tool=callgrind", "--callgrind-out-file=/dev/null"])
            .arg(std::env::current_exe().ok()?)
            .args([COUNT, &thing.to_string(), &calls.to_string()])
            .output()
            .ok()?;
        let text = String::from_utf8_lossy(&run.stderr).into_owned();
        text.lines().find_map(|line| line.split_once("Collected : ")?.1.trim().parse().ok())
    };
    Some((total(2 * calls)? - total(calls)?) / calls as f64)
}

/// The index of the thing to run and the number of calls, if this process was started to count instructions.
pub(crate) fn counted() -> Option<(usize, u64)> {
    let mut arguments = std::env::args().skip_while(|argument| argument != COUNT).skip(1);
    Some((arguments.next()?.parse().ok()?, arguments.next()?.parse().ok()?))
}
