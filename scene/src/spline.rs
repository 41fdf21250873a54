//! Cubic splines through points.

use std::hash::{Hash, Hasher};

use crate::diagnostic::Span;
use crate::expression::{Expression, Node, NodeId, Number};
use crate::function::{Differentiable, Function};

/// A cubic spline: its pieces are polynomials of degree three in the distance from their bases, and it has two continuous
/// derivatives. All its numbers are doubles, and so are the differences of bases and of coefficients of one degree.
#[derive(Clone, Debug)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Spline {
    /// Its name in formulae.
    pub name: String,
    /// Its period; `None` where it goes on as a straight line beyond its ends.
    period: Option<f64>,
    /// Where it begins.
    first: f64,
    /// Where the second piece and each one after it begin.
    steps: Vec<f64>,
    /// The bases of the pieces.
    bases: Vec<f64>,
    /// The coefficients of each piece, that of the constant first.
    pieces: Vec<[f64; 4]>,
}

impl Spline {
    /// The periodic spline through four points or more, whose last ordinate is the first one: it repeats from the last
    /// abscissa on.
    pub fn periodic(name: &str, x: &[f64], y: &[f64]) -> Self {
        let slopes = periodic_slopes(x, y);
        let count = x.len() - 1;
        let spline = Self {
            name: name.to_owned(),
            period: Some(x[count] - x[0]),
            first: x[0],
            steps: x[1..count].to_vec(),
            bases: x[..count].to_vec(),
            pieces: (0..count).map(|i| piece(x, y, &slopes, i)).collect(),
        };
        spline.rounded()
    }

    /// The natural spline through points, without curvature at its ends and straight beyond them.
    pub fn natural(name: &str, x: &[f64], y: &[f64]) -> Self {
        let slopes = natural_slopes(x, y);
        let last = x.len() - 1;
        let inner = (0..last).map(|i| piece(x, y, &slopes, i));
        let line = |i: usize| [y[i], slopes[i], 0.0, 0.0];
        let spline = Self {
            name: name.to_owned(),
            period: None,
            first: x[0],
            steps: x.to_vec(),
            bases: std::iter::once(x[0]).chain(x.iter().copied()).collect(),
            pieces: std::iter::once(line(0)).chain(inner).chain([line(last)]).collect(),
        };
        spline.rounded()
    }

    /// The spline with bases and coefficients that have their last digit in common.
    fn rounded(mut self) -> Self {
        let grid = |values: &mut dyn Iterator<Item = f64>| -> f64 {
            let largest = values.fold(0.0, |most: f64, value| most.max(value.abs()));
            // Adding it leaves 51 digits of the largest value, so that a difference has no more than 53.
            if largest > 0.0 { 1.5 * 2.0_f64.powi(largest.log2().floor() as i32 + 2) } else { 0.0 }
        };
        let of_bases = grid(&mut self.bases.iter().copied());
        let of_pieces: [f64; 4] = std::array::from_fn(|k| grid(&mut self.pieces.iter().map(|piece| piece[k])));
        self.bases.iter_mut().for_each(|base| *base = (*base + of_bases) - of_bases);
        for piece in &mut self.pieces {
            piece.iter_mut().zip(of_pieces).for_each(|(c, grid)| *c = (*c + grid) - grid);
        }
        self
    }

    /// The value of its derivative of an order; the value itself where that is zero.
    pub fn value<D: Differentiable>(&self, order: usize, x: D) -> D {
        let x = self.period.map_or(x, |period| {
            let turns = ((x.re() - self.first) / period).floor();
            x - D::from(period) * D::from(turns)
        });
        let piece = self.steps.partition_point(|step| *step <= x.re());
        let distance = x - D::from(self.bases[piece]);
        let coefficients = derived(self.pieces[piece], order);
        coefficients.iter().rev().fold(D::from(0.0), |sum, c| sum * distance + D::from(*c))
    }

    /// The shortest distance between points.
    pub fn shortest(&self) -> f64 {
        let from = std::iter::once(&self.first).chain(&self.steps);
        let between = from.zip(&self.steps).map(|(from, to)| to - from).filter(|length| *length > 0.0);
        between.fold(f64::INFINITY, f64::min)
    }

