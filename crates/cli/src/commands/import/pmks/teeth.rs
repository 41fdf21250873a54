//! Teeth of gears and racks.

use super::super::linkage::{End, Joint, Kind, rotated};
use super::Reader;
use super::line::Line;
use crate::error::Error;

impl Reader<'_> {
    /// Adds gear teeth. Both links have pins on a third one, which carries them.
    pub(super) fn teeth(&mut self, lines: &[Line], line: &Line, gears: [usize; 2]) -> Result<(), Error> {
        let mut found = None;
        for first in lines.iter().filter(|other| other.links.len() > 1) {
            for second in lines.iter().filter(|other| other.links.len() > 1) {
                let numbers = |other: &Line| -> Vec<usize> {
                    other.links.iter().filter_map(|(name, _)| self.known(name)).collect()
                };
                let [a, b] = [numbers(first), numbers(second)];
                let carrier = a.iter().copied().find(|link| b.contains(link) && !gears.contains(link));
                if let Some(carrier) = carrier
                    && a.contains(&gears[0])
                    && b.contains(&gears[1])
                {
                    found = found.or(Some((first, second, carrier)));
                }
            }
        }
        let Some((first, second, carrier)) = found else {
            let help = "join both gears to one link, by pins, or a rack by a slider";
            return Err(self.source.error(
                "these teeth have no carrier",
                line.span.clone(),
                "no link joins both gears",
                help,
            ));
        };
        let arm = |other: &Line| [other.place[0] - line.place[0], other.place[1] - line.place[1]];
        let [a, b] = [arm(first), arm(second)];
        let name = self.names.unique("teeth", "teeth");
        if first.kind == "P" || second.kind == "P" {
            let ([gear, rack], arm, slide) =
                if first.kind == "P" { ([gears[1], gears[0]], b, first) } else { (gears, a, second) };
            let [axis, side] = [[1.0, 0.0], [0.0, 1.0]].map(|axis| rotated(axis, slide.direction));
            let [along, radius] = [axis, side].map(|axis| axis[0] * arm[0] + axis[1] * arm[1]);
            if along.abs() > 1e-6 * radius.abs() {
                let help = "put the teeth where the perpendicular through the centre of the gear meets the rack";
                return Err(self.source.error(
                    "these teeth are not below the centre of their gear",
                    line.span.clone(),
                    "",
                    help,
                ));
            }
            let centre = if first.kind == "P" { second.place } else { first.place };
            let ends = vec![self.end(gear, centre), self.end(rack, line.place)];
            let kind = Kind::Rack { radius, direction: slide.direction };
            self.linkage.joints.push(Joint { model_name: name.clone(), name, kind, ends, drive: None });
            return Ok(());
        }
        let [r1, r2] = [a, b].map(|[x, y]| x.hypot(y));
        let (cross, dot) = (a[0] * b[1] - a[1] * b[0], a[0] * b[0] + a[1] * b[1]);
        if !(cross.abs() <= 1e-6 * r1 * r2) || r1 == 0.0 || r2 == 0.0 {
            let help = "put the teeth on the line through both centres";
            return Err(self.source.error("these teeth are not between the centres", line.span.clone(), "", help));
        }
        let ratio = if dot > 0.0 { r2 / r1 } else { -r2 / r1 };
        let ends = gears.map(|link| End { link, at: [0.0; 2] }).to_vec();
        self.linkage.joints.push(Joint {
            model_name: name.clone(),
            name,
            kind: Kind::Gear { ratio, phase: 0.0, carrier },
            ends,
            drive: None,
        });
        Ok(())
    }
}
