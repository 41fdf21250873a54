//! Decodes animations again.

use std::time::Instant;

use gif::{ColorOutput, DecodeOptions};
use qrm_view::gif::{NoAnimation, gif};
use qrm_view::motion::{Arrow, ForceElementPart, Motion, Node, Shape};

fn node(name: &str, x: Vec<f64>, y: Vec<f64>) -> Node {
    Node { name: name.to_owned(), is_traced: !name.is_empty() && x.len() > 1, x, y }
}

/// A crank that turns once a second, with a block that slides above it, a plate and a force.
fn crank(length: f64, frames: usize, size: f64) -> Motion {
    let times: Vec<f64> = (0..frames).map(|i| length * i as f64 / (frames - 1) as f64).collect();
    let track = |f: &dyn Fn(f64) -> f64| times.iter().map(|t| size * f(std::f64::consts::TAU * t / length)).collect();
    let nodes = vec![
        node("O", vec![0.0], vec![0.0]),
        node("Ä", track(&f64::cos), track(&f64::sin)),
        node("C", track(&f64::cos), vec![2.0 * size]),
        node("", vec![-1.5 * size], vec![2.0 * size]),
        node("", vec![1.5 * size], vec![2.0 * size]),
    ];
    let shapes = vec![
        Shape::Guide { nodes: vec![3, 4], is_channel: false },
        Shape::Pivot { node: 0 },
        Shape::Link { name: "crank".to_owned(), nodes: vec![0, 1] },
        Shape::Link { name: "plate".to_owned(), nodes: vec![0, 1, 2] },
        Shape::Block { name: "block".to_owned(), node: 2, angle: vec![0.0] },
        Shape::Mass { name: "crank".to_owned(), node: 1 },
    ];
    let force = |is_reaction| Arrow {
        name: "F".to_owned(),
        doc: "a force".to_owned(),
        is_reaction,
        node: 1,
        x: track(&|phi| 1e4 * phi.sin()),
        y: vec![0.0],
    };
    let arrows = vec![force(true), force(false)];
    let (title, doc) = ("Crank and block — µ".to_owned(), String::new());
    Motion { title, doc, times, nodes, shapes, arrows, plots: Vec::new() }
}

/// The size, the delays in hundredths of a second, and all pictures.
struct Film {
    size: (usize, usize),
    delays: Vec<u16>,
    pictures: Vec<Vec<u8>>,
}

fn decoded(bytes: &[u8]) -> Film {
    let mut options = DecodeOptions::new();
    options.set_color_output(ColorOutput::RGBA);
    let mut decoder = options.read_info(bytes).expect("it is a GIF");
    let size = (usize::from(decoder.width()), usize::from(decoder.height()));
    let mut film = Film { size, delays: Vec::new(), pictures: Vec::new() };
    let mut picture = vec![0; size.0 * size.1 * 4];
    while let Some(frame) = decoder.read_next_frame().expect("the frame can be read") {
        film.delays.push(frame.delay);
        let (left, top, width) = (usize::from(frame.left), usize::from(frame.top), usize::from(frame.width));
        for (i, pixel) in frame.buffer.chunks(4).enumerate().filter(|(_, pixel)| pixel[3] > 0) {
            let at = 4 * ((top + i / width) * size.0 + left + i % width);
            picture[at..at + 4].copy_from_slice(pixel);
        }
        film.pictures.push(picture.clone());
    }
    assert_eq!(decoder.repeat(), gif::Repeat::Infinite);
    film
}

fn shot(motion: &Motion) -> Film {
    let film = decoded(&gif(motion).expect("the motion can be shown"));
    assert!((400..=640).contains(&film.size.0) && (240..=480).contains(&film.size.1), "{:?}", film.size);
    assert!((2..=400).contains(&film.pictures.len()), "{} pictures", film.pictures.len());
    film
}

#[test]
fn runs_of_some_seconds_are_shown_in_real_time() {
    for (length, frames, delay) in [(1.8, 45, 4), (1.0, 25, 4), (20.0, 400, 5)] {
        let film = shot(&crank(length, 361, 0.2));
        assert_eq!((film.pictures.len(), film.delays[0]), (frames, delay), "{length}");
        assert!(film.delays.iter().all(|d| *d == delay));
    }
}

