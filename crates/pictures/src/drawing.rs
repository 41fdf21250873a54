//! The shapes of a mechanism: those of its scene, or shapes guessed from its points.

use num_dual::Dual2_64;
use qrm_scene::evaluate::State;
use qrm_scene::expression::Expression;
use qrm_scene::scene::Quantity;
use qrm_view::motion::Shape;

use crate::force_elements::add_force_elements;
use crate::parts::parts;
use crate::pose::Pose;
use crate::source::Source;
use crate::teeth::mesh;

/// The shapes, lowest layer first.
pub(super) fn draw(pose: &mut Pose) -> Vec<Shape> {
    let mut shapes = if pose.scene.drawing.is_empty() { guessed(pose) } else { parts(pose) };
    mesh(&mut shapes, &pose.nodes);
    add_force_elements(pose, &mut shapes);
    shapes
}

/// Guesses shapes. A point that is defined by other points is joined to them. A point that a single coordinate moves on
/// a circle is joined to the centre; one that it moves on a line slides along it. Centres of mass are marked.
fn guessed(pose: &mut Pose) -> Vec<Shape> {
    let scene = pose.scene;
    let mut shapes = Vec::new();
    for (place, point) in scene.points.iter().enumerate() {
        let name = point.name.clone();
        let node = pose.point(place);
        let names = || point.position.iter().flat_map(Expression::names);
        let origins = sorted(names().filter_map(|q| if let Quantity::Point(p, _) = q { Some(*p) } else { None }));
        let movers = sorted(names().filter_map(|q| if let Quantity::Coordinate(i) = q { Some(*i) } else { None }));
        match (&origins[..], &movers[..]) {
            ([], []) => shapes.push(Shape::Pivot { node }),
            ([], [coordinate]) => match path(pose, place, *coordinate) {
                Path::Circle(centre) => {
                    let centre = pose.fixed(centre);
                    let has_pivot = |shape: &Shape| matches!(shape, Shape::Pivot { node } if *node == centre);
                    if !shapes.iter().any(has_pivot) {
                        shapes.push(Shape::Pivot { node: centre });
                    }
                    shapes.push(Shape::Link { name, nodes: vec![centre, node] });
                    pose.nodes[node].is_traced = true;
                }
                Path::Line(from, to) => {
                    let angle = (to[1] - from[1]).atan2(to[0] - from[0]);
                    pose.angles.push(Source::Constant(angle));
                    let nodes = vec![pose.fixed(from), pose.fixed(to)];
                    shapes.extend([
                        Shape::Guide { nodes, is_channel: false },
                        Shape::Block { name, node, angle: vec![angle] },
                    ]);
                }
                Path::Other => pose.nodes[node].is_traced = true,
            },
            ([], _) => pose.nodes[node].is_traced = true,
            (origins, _) => {
                let links = origins.iter().map(|origin| vec![pose.point(*origin), node]).collect::<Vec<_>>();
                shapes.extend(links.into_iter().map(|nodes| Shape::Link { name: name.clone(), nodes }));
                pose.nodes[node].is_traced = true;
            }
        }
    }
    for constraint in &scene.constraints {
        let points = sorted(constraint.residual.names().filter_map(|q| match q {
            Quantity::Point(point, _) => Some(*point),
            _ => None,
        }));
        // A loop that keeps two points at constant distance is closed by a massless rod.
        if let [a, b] = points[..]
            && keeps_distance(pose, a, b)
        {
            let nodes = vec![pose.point(a), pose.point(b)];
            shapes.push(Shape::Rod { name: constraint.name.clone(), nodes });
        }
    }
    for body in &scene.bodies {
        if let Some(com) = &body.com {
            shapes.push(Shape::Mass { name: body.name.clone(), node: pose.place(com) });
        }
    }
    shapes
}

/// Whether two different points keep their distance during the motion.
fn keeps_distance(pose: &Pose, a: usize, b: usize) -> bool {
    let distance = |state: &State<f64>| {
        let ([ax, ay], [bx, by]) = (state.point(a), state.point(b));
        (bx - ax).hypot(by - ay)
    };
    let Some(first) = pose.states.first().map(distance) else { return false };
    let size =
        |state: &State<f64>| state.point(a).iter().chain(&state.point(b)).fold(0.0, |most: f64, c| most.max(c.abs()));
    pose.states.iter().all(|state| {
        let now = distance(state);
        now > 1e-6 * size(state) && (now - first).abs() <= 1e-6 * first
    })
}

