//! Run times of other programs on the same mechanism, measured by `benches/peers/run`.

use qrm_view::report::Content;

/// Problem, kind, tool with method, and microseconds at errors of 1e-6, 1e-9 and 1e-12; written by the benchmark.
const TIMES: &str = include_str!("peers.csv");

/// The tables for a scene; empty if it was not measured.
pub(super) fn tables(scene: &str) -> Vec<Content<'static>> {
    let of_kind = |kind: &str| -> Vec<Vec<String>> {
        let rows = TIMES.lines().skip(1).map(|line| line.split(',').map(str::to_owned).collect::<Vec<_>>());
        let own = rows.filter(|row| row[0] == scene && row[1] == kind);
        own.map(|row| row[2..].iter().map(|cell| if cell.is_empty() { "-".to_owned() } else { cell.clone() }).collect())
            .collect()
    };
    let kinds = [("run", "One run"), ("sweep", "A design in sweeps")];
    let measured = kinds.map(|(kind, title)| (title, of_kind(kind)));
    let tables = measured.into_iter().filter(|(_, rows)| !rows.is_empty()).map(|(title, rows)| {
        let head = [&format!("{title}, us for an error of"), "1e-6", "1e-9", "1e-12"].map(str::to_owned).to_vec();
        Content::Table { head, rows }
    });
    let mut contents: Vec<Content> = tables.collect();
    if !contents.is_empty() {
        let note = "All programs were measured in turn on one machine, on the scene as it is published: they compare \
                    with each other, not with the times above. How each is set up, and what it leaves out, is in \
                    `benches/peers/README.md`.";
        contents.insert(0, Content::Markdown(note));
    }
    contents
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_row_has_a_problem_a_kind_a_method_and_three_times() {
        for line in TIMES.lines().skip(1) {
            let cells: Vec<&str> = line.split(',').collect();
            assert!(cells.len() == 6 && ["run", "sweep"].contains(&cells[1]), "{line}");
            let is_time = |cell: &&str| cell.is_empty() || cell.parse::<f64>().is_ok_and(|t| t > 0.0);
            assert!(cells[3..].iter().all(is_time), "{line}");
        }
        assert_eq!(tables("quick-return").len(), 3);
        assert_eq!(tables("pendulum").len(), 2);
        assert!(tables("unknown").is_empty());
    }
}
