//! Reports: a single page that can be mailed.

use crate::animation;
use crate::html::escaped;
use crate::markdown;
use crate::motion::Motion;

/// The content of a report page, section by section.
#[derive(Debug)]
pub struct Report<'a> {
    /// The title of the report.
    pub title: String,
    /// A sentence below it.
    pub doc: String,
    /// The sections of the report.
    pub sections: Vec<Section<'a>>,
}

/// A part of a report.
#[derive(Debug)]
pub struct Section<'a> {
    /// The heading of the section.
    pub heading: String,
    /// The contents of the section.
    pub contents: Vec<Content<'a>>,
}

/// An element of a section.
#[derive(Debug)]
pub enum Content<'a> {
    /// Topics with lines about each of them.
    Facts(Vec<(String, Vec<String>)>),
    /// A warning that the reader must not miss.
    Warning(String),
    /// A table; columns of numbers are right-aligned.
    Table {
        /// Headers of the columns.
        head: Vec<String>,
        /// Rows.
        rows: Vec<Vec<String>>,
    },
    /// A figure in SVG.
    Figure(String),
    /// An animation.
    Animation(&'a Motion),
    /// Markdown with formulae in LaTeX.
    Markdown(&'a str),
}

/// The whole page.
pub fn page(report: &Report) -> String {
    let sections: Vec<String> = report.sections.iter().enumerate().map(|(i, s)| section(i, s)).collect();
    let contents = report.sections.iter().enumerate();
    let contents: Vec<String> =
        contents.map(|(i, s)| format!("<li><a href=\"#s{i}\">{}</a></li>", escaped(&s.heading))).collect();
    format!(
        include_str!("report/page.html"),
        title = escaped(&report.title),
        doc = escaped(&report.doc),
        css = include_str!("report/report.css"),
        contents = contents.concat(),
        sections = sections.concat(),
    )
}

fn section(number: usize, section: &Section) -> String {
    let mut html = format!("<section id=\"s{number}\">\n<h2>{}</h2>\n", escaped(&section.heading));
    for content in &section.contents {
        html += &match content {
            Content::Facts(facts) => facts_list(facts),
            Content::Warning(text) => format!("<p class=\"warning\">{}</p>", escaped(text)),
            Content::Table { head, rows } => table(head, rows),
            Content::Figure(svg) => format!("<figure>{svg}</figure>"),
            Content::Animation(motion) => animation::fragment(motion),
            Content::Markdown(text) => format!("<div class=\"derivation\">{}</div>", markdown::html(text)),
        };
        html.push('\n');
    }
    html + "</section>\n"
}

fn facts_list(facts: &[(String, Vec<String>)]) -> String {
    let mut html = String::from("<dl>");
    for (topic, lines) in facts {
        let lines: Vec<String> = lines.iter().map(|line| escaped(line)).collect();
        html += &format!("<dt>{}</dt><dd>{}</dd>", escaped(topic), lines.join("<br>"));
    }
    html + "</dl>"
}

fn table(head: &[String], rows: &[Vec<String>]) -> String {
    let is_number =
        |place: usize| rows.iter().all(|row| row.get(place).is_some_and(|cell| cell.parse::<f64>().is_ok()));
    let row = |tag: &str, cells: &[String]| {
        let cells = cells.iter().enumerate().map(|(place, cell)| {
            let class = if is_number(place) { " class=\"number\"" } else { "" };
            format!("<{tag}{class}>{}</{tag}>", escaped(cell))
        });
        format!("<tr>{}</tr>", cells.collect::<String>())
    };
    let rows: Vec<String> = rows.iter().map(|cells| row("td", cells)).collect();
    format!("<div class=\"wide\"><table>{}{}</table></div>", row("th", head), rows.concat())
}
