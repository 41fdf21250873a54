//! Vectors in space, and the plane in which a linkage moves.

use super::numbers::shortest;

pub(super) type Vector = [f64; 3];
/// A matrix by rows: the axes of a frame are its columns.
pub(super) type Matrix = [[f64; 3]; 3];

pub(super) const IDENTITY: Matrix = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];

/// Axes count as parallel or perpendicular within this angle.
const SAME: f64 = 1e-6;

/// A frame: its place and its axes.
#[derive(Clone, Copy)]
pub(super) struct Frame {
    pub(super) place: Vector,
    pub(super) axes: Matrix,
}

impl Frame {
    pub(super) const WORLD: Self = Self { place: [0.0; 3], axes: IDENTITY };

    pub(super) fn is_world(&self) -> bool {
        self.place == [0.0; 3] && (0..3).all(|i| norm(subtract(self.axes[i], IDENTITY[i])) < SAME)
    }

    /// Converts a frame that is given in this one into the world.
    pub(super) fn then(&self, inner: &Self) -> Self {
        Self { place: self.point(inner.place), axes: product(&self.axes, &inner.axes) }
    }

    /// Converts a point of this frame into the world.
    pub(super) fn point(&self, at: Vector) -> Vector {
        add(self.place, apply(&self.axes, at))
    }

    /// Converts a direction of this frame into the world.
    pub(super) fn direction(&self, of: Vector) -> Vector {
        apply(&self.axes, of)
    }

    /// Converts a direction of the world into this frame.
    pub(super) fn back(&self, of: Vector) -> Vector {
        apply(&transposed(&self.axes), of)
    }

    /// One of the axes.
    pub(super) fn axis(&self, number: usize) -> Vector {
        [self.axes[0][number], self.axes[1][number], self.axes[2][number]]
    }
}

/// A plane: its axes in space.
#[derive(Clone, Copy)]
pub(super) struct Plane {
    pub(super) x: Vector,
    pub(super) y: Vector,
    pub(super) normal: Vector,
}

/// The frame of a body in a plane: its axes there, in the frame of the body, and its angle.
#[derive(Clone, Copy)]
pub(super) struct BodyFrame {
    x: Vector,
    y: Vector,
    pub(super) normal: Vector,
    pub(super) angle: f64,
}

impl Plane {
    /// The plane across an axis: x to the right; y upward, where z is not the axis.
    pub(super) fn across(axis: Vector) -> Self {
        let axis = snapped(unit(axis));
        let largest = (0..3).fold(0, |best, i| if axis[i].abs() > axis[best].abs() + SAME { i } else { best });
        // Seen from this side, z is upward and x to the right.
        let sign = if largest == 1 { -axis[1].signum() } else { axis[largest].signum() };
        let normal = scaled(axis, sign);
        let up = if largest == 2 { [0.0, 1.0, 0.0] } else { [0.0, 0.0, 1.0] };
        let x = unit(cross(up, normal));
        Self { x, y: cross(normal, x), normal }
    }

    /// The components of a vector along the axes of the plane.
    pub(super) fn project(&self, vector: Vector) -> [f64; 2] {
        [dot(vector, self.x), dot(vector, self.y)]
    }

    /// 1 for an axis along the normal of the plane, -1 for one against it, `None` for one that is not perpendicular.
    pub(super) fn normal_sign(&self, axis: Vector) -> Option<f64> {
        let along = dot(unit(axis), self.normal);
        (norm(cross(unit(axis), self.normal)) < SAME).then_some(along.signum())
    }

    /// The angle between an axis and the normal of the plane, and 1 or -1 for its side.
    pub(super) fn deviation_of_hinge(&self, axis: Vector) -> (f64, f64) {
        let along = dot(unit(axis), self.normal);
        (norm(cross(unit(axis), self.normal)).atan2(along.abs()), along.signum())
    }

    /// The angle between a direction and the plane.
    pub(super) fn deviation_of_slide(&self, direction: Vector) -> f64 {
        dot(unit(direction), self.normal).abs().min(1.0).asin()
    }

    /// The axes in space, for a remark.
    pub(super) fn axes_text(&self) -> String {
        let [x, y] = [self.x, self.y].map(|axis| axis.map(shortest).join(", "));
        format!("x ({x}), y ({y})")
    }

    /// Whether a direction is in the plane.
    pub(super) fn contains(&self, direction: Vector) -> bool {
        dot(unit(direction), self.normal).abs() < SAME
    }

