//! Coordinates that can be given independently of each other, by the structure of the constraints.

use std::collections::{BTreeMap, BTreeSet};

use crate::document::Document;
use crate::parser::Formula;

/// The first candidates that may be given together, at most `count`: by their structure, the constraints can still be
/// solved for the other coordinates. That is so if as many of them as before can each have a coordinate of their own.
pub(super) fn independent_coordinates(document: &Document, candidates: &[&str], count: usize) -> BTreeSet<String> {
    if count == 0 {
        return BTreeSet::new();
    }
    let names: Vec<&str> = document.coordinates.iter().map(|own| own.identifier.name.as_str()).collect();
    let places: BTreeMap<&str, usize> = names.iter().enumerate().map(|(place, name)| (*name, place)).collect();
    let mut structure = Structure { document, places: places.clone(), of_points: BTreeMap::new() };
    let rows: Vec<BTreeSet<usize>> =
        document.constraints.iter().map(|constraint| structure.coordinates(&constraint.residual)).collect();
    let mut is_free = vec![true; names.len()];
    let rank = structural_rank(&rows, &is_free);
    let mut chosen = BTreeSet::new();
    for name in candidates {
        let Some(&place) = places.get(name).filter(|_| chosen.len() < count) else { continue };
        is_free[place] = false;
        if structural_rank(&rows, &is_free) == rank {
            chosen.insert((*name).to_owned());
        } else {
            is_free[place] = true;
        }
    }
    chosen
}

/// The coordinates on which formulae depend, also through points.
struct Structure<'d> {
    document: &'d Document,
    /// The places of the coordinates, by their names.
    places: BTreeMap<&'d str, usize>,
    of_points: BTreeMap<&'d str, BTreeSet<usize>>,
}

impl<'d> Structure<'d> {
    /// The coordinates in a formula.
    fn coordinates(&mut self, formula: &'d Formula) -> BTreeSet<usize> {
        let mut found = BTreeSet::new();
        for name in formula.names() {
            found.extend(self.places.get(name.as_str()));
            let Some((point, "x" | "y")) = name.rsplit_once('.') else { continue };
            if let Some(known) = self.of_points.get(point) {
                found.extend(known);
                continue;
            }
            let Some((own, position)) = self.document.points.iter().find(|(own, _)| own.name == point) else {
                continue;
            };
            // A point that is defined by itself has been reported.
            self.of_points.insert(&own.name, BTreeSet::new());
            let [x, y] = position.each_ref().map(|part| self.coordinates(part));
            let both: BTreeSet<usize> = x.union(&y).copied().collect();
            found.extend(&both);
            self.of_points.insert(&own.name, both);
        }
        found
    }
}

/// The largest number of rows that can each have a free column of their own.
fn structural_rank(rows: &[BTreeSet<usize>], is_free: &[bool]) -> usize {
    let mut owners: Vec<Option<usize>> = vec![None; is_free.len()];
    (0..rows.len())
        .filter(|row| takes_column(rows, is_free, &mut owners, *row, &mut vec![false; is_free.len()]))
        .count()
}

/// Whether a row finds a column, where others may move to another one.
fn takes_column(
    rows: &[BTreeSet<usize>],
    is_free: &[bool],
    owners: &mut [Option<usize>],
    row: usize,
    visited: &mut [bool],
) -> bool {
    rows[row].iter().filter(|column| is_free[**column]).any(|&column| {
        if std::mem::replace(&mut visited[column], true) {
            return false;
        }
        let is_won = owners[column].is_none_or(|owner| takes_column(rows, is_free, owners, owner, visited));
        if is_won {
            owners[column] = Some(row);
        }
        is_won
    })
}
