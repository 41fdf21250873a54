//! Tests of the outputs to read and to watch: code, derivation, animation, report.

use tempfile::TempDir;

use crate::common::qrm;

/// Runs `qrm ARGUMENTS --out` into a fresh folder, which must succeed.
fn into_folder(arguments: &[&str]) -> TempDir {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let output = qrm(arguments).arg("--out").arg(folder.path()).output().expect("the command starts");
    assert!(output.status.success(), "{arguments:?}: {}", String::from_utf8_lossy(&output.stderr));
    folder
}

/// The output of `qrm ARGUMENTS`.
fn printed(arguments: &[&str]) -> String {
    let output = qrm(arguments).output().expect("the command starts");
    assert!(output.status.success(), "{arguments:?}: {}", String::from_utf8_lossy(&output.stderr));
    String::from_utf8(output.stdout).expect("text")
}

/// The golden copy of the quick-return, without its checksum.
fn golden() -> &'static str {
    let text = include_str!("../qrm-model/golden/quick_return.rs");
    text.split_once("\n// Hash of this file, its tape").expect("a checksum").0
}

const DERIVATION: &str = include_str!("../qrm-model/golden/quick_return.md");

#[test]
fn code_is_printed_whole_or_in_parts() {
    assert_eq!(printed(&["code"]).trim_end(), golden().trim_end());
    let part = printed(&["code", "quick-return", "com_jacobian"]);
    assert!(part.starts_with("/// The transformation matrix of the TMT method") && part.ends_with("\n}\n"), "{part}");
    assert!(golden().contains(part.trim_end()), "a part of the whole");
    // Symbols of the literature lead to the same functions.
    for (symbol, function) in [("T", "com_jacobian"), ("C_q", "constraint_jacobian"), ("Mbar", "mass_matrix")] {
        assert_eq!(
            printed(&["code", "quick-return", symbol]),
            printed(&["code", "quick-return", function]),
            "{symbol}"
        );
    }
    let whole = printed(&["code", "quick-return", "QuickReturn"]);
    assert!(
        whole.contains("pub struct QuickReturn") && whole.contains("impl Generated<3, 2> for QuickReturn"),
        "{whole}"
    );
}

#[test]
fn code_is_printed_and_written_in_c() {
    let text = printed(&["code", "quick-return", "T", "--language", "c"]);
    assert!(text.starts_with("// The transformation matrix of the TMT method, `T = dx/dq`"), "{text}");
    assert!(text.contains("\n//     block.x, phi2       -O2A*sin(phi2)\n"), "{text}");
    assert!(text.contains("\n// Operations: 6 additions, 9 multiplications, 3 sine-cosine pairs.\n"), "{text}");
    assert!(text.contains("    com_jacobian[1][0] = -(p->O2A * sin_phi2);\n") && text.ends_with("\n}\n"), "{text}");
    let folder = into_folder(&["code", "quick-return", "--language", "c"]);
    let files = ["quick_return.h", "quick_return.c"];
    let texts = files.map(|file| std::fs::read_to_string(folder.path().join(file)).expect("a file"));
    assert!(texts[1].contains(text.trim_end()), "a part of the whole");
    let all = printed(&["code", "quick-return", "--language", "c"]);
    let listing = format!("// {}\n\n{}\n// {}\n\n{}", files[0], texts[0], files[1], texts[1]);
    assert_eq!(all, listing);
    let folder = into_folder(&["code", "quick-return"]);
    assert_eq!(std::fs::read_to_string(folder.path().join("quick_return.rs")).expect("a file"), golden());
}

#[test]
fn golden_copies_are_what_is_printed_of_their_tapes() {
    for entry in std::fs::read_dir("qrm-model/golden").expect("the golden copies") {
        let path = entry.expect("a file").path();
        if path.extension().is_some_and(|extension| extension == "rs") {
            let golden = std::fs::read_to_string(&path).expect("a golden copy");
            let (code, _) = golden.split_once("\n// Hash of this file, its tape").expect("a checksum");
            let scene = path.file_stem().expect("a name").to_string_lossy().replace('_', "-");
            assert_eq!(printed(&["code", &scene]).trim_end(), code.trim_end(), "{scene}");
        }
    }
}

#[test]
fn files_of_code_appear_together() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    std::fs::create_dir(folder.path().join("quick_return.c")).expect("a folder in the way");
    let output =
        qrm(&["code", "quick-return", "--language", "c", "--out"]).arg(folder.path()).output().expect("it starts");
    let error = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(output.status.code() == Some(2) && error.contains("quick_return.c: is a directory"), "{error}");
    assert_eq!(std::fs::read_dir(folder.path()).expect("a folder").count(), 1);
}

#[test]
fn unknown_languages_are_errors() {
    let output = qrm(&["code", "quick-return", "--language", "python"]).output().expect("the command starts");
    let error = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(2));
    let known = "error: invalid value 'python' for '--language <LANGUAGE>'\n  [possible values: rust, c";
    assert!(error.starts_with(known), "{error}");
    for name in ["QuickReturn", "rk4_step", "initial_state"] {
        let output = qrm(&["code", "quick-return", name, "--language", "c"]).output().expect("it starts");
        let error = String::from_utf8_lossy(&output.stderr).into_owned();
        let wanted = format!(
            "error: `{name}` of scene `quick-return` is not printed alone in C\n  \
             = help: `qrm code quick-return --language c` prints all of it\n"
        );
        assert_eq!((output.status.code(), error), (Some(2), wanted));
    }
}

