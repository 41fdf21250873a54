//! Formulae that are evaluated as they stand: values of parameters, the start, the schedule, the stop condition.

use std::collections::HashMap;

use qrm_core::Operation;
use qrm_scene::expression::Node;
use qrm_scene::function::Function;
use qrm_scene::lexer::Comparison;
use qrm_scene::scene::{Coordinate, Quantity, Scene, Start, Value};

use qrm_core::NamedTape;
use qrm_core::named_tape::{self, Argument, Part, Shape, Statement};

/// The function that gives the scene's values of the parameters: each follows from those before it.
pub(super) fn parameters(scene: &Scene, tape: &mut NamedTape) -> named_tape::Function {
    let kept = || scene.parameters.iter().filter(|p| !p.left_out);
    let parts = kept().map(|p| {
        let value = Formula::new(scene, tape).value(&p.formula);
        Part { name: p.name.clone(), doc: String::new(), values: Shape::Scalar(value) }
    });
    named_tape::Function { name: "parameters".to_owned(), parts: parts.collect(), ..Default::default() }
}

/// The function that gives the start of the motion.
pub(super) fn start(scene: &Scene, tape: &mut NamedTape) -> named_tape::Function {
    let mut values = |start: fn(&Coordinate) -> &Start| {
        let each = scene.coordinates.iter().map(|coordinate| match start(coordinate) {
            Start::Given(value) | Start::Guess(value) => Formula::new(scene, tape).value(value),
            Start::Free => tape.number(0.0),
        });
        Shape::Vector(each.collect())
    };
    let (q, qd) = (values(|c| &c.position), values(|c| &c.rate));
    let parts = [("q", q), ("qd", qd)].map(|(name, values)| Part { name: name.to_owned(), doc: String::new(), values });
    named_tape::Function { name: "start".to_owned(), parts: parts.into(), ..Default::default() }
}

/// The function that gives step and end of the motion.
pub(super) fn schedule(scene: &Scene, tape: &mut NamedTape) -> named_tape::Function {
    let parts = [("step", &scene.run.step), ("end_time", &scene.run.end_time)].map(|(name, formula)| {
        let value = Formula::new(scene, tape).value(formula);
        Part { name: name.to_owned(), doc: String::new(), values: Shape::Scalar(value) }
    });
    named_tape::Function { name: "schedule".to_owned(), parts: parts.into(), ..Default::default() }
}

/// The function that gives the value of the stop condition, if there is one.
pub(super) fn event(scene: &Scene, tape: &mut NamedTape) -> Option<named_tape::Function> {
    let condition = scene.run.until.as_ref()?;
    let mut formula = Formula::new(scene, tape);
    let difference = formula.value(&condition.difference);
    let statements = formula.statements;
    let rising = match condition.comparison {
        Comparison::GreaterOrEqual => difference,
        Comparison::LessOrEqual => tape.negative(difference),
    };
    Some(named_tape::Function {
        name: "event".to_owned(),
        arguments: vec![Argument::Time, Argument::Coordinates, Argument::Rates],
        statements,
        parts: vec![Part { name: String::new(), doc: String::new(), values: Shape::Scalar(rising) }],
        ..Default::default()
    })
}

/// A formula of a scene on its way into a tape.
struct Formula<'s> {
    scene: &'s Scene,
    tape: &'s mut NamedTape,
    /// The points that it needs, each with its name.
    statements: Vec<Statement>,
    points: HashMap<(usize, usize), u32>,
}

impl<'s> Formula<'s> {
    fn new(scene: &'s Scene, tape: &'s mut NamedTape) -> Self {
        Self { scene, tape, statements: Vec::new(), points: HashMap::new() }
    }