#[test]
fn other_runs_are_slowed_or_quickened() {
    // The factors are 5, 1e9, 2 and 1e299.
    for (length, shown) in [(0.5, 2.5), (3e-9, 3.0), (25.0, 12.5), (1e300, 10.0)] {
        let film = shot(&crank(length, 50, 0.2));
        let total: u32 = film.delays.iter().map(|delay| u32::from(*delay)).sum();
        assert!((f64::from(total) / 100.0 - shown).abs() < 0.05, "{length}: {total}");
    }
}

#[test]
fn what_moves_is_seen_to_move() {
    let film = shot(&crank(2.0, 100, 0.2));
    assert!(film.pictures.windows(2).all(|pair| pair[0] != pair[1]));
    // A quarter of a turn moves the block from the right to the middle.
    let right = |picture: &[u8]| {
        let edge = |row: &[u8]| row.chunks(4).rposition(|pixel| pixel[..3] == [0, 100, 72]);
        picture.chunks(4 * film.size.0).filter_map(edge).max().expect("the block is seen")
    };
    assert!(right(&film.pictures[0]) > right(&film.pictures[12]) + 50);
    // The background is light.
    assert!(film.pictures.iter().all(|picture| picture[..3] == [251, 251, 248]));
}

#[test]
fn animations_are_the_same_each_time_small_and_quick() {
    let motion = crank(1.8, 361, 0.2);
    let start = Instant::now();
    let bytes = gif(&motion).expect("the motion can be shown");
    let taken = start.elapsed();
    assert!(bytes == gif(&motion).expect("the motion can be shown"));
    assert!(bytes.len() < 500_000, "{} bytes", bytes.len());
    // Only optimized builds must be fast.
    assert!(cfg!(debug_assertions) || taken.as_secs_f64() < 1.0, "{taken:?}");
}

#[test]
fn mechanisms_of_any_size_look_the_same() {
    let usual = shot(&crank(1.0, 30, 1.0));
    for size in [1e-6, 1e6, 2f64.powi(-400), 2f64.powi(400)] {
        let other = shot(&crank(1.0, 30, size));
        assert_eq!(other.size, usual.size);
        let differing = usual.pictures[3].iter().zip(&other.pictures[3]).filter(|(a, b)| a != b).count();
        // The scale of the arrows is written into the picture.
        assert!(differing < 3000, "{size}: {differing}");
    }
}

#[test]
fn motions_with_little_in_them_can_be_shown() {
    let usual = crank(1.0, 10, 0.2);
    let bare = Motion { nodes: Vec::new(), shapes: Vec::new(), arrows: Vec::new(), ..usual.clone() };
    let two = Motion { title: String::new(), ..crank(1.0, 2, 0.2) };
    let still = crank(1.0, 10, 0.0);
    let mut far = crank(1.0, 10, 0.0);
    far.nodes.iter_mut().flat_map(|n| n.x.iter_mut().chain(&mut n.y)).for_each(|v| *v = 1e9);
    let mut weak = usual.clone();
    weak.arrows.iter_mut().for_each(|arrow| arrow.x = vec![0.0]);
    let mut empty = usual.clone();
    empty.shapes.push(Shape::Link { name: "nothing".to_owned(), nodes: Vec::new() });
    empty.shapes.push(Shape::Link { name: "point".to_owned(), nodes: vec![1] });
    for motion in [bare, two, still, far, weak, empty] {
        shot(&motion);
    }
}

