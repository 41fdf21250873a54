//! Each function of the quick-return mechanism: generated, by hand, and by dual numbers at run time.
//!
//! `cargo bench --bench functions`. Operations are counted while a function runs, by numbers that count; instructions
//! by valgrind, where it is installed.

mod counting;
mod measure;
#[allow(dead_code, unused_imports, reason = "another bench uses the rest")]
mod twin;

use std::cell::RefCell;
use std::hint::black_box as opaque;
use std::process::ExitCode;

use nalgebra::{SMatrix, SVector};
use num_dual::Dual64;
use qrm_core::{Angles, DoubleDouble, Dual, Dynamics, Equations, Kernel, Model, Scalar, TapeEvaluator};
use qrm_model::quick_return::{self, Parameters, QuickReturn};
use qrm_sim::solve::Solver;

use counting::{Counting, operations};
use twin::{ByDualNumbers, ByHand, KernelByHand, PlainFunctions};

/// The mechanism.
static MODEL: Model = Model::from_generated::<QuickReturn, 3, 2>();

const Q: [f64; 3] = [0.5, 1.15, 2.69];
const QD: [f64; 3] = [7.7, 2.8, 1.5];
const CALLS: u64 = 20_000;

/// A function, where it comes from, how to call it many times, and how to count its operations.
struct Row {
    function: &'static str,
    from: &'static str,
    run: Box<dyn Fn(u64)>,
    operations: Option<usize>,
}

/// A row of something that is called with nothing but what it holds.
fn row<T>(
    function: &'static str,
    from: &'static str,
    operations: Option<usize>,
    call: impl Fn() -> T + 'static,
) -> Row {
    let run = move |calls| {
        for _ in 0..calls {
            opaque(call());
        }
    };
    Row { function, from, run: Box::new(run), operations }
}

/// Position and accelerations by a kernel, from sines and cosines on.
fn by_kernel<K: Kernel<R, 3, 2>, R: Scalar>(kernel: &K, angles: &Angles<R, 3>) -> ([R; 3], [R; 2]) {
    let (q, qd) = (Q.map(R::from_f64), QD.map(R::from_f64));
    kernel.accelerations(&kernel.position(R::zero(), &q, angles), R::zero(), &q, &qd, angles)
}

/// The operations of that.
fn kernel_operations<K: Equations<Counting, 3, 2>>() -> Option<usize> {
    let values = values();
    let kernel = K::with_values(&|i| Counting(values[i]));
    let angles = Angles::new(&Q.map(Counting), [true; 3]);
    Some(operations(|| by_kernel(&kernel, &angles)))
}

/// The mechanism in numbers that count.
fn counting() -> QuickReturn<Counting> {
    let values = values();
    QuickReturn::with_values(&|i| Counting(values[i]))
}

fn values() -> Vec<f64> {
    MODEL.parameter_values(&|_| None)
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

/// A generated function of the state and its operations.
macro_rules! generated {
    ($rows:ident, $name:literal, $function:ident $(, $argument:ident)*) => {{
        let model = QuickReturn::default();
        let counting = counting();
        let count = operations(|| quick_return::$function(&counting $(, &$argument.map(Counting))*));
        $rows.push(row($name, "generated", Some(count), move || {
            quick_return::$function(opaque(&model) $(, &opaque($argument))*)
        }));
    }};
}

/// The dynamics by the tape, for any kind of number.
fn by_tape<R: Scalar + 'static>() -> impl Fn() -> R {
    let evaluator = RefCell::new((TapeEvaluator::new(quick_return::TAPE.tape()), [R::zero(); 20]));
    move || {
        let (evaluator, results) = &mut *evaluator.borrow_mut();
        evaluator.dynamics(R::zero(), &opaque(Q).map(R::from_f64), &opaque(QD).map(R::from_f64), results);
        results[0]
    }
}