    /// Appends the derivative of an order at an argument, in functions that step from piece to piece.
    ///
    /// With steps `H` of the height one, base and coefficients are sums such as `c_0 + sum (c_i - c_(i-1)) H(x - x_i)`.
    pub fn append<N>(&self, order: usize, formula: &mut Expression<N>, argument: NodeId, span: &Span) -> NodeId {
        let mut writer = Writer { formula, span };
        let (x, inside, reach) = match self.period {
            Some(period) => {
                let (first, length) = (writer.number(self.first), writer.number(period));
                let from_first = writer.push(Node::Subtract(argument, first));
                let turns = writer.push(Node::Divide(from_first, length));
                let turns = writer.call(Function::Floor, vec![turns]);
                let back = writer.push(Node::Multiply(length, turns));
                let x = writer.push(Node::Subtract(argument, back));
                (x, x, period)
            }
            None => {
                let last = self.steps[self.steps.len() - 1];
                let length = last - self.first;
                let ends = [self.first - length, last + length].map(|end| writer.number(end));
                let inside = writer.call(Function::Max, vec![argument, ends[0]]);
                let inside = writer.call(Function::Min, vec![inside, ends[1]]);
                (argument, inside, 4.0 * length)
            }
        };
        let steps: Vec<NodeId> = self.steps.iter().map(|step| writer.step(inside, *step, reach)).collect();
        let base = writer.stepped(&self.bases, &steps);
        let distance = writer.push(Node::Subtract(x, base));
        let pieces: Vec<[f64; 4]> = self.pieces.iter().map(|piece| derived(*piece, order)).collect();
        let coefficient = |writer: &mut Writer<N>, k: usize| {
            writer.stepped(&pieces.iter().map(|p| p[k]).collect::<Vec<f64>>(), &steps)
        };
        let degree = 3 - order.min(3);
        let mut sum = coefficient(&mut writer, degree);
        for k in (0..degree).rev() {
            let product = writer.push(Node::Multiply(sum, distance));
            let own = coefficient(&mut writer, k);
            sum = writer.push(Node::Add(product, own));
        }
        sum
    }

    /// All that tells it from another one.
    fn bits(&self) -> impl Iterator<Item = u64> {
        let ends = [self.period.unwrap_or(0.0), self.first].into_iter();
        ends.chain(self.steps.iter().copied()).chain(self.pieces.iter().flatten().copied()).map(f64::to_bits)
    }
}

impl PartialEq for Spline {
    fn eq(&self, other: &Self) -> bool {
        self.name == other.name && self.bits().eq(other.bits())
    }
}

impl Eq for Spline {}

impl Hash for Spline {
    fn hash<H: Hasher>(&self, state: &mut H) {
        self.name.hash(state);
        self.bits().for_each(|bits| bits.hash(state));
    }
}

impl PartialOrd for Spline {
    fn partial_cmp(&self, other: &Self) -> Option<std::cmp::Ordering> {
        Some(self.cmp(other))
    }
}

impl Ord for Spline {
    fn cmp(&self, other: &Self) -> std::cmp::Ordering {
        self.name.cmp(&other.name).then_with(|| self.bits().cmp(other.bits()))
    }
}

/// The coefficients of a derivative.
fn derived(mut coefficients: [f64; 4], order: usize) -> [f64; 4] {
    for _ in 0..order {
        let [_, b, c, d] = coefficients;
        coefficients = [b, 2.0 * c, 3.0 * d, 0.0];
    }
    coefficients
}

/// The cubic between two points with these slopes.
fn piece(x: &[f64], y: &[f64], slopes: &[f64], i: usize) -> [f64; 4] {
    let h = x[i + 1] - x[i];
    let chord = (y[i + 1] - y[i]) / h;
    let (left, right) = (slopes[i], slopes[i + 1]);
    [y[i], left, (3.0 * chord - 2.0 * left - right) / h, (left + right - 2.0 * chord) / (h * h)]
}

/// What a row of the equations of the slopes has left of the diagonal, on it, right of it, and on the right side: second
/// derivatives are equal on both sides of point `i`, which is `before` and `after` other ones.
fn row(x: &[f64], y: &[f64], [before, i, after]: [usize; 3], period: f64) -> [f64; 4] {
    let wrapped = |length: f64| if length > 0.0 { length } else { length + period };
    let (left, right) = (wrapped(x[i] - x[before]), wrapped(x[after] - x[i]));
    let chords = [(y[i] - y[before]) / left, (y[after] - y[i]) / right];
    [right, 2.0 * (left + right), left, 3.0 * (right * chords[0] + left * chords[1])]
}

