//! Prescribed motions of one coordinate.

use std::path::Path;

use num_dual::Dual2_64;
use qrm_scene::declarations::Declarations;
use qrm_scene::diagnostic::Report;
use qrm_scene::evaluate::evaluate;
use qrm_scene::parser::{Formula, parse_quantity};
use qrm_scene::spline::natural_pieces;
use qrm_scene::unit::Unit;

use crate::error::Error;

/// A coordinate as a function of time.
pub(super) enum Profile {
    /// Polynomials of time, one after another.
    Pieces(Vec<Piece>),
    /// A formula of `t`.
    Formula(Formula),
}

/// A polynomial of the time since its beginning.
pub(super) struct Piece {
    begin: f64,
    end: f64,
    coefficients: Vec<f64>,
}

impl Profile {
    /// Motion from a value at a constant rate.
    pub(super) fn constant(from: f64, rate: f64, time: f64) -> Self {
        Self::Pieces(vec![Piece { begin: 0.0, end: time, coefficients: vec![from, rate] }])
    }

    /// Motion from rest to rest: one third of the time at constant acceleration, one third at constant rate, one third
    /// at constant deceleration.
    pub(super) fn trapezoid(from: f64, distance: f64, time: f64) -> Self {
        let (third, rate) = (time / 3.0, 1.5 * distance / time);
        let half = 0.5 * rate / third;
        let piece = |k: f64, coefficients: [f64; 3]| {
            let end = if k == 2.0 { time } else { (k + 1.0) * third };
            Piece { begin: k * third, end, coefficients: coefficients.into() }
        };
        Self::Pieces(vec![
            piece(0.0, [from, 0.0, half]),
            piece(1.0, [from + 0.25 * distance, rate, 0.0]),
            piece(2.0, [from + 0.75 * distance, rate, -half]),
        ])
    }

    /// Motion from rest to rest by the polynomial of degree 5 with zero accelerations at both ends.
    pub(super) fn polynomial(from: f64, distance: f64, time: f64) -> Self {
        let scaled = |factor: f64, power: i32| factor * distance / time.powi(power);
        let coefficients = vec![from, 0.0, 0.0, scaled(10.0, 3), scaled(-15.0, 4), scaled(6.0, 5)];
        Self::Pieces(vec![Piece { begin: 0.0, end: time, coefficients }])
    }

    /// Motion along a cubic spline through the rows of a CSV file: time and value.
    pub(super) fn table(path: &Path) -> Result<Self, Error> {
        let wrong = |why: String| {
            Error::usage(format!("`{}` is no table of a motion: {why}", path.display())).help(
                "write a time in s and a value in each row, with a comma between them, the times increasing from 0",
            )
        };
        let mut reader = csv::ReaderBuilder::new()
            .has_headers(false)
            .trim(csv::Trim::All)
            .comment(Some(b'#'))
            .from_path(path)
            .map_err(|e| wrong(e.to_string()))?;
        let (mut times, mut values) = (Vec::new(), Vec::new());
        for (number, row) in reader.records().enumerate() {
            let row = row.map_err(|e| wrong(e.to_string()))?;
            let numbers: Vec<f64> = row.iter().filter_map(|field| field.parse().ok()).collect();
            match numbers[..] {
                [t, value] if row.len() == 2 && t.is_finite() && value.is_finite() => {
                    times.push(t);
                    values.push(value);
                }
                // The first row may be a header.
                _ if number == 0 => {}
                _ => return Err(wrong(format!("row {} has no two numbers", number + 1))),
            }
        }
        if times.len() < 2 || times[0] != 0.0 || !times.is_sorted_by(|a, b| a < b) {
            return Err(wrong("it has too few rows, or times that do not increase from 0".to_owned()));
        }
        let pieces = times.windows(2).zip(natural_pieces(&times, &values)).map(|(ends, coefficients)| Piece {
            begin: ends[0],
            end: ends[1],
            coefficients: coefficients.into(),
        });
        Ok(Self::Pieces(pieces.collect()))
    }

