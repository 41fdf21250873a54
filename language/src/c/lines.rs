//! Lines of C that are not too long.

const WIDTH: usize = 110;

/// A comment.
pub(super) fn comment<S: AsRef<str>>(lines: &[S]) -> String {
    let line = |line: &S| {
        let line = line.as_ref().trim_end();
        // A backslash, or what stands for one, would join the next line.
        let end = if line.ends_with('\\') || line.ends_with("??/") { "." } else { "" };
        format!("// {line}{end}").trim_end().to_owned() + "\n"
    };
    lines.iter().map(line).collect()
}

/// A statement, broken before operators.
pub(super) fn statement(text: &str) -> String {
    let mut lines = String::new();
    let (mut rest, mut indent) = (text, "    ");
    while indent.len() + rest.len() > WIDTH {
        let Some(end) = last_break(rest, WIDTH - indent.len()) else { break };
        lines += &format!("{indent}{}\n", &rest[..end]);
        (rest, indent) = (&rest[end + 1..], "        ");
    }
    lines + indent + rest + "\n"
}

/// The last space up to a width at which a line may end; before a sum if there is one in the second half.
fn last_break(text: &str, width: usize) -> Option<usize> {
    let last = |signs: &[&str]| {
        let is_break = |&at: &usize| signs.iter().any(|sign| text[at + 1..].starts_with(sign));
        text[..width].match_indices(' ').map(|(at, _)| at).rfind(is_break)
    };
    last(&["+ ", "- "]).filter(|at| *at > width / 2).or_else(|| last(&["+ ", "- ", "* ", "/ "]))
}

/// A signature; long ones have a line for each argument.
pub(super) fn signature(start: &str, arguments: &[String]) -> String {
    let line = format!("{start}({})", arguments.join(", "));
    if line.len() <= WIDTH { line } else { format!("{start}(\n    {})", arguments.join(",\n    ")) }
}
