//! Bold letters for vectors and matrices, and text escaped for Markdown.

/// Sets vectors and matrices in bold type, to distinguish them from the scene's own symbols: `@q`, `@qd` for its rate,
/// `@qdd` for its acceleration, `@m` and `@f` for the reduced quantities, `@l` for the multipliers.
pub(super) fn set(text: &str) -> String {
    let letters = [
        ("@qdd", r"\ddot{\mathbf{q}}"),
        ("@qd", r"\dot{\mathbf{q}}"),
        ("@q", r"\mathbf{q}"),
        ("@xdd", r"\ddot{\mathbf{x}}"),
        ("@xd", r"\dot{\mathbf{x}}"),
        ("@x", r"\mathbf{x}"),
        ("@m", r"\bar{\mathbf{M}}"),
        ("@f", r"\bar{\mathbf{f}}"),
        ("@l", r"\boldsymbol{\lambda}"),
        ("@T", r"\mathbf{T}"),
        ("@M", r"\mathbf{M}"),
        ("@F", r"\mathbf{F}"),
        ("@Q", r"\mathbf{Q}"),
        ("@C", r"\mathbf{C}"),
    ];
    letters.iter().fold(text.to_owned(), |text, (short, latex)| text.replace(short, latex))
}

/// Escapes all characters of a scene's text that have a meaning in Markdown.
pub(super) fn plain(text: &str) -> String {
    let mut escaped = String::new();
    for character in text.chars() {
        if r"\`*_{}[]<>$|#".contains(character) {
            escaped.push('\\');
        }
        escaped.push(character);
    }
    escaped
}
