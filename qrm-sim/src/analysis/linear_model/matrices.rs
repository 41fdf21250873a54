//! The matrices of a linear model.

use nalgebra::{Cholesky, DMatrix, DVector};
use qrm_core::{Scalar, TapeEvaluator};

use super::LinearOutput;
use crate::analysis::modes::{NoModes, ROUNDING, RestEquations, RestState, constants, seeded};
use crate::differentiated::{Differentiated, PARTS, derivative};

/// The derivatives of outputs by coordinates, rates, accelerations, multipliers and inputs, one row an output.
pub(super) struct OutputDerivatives {
    /// The values at the equilibrium.
    pub(super) values: Vec<f64>,
    by: [DMatrix<f64>; 4],
    by_inputs: DMatrix<f64>,
}

impl OutputDerivatives {
    /// # Errors
    /// A derivative is not finite.
    pub(super) fn new(
        equations: &mut RestEquations,
        at: &RestState,
        inputs: &[usize],
        outputs: &[LinearOutput],
    ) -> Result<Self, NoModes> {
        let [n, m] = equations.sizes();
        let count = equations.tape.outputs.results.len();
        let is_used = outputs.iter().any(|output| matches!(output, LinearOutput::Output(_)));
        let mut all = vec![Differentiated::<f64>::zero(); count];
        let zero = DVector::zeros(count);
        let mut columns = vec![zero.clone(); 3 * n + m];
        let mut of_inputs = vec![zero; inputs.len()];
        let rest = vec![0.0; n];
        let multipliers: Vec<f64> = at.multipliers.iter().copied().collect();
        if is_used {
            for from in (0..3 * n + m).step_by(PARTS) {
                let values = [&at.q, &rest, &rest, &multipliers];
                let places = [0, n, 2 * n, 3 * n];
                let arguments: [Vec<_>; 4] = std::array::from_fn(|k| seeded(values[k], places[k], from));
                outputs_at(equations.with_parameters(None), &arguments, &mut all);
                for (part, column) in columns[from..].iter_mut().take(PARTS).enumerate() {
                    column.iter_mut().zip(&all).for_each(|(entry, output)| *entry = derivative(output, part));
                }
            }
            let arguments = [&at.q, &rest, &rest, &multipliers].map(|values| constants(values));
            for (column, &input) in of_inputs.iter_mut().zip(inputs) {
                outputs_at(equations.with_parameters(Some(input)), &arguments, &mut all);
                column.iter_mut().zip(&all).for_each(|(entry, output)| *entry = derivative(output, 0));
            }
            equations.with_parameters(None);
        }
        let value = |output: &LinearOutput| match *output {
            LinearOutput::Coordinate(i) => at.q[i],
            LinearOutput::Rate(_) | LinearOutput::Acceleration(_) => 0.0,
            LinearOutput::Output(o) => all[o].to_f64(),
        };
        let entry = |output: &LinearOutput, block: usize, place: usize| match (*output, block) {
            (LinearOutput::Coordinate(i), 0) | (LinearOutput::Rate(i), 1) | (LinearOutput::Acceleration(i), 2) => {
                f64::from(u8::from(i == place))
            }
            (LinearOutput::Output(o), _) => columns[block * n + place][o],
            _ => 0.0,
        };
        let by = [(0, n), (1, n), (2, n), (3, m)].map(|(block, size)| {
            DMatrix::from_fn(outputs.len(), size, |row, place| entry(&outputs[row], block, place))
        });
        let by_inputs = DMatrix::from_fn(outputs.len(), inputs.len(), |row, input| match outputs[row] {
            LinearOutput::Output(o) => of_inputs[input][o],
            _ => 0.0,
        });
        for (row, output) in outputs.iter().enumerate() {
            let mut entries =
                by.iter().chain([&by_inputs]).flat_map(|matrix| matrix.row(row).iter().copied().collect::<Vec<_>>());
            if let LinearOutput::Output(output) = *output
                && !entries.all(f64::is_finite)
            {
                return Err(NoModes::OutputNotSmooth { output });
            }
        }
        Ok(Self { values: outputs.iter().map(value).collect(), by, by_inputs })
    }
}

type Evaluator<'m> = TapeEvaluator<'m, Vec<Differentiated<f64>>>;

fn outputs_at(
    evaluator: &mut Evaluator,
    [q, qd, qdd, multipliers]: &[Vec<Differentiated<f64>>; 4],
    results: &mut [Differentiated<f64>],
) {
    evaluator.outputs(Differentiated::zero(), q, qd, qdd, multipliers, results);
}

