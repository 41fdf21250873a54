//! Numbers at the nodes of the Gauss method, in vectors, and their products with matrices.

use super::GAUSS_NODES;
use super::coefficients::{BARYCENTRIC, Column, Columns, NODES};
use crate::lanes::{Lanes, Token};
use crate::scalar::Scalar;

/// Numbers at all nodes; one vector of eight lanes, or two of four.
pub(super) type AtNodes<S> = [Lanes<S>; 2];

/// The vectors of numbers at all nodes.
#[inline(always)]
pub(super) const fn groups<S: Token>() -> usize {
    GAUSS_NODES / S::F64_LANES
}

#[inline(always)]
pub(super) fn column<S: Token>(column: &Column) -> AtNodes<S> {
    let mut at = [Lanes::zero(); 2];
    for g in 0..groups::<S>() {
        at[g] = Lanes::load(&column[g * S::F64_LANES..]);
    }
    at
}

/// The product of a matrix and the numbers at the nodes.
#[inline(always)]
pub(super) fn sums<S: Token>(columns: &Columns, values: &AtNodes<S>) -> AtNodes<S> {
    let mut vectors = [[Lanes::zero(); 2]; GAUSS_NODES];
    for j in 0..GAUSS_NODES {
        vectors[j] = column(&columns.0[j]);
    }
    sums_by(&vectors, values)
}

/// The product of a matrix, whose columns are vectors, and the numbers at the nodes.
#[inline(always)]
pub(super) fn sums_by<S: Token>(columns: &[AtNodes<S>; GAUSS_NODES], values: &AtNodes<S>) -> AtNodes<S> {
    let mut sums = [Lanes::zero(); 2];
    for g in 0..groups::<S>() {
        // Two independent sums shorten the chain of dependent products.
        let mut parts = [Lanes::zero(); 2];
        for j in 0..GAUSS_NODES {
            let value = Lanes::from_f64(values[j / S::F64_LANES].get(j % S::F64_LANES));
            parts[j % 2] = columns[j][g].mul_add(value, parts[j % 2]);
        }
        sums[g] = parts[0] + parts[1];
    }
    sums
}

/// The Lagrange polynomials of the nodes, one after another, at the nodes of another step. That step begins at the
/// fraction `part` of this one and is `ratio` times as long.
#[inline(always)]
pub(super) fn lagrange_polynomials<S: Token>(part: f64, ratio: f64) -> [AtNodes<S>; GAUSS_NODES] {
    let nodes = column::<S>(&NODES);
    let mut polynomials = [[Lanes::zero(); 2]; GAUSS_NODES];
    for g in 0..groups::<S>() {
        let at = nodes[g].mul_add(Lanes::from_f64(ratio), Lanes::from_f64(part));
        // Products of the distances from the nodes before each node, then from those after it.
        let mut product = Lanes::from_f64(1.0);
        for j in 0..GAUSS_NODES {
            polynomials[j][g] = product * Lanes::from_f64(BARYCENTRIC[j]);
            product = product * (at - Lanes::from_f64(NODES[j]));
        }
        let mut product = Lanes::from_f64(1.0);
        for j in 0..GAUSS_NODES {
            let j = GAUSS_NODES - 1 - j;
            polynomials[j][g] = polynomials[j][g] * product;
            product = product * (at - Lanes::from_f64(NODES[j]));
        }
    }
    polynomials
}

/// The largest lane.
#[inline(always)]
pub(super) fn largest<S: Token>(lanes: Lanes<S>) -> f64 {
    let mut largest = lanes.get(0);
    for i in 1..S::F64_LANES {
        largest = Scalar::max(lanes.get(i), largest);
    }
    largest
}
