//! Normal forces of friction at a state, computed directly from the scene.

use super::equations::EquationsOfMotion;
use super::gradients::Gradients;
use super::sample::Sample;
use super::system::System;
use qrm_scene::evaluate::State;
use qrm_scene::function::Differentiable;
use qrm_scene::scene::{OutputKind, Scene, Value as Formula};

/// The largest number of iterations to double precision: a contraction by 0.95 needs as many.
const ITERATIONS: usize = 800;

impl<B: Differentiable> Sample<B> {
    /// Adds the normal forces for the sample's accelerations and multipliers.
    pub(super) fn with_given_forces(&self, scene: &Scene) -> Self {
        let normals = scene.normal_forces();
        let mut sample = self.clone();
        // No cycles: no normal force contains another one that contains it.
        for _ in &normals {
            let sizes: Vec<B> = components(&sample, scene, &normals).iter().map(|force| size(force)).collect();
            sample.set_normal_forces(&normals, &sizes);
        }
        sample
    }

    /// Adds the normal forces of the motion at the sample's coordinates and rates. They are not numbers if there may be
    /// no solution or several, or if the equations of motion are singular.
    pub(super) fn with_forces_of_motion(&self, scene: &Scene, rows: &[(&Formula, B)]) -> Self {
        let normals = scene.normal_forces();
        if normals.is_empty() {
            return self.clone();
        }
        let sizes = self.forces_of_motion(scene, rows, &normals);
        let mut sample = self.clone();
        sample.set_normal_forces(&normals, &sizes.unwrap_or_else(|| vec![B::from(f64::NAN); normals.len()]));
        sample
    }

    fn forces_of_motion(&self, scene: &Scene, rows: &[(&Formula, B)], normals: &[usize]) -> Option<Vec<B>> {
        let (zero, one) = (B::from(0.0), B::from(1.0));
        // The normal forces depend linearly on those in the friction: evaluated for zero, and for a unit of each.
        let at = |unit: Option<usize>| -> Option<Vec<Vec<B>>> {
            let mut sample = self.clone();
            let given: Vec<B> = (0..normals.len()).map(|k| if Some(k) == unit { one } else { zero }).collect();
            sample.set_normal_forces(normals, &given);
            let gradients = Gradients::new(&sample, scene);
            let plain = State::plain(scene, &sample.parameters, sample.t, &sample.q, &sample.qd);
            let found = EquationsOfMotion::new(&sample, rows, &gradients, &plain);
            let closing: Vec<B> = found.residuals.iter().map(|residual| -residual.v2).collect();
            let n = sample.q.len();
            let (solution, _) =
                System::new(&found.mass_matrix(rows), &found.constraint_jacobian, n).solve(&found.forces, &closing)?;
            (sample.qdd, sample.multipliers) = (solution[..n].to_vec(), solution[n..].to_vec());
            Some(components(&sample, scene, normals))
        };
        let rest = at(None)?;
        let units = (0..normals.len()).map(|k| at(Some(k))).collect::<Option<Vec<_>>>()?;
        let by = |k: usize, j: usize| -> Vec<B> {
            units[j][k].iter().zip(&rest[k]).map(|(with, without)| *with - *without).collect()
        };
        let by: Vec<Vec<Vec<B>>> = (0..normals.len()).map(|k| (0..normals.len()).map(|j| by(k, j)).collect()).collect();
        if !is_contraction(&by) {
            return None;
        }
        let next = |sizes: &[B]| -> Vec<B> {
            let component =
                |k: usize, c: usize| sizes.iter().zip(&by[k]).fold(rest[k][c], |sum, (n, by)| sum + *n * by[c]);
            let force = |k: usize| (0..rest[k].len()).map(|c| component(k, c)).collect::<Vec<B>>();
            (0..normals.len()).map(|k| size(&force(k))).collect()
        };
        let mut sizes: Vec<B> = rest.iter().map(|force| size(force)).collect();
        for count in 1..ITERATIONS {
            let last = sizes.clone();
            sizes = next(&last);
            if sizes.iter().zip(&last).all(|(size, last)| size.re() == last.re()) {
                // The digits beyond double precision need as many iterations again.
                (0..count + 10).for_each(|_| sizes = next(&sizes));
                return Some(sizes);
            }
        }
        None
    }

    fn set_normal_forces(&mut self, normals: &[usize], sizes: &[B]) {
        for (k, size) in normals.iter().zip(sizes) {
            self.normal_forces[*k] = *size;
        }
    }
}

/// The components of the normal forces for a sample's accelerations, multipliers and normal forces.
fn components<B: Differentiable>(sample: &Sample<B>, scene: &Scene, normals: &[usize]) -> Vec<Vec<B>> {
    let outputs = sample.outputs_in_si(&Gradients::new(sample, scene));
    let of = |k: usize| match &scene.outputs[k].kind {
        OutputKind::Norm { components, .. } => components.map(|i| outputs[i]).to_vec(),
        _ => vec![outputs[k]],
    };
    normals.iter().map(|&k| of(k)).collect()
}

fn size<B: Differentiable>(force: &[B]) -> B {
    match force {
        [single] => single.abs(),
        _ => force.iter().map(|component| *component * *component).sum::<B>().sqrt(),
    }
}

/// Whether the matrix of absolute values has a spectral radius below one: all pivots of the identity minus the matrix
/// are then positive.
fn is_contraction<B: Differentiable>(by: &[Vec<Vec<B>>]) -> bool {
    let count = by.len();
    let mut rows: Vec<Vec<f64>> = by.iter().map(|row| row.iter().map(|force| -size(force).re()).collect()).collect();
    (0..count).for_each(|k| rows[k][k] += 1.0);
    (0..count).all(|k| {
        for i in k + 1..count {
            let ratio = rows[i][k] / rows[k][k];
            (k..count).for_each(|j| rows[i][j] -= ratio * rows[k][j]);
        }
        rows[k][k] > 0.0
    })
}