fn rows() -> Vec<Row> {
    let parameters = Parameters::default();
    let (hand, dual) = (ByHand::new(parameters), ByDualNumbers::new(parameters));
    let (model, values) = (QuickReturn::default(), values());
    let mut rows = Vec::new();
    generated!(rows, "T", com_jacobian, Q);
    rows.push(row("T", "by hand", None, move || opaque(&hand).com_jacobian(&opaque(Q))));
    generated!(rows, "(T qd)_q qd", com_bias, Q, QD);
    rows.push(row("(T qd)_q qd", "by hand", None, move || opaque(&hand).com_bias(&opaque(Q), &opaque(QD))));
    generated!(rows, "C_q", constraint_jacobian, Q);
    rows.push(row("C_q", "by hand", None, move || opaque(&hand).constraint_jacobian(&opaque(Q))));
    generated!(rows, "(C_q qd)_q qd", constraint_bias, Q, QD);
    rows.push(row("(C_q qd)_q qd", "by hand", None, move || opaque(&hand).constraint_bias(&opaque(Q), &opaque(QD))));
    generated!(rows, "C and C_q", loop_constraints, Q);
    rows.push(row("C and C_q", "by hand", None, move || opaque(&hand).loop_constraints(&opaque(Q))));
    rows.push(row("C and C_q", "dual numbers", None, move || opaque(&dual).loop_constraints(&opaque(Q))));
    let all = "Mbar, fbar, C_q and its bias";
    let numbers = counting();
    let count = operations(|| quick_return::dynamics(&numbers, Counting(0.0), &Q.map(Counting), &QD.map(Counting)));
    rows.push(row(all, "generated", Some(count), move || {
        quick_return::dynamics(opaque(&model), 0.0, &opaque(Q), &opaque(QD))
    }));
    rows.push(row(all, "by hand", None, move || opaque(&hand).dynamics(&opaque(Q), &opaque(QD))));
    rows.push(row(all, "dual numbers", None, move || opaque(&dual).dynamics(&opaque(Q), &opaque(QD))));
    rows.push(row(all, "tape, f64", None, by_tape::<f64>()));
    rows.push(row(all, "tape, dual", None, by_tape::<Dual<Dual64>>()));
    rows.push(row(all, "tape, 32 digits", None, by_tape::<DoubleDouble>()));
    let solution = "these, then qdd and multipliers";
    let mechanism = MODEL.mechanism(&|_| None);
    let solver = RefCell::new((Solver::new(&*mechanism), [0.0; 3], [0.0; 2]));
    rows.push(row(solution, "Schur complement", None, move || {
        let (solver, qdd, multipliers) = &mut *solver.borrow_mut();
        let state = (&opaque(Q)[..], &opaque(QD)[..]);
        solver.robust_accelerations(&*mechanism, 0.0, state, (qdd, multipliers)).map(|()| qdd[0])
    }));
    rows.push(row(solution, "nalgebra's LU", None, move || {
        dense(&quick_return::dynamics(opaque(&model), 0.0, &opaque(Q), &opaque(QD)))
    }));
    let kernel = "position, qdd, multipliers at once";
    let by_hand = KernelByHand::with_values(&|i| values[i]);
    let angles = Angles::new(&Q, [true; 3]);
    let count = kernel_operations::<QuickReturn<Counting>>();
    rows.push(row(kernel, "generated", count, move || by_kernel(opaque(&model), &opaque(angles))));
    let count = kernel_operations::<KernelByHand<Counting>>();
    rows.push(row(kernel, "by hand", count, move || by_kernel(opaque(&by_hand), &opaque(angles))));
    rows
}

fn main() -> ExitCode {
    let rows = rows();
    if let Some((thing, calls)) = measure::counted() {
        (rows[thing].run)(calls);
        return ExitCode::SUCCESS;
    }
    let times = measure::in_turn(rows.len(), |i| measure::time(CALLS, &rows[i].run));
    println!("{:34} {:17} {:>22} {:>22} {:>10} {:>12}", "", "", "ns", "of the first", "operations", "instructions");
    let mut first = 0;
    for (i, (row, time)) in rows.iter().zip(&times).enumerate() {
        if row.function != rows[first].function {
            first = i;
        }
        let ratio = if i == first { String::new() } else { time.over(&times[first]).show(2) };
        let operations = row.operations.map_or_else(String::new, |count| count.to_string());
        let instructions = measure::instructions(i, 1000).map_or_else(String::new, |count| format!("{count:.0}"));
        let (function, from) = (row.function, row.from);
        println!("{function:34} {from:17} {:>22} {ratio:>22} {operations:>10} {instructions:>12}", time.show(1));
    }
    println!("medians of {} rounds in turn, with the smallest and the largest", measure::ROUNDS);
    ExitCode::SUCCESS
}
