//! The work in virtual displacements of bodies and points, computed directly from the scene.

use num_dual::{Dual, Dual2};

use super::sample::Sample;
use qrm_scene::evaluate::State;
use qrm_scene::function::Differentiable;
use qrm_scene::scene::{Body, Displacement, LoadKind, Scene, Value as Formula};

/// The displacement of a rigid body.
struct VirtualDisplacement<B> {
    along: [B; 2],
    turn: B,
    about: [B; 2],
}

impl<B: Differentiable> VirtualDisplacement<B> {
    fn at(&self, [x, y]: [B; 2]) -> [B; 2] {
        [self.along[0] - self.turn * (y - self.about[1]), self.along[1] + self.turn * (x - self.about[0])]
    }
}

/// The states at which the work is evaluated.
pub(super) struct VirtualWork<'s, B> {
    scene: &'s Scene,
    sample: &'s Sample<B>,
    plain: &'s State<B>,
    moving: &'s State<Dual2<B>>,
}

impl<'s, B: Differentiable> VirtualWork<'s, B> {
    pub(super) fn new(
        scene: &'s Scene,
        sample: &'s Sample<B>,
        plain: &'s State<B>,
        moving: &'s State<Dual2<B>>,
    ) -> Self {
        Self { scene, sample, plain, moving }
    }

    /// The work of inertia minus that of loads and constraints.
    pub(super) fn work(&self, displacements: &[Displacement]) -> B {
        let zero = B::from(0.0);
        let mut displaced = self.sample.state_at(self.scene, Dual::new(self.sample.t, zero));
        let mut work = zero;
        for own in displacements {
            let shift = self.virtual_displacement(own);
            for &point in &own.points {
                let by = shift.at(self.plain.point(point));
                let at = displaced.point(point);
                displaced = displaced.with_point(point, [0, 1].map(|axis| at[axis] + Dual::new(zero, by[axis])));
            }
            if let Some(angle) = own.turn.as_ref().and_then(|turn| turn.angle) {
                displaced.coordinates[angle] += Dual::new(zero, shift.turn);
            }
            if let Some(slide) = &own.slide {
                displaced.coordinates[slide.coordinate] += Dual::new(zero, self.plain.value(&slide.size));
            }
            for &body in &own.bodies {
                work += self.inertia_less_weight(&self.scene.bodies[body], &shift);
                work -= self.applied(body, &shift);
            }
        }
        for load in &self.scene.loads {
            if let LoadKind::Spring { along, .. } = &load.kind {
                work -= self.force_along(load) * displaced.value(along).eps;
            }
            if let LoadKind::Force { at, body: None, .. } = &load.kind {
                let forces = self.sample.load_forces(self.scene, self.plain, &load.kind);
                for ((force, _), place) in forces.iter().zip(at) {
                    work -= *force * displaced.value(place).eps;
                }
            }
        }
        for (multiplier, constraint) in self.sample.multipliers.iter().zip(&self.scene.constraints) {
            work += *multiplier * displaced.value(&constraint.residual).eps;
        }
        work
    }

    /// The work of all bodies and of external forces on the ground, along a vector.
    pub(super) fn along_ground(&self, along: &[Formula; 2]) -> B {
        let zero = B::from(0.0);
        self.on_ground(&VirtualDisplacement { along: self.pair(along), turn: zero, about: [zero; 2] })
    }

    /// The work of all bodies and of external forces on the ground, in a rotation about a point.
    pub(super) fn about_ground(&self, point: usize) -> B {
        let zero = B::from(0.0);
        self.on_ground(&VirtualDisplacement { along: [zero; 2], turn: B::from(1.0), about: self.plain.point(point) })
    }

    fn on_ground(&self, shift: &VirtualDisplacement<B>) -> B {
        let mut work = B::from(0.0);
        for body in &self.scene.bodies {
            work -= self.inertia_less_weight(body, shift);
        }
        for load in &self.scene.loads {
            let LoadKind::Force { force, at, .. } = &load.kind else { continue };
            let [force, by] = [self.pair(force), shift.at(self.pair(at))];
            work += force[0] * by[0] + force[1] * by[1];
        }
        work
    }

    /// `m (a - g) . d + I alpha w`
    fn inertia_less_weight(&self, body: &Body, shift: &VirtualDisplacement<B>) -> B {
        let mut work = B::from(0.0);
        if let (Some(mass), Some(com)) = (&body.mass, &body.com) {
            let place = [0, 1].map(|axis| self.moving.value(&com[axis]));
            let by = shift.at(place.map(|x| x.re));
            for axis in [0, 1] {
                let gravity = self.scene.loads.iter().filter_map(|load| match &load.kind {
                    LoadKind::Gravity(field) => Some(self.plain.value(&field[axis])),
                    _ => None,
                });
                work += self.plain.value(mass) * (place[axis].v2 - gravity.sum::<B>()) * by[axis];
            }
        }
        if let (Some(inertia), Some(angle)) = (&body.inertia, &body.angle) {
            work += self.plain.value(inertia) * self.moving.value(angle).v2 * shift.turn;
        }
        work
    }

    /// The work of the applied forces and torques on a body.
    fn applied(&self, number: usize, shift: &VirtualDisplacement<B>) -> B {
        let mut work = B::from(0.0);
        for load in &self.scene.loads {
            match &load.kind {
                LoadKind::Force { force, at, body } if *body == Some(number) => {
                    let [force, by] = [self.pair(force), shift.at(self.pair(at))];
                    work += force[0] * by[0] + force[1] * by[1];
                }
                LoadKind::Torque { torque, body, .. } if *body == number => {
                    work += self.plain.value(torque) * shift.turn;
                }
                _ => {}
            }
        }
        work
    }

    fn force_along(&self, load: &qrm_scene::scene::Load) -> B {
        self.sample.load_forces(self.scene, self.plain, &load.kind).into_iter().map(|(force, _)| force).sum()
    }

    fn virtual_displacement(&self, own: &Displacement) -> VirtualDisplacement<B> {
        let zero = B::from(0.0);
        let along = own.along.as_ref().map_or([zero; 2], |along| self.pair(along));
        let turn = own.turn.as_ref().map_or(zero, |turn| self.plain.value(&turn.size));
        let about = own.turn.as_ref().map_or([zero; 2], |turn| self.plain.point(turn.about));
        VirtualDisplacement { along, turn, about }
    }

    fn pair(&self, pair: &[Formula; 2]) -> [B; 2] {
        [0, 1].map(|axis| self.plain.value(&pair[axis]))
    }
}
