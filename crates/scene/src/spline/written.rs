//! Splines as branch-free expressions of `floor` and `sign`.

use super::{Spline, derived};
use crate::diagnostic::Span;
use crate::expression::{Expression, Node, NodeId, Number};
use crate::function::Function;

impl Spline {
    /// Appends the derivative of an order at an argument, without branches.
    ///
    /// With windows `W_i`, one inside the piece `i` and zero elsewhere, base and coefficients of a cubic spline are
    /// sums `sum c_i W_i`. These windows are differences of floors. A linear spline with lines `l_i` is the sum
    /// `1/2 sum l_i W_i` with windows of height two, differences of signs: integration steps end where signs jump.
    pub fn append<N>(&self, order: usize, formula: &mut Expression<N>, argument: NodeId, span: &Span) -> NodeId {
        let mut writer = Writer { formula, span };
        if self.degree == 1 {
            return self.append_lines(order, &mut writer, argument);
        }
        let (x, inside, reach) = match self.period {
            Some(period) => {
                let (first, length) = (writer.number(self.first()), writer.number(period));
                let from_first = writer.push(Node::Subtract(argument, first));
                let turns = writer.push(Node::Divide(from_first, length));
                let turns = writer.call(Function::Floor, vec![turns]);
                let back = writer.push(Node::Multiply(length, turns));
                let x = writer.push(Node::Subtract(argument, back));
                (x, x, period)
            }
            None => {
                let last = self.bases[self.bases.len() - 1];
                let length = last - self.first();
                let ends = [self.first() - length, last + length].map(|end| writer.number(end));
                let inside = writer.call(Function::Max, vec![argument, ends[0]]);
                let inside = writer.call(Function::Min, vec![inside, ends[1]]);
                (argument, inside, 4.0 * length)
            }
        };
        let windows = writer.windows(inside, self.breakpoints(), reach);
        let base = writer.chosen(&self.bases, &windows);
        let distance = writer.push(Node::Subtract(x, base));
        let pieces: Vec<[f64; 4]> = self.pieces.iter().map(|piece| derived(*piece, order)).collect();
        let coefficient = |writer: &mut Writer<N>, k: usize| {
            writer.chosen(&pieces.iter().map(|p| p[k]).collect::<Vec<f64>>(), &windows)
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

    /// Appends lines: half the sum of each line times its window.
    fn append_lines<N>(&self, order: usize, writer: &mut Writer<N>, x: NodeId) -> NodeId {
        let windows = writer.windows_of_signs(x, self.breakpoints());
        let mut sum = None;
        for ((piece, base), window) in self.pieces.iter().zip(&self.bases).zip(windows) {
            let [value, slope, ..] = derived(*piece, order);
            let mut line = (value != 0.0).then(|| writer.number(value));
            if slope != 0.0 {
                let (slope, base) = (writer.number(slope), writer.number(*base));
                let distance = writer.push(Node::Subtract(x, base));
                let rise = writer.push(Node::Multiply(slope, distance));
                line = Some(line.map_or(rise, |value| writer.push(Node::Add(rise, value))));
            }
            if let Some(line) = line {
                let term = writer.push(Node::Multiply(line, window));
                sum = Some(sum.map_or(term, |sum| writer.push(Node::Add(sum, term))));
            }
        }
        let half = writer.number(0.5);
        match sum {
            Some(sum) => writer.push(Node::Multiply(half, sum)),
            None => writer.number(0.0),
        }
    }
}

/// Appends operations that share one location in the text.
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

    /// The windows of all pieces, one inside and zero elsewhere; `x` and the steps are less than `reach` apart.
    fn windows(&mut self, x: NodeId, steps: &[f64], reach: f64) -> Vec<NodeId> {
        // Zero beyond a step, and minus one before it.
        let levels: Vec<NodeId> = steps
            .iter()
            .map(|step| {
                let (from, reach) = (self.number(*step), self.number(reach));
                let distance = self.push(Node::Subtract(x, from));
                let part = self.push(Node::Divide(distance, reach));
                self.call(Function::Floor, vec![part])
            })
            .collect();
        let one = self.number(1.0);
        let first = self.push(Node::Negate(levels[0]));
        self.windows_between(one, first, &levels)
    }

    /// The windows of all pieces, two inside, one at the ends and zero elsewhere.
    fn windows_of_signs(&mut self, x: NodeId, steps: &[f64]) -> Vec<NodeId> {
        let signs: Vec<NodeId> = steps
            .iter()
            .map(|step| {
                let from = self.number(*step);
                let distance = self.push(Node::Subtract(x, from));
                self.call(Function::Sign, vec![distance])
            })
            .collect();
        let one = self.number(1.0);
        let first = self.push(Node::Subtract(one, signs[0]));
        self.windows_between(one, first, &signs)
    }

    /// The first window, the differences of levels that are minus one before their steps, and the window of the last
    /// piece.
    fn windows_between(&mut self, one: NodeId, first: NodeId, levels: &[NodeId]) -> Vec<NodeId> {
        let mut windows = vec![first];
        windows.extend(levels.windows(2).map(|pair| self.push(Node::Subtract(pair[0], pair[1]))));
        windows.push(self.push(Node::Add(one, levels[levels.len() - 1])));
        windows
    }

    /// The value of the piece whose window is not zero.
    fn chosen(&mut self, values: &[f64], windows: &[NodeId]) -> NodeId {
        let mut sum = None;
        for (value, window) in values.iter().zip(windows).filter(|(value, _)| **value != 0.0) {
            let value = self.number(*value);
            let term = self.push(Node::Multiply(value, *window));
            sum = Some(sum.map_or(term, |sum| self.push(Node::Add(sum, term))));
        }
        sum.unwrap_or_else(|| self.number(0.0))
    }
}