/// The motion of the crank with parts of machines.
fn machine() -> Motion {
    let mut motion = crank(1.0, 10, 0.2);
    let angle: Vec<f64> = (0..10).map(|frame| 0.3 * f64::from(frame)).collect();
    let name = || "part".to_owned();
    let gear = |node, radius, teeth, is_internal| Shape::Gear {
        name: name(),
        node,
        angle: angle.clone(),
        radius,
        teeth,
        phase: 0.1,
        is_internal,
    };
    let force_element =
        |parts: &[ForceElementPart]| Shape::ForceElement { name: name(), nodes: vec![0, 2], parts: parts.to_vec() };
    let [along, turned] = [[-0.1, 0.3], [0.3, -0.1]];
    let rack = |along, pitch| Shape::Rack {
        name: String::new(),
        node: 3,
        angle: vec![0.2],
        along,
        across: 0.05,
        pitch,
        phase: 0.01,
    };
    let belt =
        |nodes, is_crossed| Shape::Belt { name: name(), nodes, radii: [0.05, 0.08], is_crossed, angle: angle.clone() };
    let (x, y) = (vec![0.1, 0.0, -0.1], vec![0.0, 0.1, 0.0]);
    motion.shapes.extend([
        Shape::Guide { nodes: vec![3, 4], is_channel: true },
        Shape::Rod { name: name(), nodes: vec![1, 2] },
        force_element(&[ForceElementPart::Spring, ForceElementPart::Damper]),
        force_element(&[ForceElementPart::Actuator]),
        force_element(&[]),
        gear(1, 0.1, 12, false),
        gear(0, 0.3, 40, true),
        gear(0, 0.0, 0, false),
        rack(along, 0.02),
        rack(turned, 0.0),
        Shape::Rail { node: 1, angle: angle.clone(), along },
        belt(vec![3, 4], false),
        belt(vec![3, 4], true),
        belt(vec![3, 3], false),
        Shape::Outline { name: name(), node: 2, angle: angle.clone(), x, y },
    ]);
    motion
}

#[test]
fn parts_of_machines_are_seen_to_move() {
    let film = shot(&machine());
    assert!(film.pictures.windows(2).all(|pair| pair[0] != pair[1]));
    // Parts that extend beyond the nodes have room.
    let mut wheel = crank(1.0, 10, 0.2);
    let narrow = shot(&wheel).size;
    let angle = vec![0.0];
    wheel.shapes = vec![Shape::Gear {
        name: String::new(),
        node: 0,
        angle,
        radius: 0.9,
        teeth: 30,
        phase: 0.0,
        is_internal: true,
    }];
    let film = shot(&wheel);
    assert!(film.size != narrow, "{narrow:?}");
    let is_light = |pixel: &[u8]| pixel[..3] == [251, 251, 248];
    let picture = &film.pictures[0];
    assert!(picture.chunks(4).take(8 * film.size.0).all(is_light), "the rim is cut off");
}

#[test]
fn what_cannot_be_shown_is_an_error() {
    let usual = crank(1.0, 10, 0.2);
    let with_times = |times: Vec<f64>| gif(&Motion { times, ..usual.clone() });
    for times in [vec![], vec![0.0], vec![0.0, 0.0], vec![1.0, 0.0], vec![0.0, f64::NAN]] {
        assert_eq!(with_times(times), Err(NoAnimation::NotRising));
    }
    let mut short = usual.clone();
    short.nodes[1].x.pop();
    assert_eq!(gif(&short), Err(NoAnimation::Inconsistent("node `Ä`".to_owned())));
    let mut lost = usual.clone();
    lost.arrows[0].node = 99;
    assert_eq!(gif(&lost), Err(NoAnimation::Inconsistent("arrow `F`".to_owned())));
    for (x, y) in [(f64::NAN, 0.0), (f64::INFINITY, 0.0), (1.7e308, -1.7e308)] {
        let mut wild = usual.clone();
        (wild.nodes[0].x, wild.nodes[2].x) = (vec![x], vec![y]);
        assert_eq!(gif(&wild), Err(NoAnimation::NotFinite));
    }
    let mut vast = machine();
    vast.shapes.push(Shape::Rail { node: 0, angle: vec![0.0], along: [0.0, f64::NAN] });
    assert_eq!(gif(&vast), Err(NoAnimation::NotFinite));
    assert_eq!(gif(&crank(1.0, 10, 1e-310)), Err(NoAnimation::NotFinite));
    assert!(gif(&lost).expect_err("the node is missing").to_string().contains("arrow `F`"));
}
