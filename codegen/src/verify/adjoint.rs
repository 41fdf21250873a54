//! Weighted sums of derivatives with respect to all coordinates, by automatic differentiation backwards.

use num_dual::Dual;

use qrm_scene::evaluate::{State, evaluate_node};
use qrm_scene::expression::Node;
use qrm_scene::function::Differentiable;
use qrm_scene::scene::{Quantity, Scene, Value as Formula};

/// The sums of weights times derivatives of formulae, with respect to coordinates and points.
pub(super) struct Adjoint<'s, B> {
    scene: &'s Scene,
    state: &'s State<B>,
    /// Whether the absolute values of all terms are added, to which rounding errors are relative.
    takes_sizes: bool,
    by_coordinates: Vec<B>,
    by_points: Vec<[B; 2]>,
}

impl<'s, B: Differentiable> Adjoint<'s, B> {
    /// Begins with sums of zero.
    pub(super) fn new(scene: &'s Scene, state: &'s State<B>, takes_sizes: bool) -> Self {
        let zero = B::from(0.0);
        let (by_coordinates, by_points) = (vec![zero; scene.coordinates.len()], vec![[zero; 2]; scene.points.len()]);
        Self { scene, state, takes_sizes, by_coordinates, by_points }
    }

    /// Adds the derivatives of a formula, multiplied by a weight.
    pub(super) fn add(&mut self, formula: &Formula, weight: B) {
        let zero = B::from(0.0);
        if weight.is_zero() {
            return;
        }
        let nodes = formula.nodes();
        let mut values: Vec<Dual<B>> = Vec::with_capacity(nodes.len());
        for node in nodes {
            values.push(evaluate_node(node, &values, &mut |name| Dual::new(self.state.quantity(*name), zero)));
        }
        let mut weights = vec![zero; nodes.len()];
        weights[nodes.len() - 1] = if self.takes_sizes { weight.abs() } else { weight };
        for (place, node) in nodes.iter().enumerate().rev() {
            let weight = weights[place];
            if weight.is_zero() {
                continue;
            }
            match node {
                Node::Name(Quantity::Coordinate(i)) => self.by_coordinates[*i] += weight,
                Node::Name(Quantity::Point(point, axis)) => self.by_points[*point][*axis] += weight,
                _ => {}
            }
            let mut operands = node.operands();
            operands.sort_unstable();
            operands.dedup();
            for operand in operands {
                values[operand].eps = B::from(1.0);
                let slope = evaluate_node(node, &values, &mut |_| Dual::from(f64::NAN)).eps;
                values[operand].eps = zero;
                weights[operand] += weight * if self.takes_sizes { slope.abs() } else { slope };
            }
        }
    }

    /// The sums with respect to the coordinates: those with respect to points go on to the formulae of the points.
    pub(super) fn sums(mut self) -> Vec<B> {
        for (point, own) in self.scene.points.iter().enumerate().rev() {
            for axis in 0..2 {
                self.add(&own.position[axis], self.by_points[point][axis]);
            }
        }
        self.by_coordinates
    }
}
