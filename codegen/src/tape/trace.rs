//! Numbers that note what is done with them.

use std::cell::RefCell;
use std::collections::HashMap;
use std::mem::Discriminant;
use std::ops::{Add, Div, Mul, Neg, Sub};

use qrm_core::{Operation, Scalar};

use crate::interpret::Number;

/// What was done with numbers so far.
#[derive(Clone, Debug, Default)]
pub(super) struct Trace {
    /// Operands are places in this list. Inputs come first.
    pub(super) entries: Vec<Entry>,
    /// The place of each operation.
    known: HashMap<Key, u32>,
    /// What the values of the parameters follow from. Parameters are the first inputs.
    pub(super) parameters: Vec<Traced>,
}

/// A value.
#[derive(Clone, Copy, Debug)]
pub(super) enum Entry {
    /// A parameter or an argument.
    Input,
    /// The result of an operation.
    Operation(Operation),
    /// The cosine that belongs to the sine before.
    Cosine,
}

type Key = (Discriminant<Operation>, [u64; 3]);

thread_local! {
    static TRACE: RefCell<Trace> = RefCell::default();
}

/// A number by its place in the trace.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Traced(pub(super) u32);

/// Begins a trace.
pub(super) fn begin() {
    TRACE.take();
}

/// The number of values so far.
pub(super) fn len() -> usize {
    TRACE.with_borrow(|trace| trace.entries.len())
}

/// The whole trace.
pub(super) fn end() -> Trace {
    TRACE.take()
}

impl Trace {
    fn push(&mut self, entry: Entry) -> u32 {
        let place = super::places::place(self.entries.len());
        self.entries.push(entry);
        place
    }

    fn operation(&mut self, operation: Operation) -> u32 {
        let key = key(operation);
        if let Some(&place) = self.known.get(&key) {
            return place;
        }
        let place = self.push(Entry::Operation(operation));
        self.known.insert(key, place);
        if matches!(operation, Operation::SinCos(_)) {
            self.push(Entry::Cosine);
        }
        place
    }
}

fn key(operation: Operation) -> Key {
    let mut numbers = [0; 3];
    let mut next = 0;
    operation.for_each_operand(|operand| {
        numbers[next] = u64::from(operand);
        next += 1;
    });
    match operation {
        Operation::Number(number) | Operation::PowF(_, number) => numbers[2] = number.to_bits(),
        Operation::PowI(_, exponent) => numbers[2] = u64::from(exponent.unsigned_abs()) << 1 | u64::from(exponent < 0),
        _ => {}
    }
    (std::mem::discriminant(&operation), numbers)
}

fn operation(operation: Operation) -> Traced {
    Traced(TRACE.with_borrow_mut(|trace| trace.operation(operation)))
}

impl Traced {
    /// The next inputs.
    pub(super) fn inputs(count: usize) -> Vec<Self> {
        TRACE.with_borrow_mut(|trace| (0..count).map(|_| Self(trace.push(Entry::Input))).collect())
    }

    /// A number that is known.
    pub(super) fn number(value: f64) -> Self {
        operation(Operation::Number(value))
    }

    /// The number, if it is known.
    fn known(self) -> Option<f64> {
        TRACE.with_borrow(|trace| match trace.entries[self.0 as usize] {
            Entry::Operation(Operation::Number(number)) => Some(number),
            _ => None,
        })
    }
}

impl Number for Traced {
    fn literal(digits: &str) -> Option<Self> {
        digits.parse().ok().map(Self::number)
    }

    fn parameter(self) -> Self {
        TRACE.with_borrow_mut(|trace| {
            trace.parameters.push(self);
            // Parameters are the first inputs.
            Self(super::places::place(trace.parameters.len() - 1))
        })
    }
}

macro_rules! operators {
    ($($operator:ident $name:ident),*) => {
        $(impl $operator for Traced {
            type Output = Self;
            fn $name(self, other: Self) -> Self {
                operation(Operation::$operator(self.0, other.0))
            }
        })*
    };
}

operators!(Add add, Sub sub, Mul mul, Div div);

impl Neg for Traced {
    type Output = Self;
    fn neg(self) -> Self {
        match self.known() {
            Some(number) => Self::number(-number),
            None => operation(Operation::Neg(self.0)),
        }
    }
}

macro_rules! unary {
    ($($name:ident $operation:ident),*) => {
        $(fn $name(self) -> Self { operation(Operation::$operation(self.0)) })*
    };
}

macro_rules! binary {
    ($($name:ident $operation:ident),*) => {
        $(fn $name(self, other: Self) -> Self { operation(Operation::$operation(self.0, other.0)) })*
    };
}

impl Scalar for Traced {
    fn from_f64(value: f64) -> Self {
        Self::number(value)
    }
    fn to_f64(self) -> f64 {
        self.known().unwrap_or_else(|| unreachable!("only exponents and sizes are asked for, and they are literals"))
    }
    fn pi() -> Self {
        operation(Operation::Pi)
    }
    unary!(
        recip Recip, sqrt Sqrt, sin Sin, cos Cos, tan Tan, asin Asin, acos Acos, atan Atan, exp Exp, ln Ln, sinh Sinh,
        cosh Cosh, tanh Tanh, sign Sign, abs Abs, floor Floor
    );
    binary!(max Max, min Min, atan2 Atan2, hypot Hypot, pow Pow);
    fn sin_cos(self) -> (Self, Self) {
        let sine = operation(Operation::SinCos(self.0));
        (sine, Self(sine.0 + 1))
    }
    fn powf(self, exponent: f64) -> Self {
        operation(Operation::PowF(self.0, exponent))
    }
    fn powi(self, exponent: i32) -> Self {
        operation(Operation::PowI(self.0, exponent))
    }
    fn mul_add(self, a: Self, b: Self) -> Self {
        operation(Operation::MulAdd(self.0, a.0, b.0))
    }
    fn neg_mul_add(self, a: Self, b: Self) -> Self {
        operation(Operation::NegMulAdd(self.0, a.0, b.0))
    }
    fn is_negative(self) -> bool {
        no_branches()
    }
    fn is_within(self, _: f64) -> bool {
        no_branches()
    }
    fn choose(self, _: f64, _: Self, _: Self) -> Self {
        no_branches()
    }
    fn quarter_turns(self, _: Self, _: Self) -> (Self, Self) {
        no_branches()
    }
    fn sin_cos_far(self) -> (Self, Self) {
        self.sin_cos()
    }
    fn sin_cos_apart(self) -> (Self, Self) {
        self.sin_cos()
    }
}

fn no_branches() -> ! {
    unreachable!("generated functions have no branches")
}
