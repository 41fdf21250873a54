//! A scene's equations of motion by the TMT method.

use symbolica::atom::Atom;

use super::Place;
use super::algebra::Algebra;
use crate::scene::{LoadKind, OutputKind, Quantity, Scene, Value};
use crate::term::{Equations, Row, Symbol, Term};

/// Derives everything that the generated functions compute. `number` tells the scenes of a process apart.
pub(super) fn equations(number: usize, scene: &Scene, place: &Place) -> Equations {
    let algebra = Algebra::new(number, scene, place);
    let mut equations = Equations::default();
    let x = com_positions(scene, &algebra, &mut equations);
    let simplify = |atoms: Vec<Atom>| -> Vec<Atom> { atoms.iter().map(|atom| algebra.simplify(atom)).collect() };
    let gradients: Vec<Vec<Atom>> = x.iter().map(|row| simplify(algebra.gradient(row))).collect();
    let bias = simplify(x.iter().map(|row| algebra.bias(row)).collect());
    let inertia: Vec<Atom> = equations.rows.iter().map(|row| inertia_of(scene, &algebra, row)).collect();
    let c = simplify(scene.constraints.iter().map(|c| algebra.atom(&c.residual)).collect());

    let terms = |atoms: &[Atom]| -> Vec<Term> { atoms.iter().map(|atom| algebra.term(atom)).collect() };
    equations.com_positions = terms(&x);
    equations.com_jacobian = gradients.iter().map(|row| terms(row)).collect();
    equations.com_bias = terms(&bias);
    equations.constraints = terms(&c);
    let c_q: Vec<Vec<Atom>> = c.iter().map(|row| simplify(algebra.gradient(row))).collect();
    equations.constraint_jacobian = c_q.iter().map(|row| terms(row)).collect();
    let hessian = |row: &Vec<Atom>| row.iter().map(|entry| terms(&simplify(algebra.gradient(entry)))).collect();
    equations.constraint_hessians = c_q.iter().map(hessian).collect();
    equations.constraint_bias = c.iter().map(|row| algebra.simple_term(&algebra.bias(row))).collect();

    let n = scene.coordinates.len();
    let mass = |i: usize, j: usize| {
        let products = gradients.iter().zip(&inertia).map(|(row, m)| m * &row[i] * &row[j]);
        algebra.simplify(&products.fold(Atom::num(0), |sum, product| sum + product))
    };
    let lower: Vec<Vec<Atom>> = (0..n).map(|i| (0..=i).map(|j| mass(i, j)).collect()).collect();
    let row = |i: usize| -> Vec<Atom> { (0..n).map(|j| lower[i.max(j)][i.min(j)].clone()).collect() };
    let mass: Vec<Vec<Atom>> = (0..n).map(row).collect();
    equations.mass_matrix = mass.iter().map(|row| terms(row)).collect();

    let loads = Loads::new(scene, &algebra, &x, &equations.rows, &inertia);
    let force = |i: usize| {
        let inertial = gradients.iter().zip(&inertia).zip(&bias).map(|((row, m), b)| m * &row[i] * b);
        algebra.simple_term(&inertial.fold(loads.generalized[i].clone(), |sum, product| sum - product))
    };
    equations.generalized_forces = (0..n).map(force).collect();
    let momenta: Vec<Atom> = mass.iter().map(|row| algebra.contract(row, Symbol::Rate)).collect();
    let kinetic = algebra.contract(&momenta, Symbol::Rate) / Atom::num(2);
    equations.energy = [kinetic, loads.potential].iter().map(|atom| algebra.simple_term(atom)).collect();
    equations.power = vec![algebra.simple_term(&loads.power)];
    equations.outputs = scene.outputs.iter().map(|o| algebra.simple_term(&output(scene, &algebra, &o.kind))).collect();
    equations.points =
        (0..scene.points.len()).map(|i| [0, 1].map(|axis| algebra.simple_term(&algebra.point(i)[axis]))).collect();
    equations
}

/// Positions and angles of the bodies, without the rows that cannot matter to the motion.
fn com_positions(scene: &Scene, algebra: &Algebra, equations: &mut Equations) -> Vec<Atom> {
    let mut x = Vec::new();
    for (i, body) in scene.bodies.iter().enumerate() {
        let com = body.com.as_ref();
        let parts = [
            (com.map(|c| &c[0]), &body.mass, "x"),
            (com.map(|c| &c[1]), &body.mass, "y"),
            (body.angle.as_ref(), &body.inertia, "angle"),
        ];
        for (axis, (position, inertia, name)) in parts.into_iter().enumerate() {
            let Some(position) = position else { continue };
            let atom = algebra.simplify(&algebra.atom(position));
            let row = Row {
                body: i,
                axis,
                inertia: inertia.as_ref().map_or_else(Term::zero, |m| algebra.simple_term(&algebra.atom(m))),
            };
            let moves = algebra.gradient(&atom).iter().any(|derivative| *derivative != Atom::num(0));
            let carries = if axis == 2 { "inertia" } else { "mass" };
            let reason = if row.inertia.is_zero() { format!("carries no {carries}") } else { "is constant".to_owned() };
            if row.inertia.is_zero() || !moves {
                equations.left_out.push(format!("{name} of body `{}`: {reason}", body.name));
                continue;
            }
            equations.rows.push(row);
            x.push(atom);
        }
    }
    x
}

