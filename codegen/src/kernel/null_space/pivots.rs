//! The choice of the dependent coordinates.

use std::collections::HashMap;

use crate::graph::Op;
use crate::kernel::algebra::Matrix;
use crate::kernel::builder::Builder;
use crate::term::{Equations, Symbol, Term};
use qrm_scene::evaluate::{constant, parameter_values};
use qrm_scene::scene::Start;

/// The smallest ratio of a pivot to the largest entry of its row.
const SMALL: f64 = 0.05;

/// The constraint and coordinate of each pivot. Pivots are large enough at the scene's start, preferably avoid
/// coordinates given there, and are ordered to preserve most zeros.
pub(super) fn pivots(builder: &Builder, equations: &Equations, jacobian: &Matrix) -> Vec<(usize, usize)> {
    let scene = builder.scene;
    let parameters = parameter_values(scene, |_| None);
    let start = |i: usize| match &scene.coordinates[i].position {
        Start::Given(value) | Start::Guess(value) => constant(value, &parameters),
        Start::Free => 0.0,
    };
    let mut named: HashMap<Symbol, f64> = HashMap::new();
    let value = |term: &Term, named: &HashMap<Symbol, f64>| {
        term.evaluate(&|symbol: Symbol| match symbol {
            Symbol::Parameter(i) => parameters[i],
            Symbol::Pi => std::f64::consts::PI,
            Symbol::Coordinate(i) => start(i),
            symbol => named.get(&symbol).copied().unwrap_or(0.0),
        })
    };
    for (symbol, term) in equations.names.iter().enumerate().flat_map(|(k, quantity)| quantity.definitions(k)) {
        let value = value(&term, &named);
        named.insert(symbol, value);
    }
    let mut size: Vec<Vec<f64>> = equations
        .constraint_jacobian
        .iter()
        .map(|row| row.iter().map(|entry| value(entry, &named)).collect())
        .collect();
    let mut filled: Vec<Vec<bool>> = jacobian
        .iter()
        .map(|row| {
            row.iter().map(|entry| entry.is_some_and(|v| *builder.lowering.graph.op(v.id) != Op::Number(0))).collect()
        })
        .collect();
    let is_given = |i: usize| matches!(scene.coordinates[i].position, Start::Given(_));
    let (mut rows, mut columns): (Vec<usize>, Vec<usize>) =
        ((0..jacobian.len()).collect(), (0..scene.coordinates.len()).collect());
    let mut pivots = Vec::new();
    while !rows.is_empty() {
        let rank = |&(r, c): &(usize, usize)| {
            let largest = columns.iter().filter(|&&j| filled[r][j]).map(|&j| size[r][j].abs()).fold(0.0, f64::max);
            let is_small = !(size[r][c].abs() >= SMALL * largest && size[r][c] != 0.0);
            let others = |count: usize| count.saturating_sub(1);
            let in_row = others(columns.iter().filter(|&&j| filled[r][j] && !is_given(j)).count());
            let in_column = others(rows.iter().filter(|&&i| filled[i][c]).count());
            (is_given(c), is_small, in_row * in_column, in_row + in_column, r, c)
        };
        let candidates = rows.iter().flat_map(|&r| columns.iter().map(move |&c| (r, c)));
        let Some((r, c)) = candidates.filter(|&(r, c)| filled[r][c]).min_by_key(rank) else { break };
        pivots.push((r, c));
        rows.retain(|&row| row != r);
        columns.retain(|&column| column != c);
        for &i in &rows {
            if filled[i][c] {
                let ratio = size[i][c] / size[r][c];
                for &j in &columns {
                    size[i][j] -= if ratio.is_finite() { ratio * size[r][j] } else { 0.0 };
                    filled[i][j] |= filled[r][j];
                }
            }
        }
    }
    pivots
}
