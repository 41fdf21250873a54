//! The columns of a trajectory: one table for files, pictures and simulation tools.

use qrm_core::{Description, Mechanism};

use crate::solve::{LoopConstraints, largest};
use crate::state::State;

/// The source of a number of a mechanism.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// Time.
    Time,
    /// A parameter.
    Parameter(usize),
    /// A coordinate.
    Coordinate(usize),
    /// The rate of a coordinate.
    Rate(usize),
    /// The acceleration of a coordinate.
    Acceleration(usize),
    /// The multiplier of a constraint.
    Multiplier(usize),
    /// An output.
    Output(usize),
    /// The largest residual of a constraint.
    Residual,
    /// The largest rate of a residual.
    ResidualRate,
    /// Kinetic energy and potential of the conservative loads.
    Energy,
}

impl Kind {
    /// Whether the number checks a row instead of describing the motion.
    pub fn is_check(self) -> bool {
        matches!(self, Self::Residual | Self::ResidualRate | Self::Energy)
    }
}

/// A named number with its unit, description and source.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Column<K = Kind> {
    /// The name of the column.
    pub name: String,
    /// The unit of the column.
    pub unit: String,
    /// The description of the column.
    pub doc: String,
    /// The source of the number.
    pub kind: K,
}

impl<K> Column<K> {
    /// Creates a column.
    pub fn new(name: impl Into<String>, unit: impl Into<String>, doc: impl Into<String>, kind: K) -> Self {
        Self { name: name.into(), unit: unit.into(), doc: doc.into(), kind }
    }
}

/// The columns of a trajectory: time, motion, multipliers, outputs, checks.
pub fn columns(description: &Description) -> Vec<Column> {
    let mut columns = vec![Column::new("t", "s", "time", Kind::Time)];
    for (i, c) in description.coordinates.iter().enumerate() {
        let doc = |what: &str| format!("{what} of {}", c.name);
        columns.extend([
            Column::new(c.name, c.unit, c.doc, Kind::Coordinate(i)),
            Column::new(format!("{}_dot", c.name), per_second(c.unit, 1), doc("rate"), Kind::Rate(i)),
            Column::new(format!("{}_ddot", c.name), per_second(c.unit, 2), doc("acceleration"), Kind::Acceleration(i)),
        ]);
    }
    for (i, c) in description.constraints.iter().enumerate() {
        let doc = format!("multiplier of constraint {}: {}", c.name, c.doc);
        let (unit, doc) = (if c.unit == "m" { "N" } else { "" }, doc.trim_end_matches([':', ' ']));
        columns.push(Column::new(format!("lambda_{}", c.name), unit, doc, Kind::Multiplier(i)));
    }
    let outputs = description.outputs.iter().enumerate();
    columns.extend(outputs.map(|(i, o)| Column::new(o.name, o.unit, o.doc, Kind::Output(i))));
    let energy = "kinetic energy and potential of the conservative loads";
    columns.extend([
        Column::new("residual_position", "m or rad", "largest residual of a constraint", Kind::Residual),
        Column::new("residual_velocity", "m/s or rad/s", "largest rate of a residual", Kind::ResidualRate),
        Column::new("energy", "J", energy, Kind::Energy),
    ]);
    columns
}

/// The numbers of a state in the order of [`columns`].
pub fn numbers(mechanism: &dyn Mechanism, at: &State) -> Vec<f64> {
    let State { t, q, qd, qdd, multipliers, .. } = at;
    let mut outputs = vec![f64::NAN; mechanism.description().outputs.len()];
    mechanism.outputs(*t, q, qd, qdd, multipliers, &mut outputs);
    let constraints = LoopConstraints::at(mechanism, *t, q);
    let [position, velocity] =
        [&constraints.residuals, &constraints.velocity_residual(qd)].map(|residuals| largest(residuals).1);
    let checks = [position, velocity, mechanism.energy(q, qd).iter().sum()];
    let mut numbers = Vec::new();
    write_row(*t, [q, qd, qdd], multipliers, &outputs, checks, &mut numbers);
    numbers
}