fn inertia_of(scene: &Scene, algebra: &Algebra, row: &Row) -> Atom {
    let body = &scene.bodies[row.body];
    let value = if row.axis == 2 { &body.inertia } else { &body.mass };
    value.as_ref().map_or_else(|| Atom::num(0), |value| algebra.atom(value))
}

/// What the applied loads do.
struct Loads {
    generalized: Vec<Atom>,
    potential: Atom,
    power: Atom,
}

impl Loads {
    fn new(scene: &Scene, algebra: &Algebra, x: &[Atom], rows: &[Row], inertia: &[Atom]) -> Self {
        let zero = Atom::num(0);
        let mut loads =
            Self { generalized: vec![zero.clone(); scene.coordinates.len()], potential: zero.clone(), power: zero };
        for load in &scene.loads {
            match &load.kind {
                LoadKind::Force { force, at } => {
                    for (force, at) in force.iter().zip(at) {
                        loads.effort(algebra, force, &algebra.atom(at));
                    }
                }
                LoadKind::Torque { torque, angle } => loads.effort(algebra, torque, &algebra.atom(angle)),
                LoadKind::Gravity(field) => {
                    for ((row, x), m) in rows.iter().zip(x).zip(inertia).filter(|((row, _), _)| row.axis < 2) {
                        let weight = m * &algebra.atom(&field[row.axis]);
                        loads.add(algebra, &weight, x);
                        loads.potential = &loads.potential - &(&weight * x);
                    }
                }
                LoadKind::Spring { along, stiffness, rest, damping } => {
                    let along = algebra.simplify(&algebra.atom(along));
                    let constant =
                        |value: &Option<Value>| value.as_ref().map_or_else(|| Atom::num(0), |v| algebra.atom(v));
                    let (stiffness, extension) = (constant(stiffness), &along - &constant(rest));
                    loads.add(algebra, &(-&stiffness * &extension), &along);
                    loads.potential = &loads.potential + &(&stiffness * &extension * &extension / Atom::num(2));
                    let rate = algebra.rate(&along);
                    let friction = -constant(damping) * &rate;
                    loads.add(algebra, &friction, &along);
                    loads.power = &loads.power + &(&friction * &rate);
                }
            }
        }
        loads
    }

    /// A force or torque along a displacement: conservative if it is constant.
    fn effort(&mut self, algebra: &Algebra, effort: &Value, displacement: &Atom) {
        let is_constant = effort.names().all(|name| matches!(name, Quantity::Parameter(_) | Quantity::Pi));
        let effort = algebra.atom(effort);
        self.add(algebra, &effort, displacement);
        if is_constant {
            self.potential = &self.potential - &(&effort * displacement);
        } else {
            self.power = &self.power + &(&effort * &algebra.rate(displacement));
        }
    }

    fn add(&mut self, algebra: &Algebra, effort: &Atom, displacement: &Atom) {
        for (sum, derivative) in self.generalized.iter_mut().zip(algebra.gradient(displacement)) {
            *sum = &*sum + &(effort * &derivative);
        }
    }
}

fn output(scene: &Scene, algebra: &Algebra, kind: &OutputKind) -> Atom {
    match kind {
        OutputKind::Value(value) => algebra.atom(value),
        OutputKind::Rate(value) => algebra.rate(&algebra.simplify(&algebra.atom(value))),
        OutputKind::SecondRate(value) => {
            let atom = algebra.simplify(&algebra.atom(value));
            algebra.contract(&algebra.gradient(&atom), Symbol::Acceleration) + algebra.bias(&atom)
        }
        OutputKind::ReactionForce { constraint, point, along } => {
            let along = [algebra.atom(&along[0]), algebra.atom(&along[1])];
            let shifted = |p: usize, axis: usize| {
                let position = algebra.point(p)[axis].clone();
                if p == *point { position + algebra.displacement() * &along[axis] } else { position }
            };
            reaction(
                algebra,
                *constraint,
                &algebra.atom_where(&scene.constraints[*constraint].residual, shifted, |i| {
                    algebra.symbol(Symbol::Coordinate(i))
                }),
            )
        }
        OutputKind::ReactionMoment { constraint, coordinate } => {
            let turned = |i: usize| {
                let angle = algebra.symbol(Symbol::Coordinate(i));
                if i == *coordinate { angle + algebra.displacement() } else { angle }
            };
            reaction(
                algebra,
                *constraint,
                &algebra.atom_where(
                    &scene.constraints[*constraint].residual,
                    |p, axis| algebra.point(p)[axis].clone(),
                    turned,
                ),
            )
        }
    }
}

/// The force of a constraint along a virtual displacement of what it acts on: -lambda dC/ds.
fn reaction(algebra: &Algebra, constraint: usize, displaced: &Atom) -> Atom {
    -algebra.derivative_by_displacement(displaced) * algebra.symbol(Symbol::Multiplier(constraint))
}