fn sorted(places: impl Iterator<Item = usize>) -> Vec<usize> {
    let mut places: Vec<usize> = places.collect();
    places.sort_unstable();
    places.dedup();
    places
}

/// The path on which a single coordinate moves a point.
enum Path {
    /// Around a centre.
    Circle([f64; 2]),
    /// Between two positions.
    Line([f64; 2], [f64; 2]),
    Other,
}

/// On a circle `P = c + r (cos, sin)` the centre `c = P + P_qq` is constant; on a line `P_qq` is zero.
fn path(pose: &Pose, point: usize, coordinate: usize) -> Path {
    let at = |value: f64| {
        let moved = |i: usize| if i == coordinate { Dual2_64::new(value, 1.0, 0.0) } else { Dual2_64::from(0.0) };
        let q: Vec<Dual2_64> = (0..pose.scene.coordinates.len()).map(moved).collect();
        State::new(pose.scene, pose.parameters, Dual2_64::from(0.0), q.clone(), q).point(point)
    };
    let values = pose.states.iter().map(|state| state.coordinates[coordinate]);
    let (low, high) = values.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), v| (l.min(v), h.max(v)));
    let samples = [at(low), at(0.3 * low + 0.7 * high), at(high), at(high + 1.0)];
    let centre = |p: &[Dual2_64; 2]| p.map(|c| c.re + c.v2);
    let radius = |p: &[Dual2_64; 2]| p[0].v2.hypot(p[1].v2);
    let size = samples.iter().map(radius).fold(0.0, f64::max);
    let first = centre(&samples[0]);
    let is_centre = |c: [f64; 2]| (c[0] - first[0]).hypot(c[1] - first[1]) <= 1e-9 * size;
    if size > 0.0 && samples.iter().all(|p| is_centre(centre(p)) && radius(p) > (1.0 - 1e-9) * size) {
        Path::Circle(first)
    } else if size == 0.0 && low < high {
        let [from, to] = [&samples[0], &samples[2]].map(|p| p.map(|c| c.re));
        Path::Line(from, to)
    } else {
        Path::Other
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use qrm_scene::resolve;

    const SCENE: &str = r#"
name = "drawn"
coordinates = ["phi", { name = "s", unit = "m" }, "psi"]
[points]
O = ['0', '0.3']
A = ['0.2*cos(phi)', '0.3 + 0.2*sin(phi)']
B = ['A.x + 0.6*cos(psi)', 'A.y + 0.6*sin(psi)']
S = ['s*cos(0.5)', 's*sin(0.5)']
D = ['s*cos(phi)', 's*sin(phi)']
[bodies]
all = { mass = 1, com = "D", angle = 'psi', inertia = 1 }
[initial]
given = { phi = 0, s = 1, psi = 0, phi_dot = 1, s_dot = 1, psi_dot = 1 }
[run]
step = 1
end_time = 2
"#;

    /// Times with coordinates and rates.
    fn states() -> Vec<(f64, Vec<f64>, Vec<f64>)> {
        [0.0, 1.0, 2.0].map(|t| (t, vec![t, 1.0 + 0.5 * t, -t], vec![1.0, 0.5, -1.0])).into()
    }

    #[test]
    fn joints_are_found_from_points() {
        let (scene, _) = resolve::read("drawn.toml", SCENE).expect("the scene is right");
        let states = states();
        let mut pose = Pose::new(&scene, &[], &states);
        let shapes = draw(&mut pose);
        let node = |name: &str| pose.nodes.iter().position(|n| n.name == name).expect(name);
        let links: Vec<Vec<usize>> = shapes
            .iter()
            .filter_map(|shape| if let Shape::Link { nodes, .. } = shape { Some(nodes.clone()) } else { None })
            .collect();
        // The crank turns about O, which is already a point; the rod is joined to the crank.
        assert_eq!(links, [[node("O"), node("A")], [node("A"), node("B")]]);
        assert_eq!(shapes.iter().filter(|shape| matches!(shape, Shape::Pivot { .. })).count(), 1);
        let guides: Vec<&Shape> = shapes.iter().filter(|shape| matches!(shape, Shape::Guide { .. })).collect();
        let [Shape::Guide { nodes, .. }] = guides[..] else { panic!("one guide: {shapes:?}") };
        let end = &pose.nodes[nodes[1]];
        assert!((end.x[0] - 2.0 * 0.5_f64.cos()).abs() < 1e-12 && (end.y[0] - 2.0 * 0.5_f64.sin()).abs() < 1e-12);
        let angle =
            shapes.iter().find_map(|shape| if let Shape::Block { angle, .. } = shape { Some(angle[0]) } else { None });
        assert!((angle.expect("a block") - 0.5).abs() < 1e-12);
        // Points that depend on two coordinates are only traced.
        assert!(pose.nodes[node("D")].is_traced && pose.nodes[node("B")].is_traced);
        assert!(matches!(shapes.last(), Some(Shape::Mass { node: at, .. }) if *at == node("D")));
    }

    #[test]
    fn a_scene_that_says_what_to_draw_gets_that() {
        let text =
            format!("{SCENE}[drawing]\nbar = {{ link = [\"O\", ['1', '2'], \"A\"] }}\npath = {{ path = \"A\" }}\n");
        let (scene, _) = resolve::read("drawn.toml", &text).expect("the scene is right");
        let states = states();
        let mut pose = Pose::new(&scene, &[], &states);
        let shapes = draw(&mut pose);
        assert!(matches!(&shapes[..], [Shape::Link { name, nodes }] if name == "bar" && nodes.len() == 3));
        let traced: Vec<&str> = pose.nodes.iter().filter(|n| n.is_traced).map(|n| n.name.as_str()).collect();
        assert_eq!(traced, ["A"]);
        assert_eq!((pose.nodes[0].x.len(), pose.nodes[2].x.len()), (1, 3));
    }

    #[test]
    fn machine_parts_are_as_large_as_they_reach() {
        let parts = "[drawing]
cam = { cam = \"O\", angle = 'phi', profile = '0.1 + 0.05*max(cos(theta), 0)' }
slide = { block = \"S\", angle = '0.5', on = ['0', '0'] }
hook = { block = \"B\", angle = 'psi', on = \"A\" }
rack = { rack = [['0', '1'], ['-0.2*phi', '2']], radius = 0.2 }
wheel = { gear = ['-0.2*phi', '2'], radius = 0.2, angle = 'phi' }
ring = { gear = ['1', '2'], radius = 0.4, internal = true }
belt = { belt = [\"O\", \"A\"], radii = [0.1, 0.2], crossed = true, angle = 'phi' }
";
        let (scene, _) = resolve::read("drawn.toml", &format!("{SCENE}{parts}")).expect("the scene is right");
        let states = states();
        let mut pose = Pose::new(&scene, &[], &states);
        let shapes = draw(&mut pose);
        let [cam, guide, slide, rail, hook, rack, wheel, ring, belt] = &shapes[..] else { panic!("{shapes:?}") };
        assert!(
            matches!(cam, Shape::Outline { x, y, .. } if x.len() == 180 && (x[0] - 0.15).abs() < 1e-12 && y[0] == 0.0)
        );
        // A line in the ground is a channel; a moving line is a rail attached to its point.
        let Shape::Guide { nodes, is_channel: true } = guide else { panic!("{guide:?}") };
        let ends = [0, 1].map(|end| pose.nodes[nodes[end]].x[0].hypot(pose.nodes[nodes[end]].y[0]));
        assert!(ends[0] < 1.0 && ends[1] > 2.0, "{ends:?}");
        assert!(matches!(rail, Shape::Rail { along: [low, high], .. } if *low < 0.0 && *high > 0.6), "{rail:?}");
        assert!(matches!((slide, hook), (Shape::Block { .. }, Shape::Block { .. })));
        // A fixed rack belongs to the ground, and has no name.
        let Shape::Rack { name, along, across, pitch, .. } = rack else { panic!("{rack:?}") };
        assert!(name.is_empty() && along[0] < -0.4 && along[1] > 0.0, "{rack:?}");
        assert!((across - 0.8).abs() < 1e-12 && (pitch - std::f64::consts::TAU * 0.2 / 12.0).abs() < 1e-12, "{rack:?}");
        assert!(matches!(wheel, Shape::Gear { name, teeth: 12, .. } if name == "wheel"), "{wheel:?}");
        assert!(matches!(ring, Shape::Gear { name, is_internal: true, .. } if name.is_empty()), "{ring:?}");
        assert!(matches!(belt, Shape::Belt { is_crossed: true, radii: [0.1, 0.2], .. }), "{belt:?}");
        // The angles are in the order of the shapes.
        assert_eq!(pose.angles.len(), shapes.iter().filter_map(Shape::angle).count());
        for (source, shape) in pose.angles.iter().zip(shapes.iter().filter(|shape| shape.angle().is_some())) {
            assert_eq!(Some(&pose.track(source)), shape.angle(), "{shape:?}");
        }
    }
}