    fn value(&mut self, value: &Value) -> u32 {
        let value = &value.without_splines();
        let mut values: Vec<u32> = Vec::with_capacity(value.nodes().len());
        for node in value.nodes() {
            let at = |i: &usize| values[*i];
            let operation = match node {
                Node::Number(number) => Operation::Number(number.value),
                Node::Name(quantity) => {
                    let value = self.quantity(*quantity);
                    values.push(value);
                    continue;
                }
                Node::Negate(a) => {
                    let value = self.tape.negative(at(a));
                    values.push(value);
                    continue;
                }
                Node::Add(a, b) => Operation::Add(at(a), at(b)),
                Node::Subtract(a, b) => Operation::Sub(at(a), at(b)),
                Node::Multiply(a, b) => Operation::Mul(at(a), at(b)),
                Node::Divide(a, b) => Operation::Div(at(a), at(b)),
                Node::Power(a, b) => match &value.nodes()[*b] {
                    Node::Number(n) if n.value.fract() == 0.0 && n.value <= 1024.0 => {
                        Operation::PowI(at(a), n.value as i32)
                    }
                    _ => Operation::Pow(at(a), at(b)),
                },
                Node::Call(function, arguments) => call(*function, &arguments.iter().map(at).collect::<Vec<u32>>()),
                Node::Spline(..) => unreachable!("splines are written out"),
            };
            values.push(self.tape.operation(operation));
        }
        values.pop().unwrap_or_else(|| unreachable!("a formula is not empty"))
    }

    fn quantity(&mut self, quantity: Quantity) -> u32 {
        let at = |argument, i| self.tape.input(argument) + named_tape::place(i);
        match quantity {
            Quantity::Parameter(i) if self.scene.parameters[i].left_out => self.tape.number(0.0),
            Quantity::Parameter(i) => {
                named_tape::place(self.scene.parameters[..i].iter().filter(|p| !p.left_out).count())
            }
            Quantity::Coordinate(i) => at(Argument::Coordinates, i),
            Quantity::Rate(i) => at(Argument::Rates, i),
            Quantity::Time => at(Argument::Time, 0),
            Quantity::Pi => self.tape.operation(Operation::Pi),
            Quantity::Point(point, axis) => self.point(point, axis),
            // The resolver lets no rate of a point into these formulae, and no scene with unknown names gets here.
            Quantity::PointRate(..) | Quantity::Stretch | Quantity::StretchRate | Quantity::Unknown => {
                unreachable!("they occur in loads alone")
            }
        }
    }

    /// A coordinate of a point, which gets a name.
    fn point(&mut self, point: usize, axis: usize) -> u32 {
        if let Some(&value) = self.points.get(&(point, axis)) {
            return value;
        }
        let own = &self.scene.points[point];
        let value = self.value(&own.position[axis]);
        self.points.insert((point, axis), value);
        if self.tape.is_computed(value) {
            let name = format!("{}_{}", own.name, ["x", "y"][axis]);
            self.statements.push(Statement { comment: None, value, names: vec![name] });
        }
        value
    }
}

/// The operation that computes a function.
pub(super) fn call(function: Function, arguments: &[u32]) -> Operation {
    let x = arguments[0];
    let y = || arguments[1];
    match function {
        Function::Sqrt => Operation::Sqrt(x),
        Function::Sin => Operation::Sin(x),
        Function::Cos => Operation::Cos(x),
        Function::Tan => Operation::Tan(x),
        Function::Asin => Operation::Asin(x),
        Function::Acos => Operation::Acos(x),
        Function::Atan => Operation::Atan(x),
        Function::Exp => Operation::Exp(x),
        Function::Log => Operation::Ln(x),
        Function::Sinh => Operation::Sinh(x),
        Function::Cosh => Operation::Cosh(x),
        Function::Tanh => Operation::Tanh(x),
        Function::Hypot => Operation::Hypot(x, y()),
        Function::Atan2 => Operation::Atan2(x, y()),
        Function::Abs => Operation::Abs(x),
        Function::Sign => Operation::Sign(x),
        Function::Min => Operation::Min(x, y()),
        Function::Max => Operation::Max(x, y()),
        Function::Floor => Operation::Floor(x),
    }
}