fn natural_slopes(x: &[f64], y: &[f64]) -> Vec<f64> {
    let last = x.len() - 1;
    let chord = |i: usize| (y[i + 1] - y[i]) / (x[i + 1] - x[i]);
    let mut rows = vec![[0.0, 2.0, 1.0, 3.0 * chord(0)]];
    rows.extend((1..last).map(|i| row(x, y, [i - 1, i, i + 1], 0.0)));
    rows.push([1.0, 2.0, 0.0, 3.0 * chord(last - 1)]);
    tridiagonal(&rows, &rows.iter().map(|row| row[3]).collect::<Vec<f64>>())
}

/// The equations are tridiagonal but for two corners, which a multiple of another solution makes up for.
fn periodic_slopes(x: &[f64], y: &[f64]) -> Vec<f64> {
    let count = x.len() - 1;
    let period = x[count] - x[0];
    let mut rows: Vec<[f64; 4]> =
        (0..count).map(|i| row(x, y, [(i + count - 1) % count, i, (i + 1) % count], period)).collect();
    let (upper, lower) = (rows[0][0], rows[count - 1][2]);
    let shift = -rows[0][1];
    rows[0][1] -= shift;
    rows[count - 1][1] -= upper * lower / shift;
    let right: Vec<f64> = rows.iter().map(|row| row[3]).collect();
    let mut corner = vec![0.0; count];
    (corner[0], corner[count - 1]) = (shift, lower);
    let (slopes, other) = (tridiagonal(&rows, &right), tridiagonal(&rows, &corner));
    let of = |v: &[f64]| v[0] + upper / shift * v[count - 1];
    let factor = of(&slopes) / (1.0 + of(&other));
    let mut slopes: Vec<f64> = slopes.iter().zip(&other).map(|(slope, other)| slope - factor * other).collect();
    slopes.push(slopes[0]);
    slopes
}

/// The solution of equations with entries next to the diagonal alone; the diagonal dominates.
fn tridiagonal(rows: &[[f64; 4]], right: &[f64]) -> Vec<f64> {
    let count = rows.len();
    let (mut diagonal, mut x) = (rows.iter().map(|row| row[1]).collect::<Vec<f64>>(), right.to_vec());
    for i in 1..count {
        let ratio = rows[i][0] / diagonal[i - 1];
        diagonal[i] -= ratio * rows[i - 1][2];
        x[i] -= ratio * x[i - 1];
    }
    x[count - 1] /= diagonal[count - 1];
    for i in (0..count - 1).rev() {
        x[i] = (x[i] - rows[i][2] * x[i + 1]) / diagonal[i];
    }
    x
}

/// Appends operations that stand at one place of the text.
struct Writer<'f, N> {
    formula: &'f mut Expression<N>,
    span: &'f Span,
}

impl<N> Writer<'_, N> {
    fn push(&mut self, node: Node<N>) -> NodeId {
        self.formula.push(node, self.span.clone())
    }

    fn call(&mut self, function: Function, arguments: Vec<NodeId>) -> NodeId {
        self.push(Node::Call(function, arguments))
    }

    fn number(&mut self, value: f64) -> NodeId {
        let size = self.push(Node::Number(Number::double(value.abs())));
        if value < 0.0 { self.push(Node::Negate(size)) } else { size }
    }

    /// One where `x` is at or beyond `from`, else zero; both are less than `reach` apart.
    fn step(&mut self, x: NodeId, from: f64, reach: f64) -> NodeId {
        let (from, reach, one) = (self.number(from), self.number(reach), self.number(1.0));
        let distance = self.push(Node::Subtract(x, from));
        let part = self.push(Node::Divide(distance, reach));
        let below = self.call(Function::Floor, vec![part]);
        self.push(Node::Add(below, one))
    }

    /// What has these values one after another.
    fn stepped(&mut self, values: &[f64], steps: &[NodeId]) -> NodeId {
        let mut sum = self.number(values[0]);
        for (pair, step) in values.windows(2).zip(steps) {
            if pair[0] == pair[1] {
                continue;
            }
            let height = self.number(pair[1] - pair[0]);
            let term = self.push(Node::Multiply(height, *step));
            sum = self.push(Node::Add(sum, term));
        }
        sum
    }
}

