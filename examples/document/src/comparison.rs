//! The errors of the script, quantity by quantity.

use std::fmt::Write;

use qrm_model::quick_return::QuickReturn;

use crate::exact::EnergyIntegral;
use crate::motion::{Row, command_rows};
use crate::script::script_rows;

/// The columns of a row, in the order of [`Row::values`].
pub const NAMES: [&str; 17] = [
    "phi2",
    "phi2_dot",
    "phi2_ddot",
    "phi4",
    "phi4_dot",
    "phi4_ddot",
    "phi5",
    "phi5_dot",
    "phi5_ddot",
    "lambda_slot",
    "lambda_guide",
    "x6",
    "x6_dot",
    "x6_ddot",
    "v_slide",
    "N3",
    "N6",
];

/// A line of the table: its name, unit and columns, and the reason for the error of the script.
struct Quantity(&'static str, &'static str, &'static [&'static str], &'static str);

const QUANTITIES: [Quantity; 10] = [
    Quantity("angles", "rad", &["phi2", "phi4", "phi5"], "that of the method, in the Euclidean metric"),
    Quantity("rates", "rad/s", &["phi2_dot", "phi4_dot", "phi5_dot"], "the same"),
    Quantity("accelerations", "rad/s^2", &["phi2_ddot", "phi4_ddot", "phi5_ddot"], "averages over the step"),
    Quantity("multipliers", "N", &["lambda_slot", "lambda_guide"], "averages over the step"),
    Quantity("x6", "m", &["x6"], "one step late"),
    Quantity("x6_dot", "m/s", &["x6_dot"], "difference of positions"),
    Quantity("x6_ddot", "m/s^2", &["x6_ddot"], "from averages, and one step late"),
    Quantity("v_slide", "m/s", &["v_slide"], "difference of distances"),
    Quantity("N3", "N", &["N3"], "from an averaged multiplier"),
    Quantity("N6", "N", &["N6"], "from an averaged multiplier"),
];

/// The rows of the script and of `qrm run`, and the exact ones at the same times.
pub struct Comparison {
    pub script: Vec<Row>,
    pub command: Vec<Row>,
    pub exact: Vec<Row>,
}

/// The largest values of a line of the table.
#[derive(Clone, Copy, Debug)]
pub struct Largest {
    pub value: f64,
    pub script_error: f64,
    pub command_error: f64,
}

impl Comparison {
    /// Integrates by both ways with one step.
    pub fn new(mechanism: &QuickReturn, step: f64) -> Result<Self, String> {
        let script = script_rows(mechanism, step)?;
        let command = command_rows(mechanism, step)?;
        let exact = EnergyIntegral::new(mechanism)?.rows(script.iter().map(|row| row.t))?;
        Ok(Self { script, command, exact })
    }

    /// The largest absolute values of some columns in any row after the first, and their largest errors.
    pub fn largest(&self, columns: &[&str]) -> Largest {
        let mut largest = Largest { value: 0.0, script_error: 0.0, command_error: 0.0 };
        for ((script, command), exact) in self.script.iter().zip(&self.command).zip(&self.exact).skip(1) {
            let (script, command, exact) = (script.values(), command.values(), exact.values());
            for (i, _) in NAMES.iter().enumerate().filter(|(_, name)| columns.contains(name)) {
                largest.value = largest.value.max(exact[i].abs());
                largest.script_error = largest.script_error.max((script[i] - exact[i]).abs());
                largest.command_error = largest.command_error.max((command[i] - exact[i]).abs());
            }
        }
        largest
    }

    /// The table that is printed.
    pub fn table(&self) -> String {
        let mut text = String::from(
            "quantity        largest    script   qrm run   unit      reason for the error of the script\n",
        );
        for Quantity(name, unit, columns, reason) in &QUANTITIES {
            let largest = self.largest(columns);
            let [value, script, command] = [(largest.value, 3), (largest.script_error, 2), (largest.command_error, 2)]
                .map(|(x, digits)| significant(x, digits));
            // Writing to a string does not fail.
            let _ = writeln!(text, "{name:13}{value:>10}{script:>10}{command:>10}   {unit:10}{reason}");
        }
        text
    }
}

/// A positive number with this many significant digits, those before the decimal point never rounded.
fn significant(x: f64, digits: usize) -> String {
    if x < 1e-3 {
        format!("{x:.*e}", digits - 1)
    } else {
        let before = x.log10().floor() as i32 + 1;
        format!("{x:.*}", (digits as i32 - before).max(0) as usize)
    }
}
