//! Tables on a terminal.

/// Where the cells of a column stand.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(crate) enum Align {
    /// At its left side.
    Left,
    /// At its right side.
    Right,
}

/// The lines of a table, indented, with columns as wide as their widest cell. All rows have as many cells as there are
/// columns.
pub(crate) fn lines(columns: &[Align], rows: &[Vec<String>]) -> Vec<String> {
    let width = |column: usize| rows.iter().map(|row| row[column].chars().count()).max().unwrap_or(0);
    let widths: Vec<usize> = (0..columns.len()).map(width).collect();
    let line = |row: &Vec<String>| {
        let mut line = String::from("  ");
        for ((cell, align), width) in row.iter().zip(columns).zip(&widths) {
            line += &match align {
                Align::Left => format!("{cell:<width$}  "),
                Align::Right => format!("{cell:>width$}  "),
            };
        }
        line.trim_end().to_owned()
    };
    rows.iter().map(line).collect()
}

#[cfg(test)]
mod tests {
    use super::{Align, lines};

    #[test]
    fn columns_are_as_wide_as_their_widest_cell() {
        let rows =
            [["", "x", "unit"], ["b_12", "-1.5", ""], ["phi", "10", "rad"]].map(|row| row.map(str::to_owned).to_vec());
        let table = lines(&[Align::Left, Align::Right, Align::Left], &rows);
        assert_eq!(table, ["           x  unit", "  b_12  -1.5", "  phi     10  rad"]);
    }
}
