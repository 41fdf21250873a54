//! Generated against hand-written: one evaluation of the equations, one solve of them, one whole run.

use std::hint::black_box;

use divan::Bencher;
use nalgebra::{SMatrix, SVector};
use qrm_mechanism::{Dynamics, Mechanism};
use qrm_model::hand_written::HandWritten;
use qrm_model::quick_return::{Parameters, QuickReturn};
use qrm_sim::simulate::{Request, simulate};
use qrm_sim::solve::{Care, accelerations};

const Q: [f64; 3] = [0.5, 1.15, 2.69];
const QD: [f64; 3] = [7.7, 2.8, 1.5];

/// The dense system of five equations by nalgebra's LU.
fn dense(d: &Dynamics<f64, 3, 2>) -> SVector<f64, 5> {
    let mut a = SMatrix::<f64, 5, 5>::zeros();
    let mut b = SVector::<f64, 5>::zeros();
    for i in 0..3 {
        b[i] = d.generalized_forces[i];
        for j in 0..3 {
            a[(i, j)] = d.mass_matrix[i][j];
        }
        for c in 0..2 {
            a[(i, 3 + c)] = d.constraint_jacobian[c][i];
            a[(3 + c, i)] = d.constraint_jacobian[c][i];
        }
    }
    b[3] = -d.constraint_bias[0];
    b[4] = -d.constraint_bias[1];
    a.lu().solve(&b).unwrap_or(b)
}

fn whole_run<X: Mechanism<3, 2>>(mechanism: &X) -> u64 {
    let request = Request { method: Default::default(), step: None, end: None, estimate_error: false };
    simulate(mechanism, &request, &mut ()).map_or(0, |outcome| outcome.counts.accepted)
}

#[divan::bench_group(name = "one evaluation of the equations")]
mod dynamics {
    use super::*;

    #[divan::bench]
    fn generated(b: Bencher) {
        let mechanism = QuickReturn::default();
        b.bench(|| black_box(&mechanism).dynamics(0.0, black_box(&Q), black_box(&QD)));
    }

    #[divan::bench]
    fn hand_written(b: Bencher) {
        let mechanism = HandWritten::new(Parameters::default());
        b.bench(|| black_box(&mechanism).dynamics(0.0, black_box(&Q), black_box(&QD)));
    }
}

#[divan::bench_group(name = "one solution for accelerations and multipliers")]
mod solve {
    use super::*;

    #[divan::bench]
    fn schur(b: Bencher) {
        let dynamics = QuickReturn::default().dynamics(0.0, &Q, &QD);
        b.bench(|| accelerations(black_box(&dynamics), &mut Care::default()));
    }

    #[divan::bench]
    fn nalgebra_dense_lu(b: Bencher) {
        let dynamics = QuickReturn::default().dynamics(0.0, &Q, &QD);
        b.bench(|| dense(black_box(&dynamics)));
    }
}

#[divan::bench_group(name = "two revolutions with outputs and checks of every row")]
mod run {
    use super::*;

    #[divan::bench]
    fn generated(b: Bencher) {
        let mechanism = QuickReturn::default();
        b.bench(|| whole_run(black_box(&mechanism)));
    }

    #[divan::bench]
    fn hand_written(b: Bencher) {
        let mechanism = HandWritten::new(Parameters::default());
        b.bench(|| whole_run(black_box(&mechanism)));
    }
}

fn main() {
    divan::main();
}
