//! Functions given by points: straight lines or a spline between them.

use std::sync::Arc;

use num_rational::BigRational;
use num_traits::{Signed, Zero};

use crate::diagnostic::Span;
use crate::expression::{Expression, Node, NodeId, Number, to_f64};
use crate::function::Function;
use crate::spline::Spline;

/// A function given by points: straight between them and constant beyond the first and the last, or a spline.
#[derive(Clone, Debug)]
pub struct Chart {
    /// Its name in formulae.
    pub name: String,
    /// Abscissae that rise, and ordinates; at least two.
    pub points: Vec<[BigRational; 2]>,
    /// The spline through the points; `None` where lines join them.
    pub spline: Option<Arc<Spline>>,
}

impl Chart {
    /// Appends the function's value at an argument: of lines half the sum of both ends, and an absolute value for each
    /// corner.
    ///
    /// With the slopes `m_i` before and after the points `x_i`, `y(x) = (y_0 + y_n)/2 + sum (m_(i+1) - m_i)/2 |x -
    /// x_i|`.
    pub fn append<N>(&self, formula: &mut Expression<N>, argument: NodeId, span: &Span) -> NodeId {
        if let Some(spline) = &self.spline {
            return formula.push(Node::Spline(Arc::clone(spline), argument), span.clone());
        }
        let half = BigRational::new(1.into(), 2.into());
        let slope = |pair: &[[BigRational; 2]]| (&pair[1][1] - &pair[0][1]) / (&pair[1][0] - &pair[0][0]);
        let slopes: Vec<BigRational> = self.points.windows(2).map(slope).collect();
        let ends = (&self.points[0][1] + &self.points[self.points.len() - 1][1]) * &half;
        let number = |formula: &mut Expression<N>, exact: BigRational| {
            let value = to_f64(&exact);
            let size = formula.push(Node::Number(Number::near(exact.abs(), value.abs())), span.clone());
            if value < 0.0 { formula.push(Node::Negate(size), span.clone()) } else { size }
        };
        let mut sum = number(formula, ends);
        for (i, [x, _]) in self.points.iter().enumerate() {
            let before = i.checked_sub(1).map_or_else(BigRational::zero, |i| slopes[i].clone());
            let bend = (slopes.get(i).cloned().unwrap_or_else(BigRational::zero) - before) * &half;
            if bend.is_zero() {
                continue;
            }
            let (bend, x) = (number(formula, bend), number(formula, x.clone()));
            let mut push = |node| formula.push(node, span.clone());
            let distance = push(Node::Subtract(argument, x));
            let distance = push(Node::Call(Function::Abs, vec![distance]));
            let term = push(Node::Multiply(bend, distance));
            sum = push(Node::Add(sum, term));
        }
        sum
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::evaluate::evaluate;

    #[test]
    fn it_passes_through_its_points_and_stays_at_its_ends() {
        let whole = |n: i32| BigRational::from_integer(n.into());
        let points = [[0, 1], [2, 5], [3, 5], [7, -3]].map(|pair| pair.map(whole)).to_vec();
        let chart = Chart { name: "cut".to_owned(), points, spline: None };
        let at = |x: f64| {
            let mut formula = Expression::<()>::new();
            let argument = formula.push(Node::Name(()), 0..0);
            chart.append(&mut formula, argument, &(0..0));
            evaluate(&formula, |()| x)
        };
        for (x, y) in
            [(-9.0, 1.0), (0.0, 1.0), (0.5, 2.0), (2.0, 5.0), (2.5, 5.0), (5.0, 1.0), (7.0, -3.0), (99.0, -3.0)]
        {
            assert!((at(x) - y).abs() < 1e-13, "{x}: {} instead of {y}", at(x));
        }
    }
}
