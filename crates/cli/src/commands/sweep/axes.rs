//! The parameters that a sweep varies.

use qrm_core::{Description, Interval};

use crate::error::Error;
use crate::options::{check_parameter, number};

/// Every combination of some values of some parameters, with the last parameter changing fastest; or pairs of values.
pub(crate) struct Axes {
    axes: Vec<Axis>,
    /// Whether design `k` takes value `k` of every axis, instead of a combination.
    is_paired: bool,
}

struct Axis {
    name: String,
    values: Vec<f64>,
}

/// The largest number of designs; more are considered a mistake.
const MAX_DESIGNS: usize = 1_000_000_000;

impl Axes {
    /// Reads axes written as `NAME=FROM:TO:COUNT` or `NAME=VALUE,VALUE,...`.
    pub(super) fn new(description: &Description, vary: &[String]) -> Result<Self, Error> {
        let mut named = Vec::new();
        for text in vary {
            let Some((name, values)) = text.split_once('=') else {
                return Err(wrong(text, "has no `=`"));
            };
            let name = name.trim();
            let values = values_of(name, text, values)?;
            check_parameter(description, name)?;
            if named.iter().any(|(other, _)| other == name) {
                return Err(wrong(text, "varies a parameter for the second time"));
            }
            named.push((name.to_owned(), values));
        }
        Self::combinations(description, named)
    }

    /// Creates every combination of these values.
    pub(crate) fn combinations(description: &Description, values: Vec<(String, Vec<f64>)>) -> Result<Self, Error> {
        let axes = axes(description, values)?;
        let count = axes.iter().try_fold(1_usize, |count, axis| count.checked_mul(axis.values.len()));
        match count {
            Some(count) if count <= MAX_DESIGNS => Ok(Self { axes, is_paired: false }),
            _ => Err(Error::usage(format!("these are more than {MAX_DESIGNS} designs"))
                .help("vary fewer parameters, or take fewer values of each")),
        }
    }

    /// Creates one design for each index of these values; all parameters must have equally many.
    pub(crate) fn paired(description: &Description, values: Vec<(String, Vec<f64>)>) -> Result<Self, Error> {
        let axes = axes(description, values)?;
        if let Some([first, other]) = axes.array_windows().find(|[a, b]| a.values.len() != b.values.len()) {
            let [[name, count], [other, others]] =
                [first, other].map(|axis| [axis.name.clone(), axis.values.len().to_string()]);
            return Err(Error::usage(format!("`{name}` has {count} values and `{other}` has {others}"))
                .help("designs that are given one by one take a value of each parameter"));
        }
        Ok(Self { axes, is_paired: true })
    }

    /// The number of designs.
    pub(super) fn count(&self) -> usize {
        if self.is_paired {
            return self.axes.first().map_or(0, |axis| axis.values.len());
        }
        self.axes.iter().map(|axis| axis.values.len()).product()
    }

    pub(super) fn names(&self) -> impl Iterator<Item = &str> {
        self.axes.iter().map(|axis| axis.name.as_str())
    }

    /// The values of a design, in the order of the names.
    pub(crate) fn values(&self, design: usize) -> Vec<f64> {
        if self.is_paired {
            return self.axes.iter().map(|axis| axis.values[design]).collect();
        }
        let mut rest = design;
        let mut values: Vec<f64> = self
            .axes
            .iter()
            .rev()
            .map(|axis| {
                let place = rest % axis.values.len();
                rest /= axis.values.len();
                axis.values[place]
            })
            .collect();
        values.reverse();
        values
    }

    /// The range of a parameter; `None` if it is not varied.
    pub(super) fn range(&self, name: &str) -> Option<Interval> {
        let values = &self.axes.iter().find(|axis| axis.name == name)?.values;
        values.iter().map(|value| Interval::point(*value)).reduce(Interval::hull)
    }

    /// The value of a parameter; `None` if it is not varied.
    pub(super) fn value(&self, values: &[f64], name: &str) -> Option<f64> {
        self.axes.iter().position(|axis| axis.name == name).map(|place| values[place])
    }
}

/// Creates the axes; the names must be parameters of the mechanism.
fn axes(description: &Description, values: Vec<(String, Vec<f64>)>) -> Result<Vec<Axis>, Error> {
    let axis = |(name, values): (String, Vec<f64>)| {
        check_parameter(description, &name)?;
        match values.iter().find(|value| !value.is_finite()) {
            Some(value) => Err(Error::usage(format!("a value of `{name}` is {value}")).help("vary over numbers")),
            None => Ok(Axis { name, values }),
        }
    };
    values.into_iter().map(axis).collect()
}

