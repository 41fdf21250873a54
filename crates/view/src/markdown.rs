//! Converts Markdown with formulae in LaTeX to HTML with formulae in MathML, which browsers display without scripts.

use pulldown_cmark::{CowStr, Event, HeadingLevel, Options, Parser, Tag, TagEnd, html};
use pulldown_latex::config::DisplayMode;
use pulldown_latex::{RenderConfig, Storage, push_mathml};

use crate::html::escaped;

/// Converts Markdown to HTML. Headings are one level lower, so that the result can be a section of a page.
pub(crate) fn html(markdown: &str) -> String {
    let events = Parser::new_ext(markdown, Options::ENABLE_TABLES | Options::ENABLE_MATH).map(|event| match event {
        Event::InlineMath(latex) => Event::InlineHtml(formula(&latex, DisplayMode::Inline).into()),
        Event::DisplayMath(latex) => Event::InlineHtml(formula(&latex, DisplayMode::Block).into()),
        Event::Start(Tag::Heading { level, .. }) => {
            Event::Start(Tag::Heading { level: lower(level), id: None, classes: Vec::new(), attrs: Vec::new() })
        }
        Event::End(TagEnd::Heading(level)) => Event::End(TagEnd::Heading(lower(level))),
        // HTML in the text of a scene is shown literally.
        Event::Html(text) | Event::InlineHtml(text) => Event::Text(CowStr::from(text.into_string())),
        other => other,
    });
    let mut text = String::new();
    html::push_html(&mut text, events);
    text.replace("<table>", "<div class=\"wide\"><table>").replace("</table>", "</table></div>")
}

fn lower(level: HeadingLevel) -> HeadingLevel {
    match level {
        HeadingLevel::H1 => HeadingLevel::H2,
        HeadingLevel::H2 => HeadingLevel::H3,
        _ => HeadingLevel::H4,
    }
}

const FUNCTIONS: [&str; 10] =
    [r"\sin", r"\cos", r"\tan", r"\arcsin", r"\arccos", r"\arctan", r"\ln", r"\sinh", r"\cosh", r"\tanh"];

/// Converts a formula to MathML; returns it unchanged if it cannot be parsed.
fn formula(latex: &str, display_mode: DisplayMode) -> String {
    // The converter places the power of a function above its name, unless the name is in a group.
    let beside = |latex: String, function: &&str| latex.replace(&format!("{function}^"), &format!("{{{function}}}^"));
    let plain = FUNCTIONS.iter().fold(latex.to_owned(), beside);
    let storage = Storage::new();
    let parser = pulldown_latex::Parser::new(&plain, &storage);
    let mut mathml = String::new();
    let config = RenderConfig { display_mode, ..RenderConfig::default() };
    let written = push_mathml(&mut mathml, parser, config);
    if written.is_err() || mathml.contains("<merror") {
        return format!("<code>{}</code>", escaped(latex));
    }
    match display_mode {
        DisplayMode::Block => format!("<span class=\"wide\">{mathml}</span>"),
        DisplayMode::Inline => mathml,
    }
}

#[cfg(test)]
mod tests {
    use super::html;

    #[test]
    fn formulae_become_mathml() {
        let page = html("# A\n\n$$x = \\frac{1}{2}$$\n\n| a |\n|---|\n| $m_{3}$ |\n\n<script>alert(1)</script>\n");
        assert!(page.contains("<h2>A</h2>") && page.contains("<mfrac>") && page.contains("<msub>"), "{page}");
        assert!(!page.contains("<script>"), "{page}");
        assert!(html(r"$$\sin^{2} x$$").contains("<msup>"), "{}", html(r"$$\sin^{2} x$$"));
        assert!(html(r"$$\unknown{x}$$").contains(r"<code>\unknown{x}</code>"), "{}", html(r"$$\unknown{x}$$"));
    }
}
