//! A scene's equations of motion by the TMT method.

use symbolica::atom::Atom;

use super::algebra::Algebra;
use super::{Place, kernel, linearization};
use crate::term::{Equations, Row, Symbol, Term};
use qrm_scene::scene::{LoadKind, OutputKind, Quantity, Scene, Value};

/// Derives everything that the generated functions compute. `number` tells the scenes of a process apart.
pub(super) fn equations(number: usize, scene: &Scene, place: &Place) -> Equations {
    let algebra = Algebra::new(number, scene, place);
    let rows = Rows::new(scene, &algebra);
    let simplify = |atoms: Vec<Atom>| -> Vec<Atom> { atoms.iter().map(|atom| algebra.simplify(atom)).collect() };
    let c = simplify(scene.constraints.iter().map(|c| algebra.atom(&c.residual)).collect());

    let terms = |atoms: &[Atom]| -> Vec<Term> { atoms.iter().map(|atom| algebra.term(atom)).collect() };
    let mut equations = Equations {
        com_positions: terms(&rows.x),
        com_jacobian: rows.gradients.iter().map(|row| terms(row)).collect(),
        com_bias: terms(&rows.bias),
        constraints: terms(&c),
        ..Equations::default()
    };
    let c_q: Vec<Vec<Atom>> = c.iter().map(|row| simplify(algebra.gradient(row))).collect();
    equations.constraint_jacobian = c_q.iter().map(|row| terms(row)).collect();
    let hessian = |row: &Vec<Atom>| row.iter().map(|entry| terms(&simplify(algebra.gradient(entry)))).collect();
    equations.constraint_hessians = c_q.iter().map(hessian).collect();
    let drifts: Vec<Atom> = c.iter().map(|row| algebra.drift(row)).collect();
    equations.constraint_rate = drifts.iter().map(|drift| algebra.simple_term(drift)).collect();
    equations.constraint_bias = c.iter().map(|row| algebra.simple_term(&algebra.bias(row))).collect();

    let zero = Atom::num(0);
    let mass = rows.mass_matrix(scene, &algebra);
    equations.mass_matrix = mass.iter().map(|row| terms(row)).collect();
    let loads = Loads::new(scene, &algebra, &rows);
    let efforts = rows.inertial().chain(loads.efforts.iter().cloned());
    let efforts: Vec<Effort> = efforts.collect();
    let force = |i: usize| {
        let moving = efforts.iter().filter(|effort| effort.along[i] != zero);
        algebra.simplify(&moving.fold(Atom::num(0), |sum, effort| sum + &effort.size * &effort.along[i]))
    };
    let forces: Vec<Atom> = (0..scene.coordinates.len()).map(force).collect();
    equations.generalized_forces = terms(&forces);
    if scene.run.stiff {
        equations.linearization = Some(linearization::derive(&algebra, &mass, &forces, &c, &c_q));
    }
    let momenta: Vec<Atom> = mass.iter().map(|row| algebra.contract(row, Symbol::Rate)).collect();
    let kinetic = algebra.contract(&momenta, Symbol::Rate) / Atom::num(2);
    equations.energy = [&kinetic, &loads.potential].into_iter().map(|atom| algebra.simple_term(atom)).collect();
    // A closure that moves by itself does work: -lambda' C_q qd = lambda' C_t.
    let driving = algebra.contract(&drifts, Symbol::Multiplier);
    equations.power = vec![algebra.simple_term(&(&loads.power + driving))];
    let output = |kind: &OutputKind| output(scene, &algebra, (&loads, &drifts), kind);
    equations.outputs = scene.outputs.iter().map(|o| algebra.simple_term(&output(&o.kind))).collect();
    equations.points =
        (0..scene.points.len()).map(|i| [0, 1].map(|axis| algebra.simple_term(&algebra.point(i)[axis]))).collect();
    (equations.rows, equations.left_out) = (rows.rows, rows.left_out);
    equations.kernel = kernel::equations(number, scene, place, &equations.outputs);
    equations
}

/// The rows of x: positions and angles of the bodies, without those that cannot matter to the motion.
pub(super) struct Rows {
    rows: Vec<Row>,
    names: Vec<String>,
    left_out: Vec<String>,
    x: Vec<Atom>,
    gradients: Vec<Vec<Atom>>,
    bias: Vec<Atom>,
    inertia: Vec<Atom>,
}

