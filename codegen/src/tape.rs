//! The functions of a scene as operations, each distinct one present once, with the names and the order in which they
//! are written. Printers write a tape; evaluators run it.

mod evaluation;
mod function;
mod placed;
mod places;
mod switching;
mod text;

use std::collections::{HashMap, HashSet};
use std::mem::Discriminant;

use qrm_core::Operation;

pub(crate) use evaluation::{Evaluation, Number};
pub use function::{Argument, Function, Operations, Part, Shape, Statement};
pub use placed::placed;
pub use text::text;

/// The functions of a scene with `n` coordinates and `m` constraints.
///
/// A value is known by its place. The inputs come first: parameters; time; positions, rates and accelerations of the
/// coordinates (`n` each); multipliers (`m`); sines and cosines of the coordinates (`n` each); residuals (`m`). Operands
/// stand before what is made of them.
#[derive(Clone, Debug)]
pub struct Tape {
    parameters: usize,
    coordinates: usize,
    constraints: usize,
    values: Vec<Value>,
    known: HashMap<Key, u32>,
    /// The functions, in the order in which they are written.
    pub functions: Vec<Function>,
    /// The names of inputs.
    pub(crate) names: HashMap<u32, String>,
    /// Whether a coordinate's sine or cosine occurs.
    pub(crate) has_angle: Vec<bool>,
    /// The coordinates along which `inverse_dynamics` gives forces and torques.
    pub actuated: Vec<usize>,
    /// What accelerations and multipliers take from sines and cosines on.
    pub solution: Operations,
}

/// A value of a tape.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Value {
    /// A parameter or an argument.
    Input,
    /// The result of an operation.
    Operation(Operation),
    /// The cosine that belongs to the sine before.
    Cosine,
}

type Key = (Discriminant<Operation>, [u64; 3]);

impl Tape {
    /// The tape without functions.
    pub(crate) fn new(parameters: usize, coordinates: usize, constraints: usize) -> Self {
        let inputs = parameters + 1 + 5 * coordinates + 2 * constraints;
        let values = vec![Value::Input; inputs];
        let (known, functions, names) = (HashMap::new(), Vec::new(), HashMap::new());
        let has_angle = vec![false; coordinates];
        let (actuated, solution) = (Vec::new(), Operations::default());
        Self { parameters, coordinates, constraints, values, known, functions, names, has_angle, actuated, solution }
    }

    /// The numbers of parameters, coordinates and constraints.
    pub(crate) fn sizes(&self) -> [usize; 3] {
        [self.parameters, self.coordinates, self.constraints]
    }

    /// The values.
    pub(crate) fn values(&self) -> &[Value] {
        &self.values
    }

    /// The number of inputs.
    pub(crate) fn inputs(&self) -> usize {
        self.parameters + 1 + 5 * self.coordinates + 2 * self.constraints
    }

    /// The first of the inputs that an argument brings.
    pub(crate) fn input(&self, argument: Argument) -> u32 {
        let (n, m) = (self.coordinates, self.constraints);
        let q = self.parameters + 1;
        place(match argument {
            Argument::Time => self.parameters,
            Argument::Coordinates => q,
            Argument::Rates => q + n,
            Argument::Accelerations => q + 2 * n,
            Argument::Multipliers => q + 3 * n,
            Argument::Angles => q + 3 * n + m,
            Argument::Residuals => q + 5 * n + m,
            Argument::Position => unreachable!("its fields are no inputs"),
        })
    }

    /// The sine of a coordinate, for functions that are given it; the cosine stands `n` places behind.
    pub(crate) fn sine(&self, coordinate: usize) -> u32 {
        self.input(Argument::Angles) + place(coordinate)
    }

    /// A function by its name.
    pub fn function(&self, name: &str) -> Option<&Function> {
        self.functions.iter().find(|function| function.name == name)
    }

    /// The operations that a function takes beside those of its arguments and of the constants.
    pub fn operations(&self, function: &Function) -> Operations {
        let of = |name: &str| self.function(name).into_iter().flat_map(Function::results);
        let is_of_position = function.arguments.contains(&Argument::Position);
        let given: HashSet<u32> = of("constants").chain(of("position").filter(|_| is_of_position)).collect();
        function.operations(self, |value| given.contains(&value))
    }

    /// The result of an operation, which is added if it is new.
    pub(crate) fn operation(&mut self, operation: Operation) -> u32 {
        let key = key(operation);
        if let Some(&value) = self.known.get(&key) {
            return value;
        }
        let value = place(self.values.len());
        self.values.push(Value::Operation(operation));
        self.known.insert(key, value);
        if matches!(operation, Operation::SinCos(_)) {
            self.values.push(Value::Cosine);
        }
        value
    }

    /// The result of an operation, if the tape has it.
    pub(crate) fn find(&self, operation: Operation) -> Option<u32> {
        self.known.get(&key(operation)).copied()
    }

    /// A number.
    pub(crate) fn number(&mut self, number: f64) -> u32 {
        self.operation(Operation::Number(number))
    }

    /// Whether a value takes an operation: it is neither an input nor a number.
    pub(crate) fn is_computed(&self, value: u32) -> bool {
        match self.values[value as usize] {
            Value::Input | Value::Operation(Operation::Number(_) | Operation::Pi) => false,
            Value::Operation(_) | Value::Cosine => true,
        }
    }

    /// A value with the other sign.
    pub(crate) fn negative(&mut self, value: u32) -> u32 {
        self.operation(match self.values[value as usize] {
            Value::Operation(Operation::Number(number)) => Operation::Number(-number),
            _ => Operation::Neg(value),
        })
    }
}

/// A place in a list.
pub(crate) fn place(length: usize) -> u32 {
    u32::try_from(length).unwrap_or_else(|_| unreachable!("no scene has 2^32 operations"))
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
