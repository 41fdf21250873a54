//! The functions of a scene in a shared graph.

use std::collections::HashSet;

use super::plan::{Plan, plans};
use crate::graph::{Graph, Id, Op, Signed};
use crate::kernel::{Choice, ImpossibleForm, Kernel};
use crate::lower::Lowering;
use crate::share::share_pairs;
use crate::term::{Equations, Named, Symbol, Term};
use qrm_scene::scene::{EliminationForm, Scene};

/// The functions of a scene in a shared graph.
#[derive(Debug)]
pub(super) struct Layout {
    pub(super) graph: Graph,
    pub(super) plans: Vec<Plan<Signed>>,
    /// Named values: coordinates of points, and sines and cosines of sums of coordinates.
    pub(super) named_values: Vec<(String, Signed)>,
    /// Other named quantities and their derivatives.
    pub(super) names: Vec<(String, Signed)>,
    pub(super) kernel: Kernel,
    /// The forms of the elimination that were counted, with their operations before pairs are shared.
    pub(super) forms: Vec<(EliminationForm, usize)>,
    /// The inverse dynamics, if the scene requests them.
    pub(super) inverse: Option<Kernel>,
}

impl Layout {
    /// The functions, with a kernel of this form or of the cheapest one.
    pub(super) fn new(
        scene: &Scene,
        equations: &Equations,
        form: Option<EliminationForm>,
    ) -> Result<Self, ImpossibleForm> {
        let plans = plans(scene, equations);
        let mut lowering = Lowering::default();
        lowering.define(&equations.names);
        Kernel::bind_dynamics(scene, equations, &mut lowering);
        let of_friction = Kernel::bind_normal_forces(scene, equations, &mut lowering);
        let mut roots = Vec::new();
        let mut place = |term: &&Term| {
            roots.push(lowering.term(term));
            roots.len() - 1
        };
        let lowered: Vec<Plan<usize>> = plans.iter().map(|plan| plan.map(&mut place)).collect();
        let point_place = roots.len();
        for term in equations.points.iter().flatten() {
            roots.push(lowering.term(term));
        }
        let name_place = roots.len();
        let quantities = equations.names.iter().enumerate();
        let symbols = quantities.flat_map(|(k, named)| named.definitions(k).into_iter().map(move |(s, _)| (named, s)));
        let symbols: Vec<(&Named, Symbol)> = symbols.collect();
        roots.extend(symbols.iter().map(|(_, symbol)| lowering.bound[symbol]));
        roots.extend(of_friction.iter().map(|(_, value)| *value));
        let Choice { mut kernel, forms } = Choice::new(scene, equations, &mut lowering, form)?;
        let angle_sums = lowering.angle_sums(|i| scene.coordinates[i].name.to_lowercase());
        let point_names = scene.points.iter().flat_map(|point| ["x", "y"].map(|axis| format!("{}_{axis}", point.name)));
        let point_names: Vec<String> = point_names.map(|name| name.to_lowercase()).collect();
        let mut own_names = angle_sums;
        if !own_names.is_empty() {
            // Points that depend on such sums have other values than in the plain functions.
            lowering = Lowering::from_kernel(lowering.graph);
            lowering.define(&equations.names);
            let points = equations.points.iter().flatten().map(|term| lowering.term(term));
            own_names.splice(0..0, point_names.iter().cloned().zip(points));
        }
        let (mut graph, roots) = share_pairs(&lowering.graph, &roots);
        // The kernel and the plain functions are optimized separately.
        let kernel_roots: Vec<Signed> = kernel.values().copied().collect();
        let (step, outputs) = kernel_roots.split_at(kernel_roots.len() - kernel.outputs.len());
        let (mut shared, mut named) = (Vec::new(), Vec::new());
        for part in [step, outputs] {
            // Pairs must not be shared across named values.
            let reachable: HashSet<Id> =
                lowering.graph.reachable(part.iter().map(|root| root.id)).into_iter().collect();
            let kept: Vec<&(String, Signed)> =
                own_names.iter().filter(|(_, value)| reachable.contains(&value.id)).collect();
            let roots: Vec<Signed> = part.iter().copied().chain(kept.iter().map(|(_, value)| *value)).collect();
            let (own, roots) = share_pairs(&lowering.graph, &roots);
            let places = graph.absorb(&own);
            let mut roots = roots.into_iter().map(|root| Signed { id: places[root.id], ..root });
            shared.extend(roots.by_ref().take(part.len()));
            named.extend(kept.iter().map(|(name, _)| name.clone()).zip(roots));
        }
        kernel.values_mut().zip(shared).for_each(|(value, place)| *value = place);
        let inverse = if scene.run.inverse { inverse_dynamics(scene, equations, &mut graph) } else { None };
        let plans = lowered.iter().map(|plan| plan.map(&mut |&i| roots[i])).collect();
        let names = symbols.iter().map(|(named, symbol)| named.symbol_name(*symbol, scene).to_lowercase());
        let names = names.chain(of_friction.into_iter().map(|(name, _)| name));
        let names = names.zip(roots[name_place..].iter().copied()).collect();
        let named_values =
            point_names.into_iter().zip(roots[point_place..name_place].iter().copied()).chain(named).collect();
        Ok(Self { graph, plans, named_values, names, kernel, forms, inverse })
    }
}

/// Creates the inverse dynamics of a scene, in a graph that already contains other functions.
fn inverse_dynamics(scene: &Scene, equations: &Equations, graph: &mut Graph) -> Option<Kernel> {
    let mut lowering = Lowering::from_kernel(Graph::default());
    let local = |op: &Op| if let Op::Input(Symbol::Local(number)) = op { Some(number + 1) } else { None };
    let next = graph.ops().iter().filter_map(local).max().unwrap_or(0);
    let mut kernel = Kernel::from_inverse_dynamics(scene, equations, &mut lowering, next)?;
    let roots: Vec<Signed> = kernel.values().copied().collect();
    let (own, roots) = share_pairs(&lowering.graph, &roots);
    let places = graph.absorb(&own);
    for (value, root) in kernel.values_mut().zip(roots) {
        *value = Signed { id: places[root.id], ..root };
    }
    Some(kernel)
}
