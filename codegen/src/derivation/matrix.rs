//! Matrices in LaTeX.

/// About as many characters of LaTeX fit beside each other on a page.
const WIDTH: usize = 220;

/// The name of a point.
pub(super) fn name(point: &str) -> String {
    format!(r"\mathrm{{{}}}", point.replace('_', r"\_"))
}

/// A column of entries.
pub(super) fn vector(entries: &[String]) -> String {
    matrix(&entries.iter().map(|entry| vec![entry.clone()]).collect::<Vec<_>>())
}

/// Rows of entries.
pub(super) fn matrix(rows: &[Vec<String>]) -> String {
    let rows: Vec<String> = rows.iter().map(|row| row.join(" & ")).collect();
    format!(r"\begin{{pmatrix}} {} \end{{pmatrix}}", rows.join(r" \\ "))
}

/// Whether a matrix is narrow enough to be read at once.
pub(super) fn fits(rows: &[Vec<String>]) -> bool {
    let columns = rows.first().map_or(0, Vec::len);
    let width = |column: usize| rows.iter().map(|row| row[column].len()).max().unwrap_or(0);
    columns <= 8 && (0..columns).map(width).sum::<usize>() <= WIDTH
}

/// The entries that are not zero, each by itself.
pub(super) fn entries(name: &str, letter: &str, rows: &[Vec<String>]) -> String {
    let columns = rows.first().map_or(0, Vec::len);
    let mut text = if name == letter { String::new() } else { format!("$${name} = {letter}$$\n\n") };
    let mut is_zero = true;
    let is_symmetric =
        columns > 1 && columns == rows.len() && (0..columns).all(|i| (0..i).all(|j| rows[i][j] == rows[j][i]));
    for (i, row) in rows.iter().enumerate() {
        let from = if is_symmetric { i } else { 0 };
        for (j, entry) in row.iter().enumerate().skip(from).filter(|(_, entry)| *entry != "0") {
            let index = if columns == 1 { format!("{}", i + 1) } else { format!("{},{}", i + 1, j + 1) };
            text += &format!("$${{{letter}}}_{{{index}}} = {entry}$$\n\n");
            is_zero = false;
        }
    }
    text + match (is_zero, is_symmetric) {
        (true, _) => "All entries are zero.",
        (false, true) => "All others are zero or follow from the symmetry of the matrix.",
        (false, false) => "All others are zero.",
    }
}
