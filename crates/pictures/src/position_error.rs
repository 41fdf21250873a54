//! The distance of a mechanism's point from a target.

use num_dual::Dual2_64;
use qrm_scene::evaluate::State;
use qrm_scene::scene::Scene;
use qrm_sim::analysis::PositionError;

/// The position of a weighted mean of points minus that of a target. Points are given by their indices in the scene.
pub fn position_error(
    scene: &Scene,
    parameters: &[f64],
    q: &[f64],
    points: &[(usize, f64)],
    target: [f64; 2],
) -> PositionError {
    let zero = Dual2_64::from(0.0);
    let by = |coordinate: usize| -> [Dual2_64; 2] {
        let moved = |(i, value): (usize, &f64)| Dual2_64::new(*value, f64::from(u8::from(i == coordinate)), 0.0);
        let q: Vec<Dual2_64> = q.iter().enumerate().map(moved).collect();
        let state = State::new(scene, parameters, zero, q.clone(), vec![zero; q.len()]);
        let mean = |axis: usize| points.iter().map(|(point, weight)| state.point(*point)[axis] * *weight).sum();
        [mean(0), mean(1)]
    };
    let derivatives: Vec<[Dual2_64; 2]> = (0..q.len()).map(by).collect();
    let [x, y] = derivatives.first().map_or([0.0; 2], |mean| mean.map(|component| component.re));
    PositionError {
        components: [x - target[0], y - target[1]],
        jacobian: [0, 1].map(|axis| derivatives.iter().map(|mean| mean[axis].v1).collect()),
    }
}
