//! Named points, each after the points that it depends on.

use std::collections::HashMap;

use super::Resolver;
use super::context::Context;
use crate::diagnostic::Span;
use crate::document::Document;
use crate::expression::{Expression, Node};
use crate::scene::{Point, Quantity, Value};

impl Resolver<'_> {
    pub(super) fn points(&mut self, document: &Document) -> Vec<Point> {
        let order = point_order(document).unwrap_or_else(|_| (0..document.points.len()).collect());
        let mut points = Vec::new();
        for &i in &order {
            let (identifier, position) = &document.points[i];
            let position = [self.value(&position[0], Context::Geometry), self.value(&position[1], Context::Geometry)];
            points.push(Point { name: identifier.name.clone(), position });
        }
        points
    }
}

/// The two formulae `P.x`, `P.y`.
pub(super) fn point_value(point: usize, span: Span) -> [Value; 2] {
    [0, 1].map(|axis| {
        let mut value = Value::new();
        value.push(Node::Name(Quantity::Point(point, axis)), span.clone());
        value
    })
}

/// Sorts points so that each depends only on earlier ones; otherwise returns the points of a cycle.
pub(super) fn point_order(document: &Document) -> Result<Vec<usize>, Vec<usize>> {
    let place: HashMap<&str, usize> =
        document.points.iter().enumerate().map(|(i, (identifier, _))| (identifier.name.as_str(), i)).collect();
    let needs: Vec<Vec<usize>> = document
        .points
        .iter()
        .map(|(_, position)| {
            let names = position.iter().flat_map(Expression::names);
            names.filter_map(|name| place.get(name.split('.').next()?).copied()).collect()
        })
        .collect();
    let mut order: Vec<usize> = Vec::new();
    let mut placed = vec![false; needs.len()];
    while order.len() < needs.len() {
        let ready = (0..needs.len()).find(|&i| !placed[i] && needs[i].iter().all(|&n| placed[n]));
        if let Some(i) = ready {
            placed[i] = true;
            order.push(i);
            continue;
        }
        // Every remaining point depends on another remaining one, so following these dependencies leads to a cycle.
        let mut trail: Vec<usize> = Vec::new();
        let mut at = placed.iter().position(|p| !p).unwrap_or(0);
        while !trail.contains(&at) {
            trail.push(at);
            at = needs[at].iter().copied().find(|&n| !placed[n]).unwrap_or(at);
        }
        let start = trail.iter().position(|&i| i == at).unwrap_or(0);
        return Err(trail.split_off(start));
    }
    Ok(order)
}
