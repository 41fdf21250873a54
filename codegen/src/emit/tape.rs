//! The functions of a scene as a tape: the operations that the printed functions do, in the same order.

mod formulae;
mod section;
mod text;

use std::collections::{BTreeMap, HashMap};

use qrm_core::{Operation, Tape, TapeFunction};

use super::Writer;
use crate::graph::{Id, Op, Signed};
use crate::term::Symbol;
use formulae::Names;
use qrm_scene::scene::{Coordinate, Start};
use section::Section;

/// A tape with the lists it refers to.
#[derive(Clone, Debug)]
pub struct OwnedTape {
    coordinates: u32,
    constraints: u32,
    constants: Vec<Operation>,
    given: Vec<bool>,
    functions: BTreeMap<&'static str, Function>,
}

/// A function with its lists.
#[derive(Clone, Debug, Default)]
struct Function {
    operations: Vec<Operation>,
    results: Vec<u32>,
}

impl Function {
    fn borrowed(&self) -> TapeFunction<'_> {
        TapeFunction { operations: &self.operations, results: &self.results }
    }
}

impl OwnedTape {
    /// The tape, ready to be evaluated.
    pub fn tape(&self) -> Tape<'_> {
        let optional = |name: &str| self.functions.get(name).map(Function::borrowed);
        let function = |name: &str| optional(name).unwrap_or_default();
        Tape {
            coordinates: self.coordinates,
            constraints: self.constraints,
            parameters: function("parameters"),
            constants: &self.constants,
            dynamics: function("dynamics"),
            loop_constraints: function("loop_constraints"),
            mass_matrix: function("mass_matrix"),
            energy: function("energy"),
            power: function("power"),
            outputs: function("outputs"),
            linearization: optional("linearization"),
            event: optional("event"),
            start: function("start"),
            given: &self.given,
            schedule: function("schedule"),
        }
    }
}

/// The printed functions that a tape has too.
const FUNCTIONS: [&str; 7] =
    ["dynamics", "loop_constraints", "mass_matrix", "energy", "power", "outputs", "linearization"];

/// The place at the end of a list.
fn place(length: usize) -> u32 {
    u32::try_from(length).unwrap_or_else(|_| unreachable!("no scene has 2^32 operations"))
}

impl Writer<'_> {
    /// The functions of the scene as a tape.
    pub(super) fn tape(&self) -> OwnedTape {
        let scene = self.scene;
        let (n, m) = (scene.coordinates.len(), scene.constraints.len());
        let names = Names::new(scene);
        let mut known: HashMap<Id, u32> = HashMap::new();
        for (id, op) in self.graph.ops().iter().enumerate() {
            if let Op::Input(symbol) = op {
                known.extend(names.symbol(*symbol).map(|place| (id, place)));
            }
        }
        let plans: Vec<(&'static str, Vec<Signed>)> = self
            .layout
            .plans
            .iter()
            .filter(|plan| FUNCTIONS.contains(&plan.name))
            .map(|plan| (plan.name, plan.values().copied().collect()))
            .collect();
        let constants = self.tape_constants(&plans, &mut known, names.first_constant());
        let first = names.first_constant() + section::places(&constants);

        let mut functions = BTreeMap::new();
        for (name, roots) in &plans {
            let mut section = Section::new(&known, first);
            let needed = self.graph.reachable(roots.iter().map(|root| root.id));
            let needed: Vec<Id> = needed.into_iter().filter(|id| !self.graph.is_constant(*id)).collect();
            let divisors = section::divisors(self.graph, &needed, roots, &self.named_values);
            section.graph(self.graph, &needed, &divisors);
            let results = roots.iter().map(|root| section.root(*root)).collect();
            functions.insert(*name, Function { operations: section.operations, results });
        }
        let starts = |start: fn(&Coordinate) -> &Start| scene.coordinates.iter().map(start);
        let starts: Vec<&Start> = starts(|c| &c.position).chain(starts(|c| &c.rate)).collect();
        let mut formulae = |name, section: Section, results| {
            functions.insert(name, Function { operations: section.operations, results });
        };
        let mut section = Section::new(&known, first);
        let results = names.kept().map(|p| section.formula(&names, &p.formula)).collect();
        formulae("parameters", section, results);
        let mut section = Section::new(&known, first);
        let results = starts.iter().map(|start| match start {
            Start::Given(value) | Start::Guess(value) => section.formula(&names, value),
            Start::Free => section.number(0.0),
        });
        let results = results.collect();
        formulae("start", section, results);
        let mut section = Section::new(&known, first);
        let results = [&scene.run.step, &scene.run.end_time].map(|value| section.formula(&names, value)).into();
        formulae("schedule", section, results);
        if let Some(condition) = &scene.run.until {
            let mut section = Section::new(&known, first);
            let result = section.condition(&names, condition);
            formulae("event", section, vec![result]);
        }
        let given = starts.iter().map(|start| matches!(start, Start::Given(_))).collect();
        OwnedTape { coordinates: place(n), constraints: place(m), constants, given, functions }
    }

    /// The operations of these functions that depend on parameters alone; their places become known.
    fn tape_constants(
        &self,
        plans: &[(&'static str, Vec<Signed>)],
        known: &mut HashMap<Id, u32>,
        first: u32,
    ) -> Vec<Operation> {
        let roots = plans.iter().flat_map(|(_, roots)| roots).map(|root| root.id);
        let needed: Vec<Id> =
            self.graph.reachable(roots).into_iter().filter(|id| self.graph.is_constant(*id)).collect();
        // The printed struct of constants has more of them, and what is divided by depends on all.
        let fields: Vec<Signed> = self.constants.iter().map(|(_, id)| Signed { negative: false, id: *id }).collect();
        let printed = self.graph.reachable(fields.iter().map(|field| field.id));
        let divisors = section::divisors(self.graph, &printed, &fields, &Default::default());
        let mut section = Section::new(known, first);
        section.graph(self.graph, &needed, &divisors);
        let (operations, places) = (section.operations, section.places);
        known.extend(places);
        operations
    }
}

/// Where the arguments of functions are.
fn argument_place(parameters: usize, n: usize, symbol: Symbol) -> Option<u32> {
    let place_of = |block: usize, i: usize| Some(place(parameters + 1 + block * n + i));
    match symbol {
        Symbol::Time => Some(place(parameters)),
        Symbol::Coordinate(i) => place_of(0, i),
        Symbol::Rate(i) => place_of(1, i),
        Symbol::Acceleration(i) => place_of(2, i),
        Symbol::Multiplier(i) => place_of(3, i),
        _ => None,
    }
}
