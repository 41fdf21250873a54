//! Refuses models that cannot move, and finds inputs that repeat others.

use super::independent_coordinates::{can_be_driven, freedom, repeated_drives};
use super::linkage::ImportedLinkage;
use super::source::Source;
use crate::error::Error;

/// The number of joints that an error names.
const SHOWN: usize = 12;

/// Refuses a linkage whose joints and constraints leave no freedom. Drives do not count.
pub(super) fn check(source: &Source, linkage: &ImportedLinkage) -> Result<(), Error> {
    if freedom(linkage) > 0 {
        return Ok(());
    }
    let joints = linkage.joints.iter().map(|joint| &joint.name);
    let names: Vec<&str> =
        joints.chain(linkage.constraints.iter().map(|constraint| &constraint.name)).map(String::as_str).collect();
    let mut shown = names.iter().take(SHOWN).map(|name| format!("`{name}`")).collect::<Vec<_>>().join(", ");
    if names.len() > SHOWN {
        shown.push_str(" and others");
    }
    let title = format!("this model cannot move: its joints leave no freedom ({shown})");
    Err(source.whole(&title, "leave out a joint or a constraint, or import a model with a degree of freedom"))
}

impl ImportedLinkage {
    /// Leaves out the inputs whose motion the first input determines.
    pub(super) fn drop_further_inputs(&mut self) {
        let driven: Vec<usize> = (0..self.joints.len()).filter(|joint| self.joints[*joint].drive.is_some()).collect();
        for joint in self.drop_repeated_drives(&driven) {
            let name = &self.joints[joint].name;
            self.left_out.push(format!("the input `{name}`, whose motion the other input determines"));
        }
    }

    /// Removes the drives that repeat others, with their parameters. Of these joints, the drive of the first one that
    /// can move the linkage stays: at a dead centre an input cannot.
    pub(super) fn drop_repeated_drives(&mut self, inputs: &[usize]) -> Vec<usize> {
        let possible = inputs.iter().find(|joint| can_be_driven(self, **joint));
        let Some(&first) = possible.or(inputs.first()) else { return Vec::new() };
        let repeated = repeated_drives(self, first);
        for joint in &repeated {
            let formula = self.joints[*joint].drive.take().unwrap_or_default();
            self.parameters.retain(|parameter| formula != format!("{}*t", parameter.name));
        }
        repeated
    }
}

#[cfg(test)]
mod tests {
    use super::super::imported;

    #[test]
    fn models_without_freedom_are_refused() {
        let error = imported("ground a R 0 0\na b R 1 0\nb ground R 1 1").expect_err("no scene");
        assert!(error.contains("this model cannot move: its joints leave no freedom (`A`, `B`, `C`)"), "{error}");
    }
}
