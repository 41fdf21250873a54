//! Forces and moments on bodies other than loads and constraints, by the principle of virtual work.

use symbolica::atom::Atom;

use super::system::System;
use qrm_codegen::term::Symbol;
use qrm_scene::scene::{Displacement, LoadKind, Turn, Value};

/// A virtual displacement: by a vector, and by an angle about a point.
pub(super) struct VirtualDisplacement {
    along: [Atom; 2],
    turn: Atom,
    about: Option<[Atom; 2]>,
}

impl VirtualDisplacement {
    /// Creates a displacement by a vector.
    pub(super) fn along(system: &System, along: &[Value; 2]) -> Self {
        let along = [0, 1].map(|axis| system.algebra.atom(&along[axis]));
        Self { along, turn: Atom::num(0), about: None }
    }

    /// Creates a displacement by a unit angle about a point.
    pub(super) fn about(system: &System, point: usize) -> Self {
        let about = Some(system.algebra.point(point).clone());
        Self { along: [Atom::num(0), Atom::num(0)], turn: Atom::num(1), about }
    }

    fn new(system: &System, own: &Displacement) -> Self {
        let zero = || [Atom::num(0), Atom::num(0)];
        let along = own.along.as_ref().map_or_else(zero, |along| Self::along(system, along).along);
        match &own.turn {
            Some(Turn { size, about, .. }) => {
                Self { along, turn: system.algebra.atom(size), about: Some(system.algebra.point(*about).clone()) }
            }
            None => Self { along, turn: Atom::num(0), about: None },
        }
    }

    /// The displacement of a point.
    fn at(&self, place: &[Atom; 2]) -> [Atom; 2] {
        let Some(about) = &self.about else { return self.along.clone() };
        let across = [&about[1] - &place[1], &place[0] - &about[0]];
        [0, 1].map(|axis| &self.along[axis] + &self.turn * &across[axis])
    }
}

/// The work of inertia minus that of loads and constraints, in displacements of bodies and points.
pub(super) fn free_body(system: &System, displacements: &[Displacement]) -> Atom {
    let algebra = &system.algebra;
    let shifts: Vec<VirtualDisplacement> =
        displacements.iter().map(|own| VirtualDisplacement::new(system, own)).collect();
    let moved = || displacements.iter().zip(&shifts);
    let shifted = |point: usize, axis: usize| {
        let place = algebra.point(point);
        let own =
            moved().filter(|(own, _)| own.points.contains(&point)).map(|(_, shift)| shift.at(place)[axis].clone());
        place[axis].clone() + own.fold(Atom::num(0), |sum, by| sum + by) * algebra.displacement()
    };
    let changed = |coordinate: usize| {
        let turns = moved().filter(|(own, _)| own.turn.as_ref().is_some_and(|turn| turn.angle == Some(coordinate)));
        let slides = displacements.iter().filter_map(|own| own.slide.as_ref());
        let slides = slides.filter(|slide| slide.coordinate == coordinate).map(|slide| algebra.atom(&slide.size));
        let change = turns.map(|(_, shift)| shift.turn.clone()).chain(slides).fold(Atom::num(0), |sum, by| sum + by);
        algebra.symbol(Symbol::Coordinate(coordinate)) + change * algebra.displacement()
    };
    let change = |value: &Value| algebra.derivative_by_displacement(&algebra.atom_where(value, shifted, changed));
    let of_body = |body: usize| moved().filter(move |(own, _)| own.bodies.contains(&body)).map(|(_, shift)| shift);
    let mut work = Atom::num(0);
    for body in 0..system.algebra.scene.bodies.len() {
        for shift in of_body(body) {
            work += inertia(system, body, shift) - weight(system, body, shift);
        }
    }
    for (number, load) in algebra.scene.loads.iter().enumerate() {
        let efforts = system.loads.efforts(number);
        match &load.kind {
            LoadKind::Gravity(_) => {}
            LoadKind::Force { at, body: Some(body), .. } => {
                let place = [0, 1].map(|axis| algebra.atom(&at[axis]));
                for shift in of_body(*body) {
                    for (effort, by) in efforts.iter().zip(shift.at(&place)) {
                        work -= &effort.size * by;
                    }
                }
            }
            LoadKind::Torque { body, .. } => {
                for shift in of_body(*body) {
                    work -= efforts.iter().fold(Atom::num(0), |sum, effort| sum + &effort.size) * &shift.turn;
                }
            }
            LoadKind::Spring { along, .. } => work -= system.loads.force_of(number) * change(along),
            LoadKind::Force { at, body: None, .. } => {
                for (effort, place) in efforts.iter().zip(at) {
                    work -= &effort.size * change(place);
                }
            }
        }
    }
    for (k, constraint) in algebra.scene.constraints.iter().enumerate() {
        work += change(&constraint.residual) * algebra.symbol(Symbol::Multiplier(k));
    }
    work
}

/// The work of all bodies and all external forces on the ground.
pub(super) fn on_ground(system: &System, shift: &VirtualDisplacement) -> Atom {
    let algebra = &system.algebra;
    let mut work = Atom::num(0);
    for body in 0..algebra.scene.bodies.len() {
        work += weight(system, body, shift) - inertia(system, body, shift);
    }
    for (number, load) in algebra.scene.loads.iter().enumerate() {
        let LoadKind::Force { at, .. } = &load.kind else { continue };
        let place = [0, 1].map(|axis| algebra.atom(&at[axis]));
        for (effort, by) in system.loads.efforts(number).iter().zip(shift.at(&place)) {
            work += &effort.size * by;
        }
    }
    work
}

/// The work of inertia, `m a . d + I alpha w`.
fn inertia(system: &System, body: usize, shift: &VirtualDisplacement) -> Atom {
    let algebra = &system.algebra;
    let acceleration = |place: &Atom| algebra.second_rate(place);
    let own = &algebra.scene.bodies[body];
    let mut work = Atom::num(0);
    if let (Some(mass), Some(com)) = (&own.mass, &own.com) {
        let place = [0, 1].map(|axis| algebra.simplify(&algebra.atom(&com[axis])));
        for (x, by) in place.iter().zip(shift.at(&place)) {
            work += algebra.atom(mass) * acceleration(x) * by;
        }
    }
    if let (Some(inertia), Some(angle), Some(_)) = (&own.inertia, &own.angle, &shift.about) {
        work += algebra.atom(inertia) * acceleration(&algebra.simplify(&algebra.atom(angle))) * &shift.turn;
    }
    work
}

/// The work of weight, `m g . d`.
fn weight(system: &System, body: usize, shift: &VirtualDisplacement) -> Atom {
    let algebra = &system.algebra;
    let own = &algebra.scene.bodies[body];
    let (Some(mass), Some(com)) = (&own.mass, &own.com) else { return Atom::num(0) };
    let by = shift.at(&[0, 1].map(|axis| algebra.simplify(&algebra.atom(&com[axis]))));
    let mut work = Atom::num(0);
    for load in &algebra.scene.loads {
        let LoadKind::Gravity(field) = &load.kind else { continue };
        for (g, by) in field.iter().zip(&by) {
            work += algebra.atom(mass) * algebra.atom(g) * by;
        }
    }
    work
}
