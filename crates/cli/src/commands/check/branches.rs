//! The positions in which a mechanism can be assembled.

use qrm_sim::analysis::{MAX_BRANCHES, branches};
use qrm_sim::position::Start;
use qrm_sim::solve::constraint_rank;

use crate::error::Error;
use crate::format::{counted, quantity};
use crate::progress::{interrupted, watch_interrupts};
use crate::setup::Setup;
use crate::table::{self, Align};

/// Creates a table with the coordinates of each branch.
pub(super) fn text(setup: &Setup) -> Result<String, Error> {
    let start = setup.start();
    let mechanism = setup.mechanism();
    let q = setup.assembled()?;
    let free = start.given.iter().filter(|given| !**given).count();
    let rank = constraint_rank(&*mechanism, 0.0, &q);
    if free != rank {
        let title = format!(
            "branches cannot be counted: {} not given, and the constraints determine {rank}",
            counted(free as u64, "coordinate") + if free == 1 { " is" } else { " are" }
        );
        return Err(Error::usage(title).help("give as many coordinates in [initial] as there are degrees of freedom"));
    }
    if free == 0 {
        return Ok(format!("{}: 1 branch, all coordinates are given", setup.description.name));
    }
    watch_interrupts();
    let found = branches(&*mechanism, &Start { q: q.clone(), ..start.clone() }, || !interrupted());
    if interrupted() {
        return Err(Error::run("the search for branches was interrupted"));
    }
    let coordinates = setup.description.coordinates;
    let (fixed, free): (Vec<usize>, Vec<usize>) = (0..q.len()).partition(|&i| start.given[i]);
    let names = free.iter().map(|&i| coordinates[i].name.to_owned());
    let mut rows: Vec<Vec<String>> = vec![[String::new()].into_iter().chain(names).chain([String::new()]).collect()];
    for (number, q) in (1..).zip(&found) {
        let values = free.iter().map(|&i| quantity(q[i], coordinates[i].unit));
        let note = if number == 1 { "the scene's own" } else { "" };
        rows.push([format!("{number}")].into_iter().chain(values).chain([note.to_owned()]).collect());
    }
    let mut columns = vec![Align::Right; free.len() + 1];
    columns.push(Align::Left);
    let given: Vec<String> =
        fixed.iter().map(|&i| format!("{} = {}", coordinates[i].name, quantity(q[i], coordinates[i].unit))).collect();
    let given = if given.is_empty() { String::new() } else { format!(" with {}", given.join(", ")) };
    let number = found.len();
    let noun = if number == 1 { "branch" } else { "branches" };
    let more = if number == MAX_BRANCHES { " and perhaps more" } else { "" };
    let mut text = format!("{}: {number} {noun}{more}{given}\n", setup.description.name);
    table::lines(&columns, &rows).iter().for_each(|line| text += &format!("\n{line}"));
    if number > 1 {
        text += "\n\nGuesses near the values of a branch choose it: `solve` in [initial], `near` and `angle` in links \
                 and joints";
    }
    Ok(text)
}
