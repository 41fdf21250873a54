//! The values of one parameter of a sweep.

/// The values that a parameter takes.
#[derive(Debug)]
pub(super) enum Values {
    /// In the order of a list.
    Listed(Vec<f64>),
    /// At equal distances.
    Spaced {
        /// The first one.
        from: f64,
        /// The last one.
        to: f64,
        /// How many there are.
        count: usize,
    },
}

/// The largest number of spaced values that are kept. To round one takes as long as a step of the integration.
const MOST_KEPT: usize = 1 << 16;

impl Values {
    /// Values at equal distances, the first and the last one and how many there are.
    pub(super) fn spaced(from: f64, to: f64, count: usize) -> Self {
        let spaced = Self::Spaced { from, to, count };
        if count > MOST_KEPT { spaced } else { Self::Listed((0..count).map(|place| spaced.at(place)).collect()) }
    }

    /// How many there are.
    pub(super) fn count(&self) -> usize {
        match self {
            Self::Listed(values) => values.len(),
            Self::Spaced { count, .. } => *count,
        }
    }

    /// One of the values. Those between the ends are rounded to fewer digits: 0.3, not 0.30000000000000004.
    pub(super) fn at(&self, place: usize) -> f64 {
        match self {
            Self::Listed(values) => values[place],
            Self::Spaced { from, .. } if place == 0 => *from,
            Self::Spaced { to, count, .. } if place + 1 == *count => *to,
            Self::Spaced { from, to, count } => {
                let exact = from + (to - from) * (place as f64 / (count - 1) as f64);
                format!("{exact:.14e}").parse().unwrap_or(exact)
            }
        }
    }

    /// Some of the values, the smallest and the largest among them.
    pub(super) fn bounds(&self) -> Vec<f64> {
        match self {
            Self::Listed(values) => values.clone(),
            Self::Spaced { from, to, .. } => vec![*from, *to],
        }
    }
}
