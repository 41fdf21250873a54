//! Creates the tape of a scene: the list of its functions with their arguments, values and names.

mod body;
mod constants;
mod formulae;
mod inverse;
mod kernel;
mod layout;
mod naming;
mod plan;
mod scene_formula;
mod switching;

use std::cell::RefCell;
use std::collections::{HashMap, HashSet};

use qrm_language::identifier::ident;
use qrm_scene::formula_tape;
use qrm_scene::scene::{Coordinate, EliminationForm, Scene, Start};

use crate::graph::{Graph, Id, Op, Signed};
use crate::kernel::ImpossibleForm;
use crate::notes::notes;
use crate::term::{Equations, Symbol};
use body::Body;
use layout::Layout;
use plan::Plan;
use qrm_core::NamedTape;
use qrm_core::named_tape::{Argument, Function, ResultField, place};

/// Creates the functions of a scene. Its kernel has the form that the scene asks for, or the one with the fewest
/// operations.
///
/// # Errors
/// The form that the scene asks for is not possible.
pub fn tape(scene: &Scene, equations: &Equations) -> Result<NamedTape, ImpossibleForm> {
    tape_of_form(scene, equations, scene.run.elimination)
}

/// Creates the functions of a scene. Its kernel has this form, or the one with the fewest operations.
///
/// # Errors
/// The form is not possible.
pub fn tape_of_form(
    scene: &Scene,
    equations: &Equations,
    form: Option<EliminationForm>,
) -> Result<NamedTape, ImpossibleForm> {
    let layout = Layout::new(scene, equations, form)?;
    let writer = Writer::new(scene, &layout);
    for plan in &layout.plans {
        let function = writer.function(plan);
        writer.add(function);
    }
    kernel::Emitter::new(&writer, &layout.kernel, true).add_functions();
    if let Some(inverse) = &layout.inverse {
        inverse::add_inverse_dynamics(&writer, inverse);
    }
    let mut tape = writer.tape.into_inner();
    let start = scene_formula::start(scene, &mut tape);
    let schedule = scene_formula::schedule(scene, &mut tape);
    let event = scene.run.until.as_ref().map(|until| formula_tape::event(scene, until, &mut tape));
    tape.functions.extend([start, schedule].into_iter().chain(event));
    let switching = switching::switching(&tape, scene.friction_by_forces().next().is_some());
    tape.functions.extend(switching);
    let is_given = |start: fn(&Coordinate) -> &Start| {
        scene.coordinates.iter().map(move |coordinate| matches!(start(coordinate), Start::Given(_)))
    };
    tape.given = is_given(|c| &c.position).chain(is_given(|c| &c.rate)).collect();
    tape.is_driven = scene.is_driven();
    tape.notes = notes(scene, equations, &tape, (layout.kernel.form, &layout.forms));
    Ok(tape)
}

/// Names of arguments and of the two structs of a mechanism.
const RESERVED: [&str; 11] =
    ["p", "k", "q", "qd", "qdd", "m", "multipliers", "rows", "angles", "position", "residuals"];

/// Names that no value of a function may have: those above, and that of time.
fn reserved() -> HashSet<String> {
    RESERVED.into_iter().chain(["t"]).map(str::to_owned).collect()
}

/// Creates the functions of a scene.
struct Writer<'a> {
    scene: &'a Scene,
    layout: &'a Layout,
    graph: &'a Graph,
    tape: RefCell<NamedTape>,
    /// Inputs and precomputed constants.
    predefined: HashMap<Id, u32>,
    hints: HashMap<Id, String>,
    /// Coordinates of points, and sines and cosines of sums of coordinates, which have names.
    named_values: HashSet<Id>,
    /// The names of arguments.
    argument_names: HashSet<String>,
}

impl<'a> Writer<'a> {
    fn new(scene: &'a Scene, layout: &'a Layout) -> Self {
        let graph = &layout.graph;
        let parameters = scene.parameters.iter().filter(|p| !p.left_out).count();
        let mut writer = Self {
            scene,
            layout,
            graph,
            tape: RefCell::new(NamedTape::new(parameters, scene.coordinates.len(), scene.constraints.len())),
            predefined: HashMap::new(),
            hints: HashMap::new(),
            named_values: HashSet::new(),
            argument_names: HashSet::new(),
        };
        writer.name_inputs();
        for (id, op) in graph.ops().iter().enumerate() {
            let Op::Input(symbol) = op else { continue };
            let hint = match *symbol {
                // Its name is assigned where it is computed.
                Symbol::Local(_) => continue,
                Symbol::Parameter(i) => scene.parameters[i].name.to_lowercase(),
                Symbol::Pi => {
                    writer.hints.insert(id, "pi".to_owned());
                    continue;
                }
                _ => writer.tape.borrow().names[&writer.input(*symbol)].clone(),
            };
            writer.hints.insert(id, hint);
            let input = writer.input(*symbol);
            writer.predefined.insert(id, input);
        }
        writer.add_constants();
        let is_new = |value: &Signed| !graph.is_constant(value.id) && !graph.op(value.id).is_leaf() && !value.negative;
        for (name, value) in layout.named_values.iter().filter(|(_, value)| is_new(value)) {
            writer.hints.entry(value.id).or_insert_with(|| name.clone());
            writer.named_values.insert(value.id);
        }
        for (name, value) in layout.names.iter().filter(|(_, value)| is_new(value)) {
            writer.hints.entry(value.id).or_insert_with(|| name.clone());
        }
        writer
    }

