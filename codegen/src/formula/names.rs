//! Names as mathematical symbols.

use qrm_scene::function::Function;

const GREEK: [(&str, &str); 24] = [
    ("alpha", r"\alpha"),
    ("beta", r"\beta"),
    ("gamma", r"\gamma"),
    ("delta", r"\delta"),
    ("epsilon", r"\varepsilon"),
    ("zeta", r"\zeta"),
    ("eta", r"\eta"),
    ("theta", r"\theta"),
    ("kappa", r"\kappa"),
    ("lambda", r"\lambda"),
    ("mu", r"\mu"),
    ("nu", r"\nu"),
    ("xi", r"\xi"),
    ("rho", r"\rho"),
    ("sigma", r"\sigma"),
    ("tau", r"\tau"),
    ("phi", r"\varphi"),
    ("chi", r"\chi"),
    ("psi", r"\psi"),
    ("omega", r"\omega"),
    ("Theta", r"\Theta"),
    ("Phi", r"\Phi"),
    ("Omega", r"\Omega"),
    ("Delta", r"\Delta"),
];

/// Formats a name in LaTeX, with its letter under an accent such as `\dot`: `phi2` becomes `\varphi_{2}`, `m3` becomes
/// `m_{3}`, and names of several letters stay words, `\mathit{BC}`.
pub(super) fn latex_name(accent: &str, name: &str) -> String {
    let (head, tail) = name.split_once('_').unwrap_or((name, ""));
    let (letter, index) = symbol(head);
    let mut indices: Vec<String> = Vec::new();
    indices.extend(Some(index.to_owned()).filter(|index| !index.is_empty()));
    indices.extend(tail.split('_').filter(|part| !part.is_empty()).map(str::to_owned));
    let letter = if accent.is_empty() { letter } else { format!("{accent}{{{letter}}}") };
    if indices.is_empty() {
        return letter;
    }
    let is_word = |index: &String| index.len() > 1 && index.chars().all(|c| c.is_ascii_alphabetic());
    let index = |index: &String| if is_word(index) { format!(r"\mathrm{{{index}}}") } else { index.clone() };
    format!("{letter}_{{{}}}", indices.iter().map(index).collect::<Vec<_>>().join(","))
}

/// The letter of a name, and the rest as its index.
fn symbol(head: &str) -> (String, &str) {
    for (spelled, letter) in GREEK {
        if let Some(index) = head.strip_prefix(spelled)
            && !index.starts_with(|c: char| c.is_ascii_lowercase())
        {
            return (letter.to_owned(), index);
        }
    }
    let rest = head.get(1..).unwrap_or_default();
    let is_lower = head.starts_with(|c: char| c.is_ascii_lowercase());
    let is_index = rest.chars().all(|c| c.is_ascii_digit())
        || rest.starts_with(|c: char| c.is_ascii_digit()) && is_lower
        || rest.starts_with(|c: char| c.is_ascii_uppercase()) && is_lower;
    if is_index {
        return (head[..head.len() - rest.len()].to_owned(), rest);
    }
    // Digits inside a word are an index of the letter before them: the length from O4 to B.
    let mut word = String::new();
    let mut in_digits = false;
    for c in head.chars() {
        match (c.is_ascii_digit(), in_digits) {
            (true, false) => word += "_{",
            (false, true) => word.push('}'),
            _ => {}
        }
        in_digits = c.is_ascii_digit();
        word.push(c);
    }
    if in_digits {
        word.push('}');
    }
    (format!(r"\mathit{{{word}}}"), "")
}

/// The LaTeX command of a function.
pub(super) fn latex_function(function: Function) -> &'static str {
    match function {
        Function::Sin => r"\sin",
        Function::Cos => r"\cos",
        Function::Tan => r"\tan",
        Function::Asin => r"\arcsin",
        Function::Acos => r"\arccos",
        Function::Atan => r"\arctan",
        Function::Log => r"\ln",
        Function::Sinh => r"\sinh",
        Function::Cosh => r"\cosh",
        Function::Tanh => r"\tanh",
        Function::Exp => r"\exp",
        Function::Sqrt => r"\operatorname{sqrt}",
        Function::Hypot => r"\operatorname{hypot}",
        Function::Atan2 => r"\operatorname{atan2}",
        Function::Abs => r"\operatorname{abs}",
        Function::Sign => r"\operatorname{sign}",
        Function::Floor => r"\operatorname{floor}",
        Function::Min => r"\min",
        Function::Max => r"\max",
    }
}

#[cfg(test)]
mod tests {
    use super::latex_name;

    #[test]
    fn names_become_symbols() {
        for (name, latex) in [
            ("phi2", r"\varphi_{2}"),
            ("m3", "m_{3}"),
            ("yC", "y_{C}"),
            ("k", "k"),
            ("F6", "F_{6}"),
            ("x6_0", "x_{6,0}"),
            ("cd", r"\mathit{cd}"),
            ("BC", r"\mathit{BC}"),
            ("O4B", r"\mathit{O_{4}B}"),
            ("O4O2", r"\mathit{O_{4}O_{2}}"),
            ("omega_max", r"\omega_{\mathrm{max}}"),
            ("alphabet", r"\mathit{alphabet}"),
        ] {
            assert_eq!(latex_name("", name), latex, "{name}");
        }
        assert_eq!(latex_name(r"\dot", "phi2"), r"\dot{\varphi}_{2}");
    }
}
