//! A condition on a steady motion: `fluctuation(phi2_dot) = 0.02`.

use qrm_scene::names::suggestion;

use super::columns::{ColumnEntry, Columns};
use crate::error::Error;
use crate::options::number;

/// A number of a steady motion, and the value that it is to have.
pub(super) struct Condition {
    /// The condition as it was typed.
    pub(super) text: String,
    quantity: &'static Quantity,
    /// The rate or output.
    column: String,
    pub(super) target: f64,
}

/// A kind of numbers.
struct Quantity {
    name: &'static str,
    /// The unit, where it is not that of the column.
    unit: Option<&'static str>,
    /// The number and its error, where the column has one.
    value: fn(&ColumnEntry) -> Option<[f64; 2]>,
}

/// The numbers of rates and outputs.
const QUANTITIES: [Quantity; 5] = [
    Quantity { name: "mean", unit: None, value: |column| Some([column.mean, column.mean_error]) },
    Quantity { name: "min", unit: None, value: |column| Some([column.min, column.min_error?]) },
    Quantity { name: "max", unit: None, value: |column| Some([column.max, column.max_error?]) },
    Quantity {
        name: "fluctuation",
        unit: Some(""),
        value: |column| Some([column.fluctuation?, column.fluctuation_error?]),
    },
    Quantity { name: "work", unit: Some("J"), value: |column| Some([column.work?, column.work_error?]) },
];

impl Condition {
    /// Reads `QUANTITY(COLUMN) = VALUE`; `columns` are those of some motion.
    ///
    /// # Errors
    /// The text is no condition, or its names are unknown.
    pub(super) fn new(text: &str, columns: &Columns) -> Result<Self, Error> {
        let wrong = |why: String| Error::usage(format!("`--for {text}`: {why}"));
        let example = || "write it as `--for 'fluctuation(phi_dot) = 0.02'`".to_owned();
        let (left, right) = text.split_once('=').ok_or_else(|| wrong("there is no `=`".to_owned()).help(example()))?;
        let inner = left.trim().strip_suffix(')').and_then(|left| left.split_once('('));
        let (name, column) =
            inner.ok_or_else(|| wrong("left of `=` stands no `QUANTITY(NAME)`".to_owned()).help(example()))?;
        let (name, column) = (name.trim(), column.trim());
        let names = || QUANTITIES.iter().map(|quantity| quantity.name);
        let Some(quantity) = QUANTITIES.iter().find(|quantity| quantity.name == name) else {
            let help = suggestion(name, names(), || format!("quantities: {}", names().collect::<Vec<_>>().join(", ")));
            return Err(wrong(format!("there is no quantity `{name}`")).help(help));
        };
        let known = || columns.0.0.iter().map(|(name, _)| name.as_str());
        let Some((_, entry)) = columns.0.0.iter().find(|(other, _)| other == column) else {
            let help = suggestion(column, known(), || {
                format!("rates and outputs: {}", known().collect::<Vec<_>>().join(", "))
            });
            return Err(wrong(format!("there is no rate or output `{column}`")).help(help));
        };
        if (quantity.value)(entry).is_none() {
            let help = match name {
                "fluctuation" => "only rates of what turns have a coefficient of fluctuation",
                "work" => "only outputs in W have a work",
                _ => "choose another rate or output",
            };
            return Err(wrong(format!("`{column}` has no {name} that is known")).help(help));
        }
        let unit = quantity.unit.unwrap_or(&entry.unit);
        let target = number("--for", right.trim(), unit)?;
        Ok(Self { text: text.to_owned(), quantity, column: column.to_owned(), target })
    }

    /// The number and its error in a motion; `None` if they are not known.
    pub(super) fn value(&self, columns: &Columns) -> Option<[f64; 2]> {
        let (_, entry) = columns.0.0.iter().find(|(name, _)| *name == self.column)?;
        (self.quantity.value)(entry).filter(|[value, error]| value.is_finite() && error.is_finite())
    }

    /// The number in words.
    pub(super) fn name(&self) -> String {
        format!("{}({})", self.quantity.name, self.column)
    }
}