    /// Motion by a formula of `t`.
    pub(super) fn formula(text: &str, unit: &str) -> Result<Self, Error> {
        let report = |finding| Report::new("--motion", text, vec![finding]);
        let (formula, dimension) = parse_quantity(text, 0, &Declarations::default(), None).map_err(report)?;
        if let Some(finding) = Unit::parse(unit).and_then(|unit| dimension.misfit(&unit, 0..text.len())) {
            return Err(report(finding).into());
        }
        if let Some(name) = formula.names().find(|name| !["t", "pi"].contains(&name.as_str())) {
            let title = format!("`--motion {text}` contains the name `{name}`");
            let help = "write `constant`, `trapezoid`, `polynomial`, `table:FILE.csv`, or a formula of `t`";
            return Err(Error::usage(title).help(help));
        }
        Ok(Self::Formula(formula))
    }

    /// The times at which the motion begins, may change its acceleration, and ends; unknown for a formula.
    pub(super) fn times(&self) -> Vec<f64> {
        match self {
            Self::Pieces(pieces) => {
                let ends = pieces.iter().map(|piece| piece.end);
                pieces.iter().take(1).map(|piece| piece.begin).chain(ends).collect()
            }
            Self::Formula(_) => Vec::new(),
        }
    }

    /// Value, rate and acceleration at a time in an interval in which the motion is smooth.
    pub(super) fn at(&self, t: f64, [from, to]: [f64; 2]) -> [f64; 3] {
        match self {
            Self::Pieces(pieces) => {
                let middle = 0.5 * (from + to);
                let inside = pieces.iter().find(|piece| middle < piece.end).or(pieces.last());
                inside.map_or([f64::NAN; 3], |piece| piece.at(t))
            }
            Self::Formula(formula) => {
                let value = evaluate(formula, |name: &String| match name.as_str() {
                    "t" => Dual2_64::new(t, 1.0, 0.0),
                    _ => Dual2_64::from(std::f64::consts::PI),
                });
                [value.re, value.v1, value.v2]
            }
        }
    }
}

impl Piece {
    fn at(&self, t: f64) -> [f64; 3] {
        let s = t - self.begin;
        let mut found = [0.0; 3];
        for coefficient in self.coefficients.iter().rev() {
            found = [found[0] * s + coefficient, found[1] * s + found[0], found[2] * s + 2.0 * found[1]];
        }
        found
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn assert_near(got: [f64; 3], expected: [f64; 3]) {
        for (got, expected) in got.iter().zip(expected) {
            assert!((got - expected).abs() < 1e-12, "{got} instead of {expected}");
        }
    }

    #[test]
    fn motions_from_rest_to_rest_meet_their_ends() {
        let polynomial = Profile::polynomial(1.0, 2.0, 4.0);
        assert_near(polynomial.at(0.0, [0.0, 4.0]), [1.0, 0.0, 0.0]);
        assert_near(polynomial.at(2.0, [0.0, 4.0]), [2.0, 15.0 / 16.0, 0.0]);
        assert_near(polynomial.at(4.0, [0.0, 4.0]), [3.0, 0.0, 0.0]);
        let trapezoid = Profile::trapezoid(1.0, 2.0, 3.0);
        assert_eq!(trapezoid.times(), [0.0, 1.0, 2.0, 3.0]);
        assert_near(trapezoid.at(1.0, [0.0, 1.0]), [1.5, 1.0, 1.0]);
        assert_near(trapezoid.at(1.0, [1.0, 2.0]), [1.5, 1.0, 0.0]);
        assert_near(trapezoid.at(3.0, [2.0, 3.0]), [3.0, 0.0, -1.0]);
    }

    #[test]
    fn a_formula_has_the_derivatives_of_the_polynomial_that_it_is() {
        let formula = Profile::formula("1 + 2*t^2 - t^3", "m").expect("a formula");
        assert_near(formula.at(0.5, [0.0, 1.0]), [1.375, 1.25, 1.0]);
        assert!(Profile::formula("1 + x", "m").is_err());
    }
}
