//! The kernel of a scene: the equations of motion as far as a step needs them, in mechanical order, with named
//! intermediate results.

mod algebra;
mod block;
mod builder;
mod choice;
mod inverse;
mod named_quantities;
mod normal_forces;
mod null_space;
mod range_space;
mod sparse;

use std::collections::{HashMap, HashSet};

use crate::graph::{Graph, Id, Signed};
use crate::lower::Lowering;
use crate::term::{EffortGroup, Equations, KernelEquations, NormalForce, Symbol, Term};
use algebra::{Matrix, Value};
pub use block::Block;
use builder::Builder;
pub use builder::Local;
pub(crate) use choice::Choice;
pub use choice::ImpossibleForm;
use null_space::NullSpace;
use qrm_scene::scene::{EliminationForm, Scene};
use range_space::RangeSpace;

/// A kernel as operations of a graph.
#[derive(Debug, Default)]
pub struct Kernel {
    /// Named values, in the order of computation.
    pub locals: Vec<Local>,
    /// C
    pub residuals: Vec<Signed>,
    /// The values that bound the growth of rounding errors.
    pub growth_factors: Vec<Signed>,
    /// C_q qd + C_t
    pub velocity_residual: Vec<Signed>,
    /// The correction of the coordinates.
    pub correction: Vec<Signed>,
    /// qdd
    pub accelerations: Vec<Signed>,
    /// lambda
    pub multipliers: Vec<Signed>,
    /// The outputs of the scene.
    pub outputs: Vec<Signed>,
    /// The independent coordinates with the forces along them for given accelerations; only for inverse dynamics.
    pub forces: Vec<(usize, Signed)>,
    /// The form of the elimination.
    pub form: EliminationForm,
    /// Whether the kernel is valid at every position.
    pub is_valid_everywhere: bool,
    /// Whether the quantities of a position depend on time too, through constraints, lengths or named quantities.
    pub is_timed: bool,
}

impl Kernel {
    /// Creates the kernel of a scene in a form; its graph may contain other operations. `None` if the equations were
    /// not derived for the form, or if a pivot is zero by structure: in the sparse form and in the range space that of
    /// a coordinate without inertia, or of a constraint that no motion changes.
    pub fn new(scene: &Scene, equations: &Equations, lowering: &mut Lowering, form: EliminationForm) -> Option<Self> {
        let builder = Builder::new(scene, lowering, 0, false);
        match form {
            EliminationForm::Sparse if equations.has_fixed_constraint() => None,
            EliminationForm::Sparse => builder.build_sparse(equations.sparse.as_ref()?),
            _ if equations.has_momenta() => None,
            EliminationForm::NullSpace | EliminationForm::RangeSpace => builder.build(equations, form),
        }
    }

    /// Binds the symbols of generalized momenta and forces to values that are valid at any position, for plain
    /// functions.
    pub fn bind_dynamics(scene: &Scene, equations: &Equations, lowering: &mut Lowering) {
        if let Some(sparse) = equations.sparse.as_ref().filter(|_| equations.has_momenta()) {
            Builder::new(scene, lowering, 0, true).bind_dynamics(sparse);
        }
    }

    /// The number of operations of a step in a graph.
    pub fn operations(&self, graph: &Graph) -> usize {
        let needed = needed(graph, &self.locals, self.values().map(|value| value.id).collect());
        let counted = needed.iter().filter(|id| !graph.is_constant(**id));
        counted.map(|&id| graph.op(id).operands().len().saturating_sub(1)).sum()
    }

    /// Creates a kernel for inverse dynamics only: the forces and torques for given accelerations. Its locals are
    /// numbered from `next`. `None` if constraints are redundant, so that forces are not determined.
    pub fn from_inverse_dynamics(
        scene: &Scene,
        equations: &Equations,
        lowering: &mut Lowering,
        next: usize,
    ) -> Option<Self> {
        Builder::new(scene, lowering, next, false).inverse_dynamics(equations)
    }

