//! Generated against hand-written: one evaluation of the equations, one solve of them, one whole run.

use std::hint::black_box;
use std::io;

use criterion::{Criterion, criterion_group, criterion_main};
use nalgebra::{SMatrix, SVector};
use qrm_mechanism::{Dynamics, Mechanism};
use qrm_model::hand_written::HandWritten;
use qrm_model::quick_return::{Parameters, QuickReturn};
use qrm_sim::simulate::{Observer, Request, Row, simulate};
use qrm_sim::solve::{Care, accelerations};

const Q: [f64; 3] = [0.5, 1.15, 2.69];
const QD: [f64; 3] = [7.7, 2.8, 1.5];

/// An observer that keeps nothing.
struct Nobody;

impl Observer for Nobody {
    fn row(&mut self, row: &Row) -> io::Result<()> {
        black_box(row.t);
        Ok(())
    }

    fn goes_on(&mut self, _t: f64, _end_time: f64) -> io::Result<bool> {
        Ok(true)
    }
}

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
    simulate(mechanism, &request, &mut Nobody).map_or(0, |outcome| outcome.steps)
}

fn step(c: &mut Criterion) {
    let generated = QuickReturn::new(Parameters::default());
    let by_hand = HandWritten::new(Parameters::default());
    let mut group = c.benchmark_group("dynamics");
    group.bench_function("generated", |b| b.iter(|| generated.dynamics(0.0, black_box(&Q), black_box(&QD))));
    group.bench_function("hand-written", |b| b.iter(|| by_hand.dynamics(0.0, black_box(&Q), black_box(&QD))));
    group.finish();

    let dynamics = generated.dynamics(0.0, &Q, &QD);
    let mut group = c.benchmark_group("solve");
    group.bench_function("Schur", |b| b.iter(|| accelerations(black_box(&dynamics), &mut Care::default())));
    group.bench_function("nalgebra LU 5x5", |b| b.iter(|| dense(black_box(&dynamics))));
    group.finish();

    let mut group = c.benchmark_group("two revolutions with rows");
    group.bench_function("generated", |b| b.iter(|| whole_run(black_box(&generated))));
    group.bench_function("hand-written", |b| b.iter(|| whole_run(black_box(&by_hand))));
    group.finish();
}

criterion_group!(benches, step);
criterion_main!(benches);
