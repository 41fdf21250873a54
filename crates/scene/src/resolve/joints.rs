//! Rules of joints that cannot be checked after their expansion.

use num_dual::Dual2_64;

use super::Resolver;
use super::context::Context;
use crate::diagnostic::Diagnostic;
use crate::document::{Document, JointKind, JointSyntax};
use crate::evaluate::evaluate;
use crate::function::Differentiable;
use crate::parser::Formula;
use crate::scene::{Quantity, Scene, Value};

/// The largest difference of a periodic profile after one turn, relative to its size.
const SAME: f64 = 1e-9;
/// The angles at which periodicity is tested.
const ANGLES: [f64; 4] = [0.1, 1.7, 3.3, 4.9];

impl Resolver<'_> {
    /// Checks that sizes of joints are constants, that some are positive, and that a cam profile depends on its angle
    /// alone.
    pub(super) fn check_joints(&mut self, document: &Document, scene: &Scene) {
        for joint in &document.joints {
            let friction = joint.friction.as_ref();
            let radius = friction.and_then(|friction| friction.radius.as_ref());
            for (own, what) in radius
                .map(|own| (own, "the radius of joint"))
                .into_iter()
                .chain(joint.radii.iter().flatten().map(|own| (own, "a radius of joint")))
            {
                self.check_positive(scene, joint, own, what);
            }
            if let (JointKind::Gear, None, Some(ratio)) = (joint.kind, &joint.radii, &joint.size) {
                self.check_not_zero(scene, joint, ratio);
            }
            let constants = friction.into_iter().flat_map(|friction| [&friction.mu, &friction.slip]).chain(&joint.face);
            for constant in constants {
                self.value(constant, Context::Constant);
            }
            if let Some(profile) = &joint.profile {
                let profile = self.value(profile, Context::Profile);
                self.check_turn(scene, joint, &profile);
                self.check_shape(scene, joint, &profile);
            }
        }
    }

    fn check_not_zero(&mut self, scene: &Scene, joint: &JointSyntax, ratio: &Formula) {
        let value = self.value(ratio, Context::Constant);
        if at(scene, &value, f64::NAN) == 0.0 {
            let title = format!("the ratio of joint `{}` is zero", joint.identifier.name);
            let error = Diagnostic::error(title, value.whole_span(), "the first link would not turn");
            self.findings
                .push(error.help("write the ratio of teeth, negative for gears side by side, or weld the link"));
        }
    }

    fn check_positive(&mut self, scene: &Scene, joint: &JointSyntax, own: &Formula, what: &str) {
        let value = self.value(own, Context::Constant);
        let size = at(scene, &value, f64::NAN);
        if size <= 0.0 {
            let title = format!("{what} `{}` is not positive", joint.identifier.name);
            let error = Diagnostic::error(title, value.whole_span(), format!("its value is {size}"));
            self.findings.push(error.help("write its size; a belt that turns the other way is `crossed = true`"));
        }
    }

    /// Warns of a profile that is not periodic.
    fn check_turn(&mut self, scene: &Scene, joint: &JointSyntax, profile: &Value) {
        let comes_back = |theta: f64| {
            let [now, then] = [theta, theta + std::f64::consts::TAU].map(|theta| at(scene, profile, theta));
            !((now - then).abs() > SAME * (now.abs() + then.abs()))
        };
        if !ANGLES.into_iter().all(comes_back) {
            let title = format!("the profile of joint `{}` differs after one turn", joint.identifier.name);
            let warning = Diagnostic::warning(title, profile.whole_span(), "does not come back");
            self.findings.push(warning.help(
                "`theta` grows beyond a turn: use functions with the period `2*pi`, or a table with `spline = \
                 \"periodic\"`",
            ));
        }
    }

    /// Warns of a profile with a negative radius, or one that a flat face cannot follow: its radius of curvature,
    /// `h + h''`, must be positive.
    fn check_shape(&mut self, scene: &Scene, joint: &JointSyntax, profile: &Value) {
        let is_flat = joint.face.is_some();
        let radius = |theta: f64| {
            let h: Dual2_64 = evaluate(profile, lookup(scene, Dual2_64::from_re(theta).derivative()));
            if is_flat { h.re + h.v2 } else { h.re }
        };
        let degrees = (0..360).map(f64::from);
        let smallest = degrees.map(|degree| (radius(degree.to_radians()), degree)).min_by(|a, b| a.0.total_cmp(&b.0));
        let Some((radius, degree)) = smallest.filter(|(radius, _)| *radius < 0.0) else { return };
        let name = &joint.identifier.name;
        let (title, help) = match is_flat {
            true => (
                format!("no flat face can follow the profile of joint `{name}`"),
                "the profile plus its second derivative by `theta` is a radius of curvature: make the base circle \
                 larger",
            ),
            false => (format!("the profile of joint `{name}` has a negative radius"), "make the base circle larger"),
        };
        let label =
            format!("its radius{} is {radius:.3e} m at {degree} degrees", if is_flat { " of curvature" } else { "" });
        self.findings.push(Diagnostic::warning(title, profile.whole_span(), label).help(help));
    }
}

/// The value of a formula of parameters and the angle of a cam.
fn at(scene: &Scene, value: &Value, theta: f64) -> f64 {
    evaluate(value, lookup(scene, theta))
}

fn lookup<D: Differentiable>(scene: &Scene, theta: D) -> impl Fn(&Quantity) -> D {
    move |quantity| match quantity {
        Quantity::Parameter(i) => D::from(scene.parameters[*i].value),
        Quantity::Pi => D::from(std::f64::consts::PI),
        Quantity::Stretch => theta,
        _ => D::from(f64::NAN),
    }
}
