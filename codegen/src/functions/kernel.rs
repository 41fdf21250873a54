//! The functions of the kernel: one computes all quantities of a position, the others use them.

mod emitter;
mod position;

use std::collections::{HashMap, HashSet};

use crate::graph::{Id, Signed};
use crate::kernel::{Block, Local};
pub(super) use emitter::Emitter;
use emitter::{KernelFunction, angle_of, define, vectors};
use position::Position;
use qrm_core::named_tape::{Argument, Function, Operations};

impl Emitter<'_> {
    /// Adds all functions to the tape.
    pub(super) fn add_functions(&self) {
        let kernel = self.kernel;
        let parts = [
            KernelFunction {
                name: "residuals",
                doc: "Residuals of the loop closures, `C(q)`.",
                arguments: &[Argument::Position],
                blocks: &[],
                results: vec![&kernel.residuals],
            },
            KernelFunction {
                name: "velocity_residual",
                doc: if self.writer.scene.is_driven() { "`C_q qd + C_t`." } else { "`C_q qd`." },
                arguments: &[Argument::Position, Argument::Rates],
                blocks: &[Block::Rates, Block::NamedRates],
                results: vec![&kernel.velocity_residual],
            },
            KernelFunction {
                name: "correction",
                doc: "The change of coordinates that is least in the metric of `Mbar` among those with `C_q dq = \
                      -residuals`.",
                arguments: &[Argument::Position, Argument::Residuals],
                blocks: &[Block::Correction],
                results: vec![&kernel.correction],
            },
            KernelFunction {
                name: "accelerations",
                doc: "`qdd`, and the multipliers.",
                arguments: &[
                    Argument::Position,
                    Argument::Time,
                    Argument::Coordinates,
                    Argument::Rates,
                    Argument::Angles,
                ],
                blocks: &[
                    Block::Rates,
                    Block::NamedRates,
                    Block::Bias,
                    Block::Forces,
                    Block::Accelerations,
                    Block::Multipliers,
                    Block::Friction,
                ],
                results: vec![&kernel.accelerations, &kernel.multipliers],
            },
            KernelFunction {
                name: "outputs_at",
                doc: "What the scene asks for, at a position that is known.",
                arguments: &[
                    Argument::Position,
                    Argument::Time,
                    Argument::Coordinates,
                    Argument::Rates,
                    Argument::Accelerations,
                    Argument::Multipliers,
                    Argument::Angles,
                ],
                blocks: &[Block::Rates, Block::NamedRates],
                results: vec![&kernel.outputs],
            },
        ];
        let fields = self.fields(&parts);
        let position = self.add_position(&fields);
        let mut inside = self.predefined.clone();
        inside.extend(&position.values);
        for part in &parts {
            self.add_function(part, &inside, &position);
        }
        self.add_growth_factor(&position);
        let solution = self.solution();
        let has_angle = (0..self.writer.scene.coordinates.len())
            .map(|i| self.graph.ops().iter().any(|op| angle_of(self.graph, op).is_some_and(|(_, j)| i == j)));
        let mut tape = self.writer.tape.borrow_mut();
        tape.has_angle = has_angle.collect();
        tape.solution = solution;
    }

    fn add_function(&self, part: &KernelFunction, inside: &HashMap<Id, u32>, position: &Position) {
        let results = || part.results.iter().copied().flatten();
        let locals = self.needed_locals(results().copied(), inside);
        let locals: Vec<&Local> = locals.into_iter().filter(|local| part.blocks.contains(&local.block)).collect();
        let roots: Vec<Signed> = locals.iter().map(|local| &local.value).chain(results()).copied().collect();
        let mut body = self.body(inside, &position.names, &roots);
        define(&mut body, &locals, &HashSet::new());
        let ends: Vec<Signed> = results().copied().collect();
        body.define_all(&ends, &HashSet::new());
        let parts = vectors(&mut body, &part.results);
        self.writer.add(Function {
            name: part.name.to_owned(),
            doc: part.doc.to_owned(),
            arguments: part.arguments.to_vec(),
            statements: body.finish(),
            parts,
            ..Default::default()
        });
    }

    /// Counts the operations for accelerations and multipliers, without sines and cosines.
    fn solution(&self) -> Operations {
        let function = self.function_without_position(
            "accelerations",
            &[],
            &[&self.kernel.accelerations, &self.kernel.multipliers],
        );
        let given: HashSet<u32> = self.predefined.values().copied().collect();
        function.operations(&self.writer.tape.borrow(), |value| given.contains(&value))
    }
}