impl Rows {
    pub(super) fn new(scene: &Scene, algebra: &Algebra) -> Self {
        let empty = Vec::new;
        let mut rows = Self {
            rows: Vec::new(),
            names: Vec::new(),
            left_out: Vec::new(),
            x: empty(),
            gradients: Vec::new(),
            bias: empty(),
            inertia: empty(),
        };
        for (i, body) in scene.bodies.iter().enumerate() {
            let com = body.com.as_ref();
            let parts = [
                (com.map(|c| &c[0]), &body.mass, "x"),
                (com.map(|c| &c[1]), &body.mass, "y"),
                (body.angle.as_ref(), &body.inertia, "angle"),
            ];
            for (axis, (position, inertia, name)) in parts.into_iter().enumerate() {
                let Some(position) = position else { continue };
                let x = algebra.simplify(&algebra.atom(position));
                let m = inertia.as_ref().map_or_else(|| Atom::num(0), |m| algebra.atom(m));
                let row = Row { body: i, axis, inertia: algebra.simple_term(&m) };
                let gradient: Vec<Atom> = algebra.gradient(&x).iter().map(|entry| algebra.simplify(entry)).collect();
                let moves = gradient.iter().any(|derivative| *derivative != Atom::num(0));
                let carries = if axis == 2 { "inertia" } else { "mass" };
                let reason =
                    if row.inertia.is_zero() { format!("carries no {carries}") } else { "is constant".to_owned() };
                if row.inertia.is_zero() || !moves {
                    rows.left_out.push(format!("{name} of body `{}`: {reason}", body.name));
                    continue;
                }
                rows.names.push(format!("{}_{name}", body.name));
                rows.rows.push(row);
                rows.bias.push(algebra.simplify(&algebra.bias(&x)));
                rows.x.push(x);
                rows.gradients.push(gradient);
                rows.inertia.push(m);
            }
        }
        rows
    }

    /// T' M T
    pub(super) fn mass_matrix(&self, scene: &Scene, algebra: &Algebra) -> Vec<Vec<Atom>> {
        let zero = Atom::num(0);
        let mass = |i: usize, j: usize| {
            let moving = self.gradients.iter().zip(&self.inertia).filter(|(row, _)| row[i] != zero && row[j] != zero);
            let products = moving.map(|(row, m)| m * &row[i] * &row[j]);
            algebra.simplify(&products.fold(Atom::num(0), |sum, product| sum + product))
        };
        let n = scene.coordinates.len();
        let lower: Vec<Vec<Atom>> = (0..n).map(|i| (0..=i).map(|j| mass(i, j)).collect()).collect();
        (0..n).map(|i| (0..n).map(|j| lower[i.max(j)][i.min(j)].clone()).collect()).collect()
    }

    /// The forces of inertia at no acceleration of the coordinates, `-M bias`.
    pub(super) fn inertial(&self) -> impl Iterator<Item = Effort> {
        let effort = |i: usize| Effort {
            group: self.rows[i].body,
            name: self.names[i].clone(),
            size: -(&self.inertia[i] * &self.bias[i]),
            along: self.gradients[i].clone(),
        };
        (0..self.rows.len()).map(effort)
    }
}

/// A force or torque along a displacement.
#[derive(Clone)]
pub(super) struct Effort {
    /// Body, or beyond them load, that it belongs to.
    pub(super) group: usize,
    pub(super) name: String,
    pub(super) size: Atom,
    /// The displacement's derivative by each coordinate.
    pub(super) along: Vec<Atom>,
}

/// What the applied loads do.
pub(super) struct Loads {
    pub(super) efforts: Vec<Effort>,
    potential: Atom,
    /// Of those that have no potential.
    power: Atom,
    /// Of each.
    powers: Vec<Atom>,
}

