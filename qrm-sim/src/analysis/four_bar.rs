//! Four-bar linkages, described by the lengths of their links.

/// The lengths of a four-bar linkage, in m: the distances of the pins on each link.
#[derive(Clone, Copy, Debug)]
pub struct FourBar {
    /// The link that does not move.
    pub ground: f64,
    /// The driven link next to the ground.
    pub input: f64,
    /// The link opposite the ground.
    pub coupler: f64,
    /// The other link next to the ground.
    pub output: f64,
}

/// The class of a four-bar linkage by the motions of its links, after Grashof. With the shortest link `s`, the longest
/// `l`, and the others `p` and `q`, the shortest turns fully relative to all others if `s + l <= p + q`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum GrashofClass {
    /// The input turns fully, the output rocks.
    CrankRocker,
    /// The output turns fully, the input rocks.
    RockerCrank,
    /// Input and output turn fully; also called drag link.
    DoubleCrank,
    /// The coupler turns fully, input and output rock.
    DoubleRocker,
    /// `s + l = p + q`: all links can lie in one line, where branches cross.
    ChangePoint,
    /// `s + l > p + q`: no link turns fully.
    TripleRocker,
}

/// The relative difference below which sums of lengths are equal.
const EQUAL: f64 = 1e-9;

impl FourBar {
    /// The class of the linkage; `None` if the loop cannot be closed.
    pub fn class(&self) -> Option<GrashofClass> {
        let Self { ground, input, coupler, output } = *self;
        let mut sorted = [ground, input, coupler, output];
        sorted.sort_unstable_by(f64::total_cmp);
        let [shortest, p, q, longest] = sorted;
        if !(shortest > 0.0 && longest < shortest + p + q) {
            return None;
        }
        let excess = shortest + longest - (p + q);
        Some(if excess.abs() <= EQUAL * longest {
            GrashofClass::ChangePoint
        } else if excess > 0.0 {
            GrashofClass::TripleRocker
        } else if shortest == ground {
            GrashofClass::DoubleCrank
        } else if shortest == input {
            GrashofClass::CrankRocker
        } else if shortest == output {
            GrashofClass::RockerCrank
        } else {
            GrashofClass::DoubleRocker
        })
    }

    /// The smallest transmission angle over the range of the input, in rad: the acute angle between coupler and output.
    /// `None` if the loop cannot be closed.
    ///
    /// With the distance `f` of the far ends of input and ground, `cos mu = (coupler^2 + output^2 - f^2)/(2 coupler
    /// output)`.
    pub fn transmission_angle(&self) -> Option<f64> {
        self.class()?;
        let Self { ground, input, coupler, output } = *self;
        let nearest = (ground - input).abs().max((coupler - output).abs());
        let farthest = (ground + input).min(coupler + output);
        let angle = |f: f64| {
            let cosine = (coupler.powi(2) + output.powi(2) - f * f) / (2.0 * coupler * output);
            cosine.clamp(-1.0, 1.0).abs().acos()
        };
        Some(angle(nearest).min(angle(farthest)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn class([ground, input, coupler, output]: [f64; 4]) -> Option<GrashofClass> {
        FourBar { ground, input, coupler, output }.class()
    }

    #[test]
    fn every_class_follows_from_the_lengths() {
        use GrashofClass::*;
        assert_eq!(class([4.0, 1.0, 4.0, 3.0]), Some(CrankRocker));
        assert_eq!(class([4.0, 3.0, 4.0, 1.0]), Some(RockerCrank));
        assert_eq!(class([1.0, 3.0, 4.0, 4.0]), Some(DoubleCrank));
        assert_eq!(class([4.0, 3.0, 1.0, 4.0]), Some(DoubleRocker));
        assert_eq!(class([4.0, 2.0, 4.0, 2.0]), Some(ChangePoint));
        assert_eq!(class([0.3, 0.1, 0.3, 0.1]), Some(ChangePoint));
        assert_eq!(class([5.0, 3.0, 4.0, 3.0]), Some(TripleRocker));
        assert_eq!(class([9.0, 3.0, 3.0, 3.0]), None);
        assert_eq!(class([1.0, 0.0, 1.0, 1.0]), None);
    }

    /// The smallest angle over all positions of the input, by brute force.
    #[test]
    fn the_transmission_angle_is_the_smallest_of_a_turn() {
        for [ground, input, coupler, output] in [[4.0, 1.0, 4.0, 3.0], [1.0, 3.0, 2.5, 2.0], [4.0, 3.0, 4.0, 1.5]] {
            let linkage = FourBar { ground, input, coupler, output };
            let mut smallest = f64::INFINITY;
            for step in 0..400_000 {
                let phi = f64::from(step) * std::f64::consts::PI / 4e5;
                let f = (ground - input * phi.cos()).hypot(input * phi.sin());
                let cosine: f64 = (coupler * coupler + output * output - f * f) / (2.0 * coupler * output);
                if cosine.abs() <= 1.0 {
                    smallest = smallest.min(cosine.abs().acos());
                }
            }
            let found = linkage.transmission_angle().expect("it closes");
            assert!(found <= smallest && smallest - found < 5e-3, "{found} {smallest}");
        }
    }
}
