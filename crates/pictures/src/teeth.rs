//! The teeth of gears: their numbers from the radii, and their meshing.

use std::f64::consts::{PI, TAU};

use qrm_view::motion::{Node, Shape};

use crate::parts::seen_from;

/// The approximate number of teeth of a small gear.
const LEAST: u32 = 12;
const MOST: u32 = 40;
/// The largest number of teeth; more could not be distinguished.
const FINEST: u32 = 400;
/// The largest distance of touching pitch circles, relative to their radii.
const NEAR: f64 = 1e-6;

/// Adds teeth to all gears and racks. Gears that touch in the first frame get equal, meshing teeth.
pub(super) fn mesh(shapes: &mut [Shape], nodes: &[Node]) {
    let mut gears: Vec<Gear> =
        shapes.iter().enumerate().filter_map(|(place, shape)| Gear::new(place, shape, nodes)).collect();
    let mut trains: Vec<Vec<usize>> = Vec::new();
    for first in 0..gears.len() {
        if trains.iter().any(|train| train.contains(&first)) {
            continue;
        }
        let mut train = vec![first];
        let mut done = 0;
        while let Some(&driver) = train.get(done) {
            done += 1;
            for driven in 0..gears.len() {
                if !train.contains(&driven) && gears[driver].touches(&gears[driven]) {
                    gears[driven].driver = Some(driver);
                    train.push(driven);
                }
            }
        }
        trains.push(train);
    }
    for train in &trains {
        let radii: Vec<f64> = train.iter().map(|&gear| gears[gear].radius).collect();
        for (&gear, teeth) in train.iter().zip(numbers(&radii)) {
            gears[gear].teeth = teeth;
            if let Some(driver) = gears[gear].driver {
                gears[gear].tooth = gears[driver].meshing(&gears[gear]);
            }
        }
    }
    for gear in &gears {
        if let Shape::Gear { teeth, phase, angle, .. } = &mut shapes[gear.place] {
            let turned = gear.tooth - angle.first().copied().unwrap_or(0.0);
            (*teeth, *phase) = (gear.teeth, turned.rem_euclid(gear.pitch()));
        }
    }
    for shape in shapes.iter_mut() {
        mesh_rack(shape, nodes, &gears);
    }
}

/// Adds the teeth of the touching gear to a rack.
fn mesh_rack(shape: &mut Shape, nodes: &[Node], gears: &[Gear]) {
    let Shape::Rack { node, angle, across, pitch, phase, .. } = shape else { return };
    let Some(direction) = angle.first().copied() else { return };
    let sign = pitch.signum();
    let local = |gear: &Gear| seen_from(place(&nodes[*node]), direction, gear.at);
    let touches = |gear: &&Gear| (local(gear)[1] - *across - sign * gear.radius).abs() <= NEAR * gear.radius;
    let Some(gear) = gears.iter().filter(|gear| !gear.is_internal).find(touches) else { return };
    // A gap of the gear faces a tooth of the rack.
    let contact = direction - sign * 0.5 * PI;
    let gap = gear.tooth + 0.5 * gear.pitch() - contact;
    *pitch = sign * gear.radius * gear.pitch();
    *phase = local(gear)[0] + sign * gear.radius * (gap % gear.pitch());
}

/// A gear in the first frame.
struct Gear {
    /// The index of the gear among the shapes.
    place: usize,
    at: [f64; 2],
    radius: f64,
    is_internal: bool,
    teeth: u32,
    /// The angle of one of its teeth.
    tooth: f64,
    /// The gear that determines the angle of its teeth.
    driver: Option<usize>,
}

impl Gear {
    fn new(number: usize, shape: &Shape, nodes: &[Node]) -> Option<Self> {
        let Shape::Gear { node, angle, radius, is_internal, .. } = shape else { return None };
        let tooth = angle.first().copied().unwrap_or(0.0);
        let (at, radius, is_internal) = (place(&nodes[*node]), *radius, *is_internal);
        Some(Self { place: number, at, radius, is_internal, teeth: LEAST, tooth, driver: None })
    }

    /// The angle between consecutive teeth.
    fn pitch(&self) -> f64 {
        TAU / f64::from(self.teeth)
    }

    fn distance(&self, other: &Self) -> f64 {
        (other.at[0] - self.at[0]).hypot(other.at[1] - self.at[1])
    }

