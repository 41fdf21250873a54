//! Normal forces of friction as functions of accelerations, multipliers and each other.

use std::collections::HashMap;

use symbolica::atom::{Atom, AtomCore};

use super::system::{System, norm};
use qrm_codegen::term::{AffineForce, NormalForce, Symbol, Term};
use qrm_scene::function::Function;
use qrm_scene::scene::{OutputKind, Scene};

/// The normal forces of a scene, in the order of their outputs.
pub(super) fn normal_forces(system: &System, outputs: &[Atom]) -> Vec<NormalForce> {
    let (algebra, scene) = (&system.algebra, system.algebra.scene);
    let normals = scene.normal_forces();
    let affine = |component: usize| {
        let force = &outputs[component];
        let by = |symbol: Symbol| algebra.simple_term(&algebra.derivative(force, symbol));
        let zero = |atom: Atom, symbol: Symbol| {
            atom.replace(algebra.symbol(symbol).to_pattern()).with(Atom::num(0).to_pattern())
        };
        let accelerations = (0..scene.coordinates.len()).map(Symbol::Acceleration);
        let multipliers = (0..scene.constraints.len()).map(Symbol::Multiplier);
        let own = normals.iter().map(|&k| Symbol::NormalForce(k));
        let all = accelerations.clone().chain(multipliers.clone()).chain(own.clone());
        AffineForce {
            rest: algebra.simple_term(&all.fold(force.clone(), zero)),
            by_accelerations: accelerations.map(by).collect(),
            by_multipliers: multipliers.map(by).collect(),
            by_normal_forces: own.map(by).collect(),
        }
    };
    let normal_force = |&k: &usize| {
        let efforts = system.loads.efforts.iter().filter(|effort| effort.normal == Some(k));
        let friction = |i: usize| {
            let along = efforts.clone().fold(Atom::num(0), |sum, effort| sum + &effort.size * &effort.along[i]);
            algebra.simple_term(&algebra.derivative(&along, Symbol::NormalForce(k)))
        };
        NormalForce {
            output: k,
            name: scene.outputs[k].name.clone(),
            components: components(scene, k).into_iter().map(affine).collect(),
            friction: (0..scene.coordinates.len()).map(friction).collect(),
        }
    };
    normals.iter().map(normal_force).collect()
}

/// The outputs that are the components of a normal force: two for a norm, otherwise the output itself.
fn components(scene: &Scene, output: usize) -> Vec<usize> {
    match scene.outputs[output].kind {
        OutputKind::Norm { components, .. } => components.to_vec(),
        _ => vec![output],
    }
}

/// The output on whose size friction depends although it contains that friction.
pub(super) struct Circular(pub(super) usize);

/// The sizes of normal forces in terms of accelerations and multipliers alone.
pub(super) struct Sizes(HashMap<usize, Term>);

impl Sizes {
    /// Finds the sizes of all normal forces from the terms of the outputs.
    ///
    /// # Panics
    /// With a [`Circular`], if a normal force contains friction that depends on it, for given accelerations and
    /// multipliers.
    pub(super) fn new(scene: &Scene, outputs: &[Term]) -> Self {
        let mut sizes = Self(HashMap::new());
        let mut open = scene.normal_forces();
        while !open.is_empty() {
            let before = open.len();
            open.retain(|&k| !sizes.add(scene, outputs, k));
            if open.len() == before {
                std::panic::panic_any(Circular(open[0]));
            }
        }
        sizes
    }

    /// Replaces the symbols of normal forces in a term.
    pub(super) fn insert(&self, term: &Term) -> Term {
        if self.0.is_empty() {
            return term.clone();
        }
        term.replacing(&|symbol| if let Symbol::NormalForce(k) = symbol { self.0.get(&k).cloned() } else { None })
    }

    /// Adds the size of a normal force; returns false if it depends on unknown ones.
    fn add(&mut self, scene: &Scene, outputs: &[Term], k: usize) -> bool {
        let parts: Vec<&Term> = components(scene, k).into_iter().map(|i| &outputs[i]).collect();
        let is_open = |symbol| matches!(symbol, Symbol::NormalForce(j) if !self.0.contains_key(&j));
        if parts.iter().any(|part| part.any_symbol(&is_open)) {
            return false;
        }
        let parts: Vec<Term> = parts.into_iter().map(|part| self.insert(part)).collect();
        let size = match &parts[..] {
            [x, y] => norm([x, y]),
            parts => Term::Call(Function::Abs, Box::new(parts[0].clone())),
        };
        self.0.insert(k, size);
        true
    }
}