/// One of the numbers of a state, by its index in [`columns`].
pub(crate) fn number(mechanism: &dyn Mechanism, at: &State, column: usize) -> f64 {
    let State { t, q, qd, qdd, multipliers, .. } = at;
    let outputs_begin = 1 + 3 * q.len() + multipliers.len();
    match column {
        0 => *t,
        _ if column <= 3 * q.len() => [q, qd, qdd][(column - 1) % 3][(column - 1) / 3],
        _ if column < outputs_begin => multipliers[column - 1 - 3 * q.len()],
        _ if column - outputs_begin < mechanism.description().outputs.len() => {
            let mut outputs = vec![f64::NAN; mechanism.description().outputs.len()];
            mechanism.outputs(*t, q, qd, qdd, multipliers, &mut outputs);
            outputs[column - outputs_begin]
        }
        _ => numbers(mechanism, at).get(column).copied().unwrap_or(f64::NAN),
    }
}

/// Reads a state from its numbers in the order of [`columns`].
pub fn state(description: &Description, numbers: &[f64]) -> State {
    let (n, m) = (description.coordinates.len(), description.constraints.len());
    let mut state = State::zero(n, m);
    state.t = numbers[0];
    for (i, motion) in numbers[1..=3 * n].chunks_exact(3).enumerate() {
        [state.q[i], state.qd[i], state.qdd[i]] = [motion[0], motion[1], motion[2]];
    }
    state.multipliers.copy_from_slice(&numbers[1 + 3 * n..1 + 3 * n + m]);
    state
}

/// Writes the numbers of a row in the order of [`columns`]; `checks` are the last three.
pub(crate) fn write_row(
    t: f64,
    [q, qd, qdd]: [&[f64]; 3],
    multipliers: &[f64],
    outputs: &[f64],
    checks: [f64; 3],
    numbers: &mut Vec<f64>,
) {
    let (n, m) = (q.len(), multipliers.len());
    numbers.resize(4 + 3 * n + m + outputs.len(), 0.0);
    let (time, rest) = numbers.split_at_mut(1);
    let (motion, rest) = rest.split_at_mut(3 * n);
    let (forces, rest) = rest.split_at_mut(m);
    let (quantities, last) = rest.split_at_mut(outputs.len());
    time[0] = t;
    for (((numbers, q), qd), qdd) in motion.chunks_exact_mut(3).zip(q).zip(qd).zip(qdd) {
        numbers.copy_from_slice(&[*q, *qd, *qdd]);
    }
    forces.copy_from_slice(multipliers);
    quantities.copy_from_slice(outputs);
    last.copy_from_slice(&checks);
}

/// The unit of a rate, or of a rate of a higher order.
pub fn per_second(unit: &str, order: u32) -> String {
    let seconds = if order == 1 { "s".to_owned() } else { format!("s^{order}") };
    match unit {
        "" | "1" => format!("1/{seconds}"),
        unit if unit.contains('/') => format!("({unit})/{seconds}"),
        unit => format!("{unit}/{seconds}"),
    }
}

#[cfg(test)]
mod tests {
    use qrm_core::QuantityDescription;

    use super::*;

    const fn quantity(name: &'static str) -> QuantityDescription {
        QuantityDescription { name, unit: "m", doc: "" }
    }

    #[test]
    fn a_row_is_in_the_order_of_the_columns() {
        let description = Description {
            name: "two",
            doc: "",
            source: "",
            derivation: "",
            coordinates: const { &[quantity("a"), quantity("b")] },
            constraints: const { &[quantity("c"), quantity("d")] },
            outputs: const { &[quantity("e"), quantity("f")] },
            parameters: &[],
            left_out: &[],
            has_corners: false,
            friction: &[],
            until: "",
        };
        let mut numbers = Vec::new();
        let motion: [&[f64]; 3] = [&[1.0, 2.0], &[11.0, 12.0], &[21.0, 22.0]];
        write_row(0.5, motion, &[31.0, 32.0], &[41.0, 42.0], [51.0, 52.0, 53.0], &mut numbers);
        let expected = columns(&description).into_iter().map(|column| match column.kind {
            Kind::Time => 0.5,
            Kind::Parameter(_) => f64::NAN,
            Kind::Coordinate(i) => 1.0 + i as f64,
            Kind::Rate(i) => 11.0 + i as f64,
            Kind::Acceleration(i) => 21.0 + i as f64,
            Kind::Multiplier(i) => 31.0 + i as f64,
            Kind::Output(i) => 41.0 + i as f64,
            Kind::Residual => 51.0,
            Kind::ResidualRate => 52.0,
            Kind::Energy => 53.0,
        });
        assert_eq!(numbers, expected.collect::<Vec<f64>>());
    }
}
