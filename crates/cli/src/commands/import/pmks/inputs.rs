//! Inputs, and joints that are written twice.

use super::super::numbers::pair;
use super::Reader;
use super::line::Line;
use crate::error::Error;

impl Reader<'_> {
    /// Leaves out the inputs whose motion the last input determines.
    pub(super) fn drop_inputs(&mut self) {
        let inputs: Vec<usize> = self.inputs.iter().rev().map(|input| input.joint).collect();
        let dropped = self.linkage.drop_repeated_drives(&inputs);
        for input in self.inputs.iter().filter(|input| dropped.contains(&input.joint)) {
            let place = pair(input.place);
            self.linkage.left_out.push(format!("the input at {place}, whose motion the other input determines"));
        }
        self.inputs.retain(|input| !dropped.contains(&input.joint));
    }

    /// Refuses a joint that is written twice.
    pub(super) fn check_repetition(&self, lines: &[Line]) -> Result<(), Error> {
        let links = |line: &Line| {
            let mut links: Vec<_> = line.links.iter().map(|(name, _)| self.known(name)).collect();
            links.sort_unstable();
            links
        };
        let mut seen = std::collections::HashSet::new();
        for line in lines.iter().filter(|line| line.links.len() > 1) {
            // Links and places of pins are the same in any order.
            let place = line.place.map(f64::to_bits);
            if !seen.insert((line.kind.clone(), place, links(line))) {
                let help = "leave this line out";
                let title = "this joint is written twice";
                return Err(self.source.error(title, line.span.clone(), "same links, type and place", help));
            }
        }
        Ok(())
    }
}
