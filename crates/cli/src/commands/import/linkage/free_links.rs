//! Links that no joint connects with the ground.

use super::super::names::Names;
use super::{End, ImportedLinkage, Joint, Kind, Link};

impl ImportedLinkage {
    /// Connects the links to the ground that no chain of joints connects with it. Links with mass move freely, links
    /// without mass are fixed.
    pub(in super::super) fn connect_free_links(&mut self, names: &mut Names) {
        let count = self.links.len();
        let mut is_connected = vec![false; count];
        for link in 0..count {
            if is_connected[link] {
                continue;
            }
            let component = self.component(link);
            component.iter().for_each(|other| is_connected[*other] = true);
            if link == 0 {
                continue;
            }
            if component.iter().any(|other| self.links[*other].mass.is_some()) {
                self.free(link, names);
                continue;
            }
            let Link { name, place, angle, .. } = &self.links[link];
            self.left_out.push(format!("the motion of `{name}`, which has no mass and no joint with the rest"));
            let ends = vec![End { link, at: [0.0; 2] }, End { link: 0, at: *place }];
            let (name, kind) = (names.unique(name, "part"), Kind::Weld { rotation: *angle });
            self.joints.push(Joint { model_name: String::new(), name, kind, ends, drive: None });
        }
    }

    /// The links that joints connect with a link.
    fn component(&self, link: usize) -> Vec<usize> {
        let mut found = vec![link];
        let mut at = 0;
        while let Some(&own) = found.get(at) {
            for joint in self.joints.iter().filter(|joint| joint.ends.iter().any(|end| end.link == own)) {
                for end in &joint.ends {
                    if !found.contains(&end.link) {
                        found.push(end.link);
                    }
                }
            }
            at += 1;
        }
        found
    }

    /// Connects a link to the ground by two sliders and a pin.
    fn free(&mut self, link: usize, names: &mut Names) {
        let Link { name, place, velocity, .. } = &self.links[link];
        let (name, place, velocity) = (name.clone(), *place, *velocity);
        let mut below = End { link: 0, at: place };
        for (axis, direction) in [("x", 0.0), ("y", std::f64::consts::FRAC_PI_2)] {
            let number = self.links.len();
            let own = names.link(&format!("{name}_{axis}"), "part");
            // The second link moves with the first one.
            let along_y = if axis == "y" { velocity[1] } else { 0.0 };
            self.links.push(Link { velocity: [velocity[0], along_y], ..Link::new(own, place, 0.0) });
            let end = End { link: number, at: [0.0; 2] };
            let own = names.unique(&format!("{name}_{axis}"), "slide");
            let kind = Kind::Slider { direction, rotation: 0.0 };
            self.joints.push(Joint { model_name: String::new(), name: own, kind, ends: vec![end, below], drive: None });
            below = end;
        }
        let own = names.unique(&format!("{name}_turn"), "turn");
        let ends = vec![End { link, at: [0.0; 2] }, below];
        self.joints.push(Joint { model_name: String::new(), name: own, kind: Kind::Pin, ends, drive: None });
    }
}
