//! The parameters that a sweep varies.

use qrm_core::{Description, Interval};

use super::values::Values;
use crate::error::Error;
use crate::options::{check_parameter, check_units, number, unit_of_parameter};

/// Every combination of some values of some parameters, with the last parameter changing fastest; or pairs of values.
pub(crate) struct Axes {
    axes: Vec<Axis>,
    /// Whether design `k` takes value `k` of every axis, instead of a combination.
    is_paired: bool,
}

struct Axis {
    name: String,
    values: Values,
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
            let values = values_of(name, unit_of_parameter(description, name), text, values)?;
            check_parameter(description, name)?;
            if named.iter().any(|(other, _)| other == name) {
                return Err(wrong(text, "varies a parameter for the second time"));
            }
            named.push((name.to_owned(), values));
        }
        Self::combined(axes(description, named)?)
    }

    /// Creates every combination of these values.
    pub(crate) fn combinations(description: &Description, values: Vec<(String, Vec<f64>)>) -> Result<Self, Error> {
        Self::combined(axes(description, listed(values))?)
    }

    fn combined(axes: Vec<Axis>) -> Result<Self, Error> {
        let count = axes.iter().try_fold(1_usize, |count, axis| count.checked_mul(axis.values.count()));
        match count {
            Some(count) if count <= MAX_DESIGNS => Ok(Self { axes, is_paired: false }),
            _ => Err(Error::usage(format!("these are more than {MAX_DESIGNS} designs"))
                .help("vary fewer parameters, or take fewer values of each")),
        }
    }

    /// Creates one design for each index of these values; all parameters must have equally many.
    pub(crate) fn paired(description: &Description, values: Vec<(String, Vec<f64>)>) -> Result<Self, Error> {
        let axes = axes(description, listed(values))?;
        if let Some([first, other]) = axes.array_windows().find(|[a, b]| a.values.count() != b.values.count()) {
            let [[name, count], [other, others]] =
                [first, other].map(|axis| [axis.name.clone(), axis.values.count().to_string()]);
            return Err(Error::usage(format!("`{name}` has {count} values and `{other}` has {others}"))
                .help("designs that are given one by one take a value of each parameter"));
        }
        Ok(Self { axes, is_paired: true })
    }

    /// The number of designs.
    pub(super) fn count(&self) -> usize {
        if self.is_paired {
            return self.axes.first().map_or(0, |axis| axis.values.count());
        }
        self.axes.iter().map(|axis| axis.values.count()).product()
    }

    pub(super) fn names(&self) -> impl Iterator<Item = &str> {
        self.axes.iter().map(|axis| axis.name.as_str())
    }

    /// The values of a design, in the order of the names.
    pub(crate) fn values(&self, design: usize) -> Vec<f64> {
        if self.is_paired {
            return self.axes.iter().map(|axis| axis.values.at(design)).collect();
        }
        let mut rest = design;
        let mut values: Vec<f64> = self
            .axes
            .iter()
            .rev()
            .map(|axis| {
                let place = rest % axis.values.count();
                rest /= axis.values.count();
                axis.values.at(place)
            })
            .collect();
        values.reverse();
        values
    }

    /// The range of a parameter; `None` if it is not varied.
    pub(super) fn range(&self, name: &str) -> Option<Interval> {
        let values = &self.axes.iter().find(|axis| axis.name == name)?.values;
        values.bounds().into_iter().map(Interval::point).reduce(Interval::hull)
    }

    /// The value of a parameter; `None` if it is not varied.
    pub(super) fn value(&self, values: &[f64], name: &str) -> Option<f64> {
        self.axes.iter().position(|axis| axis.name == name).map(|place| values[place])
    }
}

fn listed(values: Vec<(String, Vec<f64>)>) -> Vec<(String, Values)> {
    values.into_iter().map(|(name, values)| (name, Values::Listed(values))).collect()
}

/// Creates the axes; the names must be parameters of the mechanism.
fn axes(description: &Description, values: Vec<(String, Values)>) -> Result<Vec<Axis>, Error> {
    let axis = |(name, values): (String, Values)| {
        check_parameter(description, &name)?;
        match values.bounds().iter().find(|value| !value.is_finite()) {
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

fn values_of(name: &str, unit: &str, text: &str, values: &str) -> Result<Values, Error> {
    let option = format!("--vary {name}");
    let number = |value: &str| number(&option, value, unit);
    let parts: Vec<&str> = values.split(':').collect();
    match parts[..] {
        [list] => {
            let list = split(list);
            check_units(&option, &list)?;
            list.into_iter().map(|value| number(value.trim())).collect::<Result<_, _>>().map(Values::Listed)
        }
        [from, to, count] => {
            check_units(&option, &[from, to])?;
            let (from, to) = (number(from)?, number(to)?);
            let count: usize = match count.trim().parse() {
                Ok(count) if (2..=MAX_DESIGNS).contains(&count) || (count == 1 && from == to) => count,
                _ => {
                    let why = format!("asks for `{}` values, but a range has from 2 to {MAX_DESIGNS}", count.trim());
                    return Err(wrong(text, &why));
                }
            };
            Ok(Values::spaced(from, to, count))
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
        let values = |text: &str| {
            let values = values_of("x", "", "", text).expect("values");
            (0..values.count()).map(|place| values.at(place)).collect::<Vec<f64>>()
        };
        let many = values("0.15:0.25:1000");
        assert_eq!((many.len(), many[0], many[999]), (1000, 0.15, 0.25));
        assert_eq!(values("0.2:0.6:5"), [0.2, 0.3, 0.4, 0.5, 0.6]);
        assert_eq!(values("2:2:1"), [2.0]);
        assert_eq!(values("1/3:2/3:2"), [1.0 / 3.0, 2.0 / 3.0]);
        assert!(["2:5:1", "2:5:0", "2:5:-1"].iter().all(|range| values_of("x", "", "", range).is_err()));
        assert_eq!(values("3*pi, max(1,2)"), [3.0 * std::f64::consts::PI, 2.0]);
    }
}
