//! Loads: forces and torques along displacements, potential and power.

use std::ops::Range;

use symbolica::atom::Atom;

use super::algebra::Algebra;
use super::rows::Rows;
use qrm_codegen::term::Symbol;
use qrm_scene::scene::{Friction, LoadKind, Quantity, Scene, Value};

/// A force or torque along a displacement.
#[derive(Clone)]
pub(super) struct Effort {
    /// The number of its body, or the number of bodies plus that of its load.
    pub(super) group: usize,
    pub(super) name: String,
    pub(super) size: Atom,
    /// The output to whose size it is proportional; only for friction.
    pub(super) normal: Option<usize>,
    /// The displacement.
    pub(super) displacement: Atom,
    /// The derivatives of the displacement with respect to the coordinates; empty where names are variables.
    pub(super) along: Vec<Atom>,
}

/// The applied loads of a scene.
pub(super) struct Loads {
    pub(super) efforts: Vec<Effort>,
    pub(super) potential: Atom,
    /// The power of the loads without a potential.
    pub(super) power: Atom,
    /// The efforts of each load.
    own: Vec<Range<usize>>,
}

impl Loads {
    pub(super) fn new(scene: &Scene, algebra: &Algebra, rows: &Rows) -> Self {
        let mut loads = Self { efforts: Vec::new(), potential: Atom::num(0), power: Atom::num(0), own: Vec::new() };
        for (i, load) in scene.loads.iter().enumerate() {
            let known = loads.efforts.len();
            let mut adding =
                Adding { loads: &mut loads, scene, algebra, group: scene.bodies.len() + i, name: &load.name };
            match &load.kind {
                LoadKind::Force { force, at, .. } => {
                    for ((force, at), axis) in force.iter().zip(at).zip(["_x", "_y"]) {
                        adding.effort(axis, force, at);
                    }
                }
                LoadKind::Torque { torque, angle, .. } => adding.effort("", torque, angle),
                LoadKind::Gravity(field) => {
                    for (k, row) in rows.rows.iter().enumerate().filter(|(_, row)| row.axis < 2) {
                        let weight = &rows.inertia[k] * &algebra.atom(&field[row.axis]);
                        let name = rows.names[k].clone();
                        let (displacement, along) = (rows.x[k].clone(), rows.gradients[k].clone());
                        let potential = &weight * &displacement;
                        let (group, size) = (row.body, weight);
                        adding.loads.efforts.push(Effort { group, name, size, normal: None, displacement, along });
                        adding.loads.potential = &adding.loads.potential - &potential;
                    }
                }
                LoadKind::Spring { along, stiffness, rest, damping, potential, force, friction } => {
                    let is_moved = scene.depends_on_time([along]);
                    let along = algebra.simplify(&algebra.atom(along));
                    let constant =
                        |value: &Option<Value>| value.as_ref().map_or_else(|| Atom::num(0), |v| algebra.atom(v));
                    let (stiffness, extension) = (constant(stiffness), &along - &constant(rest));
                    let stretch = [along.clone(), algebra.rate(&along)];
                    let law =
                        |law: &Option<Value>| law.as_ref().map_or_else(|| Atom::num(0), |v| algebra.law(v, &stretch));
                    let (normal, friction) = friction.as_ref().map_or_else(
                        || (None, Atom::num(0)),
                        |Friction { size, slip, normal, .. }| {
                            let size = algebra.law(size, &stretch);
                            let size = normal.map_or(size.clone(), |k| size * algebra.symbol(Symbol::NormalForce(k)));
                            (*normal, -size * algebra.tanh(&(&stretch[1] / algebra.atom(slip))))
                        },
                    );
                    let others = -constant(damping) * &stretch[1] + law(force);
                    let slope = algebra.slope_of_potential(&constant(potential), &along);
                    let own = -&stiffness * &extension - slope;
                    let loss = &others + &friction;
                    let effort = &own + &loss;
                    if let Some(normal) = normal {
                        adding.add("", &(own + others), &along);
                        adding.add("_friction", &friction, &along);
                        adding.loads.efforts.last_mut().into_iter().for_each(|effort| effort.normal = Some(normal));
                    } else {
                        adding.add("", &effort, &along);
                    }
                    let velocity = algebra.velocity(&along);
                    if is_moved {
                        loads.power = &loads.power + &(&effort * &velocity);
                    } else {
                        let spring = &stiffness * &extension * &extension / Atom::num(2);
                        loads.potential = &loads.potential + &spring + law(potential);
                        loads.power = &loads.power + &(&loss * &velocity);
                    }
                }
            }
            loads.own.push(known..loads.efforts.len());
        }
        loads
    }

    /// The forces and torques of one load.
    pub(super) fn efforts(&self, load: usize) -> &[Effort] {
        &self.efforts[self.own[load].clone()]
    }

    /// The force of a load along its length.
    pub(super) fn force_of(&self, load: usize) -> Atom {
        self.efforts(load).iter().fold(Atom::num(0), |sum, effort| sum + &effort.size)
    }

    /// The power of one load.
    pub(super) fn power_of(&self, algebra: &Algebra, load: usize) -> Atom {
        let velocity = |effort: &Effort| match algebra.names_are_variables {
            true => algebra.velocity(&effort.displacement),
            false => algebra.contract(&effort.along, Symbol::Rate),
        };
        let power = |sum: Atom, effort: &Effort| sum + &effort.size * velocity(effort);
        self.efforts(load).iter().fold(Atom::num(0), power)
    }
}

/// A load in progress.
struct Adding<'a> {
    loads: &'a mut Loads,
    scene: &'a Scene,
    algebra: &'a Algebra<'a>,
    group: usize,
    name: &'a str,
}

impl Adding<'_> {
    /// Adds a force or torque along a displacement. It is conservative if it is constant, and its displacement does not
    /// depend on time.
    fn effort(&mut self, axis: &str, effort: &Value, displacement: &Value) {
        let is_constant = effort.names().all(|name| matches!(name, Quantity::Parameter(_) | Quantity::Pi))
            && !self.scene.depends_on_time([displacement]);
        let (effort, displacement) = (self.algebra.atom(effort), self.algebra.atom(displacement));
        self.add(axis, &effort, &displacement);
        if is_constant {
            self.loads.potential = &self.loads.potential - &(&effort * &displacement);
        } else {
            self.loads.power = &self.loads.power + &(&effort * &self.algebra.velocity(&displacement));
        }
    }

    fn add(&mut self, axis: &str, effort: &Atom, displacement: &Atom) {
        let displacement = self.algebra.in_known_sums(&self.algebra.simplify(displacement));
        let along = self.algebra.gradient(&displacement).iter().map(|entry| self.algebra.simplify(entry)).collect();
        let name = format!("{}{axis}", self.name);
        let (group, size) = (self.group, effort.clone());
        self.loads.efforts.push(Effort { group, name, size, normal: None, displacement, along });
    }
}