impl Loads {
    pub(super) fn new(scene: &Scene, algebra: &Algebra, rows: &Rows) -> Self {
        let mut loads = Self { efforts: Vec::new(), potential: Atom::num(0), power: Atom::num(0), powers: Vec::new() };
        for (i, load) in scene.loads.iter().enumerate() {
            let known = loads.efforts.len();
            let mut adding =
                Adding { loads: &mut loads, scene, algebra, group: scene.bodies.len() + i, name: &load.name };
            match &load.kind {
                LoadKind::Force { force, at } => {
                    for ((force, at), axis) in force.iter().zip(at).zip(["_x", "_y"]) {
                        adding.effort(axis, force, at);
                    }
                }
                LoadKind::Torque { torque, angle } => adding.effort("", torque, angle),
                LoadKind::Gravity(field) => {
                    for (k, row) in rows.rows.iter().enumerate().filter(|(_, row)| row.axis < 2) {
                        let weight = &rows.inertia[k] * &algebra.atom(&field[row.axis]);
                        let name = rows.names[k].clone();
                        let along = rows.gradients[k].clone();
                        let potential = &weight * &rows.x[k];
                        adding.loads.efforts.push(Effort { group: row.body, name, size: weight, along });
                        adding.loads.potential = &adding.loads.potential - &potential;
                    }
                }
                LoadKind::Spring { along, stiffness, rest, damping, potential, force, friction } => {
                    let is_moved = scene.depends_on_time(along);
                    let along = algebra.simplify(&algebra.atom(along));
                    let constant =
                        |value: &Option<Value>| value.as_ref().map_or_else(|| Atom::num(0), |v| algebra.atom(v));
                    let (stiffness, extension) = (constant(stiffness), &along - &constant(rest));
                    let stretch = [along.clone(), algebra.rate(&along)];
                    let law =
                        |law: &Option<Value>| law.as_ref().map_or_else(|| Atom::num(0), |v| algebra.law(v, &stretch));
                    let friction = friction.as_ref().map_or_else(
                        || Atom::num(0),
                        |(size, slip)| -algebra.law(size, &stretch) * algebra.tanh(&(&stretch[1] / algebra.atom(slip))),
                    );
                    let loss = -constant(damping) * &stretch[1] + law(force) + friction;
                    let slope = algebra.slope_of_potential(&constant(potential), &along);
                    let effort = -&stiffness * &extension - slope + &loss;
                    adding.add("", &effort, &along);
                    let velocity = adding.velocity(&along);
                    if is_moved {
                        loads.power = &loads.power + &(&effort * &velocity);
                    } else {
                        let spring = &stiffness * &extension * &extension / Atom::num(2);
                        loads.potential = &loads.potential + &spring + law(potential);
                        loads.power = &loads.power + &(&loss * &velocity);
                    }
                }
            }
            let power = |sum: Atom, effort: &Effort| sum + &effort.size * algebra.contract(&effort.along, Symbol::Rate);
            let power = loads.efforts[known..].iter().fold(Atom::num(0), power);
            loads.powers.push(power);
        }
        loads
    }
}

/// A load that is being added.
struct Adding<'a> {
    loads: &'a mut Loads,
    scene: &'a Scene,
    algebra: &'a Algebra<'a>,
    group: usize,
    name: &'a str,
}

impl Adding<'_> {
    /// A force or torque along a displacement: conservative if it is constant, and time does not move what it acts on.
    fn effort(&mut self, axis: &str, effort: &Value, displacement: &Value) {
        let is_constant = effort.names().all(|name| matches!(name, Quantity::Parameter(_) | Quantity::Pi))
            && !self.scene.depends_on_time(displacement);
        let (effort, displacement) = (self.algebra.atom(effort), self.algebra.atom(displacement));
        self.add(axis, &effort, &displacement);
        if is_constant {
            self.loads.potential = &self.loads.potential - &(&effort * &displacement);
        } else {
            self.loads.power = &self.loads.power + &(&effort * &self.velocity(&displacement));
        }
    }

    /// The rate of a displacement that the coordinates bring: what time moves by itself works on what moves it.
    fn velocity(&self, displacement: &Atom) -> Atom {
        self.algebra.contract(&self.algebra.gradient(displacement), Symbol::Rate)
    }

    fn add(&mut self, axis: &str, effort: &Atom, displacement: &Atom) {
        let displacement = self.algebra.simplify(displacement);
        let along = self.algebra.gradient(&displacement).iter().map(|entry| self.algebra.simplify(entry)).collect();
        let name = format!("{}{axis}", self.name);
        self.loads.efforts.push(Effort { group: self.group, name, size: effort.clone(), along });
    }
}

fn output(scene: &Scene, algebra: &Algebra, (loads, drifts): (&Loads, &[Atom]), kind: &OutputKind) -> Atom {
    match kind {
        OutputKind::LoadPower(load) => loads.powers[*load].clone(),
        OutputKind::DrivePower(k) => &drifts[*k] * algebra.symbol(Symbol::Multiplier(*k)),
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
