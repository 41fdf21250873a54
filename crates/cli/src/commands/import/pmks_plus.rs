//! Links of PMKS+: settings, joints, links and forces, packed into numbers with 64 digits.

mod payload;

use super::linkage::{End, Joint, Kind, Link, Linkage, Load, Mass, Parameter};
use super::names::Names;
use super::numbers::{pair, shortest};
use super::source::Source;
use crate::error::Error;
use payload::{Force, Payload, Pivot, Rod};

pub(super) use payload::is_of;

/// Reads the mechanism of a link.
pub(super) fn read(source: &Source) -> Result<Linkage, Error> {
    let payload = Payload::read(source)?;
    let mut reader =
        Reader { source, linkage: Linkage::new("a mechanism of PMKS+"), names: Names::new(), links: vec![] };
    reader.names.unique("speed", "speed");
    reader.read(&payload)?;
    Ok(reader.linkage)
}

struct Reader<'s> {
    source: &'s Source,
    linkage: Linkage,
    names: Names,
    /// The identifiers of the links; the ground has none.
    links: Vec<String>,
}

impl Reader<'_> {
    fn read(&mut self, payload: &Payload) -> Result<(), Error> {
        self.links.push(String::new());
        for rod in payload.rods.iter().filter(|rod| rod.is_root) {
            self.link(payload, rod);
        }
        let mut drives = Vec::new();
        for pivot in &payload.pivots {
            if pivot.is_slider {
                self.slider(payload, pivot, &mut drives)?;
            } else {
                self.pin(payload, pivot, &mut drives);
            }
        }
        if !self.linkage.joints.iter().any(|joint| joint.ends.iter().any(|end| end.link == 0)) {
            return Err(self.source.whole("no joint is on the ground", "ground a joint in PMKS+"));
        }
        self.linkage.with_free_links(&mut self.names);
        self.forces(payload)?;
        self.finish(payload, &drives);
        Ok(())
    }

    /// A link with its mass, its frame at its first joint.
    fn link(&mut self, payload: &Payload, rod: &Rod) {
        let first = rod.joints.iter().find_map(|id| payload.pivot(id));
        let place = first.map_or([0.0; 2], |pivot| pivot.place);
        let name = self.names.link(&rod.name, "link");
        let com = if rod.is_block { [0.0; 2] } else { [rod.com[0] - place[0], rod.com[1] - place[1]] };
        let inertia = if rod.is_block { 0.0 } else { rod.inertia };
        let mass = (rod.mass > 0.0 || inertia > 0.0).then_some(Mass { mass: rod.mass, com, inertia });
        self.links.push(rod.id.clone());
        self.linkage.links.push(Link { name, place, angle: 0.0, points: Vec::new(), mass, rate: 0.0 });
    }

    /// The links that have a joint.
    fn holders(&self, payload: &Payload, id: &str) -> Vec<usize> {
        let has = |link: &&Rod| link.is_root && link.joints.iter().any(|joint| joint == id);
        payload.rods.iter().filter(has).filter_map(|rod| self.number(payload, &rod.id)).collect()
    }

    /// The number of a link. A part of a welded link belongs to that.
    fn number(&self, payload: &Payload, id: &str) -> Option<usize> {
        self.links.iter().position(|own| own == id).filter(|number| *number > 0).or_else(|| {
            let whole = payload.rods.iter().find(|rod| rod.is_root && rod.parts.iter().any(|part| part == id))?;
            self.links.iter().position(|own| *own == whole.id)
        })
    }

    fn end(&self, link: usize, place: [f64; 2]) -> End {
        End { link, at: self.linkage.local(link, place) }
    }

    /// A pin of links, and of the ground.
    fn pin(&mut self, payload: &Payload, pivot: &Pivot, drives: &mut Vec<f64>) {
        let mut links = self.holders(payload, &pivot.id);
        // The pin of a block that is welded to it holds the angle too.
        let is_block = |link: &usize| payload.rods.iter().any(|rod| rod.is_block && rod.id == self.links[*link]);
        let is_held = pivot.is_welded && links.iter().any(is_block);
        if pivot.is_grounded && !links.iter().any(is_block) {
            links.push(0);
        }
        let name = self.names.unique(&pivot.name, "joint");
        if links.len() < 2 {
            if let Some(&link) = links.first().filter(|link| **link > 0) {
                let at = self.linkage.local(link, pivot.place);
                self.linkage.links[link].points.push((name.clone(), at));
                self.trace(pivot, &name);
            }
            return;
        }
        let ends = links.iter().map(|link| self.end(*link, pivot.place)).collect();
        let kind = if is_held { Kind::Weld { rotation: 0.0 } } else { Kind::Pin };
        let drive = (pivot.is_input && !is_held).then(|| self.drive(pivot, false, drives));
        self.linkage.joints.push(Joint { title: name.clone(), name: name.clone(), kind, ends, drive });
        if !links.contains(&0) {
            self.trace(pivot, &name);
        }
    }

    /// A slider on the ground, or on a line of a link.
    fn slider(&mut self, payload: &Payload, pivot: &Pivot, drives: &mut Vec<f64>) -> Result<(), Error> {
        let refuse = |title: &str| self.source.error(title, pivot.span.clone(), "", "draw this slider again in PMKS+");
        let links = self.holders(payload, &pivot.id);
        let (line, direction) = match &pivot.slot {
            None => (0, pivot.angle),
            Some([carrier, a, b]) => {
                let (Some(line), Some(a), Some(b)) =
                    (self.number(payload, carrier), payload.pivot(a), payload.pivot(b))
                else {
                    return Err(refuse("the slot of this slider is not known"));
                };
                (line, (b.place[1] - a.place[1]).atan2(b.place[0] - a.place[0]))
            }
        };
        let Some(&first) = links.iter().find(|link| **link != line) else {
            return Err(refuse("this slider has no link that slides"));
        };
        let is_block = payload.rods.iter().any(|rod| rod.is_block && rod.id == self.links[first]);
        let kind = if is_block || pivot.is_welded {
            Kind::Slider { direction, rotation: 0.0 }
        } else {
            Kind::Slot { direction }
        };
        let ends = vec![self.end(first, pivot.place), self.end(line, pivot.place)];
        let name = self.names.unique(&pivot.name, "joint");
        let drive = pivot.is_input.then(|| self.drive(pivot, true, drives));
        self.linkage.joints.push(Joint { title: name.clone(), name, kind, ends, drive });
        let others: Vec<usize> = links.into_iter().filter(|link| *link != line).collect();
        if others.len() > 1 {
            let name = self.names.unique(&format!("{}_pin", pivot.name), "joint");
            let ends = others.iter().map(|link| self.end(*link, pivot.place)).collect();
            self.linkage.joints.push(Joint { title: name.clone(), name, kind: Kind::Pin, ends, drive: None });
        }
        Ok(())
    }

    /// The drive of a joint, whose speed is a parameter.
    fn drive(&mut self, pivot: &Pivot, is_slider: bool, drives: &mut Vec<f64>) -> String {
        drives.push(if is_slider { -1.0 } else { pivot.speed });
        let name = if drives.len() == 1 { "speed".to_owned() } else { self.names.unique("speed", "speed") };
        let (unit, what) = if is_slider { ("m/s", "slider") } else { ("rpm", "pin") };
        let doc = format!("speed of the {what} {}", pivot.name);
        self.linkage.parameters.push(Parameter { name: name.clone(), value: pivot.speed, unit, doc });
        format!("{name}*t")
    }

    /// The place of a joint as outputs, where PMKS+ shows its path.
    fn trace(&mut self, pivot: &Pivot, point: &str) {
        for axis in ["x", "y"].into_iter().filter(|_| pivot.is_traced) {
            let name = self.names.unique(&format!("{axis}_{point}"), "place");
            self.linkage.outputs.push((name, format!("{{ value = '{point}.{axis}', unit = \"m\" }}")));
        }
    }

    fn forces(&mut self, payload: &Payload) -> Result<(), Error> {
        for Force { name, link, at, components, is_local, span } in &payload.forces {
            let Some(number) = self.number(payload, link) else {
                let help = "put the force on a link of the mechanism";
                return Err(self.source.error("the link of this force is not known", span.clone(), "", help));
            };
            let point = self.names.unique(&format!("{name}_point"), "point");
            let local = self.linkage.local(number, *at);
            self.linkage.links[number].points.push((point.clone(), local));
            let force = if *is_local {
                let size = shortest(components[0].hypot(components[1]));
                let angle = self.linkage.turn(number, 0, components[1].atan2(components[0]));
                format!("['{size}*cos({angle})', '{size}*sin({angle})']")
            } else {
                pair(*components)
            };
            let at = format!("{}.{point}", self.linkage.links[number].name);
            self.linkage.loads.push(Load::Force { name: self.names.unique(name, "force"), force, at });
        }
        Ok(())
    }

    /// Gravity, the run and remarks.
    fn finish(&mut self, payload: &Payload, drives: &[f64]) {
        let linkage = &mut self.linkage;
        if payload.has_gravity {
            linkage.loads.insert(0, Load::Gravity([0.0, -9.81]));
        }
        let speed = drives.iter().copied().find(|speed| *speed > 0.0 || *speed < -1.0);
        linkage.end_time = speed.map_or(1.0, |speed| 60.0 / speed.abs());
        linkage.step = linkage.end_time / 1000.0;
        linkage.remarks.push(format!("PMKS+ has {} here; numbers of the scene are in SI units.", payload.units));
        for joint in linkage.joints.iter().filter(|joint| joint.has_force() && payload.has_masses()) {
            let name = self.names.unique(&format!("F_{}", joint.name), "force");
            linkage.outputs.push((name, format!("{{ joint = \"{}\" }}", joint.name)));
        }
        for joint in linkage.joints.iter().filter(|joint| joint.drive.is_some()) {
            let name = self.names.unique(&format!("T_{}", joint.name), "drive");
            linkage.outputs.push((name, format!("{{ drive = \"{}\" }}", joint.name)));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::imported;

    /// A crank of 3 cm and a rod that slides on a line of 90 degrees, with a force on the rod.
    const LINK: &str = "https://app.pmksplus.com/?01.Ay,1E8.K,0.1011.MA,A,0,0,0.GB,B,ku,0,0.GC,C,ku,ku,0.\
                        LP,P,ku,ku,OY..\
                        YRAB,Crank,VG,o,NS,0,c5cae9,A,B,,.YRBC,Connecting rod,ku,6G,ku,NS,303e9f,B,C,,.\
                        YPCP,CP,1Tm,0,0,0,,C,P,,..2F1,BC,F1,ku,ku,ku,VG,Fe..N_J";

    #[test]
    fn a_slider_crank_has_its_masses_its_block_and_its_force() {
        let scene = imported(LINK).expect("a scene");
        let shown = "\
[parameters]
speed = { value = -20, unit = \"rpm\", doc = \"speed of the pin A\" }
[links]
ground         = { points = { A = [0, 0], P_line = [0.03, 0.03] } }
Crank          = { points = { A = [0, 0], B = [0.03, 0] }, mass = 0.002, com = [0.015, 0], inertia = 5e-6 }
Connecting_rod = { points = { B = [0, 0], C = [0, 0.03], F1_point = [0, 0.03] }, mass = 0.003, com = [0, 0.015], \
inertia = 4e-5, angle = 0 }
CP             = { points = { C = [0, 0], P = [0, 0] }, mass = 0.006, com = [0, 0], inertia = 0 }
[joints]
A = { revolute = [\"Crank\", \"ground\"], drive = 'speed*t' }
B = { revolute = [\"Crank\", \"Connecting_rod\"] }
C = { revolute = [\"Connecting_rod\", \"CP\"] }
P = { prismatic = [\"CP\", \"ground.P_line\"], direction = 1.57, start = 0 }
[loads]
gravity = { gravity = [0, -9.81] }
F1      = { force = [0, -1], at = \"Connecting_rod.F1_point\" }
";
        assert!(scene.contains(shown), "{scene}");
    }

    #[test]
    fn errors_name_their_record() {
        let error = |from: &str, to: &str| imported(&LINK.replace(from, to)).expect_err("no scene");
        for (from, to, said) in [
            ("YRAB", "ZRAB", "the kind of this link is not known"),
            ("GB,B,ku", "GB,B,k*", "a number that cannot be read"),
            ("GB,B,ku", "GB,B,zzzzzzzzzz", "a number that is too large"),
            ("F1,BC", "F1,XY", "the link of this force is not known"),
            ("OY..", "OY,AB,A..", "needs a link and two joints"),
            ("1011", "7011", "the unit of length is not known"),
        ] {
            assert!(error(from, to).contains(said), "{}", error(from, to));
        }
    }
}
