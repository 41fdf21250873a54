//! Breaks long lines of code.

const WIDTH: usize = 110;

/// Breaks a statement before operators; continued lines end with `continuation`.
pub(super) fn statement(text: &str, continuation: &str) -> String {
    let mut lines = String::new();
    let (mut rest, mut indent) = (text, "    ");
    while indent.len() + rest.len() > WIDTH {
        let Some(end) = last_break(rest, WIDTH - indent.len() - continuation.len()) else { break };
        lines += &format!("{indent}{}{continuation}\n", &rest[..end]);
        (rest, indent) = (&rest[end + 1..], "        ");
    }
    lines + indent + rest + "\n"
}

/// The last space before `width` at which a line may be broken; preferably before a sum, if there is one in the second
/// half.
fn last_break(text: &str, width: usize) -> Option<usize> {
    let last = |signs: &[&str]| {
        let is_break = |&at: &usize| signs.iter().any(|sign| text[at + 1..].starts_with(sign));
        text[..width].match_indices(' ').map(|(at, _)| at).rfind(is_break)
    };
    last(&["+ ", "- "]).filter(|at| *at > width / 2).or_else(|| last(&["+ ", "- ", "* ", "/ "]))
}

/// Formats a signature; long ones have a line for each argument.
pub(super) fn signature(start: &str, arguments: &[String]) -> String {
    let line = format!("{start}({})", arguments.join(", "));
    if line.len() <= WIDTH { line } else { format!("{start}(\n    {})", arguments.join(",\n    ")) }
}

/// The first paragraph of a documentation text.
pub(super) fn summary(doc: &[String]) -> &[String] {
    let end = doc.iter().position(String::is_empty).unwrap_or(doc.len());
    &doc[..end]
}
