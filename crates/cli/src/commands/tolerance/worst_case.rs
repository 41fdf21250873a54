//! Designs within tolerances that are run separately.

use super::derivatives::Derived;
use super::motions::Motions;
use super::nominal::Nominal;
use super::parameter::TolerancedParameter;
use super::slope::{PLACES, Slope};
use crate::error::Error;
use crate::format::number;

/// The largest number of parameters for which all corners of the tolerances are run.
const MOST_FOR_ALL_CORNERS: usize = 10;

/// Designs and their results: the nominal one, those with one changed parameter, corners, and samples.
pub(super) struct Probes {
    /// The values of each parameter in all designs.
    pub(super) points: Vec<Vec<f64>>,
    /// The values of each quantity in all designs.
    pub(super) values: Vec<Vec<f64>>,
    /// The relative resolution of each quantity.
    resolutions: Vec<f64>,
    has_all_corners: bool,
}

/// The range of a quantity over designs.
pub(super) struct WorstCase {
    /// The smallest and the largest value.
    pub(super) ends: [f64; 2],
    /// The designs that attain them.
    pub(super) designs: [usize; 2],
    /// Whether all designs are consistent with a quantity that is monotonic in each parameter.
    pub(super) is_monotonic: bool,
}

/// The number of the design with one parameter at one of `PLACES`.
fn single(parameter: usize, place: usize) -> usize {
    1 + PLACES.len() * parameter + place
}

impl Probes {
    /// Runs the nominal design, those with one changed parameter, and corners: all of them for few parameters,
    /// otherwise two for each quantity according to the signs of its slopes.
    ///
    /// # Errors
    /// A design fails, or the user interrupts.
    pub(super) fn run(
        motions: &mut Motions,
        parameters: &[TolerancedParameter],
        derived: &[Derived],
        nominal: &[Nominal],
        resolution: f64,
    ) -> Result<(Self, Vec<Vec<Slope>>), Error> {
        let count = parameters.len();
        let resolutions = nominal.iter().map(|nominal| resolution * nominal.size).collect();
        let has_all_corners = count <= MOST_FOR_ALL_CORNERS;
        let [points, values] = [parameters.len(), nominal.len()].map(|count| vec![Vec::new(); count]);
        let mut probes = Self { points, values, resolutions, has_all_corners };
        let own: Vec<f64> = parameters.iter().map(|parameter| parameter.value).collect();
        let mut designs = vec![own.clone()];
        for (i, TolerancedParameter { value, tolerance, .. }) in parameters.iter().enumerate() {
            designs.extend(PLACES.map(|place| {
                let mut design = own.clone();
                design[i] = value + place * tolerance;
                design
            }));
        }
        probes.add_all(motions, parameters, &designs)?;
        let slope = |quantity: usize, i: usize| {
            let values = [0, 1, 2, 3].map(|place| probes.values[quantity][single(i, place)]);
            Slope::new(derived[quantity].derivatives[i], values, parameters[i].tolerance, probes.resolutions[quantity])
        };
        let slopes: Vec<Vec<Slope>> =
            (0..nominal.len()).map(|quantity| (0..count).map(|i| slope(quantity, i)).collect()).collect();
        let corner = |is_up: &dyn Fn(usize) -> bool| {
            let end = |(i, parameter): (usize, &TolerancedParameter)| {
                parameter.value + if is_up(i) { parameter.tolerance } else { -parameter.tolerance }
            };
            parameters.iter().enumerate().map(end).collect::<Vec<f64>>()
        };
        let corners: Vec<Vec<f64>> = if has_all_corners {
            (0..1_usize << count).map(|bits| corner(&|i| bits >> i & 1 == 1)).collect()
        } else {
            let by_signs = |slopes: &Vec<Slope>| {
                [true, false].map(|is_larger| corner(&|i| (slopes[i].difference_quotient > 0.0) == is_larger))
            };
            slopes.iter().flat_map(by_signs).collect()
        };
        probes.add_all(motions, parameters, &corners)?;
        Ok((probes, slopes))
    }

    /// The number of designs.
    pub(super) fn count(&self) -> usize {
        self.values.first().map_or(0, Vec::len)
    }

    /// Runs designs and adds them.
    ///
    /// # Errors
    /// A design fails, or the user interrupts.
    fn add_all(
        &mut self,
        motions: &mut Motions,
        parameters: &[TolerancedParameter],
        designs: &[Vec<f64>],
    ) -> Result<(), Error> {
        match self.add(motions, designs)?.first() {
            None => Ok(()),
            Some((design, why)) => Err(fails(parameters, &designs[*design], why)),
        }
    }

    /// Runs designs and adds them; returns those that fail, with the reasons.
    pub(super) fn add(&mut self, motions: &mut Motions, designs: &[Vec<f64>]) -> Result<Vec<(usize, String)>, Error> {
        let points: Vec<Vec<f64>> =
            (0..self.points.len()).map(|i| designs.iter().map(|design| design[i]).collect()).collect();
        let found = motions.alone(&points)?;
        self.points.iter_mut().zip(points).for_each(|(all, points)| all.extend(points));
        self.values.iter_mut().zip(found.values).for_each(|(all, values)| all.extend(values));
        Ok(found.failures)
    }

    /// The range of a quantity over all designs.
    pub(super) fn worst_case(&self, quantity: usize) -> WorstCase {
        let values = &self.values[quantity];
        let (mut least, mut most) = (0, 0);
        for (design, value) in values.iter().enumerate() {
            if *value < values[least] {
                least = design;
            }
            if *value > values[most] {
                most = design;
            }
        }
        let ends = [values[least], values[most]];
        WorstCase { ends, designs: [least, most], is_monotonic: self.is_monotonic(quantity, ends) }
    }

    fn is_monotonic(&self, quantity: usize, ends: [f64; 2]) -> bool {
        let (values, known) = (&self.values[quantity], self.resolutions[quantity]);
        let count = self.points.len();
        let first_corner = single(count, 0);
        let corners = &values[first_corner..];
        let is_steady = |i: usize| {
            let at = |place: usize| values[single(i, place)];
            let line = [at(0), at(1), values[0], at(2), at(3)];
            let mut rises: Vec<f64> = line.windows(2).map(|pair| pair[1] - pair[0]).collect();
            if self.has_all_corners {
                let lower = (0..1_usize << count).filter(|bits| bits >> i & 1 == 0);
                rises.extend(lower.map(|bits| corners[bits | 1 << i] - corners[bits]));
            }
            !(rises.iter().any(|rise| *rise > known) && rises.iter().any(|rise| *rise < -known))
        };
        let of_corners = if self.has_all_corners { &corners[..1 << count] } else { corners };
        let least = of_corners.iter().copied().fold(f64::INFINITY, f64::min);
        let most = of_corners.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        (0..count).all(is_steady) && least - ends[0] <= known && ends[1] - most <= known
    }
}

/// The error of a failed design.
fn fails(parameters: &[TolerancedParameter], design: &[f64], why: &str) -> Error {
    let changed = parameters.iter().zip(design).filter(|(parameter, value)| parameter.value != **value);
    let changed: Vec<String> =
        changed.map(|(parameter, value)| format!("{} = {}", parameter.name, number(*value))).collect();
    let which = if changed.is_empty() { "without tolerances".to_owned() } else { format!("at {}", changed.join(", ")) };
    Error::run(format!("the mechanism {which} fails: {why}")).help("choose other values or smaller tolerances")
}
