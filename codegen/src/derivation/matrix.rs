//! Matrices in LaTeX.

/// The approximate number of letters in a line of a page.
const WIDTH: usize = 72;

/// The approximate number of visible letters of a formula: a command counts as one, braces as none.
fn width(latex: &str) -> usize {
    let hidden = [
        r"\left",
        r"\right",
        r"\mathit",
        r"\mathrm",
        r"\dot",
        r"\ddot",
        r"\frac",
        r"\mathbf",
        r"\mathcal",
        r"\bar",
        r"\,",
    ];
    let bare = hidden.iter().fold(latex.to_owned(), |text, command| text.replace(command, ""));
    let mut in_command = false;
    let mut is_seen = |c: &char| {
        let c = *c;
        let begins = c == '\\';
        in_command = begins || in_command && c.is_ascii_alphabetic();
        begins || !in_command && !"{}_^ ".contains(c)
    };
    bare.chars().filter(|c| is_seen(c)).count()
}

/// The name of a point.
pub(super) fn name(point: &str) -> String {
    format!(r"\mathrm{{{}}}", point.replace('_', r"\_"))
}

/// Writes a column of entries.
pub(super) fn vector(entries: &[String]) -> String {
    matrix(&entries.iter().map(|entry| vec![entry.clone()]).collect::<Vec<_>>())
}

/// Writes rows of entries.
pub(super) fn matrix(rows: &[Vec<String>]) -> String {
    let rows: Vec<String> = rows.iter().map(|row| row.join(" & ")).collect();
    format!(r"\begin{{pmatrix}} {} \end{{pmatrix}}", rows.join(r" \\ "))
}

/// Whether a matrix fits into a line.
pub(super) fn fits(rows: &[Vec<String>]) -> bool {
    let columns = rows.first().map_or(0, Vec::len);
    let widest = |column: usize| rows.iter().map(|row| width(&row[column])).max().unwrap_or(0);
    (0..columns).map(|column| widest(column) + 4).sum::<usize>() <= WIDTH
}

/// `name = formula`, on several lines if the formula is long.
pub(super) fn equation(name: &str, summands: &[String]) -> String {
    match &lines(summands)[..] {
        [whole] => format!("$${name} = {whole}$$"),
        lines => format!(r"$$\begin{{aligned}} {name} ={{}}& {} \end{{aligned}}$$", lines.join(r" \\ & ")),
    }
}

/// Writes a formula without a name.
pub(super) fn formula(summands: &[String]) -> String {
    match &lines(summands)[..] {
        [whole] => format!("$${whole}$$"),
        lines => format!(r"$$\begin{{aligned}} & {} \end{{aligned}}$$", lines.join(r" \\ & ")),
    }
}

/// Splits the summands into as few lines as possible, filled evenly.
fn lines(summands: &[String]) -> Vec<String> {
    let widths: Vec<usize> = summands.iter().map(|summand| width(summand)).collect();
    let total: usize = widths.iter().sum();
    let target = total / total.div_ceil(WIDTH).max(1);
    let mut lines = vec![String::new()];
    let mut filled = 0;
    for (summand, width) in summands.iter().zip(widths) {
        if filled > 0 && (filled + width > WIDTH || filled + width / 2 > target) {
            lines.push(String::new());
            filled = 0;
        }
        if let Some(line) = lines.last_mut() {
            *line += summand;
        }
        filled += width;
    }
    lines
}

/// Writes the nonzero entries one by one.
pub(super) fn entries(name: &str, letter: &str, rows: &[Vec<Vec<String>>]) -> String {
    let columns = rows.first().map_or(0, Vec::len);
    let mut text = if name == letter { String::new() } else { format!("$${name} = {letter}$$\n\n") };
    let mut is_zero = true;
    let is_symmetric =
        columns > 1 && columns == rows.len() && (0..columns).all(|i| (0..i).all(|j| rows[i][j] == rows[j][i]));
    for (i, row) in rows.iter().enumerate() {
        let from = if is_symmetric { i } else { 0 };
        for (j, entry) in row.iter().enumerate().skip(from).filter(|(_, entry)| entry[..] != ["0"]) {
            let index = if columns == 1 { format!("{}", i + 1) } else { format!("{},{}", i + 1, j + 1) };
            text += &equation(&format!("{{{letter}}}_{{{index}}}"), entry);
            text += "\n\n";
            is_zero = false;
        }
    }
    text + match (is_zero, is_symmetric) {
        (true, _) => "All entries are zero.",
        (false, true) => "All others are zero or follow from the symmetry of the matrix.",
        (false, false) => "All others are zero.",
    }
}