    fn touches(&self, other: &Self) -> bool {
        let apart = match (self.is_internal, other.is_internal) {
            (false, false) => self.radius + other.radius,
            (true, false) => self.radius - other.radius,
            (false, true) => other.radius - self.radius,
            (true, true) => return false,
        };
        let are_sized = self.radius > 0.0 && other.radius > 0.0 && apart > 0.0;
        are_sized && (self.distance(other) - apart).abs() <= NEAR * (self.radius + other.radius)
    }

    /// The angle of a tooth of another gear that meshes with this one.
    fn meshing(&self, other: &Self) -> f64 {
        let towards = |from: &Self, to: &Self| (to.at[1] - from.at[1]).atan2(to.at[0] - from.at[0]);
        let is_within = self.is_internal || other.is_internal;
        let contact = if other.is_internal { towards(other, self) } else { towards(self, other) };
        // Both move past the contact by the same distance; inside a ring, in the same direction.
        let way = self.radius * ((self.tooth - contact) % self.pitch()) / other.radius;
        let gap = if is_within { contact + way } else { contact + PI - way };
        gap + 0.5 * other.pitch()
    }
}

fn place(node: &Node) -> [f64; 2] {
    [&node.x, &node.y].map(|track| track.first().copied().unwrap_or(0.0))
}

/// Numbers of teeth whose ratios approximate those of the radii.
fn numbers(radii: &[f64]) -> Vec<u32> {
    let least = radii.iter().copied().fold(f64::INFINITY, f64::min);
    let exact = |of_least: u32| radii.iter().map(move |radius| f64::from(of_least) * radius / least);
    let error = |of_least: u32| exact(of_least).map(|teeth| (teeth - teeth.round()).abs()).fold(0.0, f64::max);
    let fits = (LEAST..=MOST).find(|of_least| error(*of_least) < 1e-6);
    let best = || (LEAST..=MOST).min_by(|a, b| error(*a).total_cmp(&error(*b)));
    let of_least = fits.or_else(best).unwrap_or(LEAST);
    exact(of_least).map(|teeth| (teeth.round() as u32).clamp(LEAST, FINEST)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn gear(node: usize, radius: f64, is_internal: bool) -> Shape {
        let name = String::new();
        Shape::Gear { name, node, angle: vec![0.3 * node as f64], radius, teeth: 1, phase: 0.0, is_internal }
    }

    /// The position of a gear's teeth in the first frame, seen from its centre in a direction, in pitches.
    fn offset(shape: &Shape, direction: f64) -> f64 {
        let Shape::Gear { angle, teeth, phase, .. } = shape else { panic!("{shape:?}") };
        let pitch = TAU / f64::from(*teeth);
        ((angle[0] + phase - direction) / pitch).rem_euclid(1.0)
    }

    #[test]
    fn teeth_mesh_in_a_planetary_gear() {
        let place = |x: f64, y: f64| Node { name: String::new(), is_traced: false, x: vec![x], y: vec![y] };
        let direction = 0.7_f64;
        let nodes = [place(0.0, 0.0), place(0.042 * direction.cos(), 0.042 * direction.sin())];
        let mut shapes = vec![gear(0, 0.06, true), gear(0, 0.024, false), gear(1, 0.018, false)];
        mesh(&mut shapes, &nodes);
        let teeth = |shape: &Shape| if let Shape::Gear { teeth, .. } = shape { *teeth } else { 0 };
        assert_eq!([0, 1, 2].map(|i| teeth(&shapes[i])), [40, 16, 12]);
        let is_half = |difference: f64| (difference.rem_euclid(1.0) - 0.5).abs() < 1e-9;
        let (ring, sun) = (offset(&shapes[0], direction), offset(&shapes[1], direction));
        let [outside, inside] = [direction, direction + PI].map(|direction| offset(&shapes[2], direction));
        assert!(is_half(ring - outside), "{ring} {outside}");
        assert!(is_half(sun + inside), "{sun} {inside}");
    }

    #[test]
    fn gears_that_do_not_fit_have_teeth_too() {
        assert_eq!(numbers(&[0.1, 0.25]), [12, 30]);
        let odd = numbers(&[1.0, std::f64::consts::PI]);
        assert!(odd[0] >= LEAST && (f64::from(odd[1]) / f64::from(odd[0]) - PI).abs() < 0.05, "{odd:?}");
    }
}