    /// The input that represents a symbol.
    fn input(&self, symbol: Symbol) -> u32 {
        let tape = self.tape.borrow();
        let at = |argument, i: usize| tape.input(argument) + place(i);
        match symbol {
            Symbol::Parameter(i) => place(self.scene.parameters[..i].iter().filter(|p| !p.left_out).count()),
            Symbol::Time => at(Argument::Time, 0),
            Symbol::Coordinate(i) => at(Argument::Coordinates, i),
            Symbol::Rate(i) => at(Argument::Rates, i),
            Symbol::Acceleration(i) => at(Argument::Accelerations, i),
            Symbol::Multiplier(i) => at(Argument::Multipliers, i),
            Symbol::Residual(i) => at(Argument::Residuals, i),
            other => unreachable!("{other:?} is no input of a function"),
        }
    }

    /// Names the parameters, arguments, sines and cosines.
    fn name_inputs(&mut self) {
        let scene = self.scene;
        let mut tape = self.tape.borrow_mut();
        for (input, parameter) in (0..).zip(scene.parameters.iter().filter(|p| !p.left_out)) {
            tape.names.insert(input, parameter.name.clone());
        }
        let coordinates = |of: fn(&str) -> String| scene.coordinates.iter().map(move |c| of(&c.name));
        let constraints = |of: fn(&str) -> String| scene.constraints.iter().map(move |c| of(&c.name));
        let wishes = [
            (Argument::Time, vec!["t".to_owned()]),
            (Argument::Coordinates, coordinates(str::to_owned).collect()),
            (Argument::Rates, coordinates(|name| format!("{name}_dot")).collect()),
            (Argument::Accelerations, coordinates(|name| format!("{name}_ddot")).collect()),
            (Argument::Multipliers, constraints(|name| format!("lambda_{name}")).collect()),
            (Argument::Residuals, constraints(|name| format!("{name}_open")).collect()),
        ];
        for (argument, wishes) in wishes {
            for (input, wish) in (tape.input(argument)..).zip(wishes) {
                let name = self.argument_name(&wish);
                self.argument_names.insert(name.clone());
                tape.names.insert(input, name);
            }
        }
        for i in 0..scene.coordinates.len() {
            let angle = tape.names[&(tape.input(Argument::Coordinates) + place(i))].clone();
            let (sine, n) = (tape.sine(i), place(scene.coordinates.len()));
            tape.names.insert(sine, format!("sin_{angle}"));
            tape.names.insert(sine + n, format!("cos_{angle}"));
        }
    }

    fn argument_name(&self, wish: &str) -> String {
        let name = ident(wish).to_string();
        // The arguments and the two structs of a mechanism share a scope, and a raw identifier cannot be part of a
        // longer name.
        let mut name = name.strip_prefix("r#").map_or(name.clone(), |word| format!("{word}_"));
        while RESERVED.contains(&name.as_str()) || self.argument_names.contains(&name) {
            name.push('_');
        }
        name
    }

    /// Adds a function to the tape, without statements that no result depends on and those that compute a value again:
    /// different sums may become the same operations.
    fn add(&self, mut function: Function) {
        let mut tape = self.tape.borrow_mut();
        let needed: HashSet<u32> = tape.needed(function.results()).into_iter().collect();
        let (mut comment, mut named) = (None, HashSet::new());
        function.statements.retain_mut(|statement| {
            comment = statement.comment.take().or(comment.take());
            let is_used = (statement.value..).take(statement.names.len()).any(|value| needed.contains(&value));
            let is_used = is_used && named.insert(statement.value);
            statement.comment = if is_used { comment.take() } else { None };
            is_used
        });
        tape.functions.push(function);
    }

    fn function(&self, plan: &Plan<Signed>) -> Function {
        let roots: Vec<Signed> = plan.values().copied().collect();
        let mut taken = reserved();
        taken.extend(self.argument_names.iter().cloned());
        let graph = (self.graph, &self.tape);
        let mut body = Body::new(graph, &self.predefined, &self.hints, &self.named_values, taken, &roots);
        let parts = plan.parts.iter().map(|(name, shape)| {
            let values = shape.map(&mut |root| body.root(*root));
            ResultField { name: (*name).to_owned(), doc: String::new(), values }
        });
        let parts = parts.collect();
        Function {
            name: plan.name.to_owned(),
            doc: plan.doc.clone(),
            aliases: plan.aliases.iter().map(|&alias| alias.to_owned()).collect(),
            arguments: plan.arguments.to_vec(),
            statements: body.finish(),
            parts,
            structure: plan.structure.map(str::to_owned),
        }
    }
}