/// The parts of the linear equations: with them `N'Mbar N a'' = -(N'K N a + N'D N a' + N'r_u u)`, and
/// `lambda = -P (Mbar q'' + K q + D q' + r_u u)` for the changes.
pub(super) struct Matrices<'a> {
    at: &'a RestState,
    basis: DMatrix<f64>,
    /// The inverse of the reduced mass matrix.
    inverse_mass: DMatrix<f64>,
    /// `P`, which gives the multipliers that balance forces on the dependent coordinates.
    multipliers: DMatrix<f64>,
    /// `r_u`
    of_inputs: DMatrix<f64>,
    outputs: &'a OutputDerivatives,
}

impl<'a> Matrices<'a> {
    /// # Errors
    /// A motion has no inertia.
    pub(super) fn new(
        at: &'a RestState,
        of_inputs: DMatrix<f64>,
        outputs: &'a OutputDerivatives,
    ) -> Result<Self, NoModes> {
        let factors =
            Cholesky::new(at.null_space.reduced(&at.mass)).ok_or_else(|| NoModes::Massless { q: at.q.clone() })?;
        let (n, m) = (at.q.len(), at.multipliers.len());
        let mut multipliers = DMatrix::zeros(m, n);
        for (i, mut column) in multipliers.column_iter_mut().enumerate() {
            let mut unit = DVector::zeros(n);
            unit[i] = 1.0;
            column.copy_from(&at.null_space.multipliers(&unit));
        }
        let basis = at.null_space.basis.clone();
        Ok(Self { at, basis, inverse_mass: factors.inverse(), multipliers, of_inputs, outputs })
    }

    /// `A`, `B`, `C` and `D`.
    pub(super) fn state_space(&self) -> [DMatrix<f64>; 4] {
        let RestState { mass, stiffness, damping, .. } = self.at;
        let outputs = self.outputs.by.each_ref();
        self.assembled(-1.0, [mass, stiffness, damping], &self.outputs.by_inputs, outputs)
    }

    /// The rounding errors of these matrices.
    pub(super) fn rounding(&self) -> [DMatrix<f64>; 4] {
        let RestState { jacobian, .. } = self.at;
        let (mass, damping) = (self.at.mass.abs(), self.at.damping.abs());
        let inverse = self.inverse_mass.abs();
        let basis = self.basis.abs();
        let multipliers = self.multipliers.abs();
        // Errors of the motions follow from those of their constraints.
        let basis = &basis + multipliers.transpose() * (jacobian.abs() * &basis);
        let sizes = Self {
            at: self.at,
            inverse_mass: &inverse + &inverse * (basis.transpose() * &mass * &basis) * &inverse,
            basis,
            multipliers,
            of_inputs: self.of_inputs.abs(),
            outputs: self.outputs,
        };
        let outputs = self.outputs.by.each_ref().map(DMatrix::abs);
        let by_inputs = self.outputs.by_inputs.abs();
        let parts = [&mass, &self.at.stiffness_terms, &damping];
        sizes.assembled(1.0, parts, &by_inputs, outputs.each_ref()).map(|terms| terms * ROUNDING)
    }

    /// The matrices with this sign of the right sides.
    fn assembled(
        &self,
        sign: f64,
        [mass, stiffness, damping]: [&DMatrix<f64>; 3],
        by_inputs: &DMatrix<f64>,
        [by_q, by_qd, by_qdd, by_multipliers]: [&DMatrix<f64>; 4],
    ) -> [DMatrix<f64>; 4] {
        let Self { basis, inverse_mass, multipliers, of_inputs, .. } = self;
        let (n, f) = basis.shape();
        let inputs = of_inputs.ncols();
        // Changes of coordinates and rates for states and inputs.
        let mut q = DMatrix::zeros(n, 2 * f + inputs);
        let mut qd = q.clone();
        q.columns_mut(0, f).copy_from(basis);
        qd.columns_mut(f, f).copy_from(basis);
        let mut forces = stiffness * &q + damping * &qd;
        let mut own = forces.columns_mut(2 * f, inputs);
        own += of_inputs;
        let accelerations = inverse_mass * (basis.transpose() * &forces) * sign;
        let qdd = basis * &accelerations;
        let lambda = multipliers * (mass * &qdd + &forces) * sign;
        let mut outputs = by_q * &q + by_qd * &qd + by_qdd * &qdd + by_multipliers * lambda;
        let mut own = outputs.columns_mut(2 * f, inputs);
        own += by_inputs;
        let mut states = DMatrix::zeros(2 * f, 2 * f + inputs);
        for i in 0..f {
            // Exact in either case.
            states[(i, f + i)] = if sign < 0.0 { 1.0 } else { 0.0 };
        }
        states.rows_mut(f, f).copy_from(&accelerations);
        let split =
            |matrix: &DMatrix<f64>| [matrix.columns(0, 2 * f).into_owned(), matrix.columns(2 * f, inputs).into_owned()];
        let ([a, b], [c, d]) = (split(&states), split(&outputs));
        [a, b, c, d]
    }
}
