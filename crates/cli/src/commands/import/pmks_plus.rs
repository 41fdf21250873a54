//! Links of PMKS+: settings, joints, links and forces, packed into numbers with 64 digits.

mod payload;

use super::linkage::{End, ImportedLinkage, Joint, Kind, Link, Load, Mass, Parameter};
use super::names::Names;
use super::source::Source;
use crate::error::Error;
use payload::{Force, Payload};

pub(super) use payload::recognizes;

/// Reads the mechanism that a shared link contains.
pub(super) fn read(source: &Source) -> Result<ImportedLinkage, Error> {
    let payload = Payload::read(source)?;
    let mut reader =
        Reader { source, linkage: ImportedLinkage::new("a mechanism of PMKS+"), names: Names::new(), links: vec![] };
    reader.names.unique("speed", "speed");
    reader.read(&payload)?;
    Ok(reader.linkage)
}

struct Reader<'s> {
    source: &'s Source,
    linkage: ImportedLinkage,
    names: Names,
    /// The identifiers of the links of the mechanism. That of the ground is empty.
    links: Vec<String>,
}

impl Reader<'_> {
    fn read(&mut self, payload: &Payload) -> Result<(), Error> {
        self.links.push(String::new());
        for record in payload.links.iter().filter(|link| link.is_root) {
            self.link(payload, record);
        }
        let mut drives = Vec::new();
        for record in &payload.joints {
            if record.is_slider {
                self.slider(payload, record, &mut drives)?;
            } else {
                self.pin(payload, record, &mut drives);
            }
        }
        if !self.linkage.joints.iter().any(|joint| joint.ends.iter().any(|end| end.link == 0)) {
            return Err(self.source.whole("no joint is on the ground", "ground a joint in PMKS+"));
        }
        self.linkage.connect_free_links(&mut self.names);
        self.forces(payload)?;
        self.linkage.drop_further_inputs();
        self.finish(payload, &drives);
        Ok(())
    }

    /// Adds a link with its mass. Its frame is at its first joint.
    fn link(&mut self, payload: &Payload, record: &payload::Link) {
        let first = record.joints.iter().find_map(|id| payload.joint(id));
        let place = first.map_or([0.0; 2], |joint| joint.place);
        let name = self.names.link(&record.name, "link");
        let com = if record.is_block { [0.0; 2] } else { [record.com[0] - place[0], record.com[1] - place[1]] };
        let inertia = if record.is_block { 0.0 } else { record.inertia };
        let mass = (record.mass > 0.0 || inertia > 0.0).then_some(Mass { mass: record.mass, com, inertia });
        self.links.push(record.id.clone());
        self.linkage.links.push(Link { mass, ..Link::new(name, place, 0.0) });
    }

    /// The links that have a joint.
    fn holders(&self, payload: &Payload, id: &str) -> Vec<usize> {
        let has = |link: &&payload::Link| link.is_root && link.joints.iter().any(|joint| joint == id);
        payload.links.iter().filter(has).filter_map(|link| self.number(payload, &link.id)).collect()
    }

    /// The number of a link. A part of a welded link has the number of the welded link.
    fn number(&self, payload: &Payload, id: &str) -> Option<usize> {
        self.links.iter().position(|own| own == id).filter(|number| *number > 0).or_else(|| {
            let whole =
                payload.links.iter().find(|whole| whole.is_root && whole.parts.iter().any(|part| part == id))?;
            self.links.iter().position(|own| *own == whole.id)
        })
    }

    fn end(&self, link: usize, place: [f64; 2]) -> End {
        End { link, at: self.linkage.local(link, place) }
    }

    /// Adds a pin of links, or a point of one link.
    fn pin(&mut self, payload: &Payload, record: &payload::Joint, drives: &mut Vec<Option<f64>>) {
        let mut links = self.holders(payload, &record.id);
        // The pin of a block that is welded to it holds the angle too.
        let is_block = |link: &usize| payload.links.iter().any(|other| other.is_block && other.id == self.links[*link]);
        let is_held = record.is_welded && links.iter().any(is_block);
        if record.is_grounded && !links.iter().any(is_block) {
            links.push(0);
        }
        let name = self.names.unique(&record.name, "joint");
        if links.len() < 2 {
            if let Some(&link) = links.first().filter(|link| **link > 0) {
                let at = self.linkage.local(link, record.place);
                self.linkage.links[link].points.push((name.clone(), at));
                self.trace(record, &name);
            }
            return;
        }
        let ends = links.iter().map(|link| self.end(*link, record.place)).collect();
        let kind = if is_held { Kind::Weld { rotation: 0.0 } } else { Kind::Pin };
        let drive = (record.is_input && !is_held).then(|| self.drive(record, false, drives));
        self.linkage.joints.push(Joint { model_name: name.clone(), name: name.clone(), kind, ends, drive });
        if !links.contains(&0) {
            self.trace(record, &name);
        }
    }

    /// Adds a slider on the ground, or on a line of a link.
    fn slider(
        &mut self,
        payload: &Payload,
        record: &payload::Joint,
        drives: &mut Vec<Option<f64>>,
    ) -> Result<(), Error> {
        let refuse = |title: &str| self.source.error(title, record.span.clone(), "", "draw this slider again in PMKS+");
        let links = self.holders(payload, &record.id);
        let (line, direction) = match &record.slot {
            None => (0, record.angle),
            Some([carrier, a, b]) => {
                let (Some(line), Some(a), Some(b)) =
                    (self.number(payload, carrier), payload.joint(a), payload.joint(b))
                else {
                    return Err(refuse("the slot of this slider is not known"));
                };
                (line, (b.place[1] - a.place[1]).atan2(b.place[0] - a.place[0]))
            }
        };
        let Some(&first) = links.iter().find(|link| **link != line) else {
            return Err(refuse("this slider has no link that slides"));
        };
        let is_block = payload.links.iter().any(|other| other.is_block && other.id == self.links[first]);
        let kind = if is_block || record.is_welded {
            Kind::Slider { direction, rotation: 0.0 }
        } else {
            Kind::Slot { direction }
        };
        let ends = vec![self.end(first, record.place), self.end(line, record.place)];
        let name = self.names.unique(&record.name, "joint");
        let drive = record.is_input.then(|| self.drive(record, true, drives));
        self.linkage.joints.push(Joint { model_name: name.clone(), name, kind, ends, drive });
        let others: Vec<usize> = links.into_iter().filter(|link| *link != line).collect();
        if others.len() > 1 {
            let name = self.names.unique(&format!("{}_pin", record.name), "joint");
            let ends = others.iter().map(|link| self.end(*link, record.place)).collect();
            self.linkage.joints.push(Joint { model_name: name.clone(), name, kind: Kind::Pin, ends, drive: None });
        }
        Ok(())
    }

    /// The formula of the drive of a joint. Its speed is a parameter, and that of a pin is noted in `drives`.
    fn drive(&mut self, record: &payload::Joint, is_slider: bool, drives: &mut Vec<Option<f64>>) -> String {
        drives.push((!is_slider).then_some(record.speed));
        let name = if drives.len() == 1 { "speed".to_owned() } else { self.names.unique("speed", "speed") };
        let (unit, what) = if is_slider { ("m/s", "slider") } else { ("rpm", "pin") };
        let doc = format!("speed of the {what} {}", record.name);
        self.linkage.parameters.push(Parameter { name: name.clone(), value: record.speed, unit, doc });
        format!("{name}*t")
    }

    /// Adds the coordinates of a joint as outputs, if PMKS+ shows its path.
    fn trace(&mut self, record: &payload::Joint, point: &str) {
        if record.is_traced {
            self.linkage.trace_point(point, &mut self.names);
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
            // The frames of all links have the axes of the ground at the start.
            let link = &self.linkage.links[number].name;
            let (at, frame) = (format!("{link}.{point}"), is_local.then(|| link.clone()));
            let name = self.names.unique(name, "force");
            self.linkage.loads.push(Load::Force { name, force: *components, at, frame });
        }
        Ok(())
    }

    /// Adds gravity, the run, remarks and outputs.
    fn finish(&mut self, payload: &Payload, drives: &[Option<f64>]) {
        let linkage = &mut self.linkage;
        if payload.has_gravity {
            linkage.loads.insert(0, Load::Gravity([0.0, -9.81]));
        }
        let speed = drives.iter().flatten().find(|speed| **speed != 0.0);
        linkage.end_time = speed.map_or(1.0, |speed| 60.0 / speed.abs());
        linkage.step = linkage.end_time / 1000.0;
        linkage.remarks.push(format!("PMKS+ has {} here; numbers of the scene are in SI units.", payload.units));
        linkage.add_joint_forces(&mut self.names);
        for joint in 0..linkage.joints.len() {
            if linkage.joints[joint].drive.is_some() {
                linkage.add_drive_force(joint, &mut self.names);
            }
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
                        YPCP,CP,1Tm,0,0,0,,C,P,,..2F1,BC,F1,ku,ku,ku,VG,Fe..N_H";

    /// Sets the last character of a link, which is the length of the others.
    fn sealed(link: &str) -> String {
        const DIGITS: &str = "0123456789ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz";
        let body = &link[..link.len() - 1];
        let count = body.len() - body.find('?').map_or(0, |at| at + 1);
        format!("{body}{}", &DIGITS[count % 62..=count % 62])
    }

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
    fn forces_that_turn_with_their_link_are_in_its_frame() {
        let scene = imported(&sealed(&LINK.replace("..2F1,BC", "..3F1,BC"))).expect("a scene");
        let force = "F1      = { force = [0, -1], at = \"Connecting_rod.F1_point\", frame = \"Connecting_rod\" }";
        assert!(scene.contains(force), "{scene}");
    }

    #[test]
    fn a_turn_of_the_slowest_input_ends_the_run() {
        // The speed is 0.5 turns a minute, in the sense of clocks.
        let scene = imported(&sealed(&LINK.replace("A,0,0,0.GB", "A,0,0,0,,,,07q.GB"))).expect("a scene");
        assert!(scene.contains("speed = { value = -0.5,") && scene.contains("end_time = 120 }"), "{scene}");
    }

    #[test]
    fn errors_name_their_record() {
        let error = |from: &str, to: &str| imported(&sealed(&LINK.replace(from, to))).expect_err("no scene");
        for (from, to, said) in [
            ("YRAB", "ZRAB", "the kind of this link is not known"),
            ("GB,B,ku", "GB,B,k*", "a number that cannot be read"),
            ("GB,B,ku", "GB,B,zzzzzzzzzz", "a number that is too large"),
            ("F1,BC", "F1,XY", "the link of this force is not known"),
            ("OY..", "OY,AB,A..", "needs a link and two joints"),
            ("1011", "7011", "the unit of length is not known"),
            ("A,B,,", "A,X,,", "the link `AB` has a joint `X`, which is missing"),
            ("YRBC,", "YRAB,", "the link `AB` is there twice"),
            ("GB,B,", "GA,B,", "the joint `A` is there twice"),
            ("VG,Fe..", "VG,..", "a number that is missing"),
            ("A,B,,.", "A,B.", "the list of joints of this link has no end"),
        ] {
            assert!(error(from, to).contains(said), "{}", error(from, to));
        }
    }

    #[test]
    fn links_that_are_not_whole_are_refused() {
        for text in [&LINK[..LINK.len() - 1], &LINK[..LINK.len() - 9], &LINK.replace("N_H", "N_J")] {
            let error = imported(text).expect_err("no scene");
            assert!(error.contains("this link is not whole") && error.contains("copy the whole link again"), "{error}");
        }
        assert!(imported(&LINK.replace("Connecting rod", "Connecting%20rod")).is_ok());
        assert!(imported(&format!("{LINK})")).is_ok());
    }
}