    /// The frame of a body in the plane: along an axis of the body, if one is in the plane.
    pub(super) fn body(&self, frame: &Frame) -> BodyFrame {
        let normal = snapped(unit(frame.back(self.normal)));
        let own = IDENTITY.into_iter().find(|axis| dot(*axis, normal).abs() < 1e-9);
        let x = own.unwrap_or_else(|| unit(frame.back(self.x)));
        let [across, up] = self.project(frame.direction(x));
        BodyFrame { x, y: cross(normal, x), normal, angle: up.atan2(across) }
    }
}

impl BodyFrame {
    /// The components of a vector of the body along its axes in the plane.
    pub(super) fn project(&self, vector: Vector) -> [f64; 2] {
        [dot(vector, self.x), dot(vector, self.y)]
    }

    /// The angle of a direction of the body.
    pub(super) fn angle_of(&self, direction: Vector) -> f64 {
        let [x, y] = self.project(direction);
        y.atan2(x)
    }
}

/// Sets components to 0 or 1 where they differ only by rounding.
fn snapped(vector: Vector) -> Vector {
    vector.map(|value| if (value - value.round()).abs() < 1e-12 { value.round() + 0.0 } else { value })
}

pub(super) fn add(a: Vector, b: Vector) -> Vector {
    [a[0] + b[0], a[1] + b[1], a[2] + b[2]]
}

pub(super) fn subtract(a: Vector, b: Vector) -> Vector {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

pub(super) fn scaled(a: Vector, factor: f64) -> Vector {
    a.map(|value| value * factor)
}

pub(super) fn dot(a: Vector, b: Vector) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

pub(super) fn cross(a: Vector, b: Vector) -> Vector {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

pub(super) fn norm(a: Vector) -> f64 {
    dot(a, a).sqrt()
}

/// The vector of length 1; zero stays zero.
pub(super) fn unit(a: Vector) -> Vector {
    let largest = a.iter().fold(0.0, |most: f64, value| most.max(value.abs()));
    if largest == 0.0 {
        return a;
    }
    let a = scaled(a, 1.0 / largest);
    scaled(a, 1.0 / norm(a))
}

pub(super) fn apply(matrix: &Matrix, vector: Vector) -> Vector {
    [dot(matrix[0], vector), dot(matrix[1], vector), dot(matrix[2], vector)]
}

pub(super) fn transposed(matrix: &Matrix) -> Matrix {
    [0, 1, 2].map(|i| [matrix[0][i], matrix[1][i], matrix[2][i]])
}

pub(super) fn product(a: &Matrix, b: &Matrix) -> Matrix {
    let columns = transposed(b);
    [0, 1, 2].map(|i| [0, 1, 2].map(|k| dot(a[i], columns[k])))
}

/// The matrix of a turn about an axis.
pub(super) fn turn(axis: Vector, angle: f64) -> Matrix {
    let [x, y, z] = unit(axis);
    let (sine, cosine) = angle.sin_cos();
    let rest = 1.0 - cosine;
    [
        [cosine + x * x * rest, x * y * rest - z * sine, x * z * rest + y * sine],
        [y * x * rest + z * sine, cosine + y * y * rest, y * z * rest - x * sine],
        [z * x * rest - y * sine, z * y * rest + x * sine, cosine + z * z * rest],
    ]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn planes_are_seen_with_z_upward() {
        let of = |axis| Plane::across(axis);
        assert_eq!([of([0.0, 0.0, -2.0]).x, of([0.0, 0.0, 1.0]).y], [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]);
        assert_eq!([of([0.0, 1.0, 0.0]).x, of([0.0, 1.0, 0.0]).y], [[1.0, 0.0, 0.0], [0.0, 0.0, 1.0]]);
        assert_eq!([of([1.0, 0.0, 0.0]).x, of([1.0, 0.0, 0.0]).y], [[0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]);
        let oblique = of([0.0, 0.6, 0.8]);
        assert!(dot(oblique.x, oblique.y).abs() < 1e-15 && (norm(oblique.y) - 1.0).abs() < 1e-15);
    }

    #[test]
    fn bodies_keep_their_own_axes() {
        let plane = Plane::across([0.0, 0.0, 1.0]);
        let frame = Frame { place: [0.0; 3], axes: turn([0.0, 0.0, 1.0], 0.3) };
        assert!((plane.body(&frame).angle - 0.3).abs() < 1e-15);
        let upright = Frame { place: [0.0; 3], axes: turn([1.0, 0.0, 0.0], -std::f64::consts::FRAC_PI_2) };
        let body = plane.body(&upright);
        // The z axis of the body is upward.
        assert!((body.angle_of([0.0, 0.0, 1.0]) - std::f64::consts::FRAC_PI_2).abs() < 1e-15, "{}", body.angle);
    }
}