#[cfg(test)]
mod tests {
    use num_dual::Dual2_64;

    use super::*;
    use crate::evaluate::evaluate;

    /// The value with two derivatives.
    fn at(spline: &Spline, x: f64) -> [f64; 3] {
        let value: Dual2_64 = spline.value(0, Dual2_64::from_re(x).derivative());
        [value.re, value.v1, value.v2]
    }

    fn near(found: f64, expected: f64, allowed: f64) {
        assert!((found - expected).abs() <= allowed, "{found:?} instead of {expected:?}");
    }

    /// Equal second derivatives on both sides of the middle, and none at the ends: 2 m0 + m1 = 3,
    /// 2 m0 + 6 m1 + m2 = 4.5, m1 + 2 m2 = -1.5.
    #[test]
    fn a_natural_spline_through_three_points() {
        let spline = Spline::natural("hill", &[-1.0, 0.0, 2.0], &[0.0, 1.0, 0.0]);
        near(at(&spline, 0.0)[1], 0.5, 1e-15);
        for (x, y) in [(-1.0, 0.0), (0.0, 1.0), (2.0, 0.0)] {
            near(at(&spline, x)[0], y, 1e-15);
        }
        near(at(&spline, -1.0)[2], 0.0, 1e-14);
        // Beyond the ends it is straight.
        let [y, slope, _] = at(&spline, 2.0);
        near(at(&spline, 5.0)[0], y + 3.0 * slope, 1e-14);
        near(at(&spline, -7.0)[2], 0.0, 0.0);
    }

    #[test]
    fn a_periodic_spline_comes_back() {
        let x: Vec<f64> = (0..=12).map(|i| f64::from(i) * 30.0 - 40.0).collect();
        let mut y: Vec<f64> = (0..12).map(|i| (f64::from(i) * 1.7).sin() + 0.1 * f64::from(i * (12 - i))).collect();
        y.push(y[0]);
        let spline = Spline::periodic("lift", &x, &y);
        for turn in [-3.0, 0.0, 2.0] {
            for (x, y) in x.iter().zip(&y) {
                near(at(&spline, x + 360.0 * turn)[0], *y, 1e-13);
            }
        }
        // Value and both derivatives go on at every point.
        for x in &x {
            let (before, after) = (at(&spline, x - 1e-9), at(&spline, x + 1e-9));
            for (order, allowed) in [1e-8, 1e-10, 1e-10].into_iter().enumerate() {
                near(before[order], after[order], allowed);
            }
        }
    }

    /// A sine through points every five degrees: the error falls with the fourth power of their distance.
    #[test]
    fn a_fine_spline_is_near_the_function_behind_it() {
        let error = |count: i32| {
            let x: Vec<f64> = (0..=count).map(|i| 360.0 / f64::from(count) * f64::from(i)).collect();
            let mut y: Vec<f64> = x.iter().map(|x| x.to_radians().sin()).collect();
            y[count as usize] = y[0];
            let spline = Spline::periodic("wave", &x, &y);
            (0..1000)
                .map(|i| f64::from(i) * 0.36)
                .map(|x| (at(&spline, x)[0] - x.to_radians().sin()).abs())
                .fold(0.0, f64::max)
        };
        let ratio = error(36) / error(72);
        assert!((ratio - 16.0).abs() < 0.5, "{ratio}");
    }

    #[test]
    fn the_steps_are_the_spline() {
        let x = [0.0, 20.0, 75.0, 180.0, 360.0];
        let periodic = Spline::periodic("lift", &x, &[0.0, 2.0, 5.0, 1.0, 0.0]);
        let natural = Spline::natural("lift", &x, &[0.0, 2.0, 5.0, 1.0, -3.0]);
        for spline in [periodic, natural] {
            for order in 0..=4 {
                let mut formula = Expression::<()>::new();
                let argument = formula.push(Node::Name(()), 0..0);
                spline.append(order, &mut formula, argument, &(0..0));
                for x in (-90..90).map(|i| f64::from(i) * 10.0).chain(x) {
                    let expected = spline.value(order, x);
                    near(evaluate(&formula, |()| x), expected, 1e-12 * (1.0 + expected.abs()));
                }
            }
        }
    }
}
