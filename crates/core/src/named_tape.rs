//! The functions of a scene as a list of operations without duplicates, with names and the order in which they are
//! written. Printers write a tape; evaluators run it.

mod function;
mod order;
mod placed;
mod places;
mod rate;

use std::collections::{BTreeMap, HashMap, HashSet};
use std::mem::Discriminant;
use std::string::String;
use std::vec;
use std::vec::Vec;

use serde::{Deserialize, Serialize};

pub use function::{Argument, Function, Operations, ResultField, Shape, Statement};

use crate::digest::digest;
use crate::tape::Operation;

/// The functions of a scene with `n` coordinates and `m` constraints.
///
/// An index identifies a value. The inputs come first: parameters; time; positions, rates and accelerations of the
/// coordinates (`n` each); multipliers (`m`); sines and cosines of the coordinates (`n` each); residuals (`m`).
/// Operands stand before the operations that use them.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub struct NamedTape {
    parameters: usize,
    coordinates: usize,
    constraints: usize,
    values: Vec<Value>,
    #[serde(skip)]
    known: HashMap<Key, u32>,
    /// The functions, in the order in which they are written.
    pub functions: Vec<Function>,
    /// The names of inputs.
    pub names: BTreeMap<u32, String>,
    /// Whether constraints depend on time.
    pub is_driven: bool,
    /// Whether each coordinate, then each rate, is given at the start (`n` each).
    pub given: Vec<bool>,
    /// Whether a coordinate's sine or cosine occurs.
    pub has_angle: Vec<bool>,
    /// The coordinates along which `inverse_dynamics` gives forces and torques.
    pub actuated: Vec<usize>,
    /// The operations for accelerations and multipliers, without sines and cosines.
    pub solution: Operations,
    /// Notes on the functions: how many operations other forms take, and which functions are omitted.
    pub notes: Vec<String>,
}

/// A value of a tape.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub enum Value {
    /// A parameter or an argument.
    Input,
    /// The result of an operation.
    Operation(Operation),
    /// The cosine of the sine just before.
    Cosine,
}

type Key = (Discriminant<Operation>, [u64; 3]);

impl NamedTape {
    /// Creates a tape without functions.
    pub fn new(parameters: usize, coordinates: usize, constraints: usize) -> Self {
        let inputs = parameters + 1 + 5 * coordinates + 2 * constraints;
        let (values, has_angle) = (vec![Value::Input; inputs], vec![false; coordinates]);
        Self { parameters, coordinates, constraints, values, has_angle, ..Self::default() }
    }

    /// The numbers of parameters, coordinates and constraints.
    pub fn sizes(&self) -> [usize; 3] {
        [self.parameters, self.coordinates, self.constraints]
    }

    /// The values.
    pub fn values(&self) -> &[Value] {
        &self.values
    }

    /// The number of inputs.
    pub fn inputs(&self) -> usize {
        self.parameters + 1 + 5 * self.coordinates + 2 * self.constraints
    }

    /// The index of the first input that belongs to an argument.
    pub fn input(&self, argument: Argument) -> u32 {
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

    /// The index of a coordinate's sine, for functions that take angles; its cosine stands `n` places later.
    pub fn sine(&self, coordinate: usize) -> u32 {
        self.input(Argument::Angles) + place(coordinate)
    }

    /// A function by its name.
    pub fn function(&self, name: &str) -> Option<&Function> {
        self.functions.iter().find(|function| function.name == name)
    }

    /// Counts the operations of a function, without those of its arguments and of the constants.
    pub fn operations(&self, function: &Function) -> Operations {
        let of = |name: &str| self.function(name).into_iter().flat_map(Function::results);
        let is_of_position = function.arguments.contains(&Argument::Position);
        let given: HashSet<u32> = of("constants").chain(of("position").filter(|_| is_of_position)).collect();
        function.operations(self, |value| given.contains(&value))
    }

    /// Returns the result of an operation, which is added if it is new.
    pub fn operation(&mut self, operation: Operation) -> u32 {
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

    /// Finds the result of an operation, if the tape has it.
    pub fn find(&self, operation: Operation) -> Option<u32> {
        self.known.get(&key(operation)).copied()
    }

    /// A number.
    pub fn number(&mut self, number: f64) -> u32 {
        self.operation(Operation::Number(number))
    }

    /// Whether a value is the number zero.
    pub fn is_zero(&self, value: u32) -> bool {
        matches!(self.values[value as usize], Value::Operation(Operation::Number(number)) if number == 0.0)
    }

    /// Whether a value takes an operation, that is, it is neither an input nor a number.
    pub fn is_computed(&self, value: u32) -> bool {
        match self.values[value as usize] {
            Value::Input | Value::Operation(Operation::Number(_) | Operation::Pi) => false,
            Value::Operation(_) | Value::Cosine => true,
        }
    }

    /// All values that these roots depend on, and the roots, in their order.
    pub fn needed(&self, roots: impl Iterator<Item = u32>) -> Vec<u32> {
        let mut is_needed = vec![false; self.values.len()];
        let mut pending: Vec<u32> = roots.collect();
        while let Some(value) = pending.pop() {
            if std::mem::replace(&mut is_needed[value as usize], true) {
                continue;
            }
            match self.values[value as usize] {
                Value::Input => {}
                Value::Cosine => pending.push(value - 1),
                Value::Operation(operation) => operation.for_each_operand(|operand| pending.push(operand)),
            }
        }
        (0..place(is_needed.len())).filter(|&value| is_needed[value as usize]).collect()
    }

    /// Whether each value follows from parameters alone.
    pub fn are_constant(&self) -> Vec<bool> {
        let mut constant: Vec<bool> = Vec::with_capacity(self.values.len());
        for (i, entry) in self.values.iter().enumerate() {
            constant.push(match entry {
                Value::Input => i < self.parameters,
                Value::Cosine => constant[i - 1],
                Value::Operation(operation) => {
                    let mut all = true;
                    operation.for_each_operand(|operand| all &= constant[operand as usize]);
                    all
                }
            });
        }
        constant
    }

    /// Replaces a result of a function by a number.
    pub fn set_number(&mut self, function: &str, result: usize, number: f64) {
        let value = self.number(number);
        let function = self.functions.iter_mut().find(|own| own.name == function);
        let results =
            function.into_iter().flat_map(|own| own.parts.iter_mut().flat_map(|part| part.values.values_mut()));
        results.skip(result).take(1).for_each(|own| *own = value);
    }

    /// Encodes the tape as bytes, which end with their hash.
    ///
    /// # Panics
    /// Never: encoding needs nothing but memory.
    pub fn to_bytes(&self) -> Vec<u8> {
        let mut bytes = postcard::to_stdvec(self).unwrap_or_else(|e| unreachable!("memory takes all bytes: {e}"));
        let hash = digest(bytes.iter().copied());
        bytes.extend(hash.to_le_bytes());
        bytes
    }

    /// Decodes a tape; `None` if the bytes were truncated or changed.
    pub fn from_bytes(bytes: &[u8]) -> Option<Self> {
        let (bytes, hash) = bytes.split_last_chunk()?;
        (digest(bytes.iter().copied()) == u64::from_le_bytes(*hash)).then(|| postcard::from_bytes(bytes).ok())?
    }

    /// The negative of a value.
    pub fn negative(&mut self, value: u32) -> u32 {
        self.operation(match self.values[value as usize] {
            Value::Operation(Operation::Number(number)) => Operation::Number(-number),
            _ => Operation::Neg(value),
        })
    }
}

/// A length as an index.
///
/// # Panics
/// Never: no scene has 2^32 operations.
pub fn place(length: usize) -> u32 {
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
