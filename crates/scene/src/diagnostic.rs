//! Diagnostics of scenes: the error, its location and a remedy, printed in the format of rustc's messages.

use std::collections::HashSet;
use std::fmt;
use std::ops::Range;

use annotate_snippets::{AnnotationKind, Group, Level, Renderer, Snippet};

/// A range of bytes in the text of a scene.
pub type Span = Range<usize>;

/// One error or warning about a scene.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Diagnostic {
    /// Whether the scene is unusable or only suspicious.
    pub severity: Severity,
    /// The problem, in one sentence.
    pub title: String,
    /// The location; `None` if the diagnostic concerns the whole file.
    pub span: Option<Span>,
    /// A short text at the location.
    pub label: String,
    /// A second location that explains the first.
    pub context: Option<(Span, String)>,
    /// How to correct the error.
    pub help: Option<String>,
}

/// The severity of a [`Diagnostic`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Severity {
    /// The scene cannot be used.
    Error,
    /// The scene can be used, but part of it looks like a mistake.
    Warning,
}

impl Diagnostic {
    /// Creates an error at a location.
    pub fn error(title: impl Into<String>, span: Span, label: impl Into<String>) -> Self {
        Self {
            severity: Severity::Error,
            title: title.into(),
            span: Some(span),
            label: label.into(),
            context: None,
            help: None,
        }
    }

    /// Creates a warning at a location.
    pub fn warning(title: impl Into<String>, span: Span, label: impl Into<String>) -> Self {
        Self { severity: Severity::Warning, ..Self::error(title, span, label) }
    }

    /// Creates an error about the whole file.
    pub fn whole_file(title: impl Into<String>) -> Self {
        Self { span: None, ..Self::error(title, 0..0, "") }
    }

    /// Creates an error about a bare number of more than a turn that is taken as an angle.
    pub(crate) fn angle_without_unit(text: &str, span: Span) -> Self {
        let title = format!("an angle of {text} has no unit, and is more than a turn in radians");
        let help = format!("write `'{text}deg'`, or `'{text} rad'` if it is in radians");
        Self::error(title, span, "degrees or radians?").help(help)
    }

    /// Adds a remedy.
    #[must_use]
    pub fn help(mut self, help: impl Into<String>) -> Self {
        self.help = Some(help.into());
        self
    }

    /// Adds a second location that explains the first.
    #[must_use]
    pub fn context(mut self, span: Span, label: impl Into<String>) -> Self {
        self.context = Some((span, label.into()));
        self
    }
}

/// The largest number of findings in a report.
pub(crate) const MAX_SHOWN: usize = 20;

/// The diagnostics about one file, in the order of its lines.
#[derive(Clone, Debug)]
pub struct Report {
    /// The path of the file as the user typed it.
    pub path: String,
    /// The text of the file.
    pub source: String,
    /// The errors and warnings about the file.
    pub diagnostics: Vec<Diagnostic>,
}

impl Report {
    /// Collects findings about `source`, sorted by location. Duplicates are removed, and long lists truncated.
    pub fn new(path: impl Into<String>, source: impl Into<String>, mut diagnostics: Vec<Diagnostic>) -> Self {
        diagnostics.sort_by_key(|d| d.span.as_ref().map_or((0, 0), |s| (s.start, s.end)));
        let mut known = HashSet::new();
        diagnostics.retain(|d| known.insert((d.span.clone(), d.title.clone())));
        shorten(&mut diagnostics);
        Self { path: path.into(), source: source.into(), diagnostics }
    }

    /// Whether any finding makes the scene unusable.
    pub fn has_errors(&self) -> bool {
        errors(&self.diagnostics) > 0
    }

    /// Renders the report as text, with terminal colours if `colour` is true.
    pub fn render(&self, colour: bool) -> String {
        let renderer = if colour { Renderer::styled() } else { Renderer::plain() };
        let rendered: Vec<String> = self.diagnostics.iter().map(|d| renderer.render(&[self.group(d)])).collect();
        rendered.join("\n\n")
    }

    fn group<'a>(&'a self, diagnostic: &'a Diagnostic) -> Group<'a> {
        let level = match diagnostic.severity {
            Severity::Error => Level::ERROR,
            Severity::Warning => Level::WARNING,
        };
        let title = level.primary_title(diagnostic.title.as_str());
        let mut group = match &diagnostic.span {
            None => title.element(annotate_snippets::Origin::path(self.path.as_str())),
            Some(span) => {
                let primary = AnnotationKind::Primary.span(self.visible(span)).label(diagnostic.label.as_str());
                let mut snippet = Snippet::source(self.source.as_str()).path(self.path.as_str()).annotation(primary);
                if let Some((span, label)) = &diagnostic.context {
                    snippet =
                        snippet.annotation(AnnotationKind::Context.span(self.visible(span)).label(label.as_str()));
                }
                title.element(snippet)
            }
        };
        if let Some(help) = &diagnostic.help {
            group = group.element(Level::HELP.message(help.as_str()));
        }
        group
    }

    /// Restricts a span to the text and to character boundaries, and makes it wide enough to be visible.
    fn visible(&self, span: &Span) -> Span {
        let mut start = span.start.min(self.source.len());
        while !self.source.is_char_boundary(start) {
            start -= 1;
        }
        // Only line ends cannot be shown as a location without width.
        let is_wide = self.source[start..].starts_with(|c: char| !c.is_control());
        let mut end = span.end.max(start + usize::from(is_wide)).clamp(start, self.source.len());
        while !self.source.is_char_boundary(end) {
            end += 1;
        }
        start..end
    }
}

/// Counts the findings that make the scene unusable.
pub(crate) fn errors(findings: &[Diagnostic]) -> usize {
    findings.iter().filter(|finding| finding.severity == Severity::Error).count()
}

/// Truncates the findings, errors before warnings, and mentions how many were dropped.
fn shorten(diagnostics: &mut Vec<Diagnostic>) {
    if diagnostics.len() <= MAX_SHOWN {
        return;
    }
    let mut errors = errors(diagnostics).min(MAX_SHOWN);
    let mut warnings = MAX_SHOWN - errors;
    let severity = if errors > 0 { Severity::Error } else { Severity::Warning };
    diagnostics.retain(|d| {
        let left = if d.severity == Severity::Error { &mut errors } else { &mut warnings };
        let is_kept = *left > 0;
        *left = left.saturating_sub(1);
        is_kept
    });
    let more = Diagnostic::whole_file(format!("there is more: only {MAX_SHOWN} findings are shown"));
    diagnostics.push(Diagnostic { severity, ..more.help("mend those above first") });
}

impl fmt::Display for Report {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.render(false))
    }
}

impl std::error::Error for Report {}
