//! Rates of a tape's values compared with differences along a motion.

use qrm_core::Operation::{self, *};
use qrm_core::named_tape::{Argument, Function, ResultField, Shape};
use qrm_core::{NamedTape, TapeEvaluator};

/// A value of a tape at a time during a motion of two coordinates with constant accelerations.
fn value_at(time: f64, mut tape: NamedTape, value: u32) -> f64 {
    tape.functions.push(Function {
        name: "event".to_owned(),
        arguments: Argument::STATE.to_vec(),
        parts: vec![ResultField { name: String::new(), doc: String::new(), values: Shape::Scalar(value) }],
        ..Default::default()
    });
    let (q, qd, qdd) = ([0.7, 0.4], [-1.1, 0.6], [2.0, -3.0]);
    let moved = [0, 1].map(|i| q[i] + qd[i] * time + 0.5 * qdd[i] * time * time);
    let rates = [0, 1].map(|i| qd[i] + qdd[i] * time);
    let value = TapeEvaluator::new(&tape.placed()).event(0.3 + time, &moved, &rates, &qdd, &[]);
    value.expect("the tape has an event")
}

/// The derivative with respect to time at time zero, by central differences of order 4.
fn derivative(tape: &NamedTape, value: u32) -> f64 {
    let h = 1e-3;
    let difference = |times: f64| {
        let [after, before] = [h * times, -h * times].map(|time| value_at(time, tape.clone(), value));
        (after - before) / (2.0 * h * times)
    };
    (4.0 * difference(1.0) - difference(2.0)) / 3.0
}

#[test]
fn rates_of_all_operations_are_derivatives_along_the_motion() {
    let tape = NamedTape::new(0, 2, 0);
    let [t, q, qd] = [Argument::Time, Argument::Coordinates, Argument::Rates].map(|argument| tape.input(argument));
    let (a, b, c) = (q, q + 1, qd + 1);
    let operations: [Operation; 34] = [
        Number(2.0),
        Pi,
        Neg(a),
        Add(a, qd),
        Sub(t, b),
        Mul(a, qd),
        Div(a, c),
        Recip(a),
        Sqrt(a),
        Sin(a),
        Cos(qd),
        SinCos(a),
        Tan(a),
        Asin(a),
        Acos(b),
        Atan(qd),
        Exp(a),
        Ln(a),
        Sinh(a),
        Cosh(a),
        Tanh(a),
        Abs(qd),
        Sign(qd),
        Floor(a),
        Min(a, b),
        Max(qd, b),
        Hypot(a, b),
        Atan2(qd, b),
        PowI(qd, 3),
        PowF(a, -1.5),
        Pow(a, b),
        Pow(a, t),
        MulAdd(a, c, t),
        NegMulAdd(a, qd, t),
    ];
    for operation in operations {
        let mut tape = tape.clone();
        let value = tape.operation(operation);
        let values = if matches!(operation, SinCos(_)) { vec![value, value + 1] } else { vec![value] };
        for inner in values {
            // The outer product needs both the value and its rate.
            let outer = tape.operation(Mul(inner, c));
            let rate = tape.rate(outer).expect("a rate");
            let (got, expected) = (value_at(0.0, tape.clone(), rate), derivative(&tape, outer));
            assert!((got - expected).abs() < 1e-9 * (1.0 + expected.abs()), "{operation:?}: {got} and {expected}");
        }
    }
}

#[test]
fn values_of_accelerations_have_no_rate() {
    let mut tape = NamedTape::new(0, 1, 1);
    for argument in [Argument::Accelerations, Argument::Multipliers] {
        let doubled = tape.operation(Add(tape.input(argument), tape.input(argument)));
        assert_eq!(tape.rate(doubled), None);
    }
}