    /// Binds the symbols of normal forces to values that are valid at any position, for plain functions. Returns the
    /// named intermediate values.
    pub fn bind_normal_forces(scene: &Scene, equations: &Equations, lowering: &mut Lowering) -> Vec<(String, Signed)> {
        if equations.normal_forces.is_empty() {
            return Vec::new();
        }
        Builder::new(scene, lowering, 0, true).bind_normal_forces(&KernelEquations::without_roots(equations))
    }

    /// All values.
    pub fn values(&self) -> impl Iterator<Item = &Signed> {
        let locals = self.locals.iter().flat_map(|local| [&local.value, &local.input]);
        let results = [&self.residuals, &self.growth_factors, &self.velocity_residual, &self.correction];
        let solution = [&self.accelerations, &self.multipliers, &self.outputs];
        let forces = self.forces.iter().map(|(_, force)| force);
        locals.chain(results.into_iter().chain(solution).flatten()).chain(forces)
    }

    /// All values, mutable.
    pub fn values_mut(&mut self) -> impl Iterator<Item = &mut Signed> {
        let locals = self.locals.iter_mut().flat_map(|local| [&mut local.value, &mut local.input]);
        let results =
            [&mut self.residuals, &mut self.growth_factors, &mut self.velocity_residual, &mut self.correction];
        let solution = [&mut self.accelerations, &mut self.multipliers, &mut self.outputs];
        let forces = self.forces.iter_mut().map(|(_, force)| force);
        locals.chain(results.into_iter().chain(solution).flatten()).chain(forces)
    }
}

/// The solved linear equations of a kernel.
struct Solved {
    growth_factors: Vec<Value>,
    accelerations: Vec<Value>,
    multipliers: Vec<Value>,
    correction: Vec<Value>,
}

