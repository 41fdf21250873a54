//! Entries of `[tables]`.

use std::sync::Arc;

use num_rational::BigRational;

use super::Identifier;
use super::reader::{self, Reader};
use crate::diagnostic::{Diagnostic, Span};
use crate::expression::to_f64;
use crate::function::Function;
use crate::spline::Spline;

/// The largest number of points of a table: each is a term of the generated code, and the time of an evaluation grows
/// with their number.
const MOST_POINTS: usize = 2000;

/// Reads a function given by points: lines between them, or a spline.
pub(super) fn lookup_table(r: &mut Reader, identifier: Identifier, value: reader::Value) -> Option<Arc<Spline>> {
    let what = format!("table `{}`", identifier.name);
    let meaning = match identifier.name.as_str() {
        name if Function::named(name).is_some() => Some("a function"),
        "t" => Some("time"),
        "pi" => Some("the number pi"),
        "s" | "s_dot" => Some("the length that a load acts along, or its rate"),
        _ => None,
    };
    if let Some(meaning) = meaning {
        let title = format!("`{}` already means {meaning}", identifier.name);
        let error = Diagnostic::error(title, identifier.span, "cannot be a table").help("choose another name");
        r.findings.push(error);
        return None;
    }
    let table = r.table(&what, value)?;
    table.string(r, "doc");
    let mut axis = |key: &str| -> Option<Vec<BigRational>> {
        let value = table.required(r, key)?;
        let items = r.array(value);
        if items.len() > MOST_POINTS {
            let title = format!("{what} has {} points, more than {MOST_POINTS}", items.len());
            let error = Diagnostic::error(title, value.span(), "too many");
            r.findings.push(error.help("leave out points, or join fewer of them by `spline = \"natural\"`"));
            return None;
        }
        items.into_iter().map(|item| r.number(item)).collect()
    };
    let (x, y) = (axis("x"), axis("y"));
    let spline = table.optional("spline").map(|v| (v.span(), r.text(v)));
    table.finish(r);
    // Avoids further errors in the formulae that use an unreadable table.
    let placeholder = || Spline::natural(&identifier.name, &[0.0, 1.0], &[0.0, 0.0]).map(Arc::new);
    let Some((x, y)) = x.zip(y) else { return placeholder() };
    let wrong = match x.windows(2).position(|pair| pair[0] >= pair[1]) {
        _ if x.len() != y.len() => {
            Some((format!("{} abscissae and {} ordinates", x.len(), y.len()), "give one `y` for each `x`"))
        }
        _ if x.len() < 2 => {
            Some(("a line needs two points or more".to_owned(), "give the points that lines are drawn through"))
        }
        Some(i) => Some((
            format!("abscissa {} does not lie above the one before", i + 2),
            "write the points from left to right",
        )),
        None => None,
    };
    if let Some((label, help)) = wrong {
        r.findings.push(Diagnostic::error(format!("{what} is no function"), value.span(), label).help(help));
        return placeholder();
    }
    let doubles = [&x, &y].map(|axis| axis.iter().map(to_f64).collect::<Vec<f64>>());
    spline_through(r, &identifier, spline, &doubles).or_else(placeholder)
}

/// The spline of a table: lines, or the kind that the table names.
fn spline_through(
    r: &mut Reader,
    identifier: &Identifier,
    kind: Option<(Span, Option<Identifier>)>,
    [x, y]: &[Vec<f64>; 2],
) -> Option<Arc<Spline>> {
    let name = &identifier.name;
    let natural = Spline::natural(name, x, y);
    let (span, kind) = match &kind {
        None => (&identifier.span, None),
        Some((span, kind)) => (span, Some(kind.as_ref()?.name.as_str())),
    };
    let linear = Spline::linear(name, x, y);
    let (wrong, label, help) = match kind {
        None if linear.is_some() => return linear.map(Arc::new),
        None => ("points that no lines join", "too close together, or too large", "doubles have 16 digits"),
        _ if natural.is_none() => {
            ("points that no spline passes through", "too close together, or too large", "doubles have 16 digits")
        }
        Some("natural") => return natural.map(Arc::new),
        Some("periodic") if x.len() < 4 => {
            ("too few points", "needs four or more", "the last point repeats the first one")
        }
        Some("periodic") if y.first() != y.last() => {
            ("a last point that is not the first one", "does not come back", "repeat the first `y` after a period")
        }
        Some("periodic") => return Spline::periodic(name, x, y).or(natural).map(Arc::new),
        _ => ("an unknown kind of spline", "not known", "write `spline = \"periodic\"` or `spline = \"natural\"`"),
    };
    r.findings.push(Diagnostic::error(format!("table `{name}` has {wrong}"), span.clone(), label).help(help));
    // Avoids further errors in the formulae that use it.
    natural.map(Arc::new)
}
