//! The variables of a sparse elimination: coordinates, then named quantities.

use super::super::algebra::Value;
use super::super::block::Block;
use super::super::builder::Builder;
use crate::graph::Signed;
use crate::term::{NamedVariable, Symbol};

/// The coordinates and named quantities of a scene.
pub(super) struct Variables {
    coordinates: usize,
    names: Vec<String>,
    /// The derivatives of each named quantity with respect to the variables in its formula.
    pub(super) definitions: Vec<Vec<(usize, Value)>>,
    /// One over each root.
    inverses: Vec<Value>,
    /// The rates of all variables.
    pub(super) rates: Vec<Value>,
    /// The second rates of all variables at zero accelerations of the coordinates.
    pub(super) biases: Vec<Value>,
    /// The parts of `biases` that are not proportional to those of other variables.
    own_biases: Vec<Value>,
}

impl Variables {
    /// Computes the named quantities and their derivatives.
    pub(super) fn new(builder: &mut Builder, named: &[NamedVariable]) -> Self {
        let coordinates: Vec<String> = builder.scene.coordinates.iter().map(|c| c.name.clone()).collect();
        let mut variables = Self {
            coordinates: coordinates.len(),
            names: coordinates,
            definitions: Vec::new(),
            inverses: Vec::new(),
            rates: Vec::new(),
            biases: Vec::new(),
            own_biases: Vec::new(),
        };
        for (k, NamedVariable { name, is_root, function, .. }) in named.iter().enumerate() {
            variables.names.push(name.clone());
            let (block, inverse) = match is_root {
                true => (Block::Roots, builder.named_root(k, name, &function.value)),
                false => {
                    let value = builder.value(&function.value);
                    let kept = builder.keep(Block::Names, name, value);
                    builder.bind(Symbol::Named(k), kept);
                    builder.keep_angle(name, value, kept);
                    (Block::Names, Some(builder.lowering.graph.number(1.0)))
                }
            };
            let definition = function.by.iter().map(|(symbol, by)| {
                let variable = variables.place(*symbol);
                let by = builder.value(by);
                let by = builder.multiply(by, inverse);
                (variable, builder.keep(block, &format!("{name}_{}", variables.names[variable]), by))
            });
            let definition = definition.collect();
            variables.definitions.push(definition);
            variables.inverses.push(inverse);
        }
        variables
    }

    /// The number of variables.
    pub(super) fn count(&self) -> usize {
        self.names.len()
    }

    /// The number of coordinates.
    pub(super) fn coordinates(&self) -> usize {
        self.coordinates
    }

    /// The name of a variable.
    pub(super) fn name(&self, variable: usize) -> &str {
        &self.names[variable]
    }

    /// The variable of a symbol.
    pub(super) fn place(&self, symbol: Symbol) -> usize {
        match symbol {
            Symbol::Coordinate(i) => i,
            Symbol::Named(k) => self.coordinates + k,
            other => unreachable!("{other:?} is no variable"),
        }
    }

    /// Computes rates and biases.
    pub(super) fn rates(&mut self, builder: &mut Builder, named: &[NamedVariable]) {
        for i in 0..self.coordinates {
            self.rates.push(Some(builder.lowering.graph.input(Symbol::Rate(i))));
            self.biases.push(None);
        }
        for (k, NamedVariable { name, is_root, function, .. }) in named.iter().enumerate() {
            let inverse = self.inverses[k];
            let block = if *is_root { Block::Rates } else { Block::NamedRates };
            let by_time = builder.value(&function.by_time);
            let by_time = builder.multiply(by_time, inverse);
            let moved = self.moved(builder, k, &self.rates);
            let rate = builder.sum(moved.into_iter().chain(by_time).collect());
            let rate = builder.keep(block, &format!("{name}_dot"), rate);
            builder.bind(Symbol::NamedRate(k), rate);
            self.rates.push(rate);
            let own = builder.value(&function.bias);
            let own = match is_root {
                true => {
                    let square = builder.multiply(rate, rate);
                    builder.difference(own, square)
                }
                false => own,
            };
            let own = builder.multiply(own, inverse);
            let moved = self.moved(builder, k, &self.biases);
            let bias = builder.sum(moved.into_iter().chain(own).collect());
            let bias = builder.keep(block, &format!("{name}_bias"), bias);
            builder.bind(Symbol::NamedBias(k), bias);
            self.biases.push(bias);
            self.own_biases.push(own);
        }
    }

    /// Computes the second rates of the named quantities from the accelerations of the coordinates, for outputs.
    pub(super) fn accelerations(&self, builder: &mut Builder, named: &[NamedVariable]) {
        let mut known: Vec<Value> =
            (0..self.coordinates).map(|i| Some(builder.lowering.graph.input(Symbol::Acceleration(i)))).collect();
        for (k, NamedVariable { name, is_root, .. }) in named.iter().enumerate() {
            let block = if *is_root { Block::Rates } else { Block::NamedRates };
            let moved = self.moved(builder, k, &known);
            let sum = builder.sum(moved.into_iter().chain(self.own_biases[k]).collect());
            let acceleration = builder.keep(block, &format!("{name}_ddot"), sum);
            builder.bind(Symbol::NamedAcceleration(k), acceleration);
            known.push(acceleration);
        }
    }

    /// The rates of all variables that are due to those of the coordinates, without the parts due to time.
    pub(super) fn velocities(&self, builder: &mut Builder) -> Vec<Value> {
        let mut velocities = self.rates[..self.coordinates].to_vec();
        for k in 0..self.definitions.len() {
            let moved = self.moved(builder, k, &velocities);
            velocities.push(builder.sum(moved));
        }
        velocities
    }

    /// The products of the derivatives of a named quantity with values of variables.
    fn moved(&self, builder: &mut Builder, named: usize, values: &[Value]) -> Vec<Signed> {
        self.definitions[named].iter().filter_map(|(z, by)| builder.multiply(*by, values[*z])).collect()
    }
}