#[test]
fn code_has_colours_on_a_terminal_only() {
    let plain = printed(&["code", "quick-return", "mass_matrix"]);
    assert!(!plain.contains('\u{1b}'));
    let coloured =
        qrm(&["code", "quick-return", "mass_matrix"]).env("CLICOLOR_FORCE", "1").output().expect("it starts");
    let coloured = String::from_utf8(coloured.stdout).expect("text");
    assert!(coloured.contains("\u{1b}[35mlet\u{1b}[0m"), "{coloured}");
    let mut bare = coloured;
    while let Some(start) = bare.find('\u{1b}') {
        let end = start + bare[start..].find('m').expect("the end of a colour");
        bare.replace_range(start..=end, "");
    }
    assert_eq!(bare, plain);
}

#[test]
fn unknown_parts_are_errors() {
    let output = qrm(&["code", "quick-return", "com_jacobien"]).output().expect("the command starts");
    let error = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(2));
    assert!(error.contains("has no part `com_jacobien`") && error.contains("did you mean `com_jacobian`?"), "{error}");
    // The end of a function's name is not a function.
    for language in ["rust", "c", "cuda", "matlab"] {
        let output = qrm(&["code", "quick-return", "jacobian", "--language", language]).output().expect("it starts");
        let error = String::from_utf8_lossy(&output.stderr).into_owned();
        assert!(error.contains("has no part `jacobian`"), "{language}: {error}");
    }
}

#[test]
fn the_derivation_is_written() {
    let folder = into_folder(&["derive", "quick-return"]);
    let written = std::fs::read_to_string(folder.path().join("derivation.md")).expect("a derivation");
    assert_eq!(written, DERIVATION);
    // Entries that can be worked out by hand.
    for formula in [
        r"{\bar{\mathbf{M}}}_{1,1} = J_{2} + \mathit{O_{2}A}^{2}\,m_{3}",
        r"\frac{\partial^{2} C_{\mathrm{guide}}}{\partial \varphi_{5}^{2}} = -\mathit{BC}\,\sin \varphi_{5}",
        r"r = \sqrt{2\,\mathit{O_{2}A}\,\mathit{O_{4}O_{2}}\,\sin \varphi_{2} + \mathit{O_{2}A}^{2} + \mathit{O_{4}O_{2}}^{2}}",
        r"\frac{\partial^{2} C_{\mathrm{slot}}}{\partial \varphi_{4}^{2}} = r\,\cos \varphi_{4}",
    ] {
        assert!(written.contains(formula), "{formula}");
    }
}

#[test]
fn an_animation_is_one_page_and_a_picture() {
    for scene in ["quick-return", "quick-return-loaded"] {
        let folder = into_folder(&["animate", scene]);
        let page = std::fs::read_to_string(folder.path().join("animation.html")).expect("a page");
        assert!(page.len() < 2_000_000, "{} bytes", page.len());
        stands_alone(&page);
        for name in ["crank", "rocker", "rod", "block", "ram", "N3", "N6", "cutting", "phi4_dot"] {
            assert!(page.contains(&format!("\"name\":\"{name}\"")), "{name}");
        }
        let gif = std::fs::read(folder.path().join("animation.gif")).expect("a picture");
        assert!(gif.starts_with(b"GIF89a") && gif.len() < 2_000_000, "{} bytes", gif.len());
    }
    let folder = into_folder(&["animate", "--no-gif"]);
    assert!(!folder.path().join("animation.gif").exists());
}

#[test]
#[ignore = "full tier: compiled"]
fn a_report_holds_everything_on_one_page() {
    let folder = into_folder(&["report", "quick-return", "--set", "w0=9"]);
    let page = std::fs::read_to_string(folder.path().join("report.html")).expect("a page");
    assert!(page.len() < 2_000_000, "{} bytes", page.len());
    stands_alone(&page);
    for part in [
        "<h2>Run</h2>",
        "<h2>Motion</h2>",
        "<h2>Figures</h2>",
        "<h2>Mechanism</h2>",
        "<h2>Error against run time</h2>",
        "<h2>Derivation</h2>",
    ] {
        assert!(page.contains(part), "{part}");
    }
    assert_eq!(page.matches("<svg xmlns").count(), 8, "figures, and the diagram of accuracy");
    // Every formula of the derivation could be set.
    assert!(page.matches("<math").count() > 60 && !page.contains("<merror") && !page.contains("<code>\\"), "formulae");
}

/// Asserts that a page loads nothing.
fn stands_alone(page: &str) {
    let outside = page.replace("http://www.w3.org/", "");
    assert!(
        !outside.contains("http:") && !outside.contains("https:") && !outside.contains("src="),
        "needs the network"
    );
}
