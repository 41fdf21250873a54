//! The animation: what stands in its text, and how it behaves in a browser.

use std::f64::consts::PI;
use std::path::PathBuf;
use std::process::Command;

use qrm_view::animation::{fragment, page};
use qrm_view::motion::{Arrow, Motion, Node, Plot, PlotCurve, Shape, Track};

/// The number of frames of the sample.
const FRAMES: usize = 301;
/// What the sample lasts in s.
const DURATION: f64 = 0.88;

fn node(name: &str, is_traced: bool, x: Track, y: Track) -> Node {
    Node { name: name.to_owned(), is_traced, x, y }
}

fn plot(title: &str, unit: &str, curves: &[(&str, &Track)]) -> Plot {
    let curves = curves.iter().map(|&(name, values)| PlotCurve { name: name.to_owned(), values: values.clone() });
    Plot { title: title.to_owned(), unit: unit.to_owned(), curves: curves.collect() }
}

/// The differences between neighbours, over the time between them.
fn rate(times: &[f64], values: &[f64]) -> Track {
    let rate = |frame: usize| {
        let (before, after) = (frame.saturating_sub(1), (frame + 1).min(values.len() - 1));
        (values[after] - values[before]) / (times[after] - times[before])
    };
    (0..values.len()).map(rate).collect()
}

fn crank_angle(time: f64) -> f64 {
    0.4 + 2.0 * PI * time / DURATION
}

/// A quick-return shaper: crank, rocker, rod and ram.
fn quick_return() -> Motion {
    let times: Track = (0..FRAMES).map(|frame| DURATION * frame as f64 / (FRAMES - 1) as f64).collect();
    let [mut ax, mut ay, mut bx, mut by, mut cx, mut phi4] = [(); 6].map(|()| Track::with_capacity(FRAMES));
    let [mut n3x, mut n3y, mut n3, mut n6, mut torque] = [(); 5].map(|()| Track::with_capacity(FRAMES));
    for &time in &times {
        let crank = crank_angle(time);
        let a = (0.2 * crank.cos(), 0.3 + 0.2 * crank.sin());
        let rocker = f64::atan2(a.1, a.0);
        let b = (0.7 * rocker.cos(), 0.7 * rocker.sin());
        let rise = 0.9 - b.1;
        let c = b.0 - (0.36 - rise * rise).sqrt();
        // Statics: the rod takes the load on the ram, the die turns the rocker against it.
        let along = ((c - b.0) / 0.6, rise / 0.6);
        let rod = -1000.0 / along.0;
        let moment = -rod * (b.0 * along.1 - b.1 * along.0);
        let force = moment / a.0.hypot(a.1);
        ax.push(a.0);
        ay.push(a.1);
        bx.push(b.0);
        by.push(b.1);
        cx.push(c);
        phi4.push(rocker);
        n3x.push(-force * rocker.sin());
        n3y.push(force * rocker.cos());
        n3.push(force);
        n6.push(-rod * along.1);
        torque.push(-force * (rocker.cos() * (a.0) + rocker.sin() * (a.1 - 0.3)));
    }
    let arrow = |name: &str, doc: &str, is_reaction, node, x, y| Arrow {
        name: name.to_owned(),
        doc: doc.to_owned(),
        is_reaction,
        node,
        x,
        y,
    };
    let link = |name: &str, nodes: &[usize]| Shape::Link { name: name.to_owned(), nodes: nodes.to_vec() };
    let block = |name: &str, node, angle| Shape::Block { name: name.to_owned(), node, angle };
    let (speed4, speed6) = (rate(&times, &phi4), rate(&times, &cx));
    let ram = rate(&times, &speed6);
    let crank: Track = times.iter().map(|&time| crank_angle(time)).collect();
    Motion {
        title: "Quick-return shaper".to_owned(),
        doc: "The crank turns evenly; the ram goes slowly against the load and quickly back.".to_owned(),
        nodes: vec![
            node("O2", false, vec![0.0], vec![0.3]),
            node("O4", false, vec![0.0], vec![0.0]),
            node("A", false, ax, ay),
            node("B", true, bx, by),
            node("C", true, cx.clone(), vec![0.9]),
            node("", false, vec![-1.1], vec![0.9]),
            node("", false, vec![0.2], vec![0.9]),
        ],
        shapes: vec![
            Shape::Guide { nodes: vec![5, 6] },
            Shape::Pivot { node: 0 },
            Shape::Pivot { node: 1 },
            link("rocker", &[1, 3]),
            block("die", 2, phi4.clone()),
            link("crank", &[0, 2]),
            link("rod", &[3, 4]),
            block("ram", 4, vec![0.0]),
        ],
        arrows: vec![
            arrow("N3", "the die on the rocker", true, 2, n3x, n3y),
            arrow("N6", "the guide on the ram", true, 4, vec![0.0], n6.clone()),
            arrow("F6", "the cut on the ram", false, 4, vec![1000.0], vec![0.0]),
        ],
        plots: vec![
            plot("angles", "rad", &[("phi2", &crank), ("phi4", &phi4)]),
            plot("angular speed", "rad/s", &[("phi2_dot", &vec![2.0 * PI / DURATION; FRAMES]), ("phi4_dot", &speed4)]),
            plot("place of the ram", "m", &[("s6", &cx)]),
            plot("speed of the ram", "m/s", &[("s6_dot", &speed6)]),
            plot("acceleration of the ram", "m/s²", &[("s6_ddot", &ram)]),
            plot("reactions", "N", &[("N3", &n3), ("N6", &n6)]),
            plot("torque on the crank", "N m", &[("M2", &torque)]),
        ],
        times,
    }
}

#[test]
#[ignore = "scratch"]
fn dump() {
    let dir = PathBuf::from("/tmp/anim");
    std::fs::create_dir_all(&dir).expect("dir");
    std::fs::write(dir.join("qr.html"), page(&quick_return())).expect("write");
    let piece = fragment(&quick_return());
    std::fs::write(dir.join("two.html"), format!("<!DOCTYPE html><meta charset=utf-8><body style='max-width:900px;margin:auto;font-family:serif'><h1>Report</h1><p>Text before.</p>{piece}<p>Between.</p>{piece}")).expect("write");
    let _ = Command::new("true");
}