fn wrong(text: &str, why: &str) -> Error {
    Error::usage(format!("`--vary {text}` {why}"))
        .help("write `--vary NAME=FROM:TO:COUNT` or `--vary NAME=VALUE,VALUE,...`")
}

fn values_of(name: &str, text: &str, values: &str) -> Result<Vec<f64>, Error> {
    let number = |value: &str| number(&format!("--vary {name}"), value);
    let parts: Vec<&str> = values.split(':').collect();
    match parts[..] {
        [list] => split(list).into_iter().map(|value| number(value.trim())).collect(),
        [from, to, count] => {
            let (from, to) = (number(from)?, number(to)?);
            let count: usize = match count.trim().parse() {
                Ok(count) if (2..=MAX_DESIGNS).contains(&count) || (count == 1 && from == to) => count,
                _ => {
                    let why = format!("asks for `{}` values, but a range has from 2 to {MAX_DESIGNS}", count.trim());
                    return Err(wrong(text, &why));
                }
            };
            let last = (count - 1).max(1) as f64;
            // Rounded to fewer digits: 0.3, not 0.30000000000000004.
            let value = |i: usize| {
                if i == 0 || i == count - 1 {
                    return if i == 0 { from } else { to };
                }
                let exact = from + (to - from) * (i as f64 / last);
                format!("{exact:.14e}").parse().unwrap_or(exact)
            };
            Ok((0..count).map(value).collect())
        }
        _ => Err(wrong(text, "has neither one `:` list nor three parts")),
    }
}

/// Splits at commas outside of parentheses.
fn split(list: &str) -> Vec<&str> {
    let (mut parts, mut depth, mut begin) = (Vec::new(), 0, 0);
    for (i, c) in list.char_indices() {
        match c {
            '(' => depth += 1,
            ')' => depth -= 1,
            ',' if depth == 0 => {
                parts.push(&list[begin..i]);
                begin = i + 1;
            }
            _ => {}
        }
    }
    parts.push(&list[begin..]);
    parts
}

/// The designs of part K of N, given as `K/N`.
pub(super) fn shard(text: &str, count: usize) -> Result<(usize, usize), Error> {
    let parts = text.split_once('/').and_then(|(k, n)| Some((k.trim().parse().ok()?, n.trim().parse().ok()?)));
    let (k, n): (usize, usize) = parts.filter(|(k, n)| (1..=*n).contains(k)).ok_or_else(|| {
        Error::usage(format!("`--shard {text}` is not a part of a whole")).help("write `--shard 1/4` to `--shard 4/4`")
    })?;
    let edge = |k: usize| (k as u128 * count as u128 / n as u128) as usize;
    Ok((edge(k - 1), edge(k)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parts_cover_everything_once() {
        for (count, n) in [(10, 3), (2, 5), (0, 2), (1000, 7)] {
            let parts: Vec<_> = (1..=n).map(|k| shard(&format!("{k}/{n}"), count).expect("a part")).collect();
            assert_eq!((parts[0].0, parts[n - 1].1), (0, count));
            assert!(parts.windows(2).all(|pair| pair[0].1 == pair[1].0));
        }
        assert!(["0/3", "4/3", "1", "a/b", "1/0"].iter().all(|text| shard(text, 10).is_err()));
    }

    #[test]
    fn ranges_reach_their_ends_exactly() {
        let values = values_of("x", "", "0.15:0.25:1000").expect("a range");
        assert_eq!((values.len(), values[0], values[999]), (1000, 0.15, 0.25));
        assert_eq!(values_of("x", "", "0.2:0.6:5").expect("a range"), [0.2, 0.3, 0.4, 0.5, 0.6]);
        assert_eq!(values_of("x", "", "2:2:1").expect("one value"), [2.0]);
        assert_eq!(values_of("x", "", "1/3:2/3:2").expect("both ends"), [1.0 / 3.0, 2.0 / 3.0]);
        assert!(["2:5:1", "2:5:0", "2:5:-1"].iter().all(|range| values_of("x", "", range).is_err()));
        assert_eq!(values_of("x", "", "3*pi, max(1,2)").expect("a list"), [3.0 * std::f64::consts::PI, 2.0]);
    }
}