impl Builder<'_> {
    /// The kernel by the null space or the range space of `C_q`.
    fn build(mut self, equations: &Equations, form: EliminationForm) -> Option<Kernel> {
        let e = &equations.kernel;
        let (n, m) = (self.scene.coordinates.len(), self.scene.constraints.len());
        let constraints: Vec<String> = self.scene.constraints.iter().map(|c| c.name.clone()).collect();
        self.names(&e.names);
        let residuals: Vec<Value> = (0..m)
            .map(|k| self.named(Block::Constraints, &format!("{}_residual", constraints[k]), &e.constraints[k]))
            .collect();
        let jacobian = self.jacobian(e);
        let own_rate = |k: usize| self.named(Block::Jacobian, &format!("{}_t", constraints[k]), &e.constraint_rate[k]);
        let own_rates: Vec<Value> = (0..m).map(own_rate).collect();
        let mass = self.mass_matrix(e);
        let null_space =
            (form == EliminationForm::NullSpace).then(|| NullSpace::new(&mut self, equations, &jacobian, &mass));

        self.named_rates(&e.names);
        let bias = (0..m).map(|k| {
            let name = format!("{}_bias", constraints[k]);
            self.named(Block::Bias, &name, &e.constraint_bias[k]).map(Signed::negated)
        });
        let bias: Vec<Value> = bias.collect();
        let forces = self.forces(&e.effort_groups);
        let solved = match &null_space {
            Some(null_space) => self.by_null_space(null_space, (&bias, &forces), &e.normal_forces),
            None => self.by_range_space((&jacobian, &mass), (&bias, &forces), &e.normal_forces)?,
        };
        let rates: Vec<Value> = (0..n).map(|i| Some(self.lowering.graph.input(Symbol::Rate(i)))).collect();
        let velocity_residual = jacobian.iter().zip(own_rates).map(|(row, own)| {
            let moved = self.dot(row, &rates);
            self.sum(moved.into_iter().chain(own).collect())
        });
        let velocity_residual: Vec<Value> = velocity_residual.collect();
        let outputs: Vec<Value> = e.outputs.iter().map(|output| self.value(output)).collect();
        let zero = self.lowering.graph.number(0.0);
        let all = |values: Vec<Value>| values.into_iter().map(|value| value.unwrap_or(zero)).collect();
        let mut kernel = Kernel {
            residuals: all(residuals),
            growth_factors: all(solved.growth_factors),
            velocity_residual: all(velocity_residual),
            correction: all(solved.correction),
            accelerations: all(solved.accelerations),
            multipliers: all(solved.multipliers),
            outputs: all(outputs),
            form,
            is_valid_everywhere: null_space.is_none_or(|null_space| null_space.is_valid_everywhere()),
            is_timed: self.scene.is_driven()
                || e.names.iter().any(|named| named.inside().any_symbol(&|symbol| symbol == Symbol::Time)),
            ..Kernel::default()
        };
        let needed = self.needed(&self.locals, kernel.values().map(|value| value.id).collect());
        kernel.locals = self.locals.into_iter().filter(|local| needed.contains(&local.input.id)).collect();
        Some(kernel)
    }

    /// The change of the constraints that a correction of the coordinates makes.
    fn required_change(&mut self) -> Vec<Value> {
        let m = self.scene.constraints.len();
        (0..m).map(|k| Some(self.lowering.graph.input(Symbol::Residual(k)).negated())).collect()
    }

    /// C_q
    fn jacobian(&mut self, e: &KernelEquations) -> Matrix {
        let scene = self.scene;
        let entry = |(k, i): (usize, usize)| {
            let name = format!("{}_{}", scene.constraints[k].name, scene.coordinates[i].name);
            self.named(Block::Jacobian, &name, &e.constraint_jacobian[k][i])
        };
        let n = scene.coordinates.len();
        let places = (0..scene.constraints.len()).flat_map(|k| (0..n).map(move |i| (k, i)));
        let entries: Vec<Value> = places.map(entry).collect();
        entries.chunks(n.max(1)).map(<[Value]>::to_vec).collect()
    }

    /// Mbar
    fn mass_matrix(&mut self, e: &KernelEquations) -> Matrix {
        let coordinates = &self.scene.coordinates;
        let n = coordinates.len();
        let mut mass: Matrix = vec![vec![None; n]; n];
        for i in 0..n {
            for j in 0..=i {
                let name = format!("mass_{}_{}", coordinates[j].name, coordinates[i].name);
                mass[i][j] = self.named(Block::Mass, &name, &e.mass_matrix[i][j]);
                mass[j][i] = mass[i][j];
            }
        }
        mass
    }

    /// Solves the linear equations by the null-space method, which first finds the motions that the loops allow.
    fn by_null_space(
        &mut self,
        null_space: &NullSpace,
        (closing, forces): (&[Value], &[Value]),
        normal_forces: &[NormalForce],
    ) -> Solved {
        let still = vec![None; self.scene.coordinates.len()];
        let particular = null_space.particular(self, closing, Block::Accelerations, "closing");
        let solve = |builder: &mut Self, forces: &[Value], unit: Option<&str>| {
            let (rest, what) = unit.map_or((&particular, "ddot".to_owned()), |name| (&still, format!("by_{name}")));
            let accelerations = null_space.free(builder, rest, Some(forces), Block::Accelerations, &what);
            let multipliers = null_space.multipliers(builder, forces, &accelerations);
            (accelerations, multipliers)
        };
        let (accelerations, multipliers) = self.with_friction(normal_forces, forces, &solve);
        let required = self.required_change();
        let particular = null_space.particular(self, &required, Block::Correction, "closing");
        let correction = null_space.free(self, &particular, None, Block::Correction, "correction");
        Solved { growth_factors: null_space.growth_factors(), accelerations, multipliers, correction }
    }

    /// Solves the linear equations by the range-space method, which first finds the forces of the loops.
    fn by_range_space(
        &mut self,
        (jacobian, mass): (&Matrix, &Matrix),
        (closing, forces): (&[Value], &[Value]),
        normal_forces: &[NormalForce],
    ) -> Option<Solved> {
        let system = RangeSpace::new(self, jacobian, mass)?;
        let still = vec![None; closing.len()];
        let solve = |builder: &mut Self, forces: &[Value], unit: Option<&str>| {
            system.accelerations(builder, if unit.is_some() { &still } else { closing }, forces)
        };
        let (accelerations, multipliers) = self.with_friction(normal_forces, forces, &solve);
        let required = self.required_change();
        let correction = system.correction(self, &required);
        Some(Solved { growth_factors: system.growth_factors(), accelerations, multipliers, correction })
    }

    /// The reduced forces, each effort in the form with fewer operations.
    fn forces(&mut self, effort_groups: &[EffortGroup]) -> Vec<Value> {
        let coordinates: Vec<String> = self.scene.coordinates.iter().map(|c| c.name.clone()).collect();
        let mut parts: Vec<Vec<Signed>> = vec![Vec::new(); coordinates.len()];
        let all: Vec<usize> = (0..coordinates.len()).collect();
        for group in effort_groups {
            self.add_efforts(&group.efforts, &group.total, &all, &mut parts);
        }
        let force = |(part, name): (Vec<Signed>, &String)| {
            let sum = self.sum(part);
            self.keep(Block::Forces, &format!("force_{name}"), sum)
        };
        parts.into_iter().zip(&coordinates).map(force).collect()
    }

    /// Adds efforts to the forces in these places, in the form with fewer operations: the sizes times the derivatives
    /// of the displacements, or their total.
    fn add_efforts(
        &mut self,
        efforts: &[(String, Term, Vec<Term>)],
        total: &[Term],
        places: &[usize],
        forces: &mut [Vec<Signed>],
    ) {
        let together: Vec<Value> = total.iter().map(|term| self.value(term)).collect();
        let apart: Vec<(Value, Vec<Value>)> = efforts
            .iter()
            .map(|(_, size, along)| (self.value(size), along.iter().map(|entry| self.value(entry)).collect()))
            .collect();
        let entries = apart.iter().flat_map(|(_, along)| along.iter().flatten()).count();
        let apart_cost = self.cost(apart.iter().map(|(size, _)| *size)) + 2 * entries - entries.min(places.len());
        if efforts.is_empty() || self.cost(together.iter().copied()) <= apart_cost {
            for (place, force) in places.iter().zip(together) {
                forces[*place].extend(force);
            }
            return;
        }
        for ((name, ..), (size, along)) in efforts.iter().zip(apart) {
            let size = self.keep(Block::Forces, &format!("load_{name}"), size);
            for (place, entry) in places.iter().zip(along) {
                forces[*place].extend(self.multiply(entry, size));
            }
        }
    }

    /// All values that `pending` depends on, also through names.
    fn needed(&self, locals: &[Local], pending: Vec<Id>) -> HashSet<Id> {
        needed(&self.lowering.graph, locals, pending)
    }

    /// The value of a term, with a name unless it needs no computation.
    fn named(&mut self, block: Block, name: &str, term: &Term) -> Value {
        let value = self.value(term);
        self.keep(block, name, value)
    }
}

/// All values of a graph that `pending` depends on, also through the names of locals.
fn needed(graph: &Graph, locals: &[Local], mut pending: Vec<Id>) -> HashSet<Id> {
    let definitions: HashMap<Id, Id> = locals.iter().map(|local| (local.input.id, local.value.id)).collect();
    let mut needed = HashSet::new();
    while let Some(id) = pending.pop() {
        if needed.insert(id) {
            pending.extend(graph.op(id).operands());
            pending.extend(definitions.get(&id));
        }
    }
    needed
}
