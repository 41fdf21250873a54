//! Comments.

/// Formats lines as a comment.
pub(super) fn comment<S: AsRef<str>>(lines: &[S]) -> String {
    let line = |line: &S| {
        let line = line.as_ref().trim_end();
        // A backslash, or its trigraph, would join the next line.
        let end = if line.ends_with('\\') || line.ends_with("??/") { "." } else { "" };
        format!("// {line}{end}").trim_end().to_owned() + "\n"
    };
    lines.iter().map(line).collect()
}
