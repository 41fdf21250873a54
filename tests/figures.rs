//! The figures of a run, read back from their files, against exact values and against the run's own rows.

use roxmltree::{Document, Node};

use crate::common;
use crate::common::{Run, Table, near, run};

/// A curve as a reader of the picture sees it.
struct Curve {
    points: Vec<(f64, f64)>,
    /// One unit of the picture, in the units of the axes.
    unit: (f64, f64),
    extremes: [(f64, f64); 2],
    labels: Vec<String>,
}

/// Reads one curve of `figures/FILE.svg`.
fn curve(run: &Run, file: &str, name: &str) -> Curve {
    let text = std::fs::read_to_string(run.path(&format!("figures/{file}.svg"))).expect("a figure");
    let svg = Document::parse(&text).expect("well-formed XML");
    let of_class = |node: &Node, class: &str| node.attribute("class") == Some(class);
    let curve = svg
        .descendants()
        .find(|node| of_class(node, "curve") && node.attribute("data-name") == Some(name))
        .unwrap_or_else(|| panic!("no curve `{name}` in {file}"));
    let panel = curve.ancestors().find(|node| of_class(node, "panel")).expect("a panel around it");
    let number = |key: &str| -> f64 { panel.attribute(key).expect(key).parse().expect("a number") };
    let (left, right, top, bottom) =
        (number("data-left"), number("data-right"), number("data-top"), number("data-bottom"));
    let (t0, t1, low, high) = (number("data-t0"), number("data-t1"), number("data-low"), number("data-high"));
    let unit = ((t1 - t0) / (right - left), (high - low) / (bottom - top));
    let stroke = curve.attribute("data-stroke").expect("a colour");
    let lines =
        svg.descendants().filter(|node| node.has_tag_name("polyline") && node.attribute("stroke") == Some(stroke));
    let mut points = Vec::new();
    for pair in lines.flat_map(|line| line.attribute("points").expect("points").split_whitespace()) {
        let (x, y) = pair.split_once(',').expect("a pair");
        let (x, y): (f64, f64) = (x.parse().expect("a number"), y.parse().expect("a number"));
        // The sample in the legend lies above the panel, and so may others do, or below.
        if (top - 1.0..=bottom + 1.0).contains(&y) {
            points.push((t0 + (x - left) * unit.0, low + (bottom - y) * unit.1));
        }
    }
    // A curve over something else than time has no extremes.
    let extreme = |key: &str| {
        let (t, value) = curve.attribute(key).unwrap_or("NaN NaN").split_once(' ').expect("time and value");
        (t.parse().expect("a number"), value.parse().expect("a number"))
    };
    let ink = curve.attribute("data-ink").expect("a colour");
    let texts = svg.descendants().filter(|node| node.has_tag_name("text") && node.attribute("fill") == Some(ink));
    Curve {
        points,
        unit,
        extremes: [extreme("data-minimum"), extreme("data-maximum")],
        labels: texts.filter_map(|node| node.text().map(|text| text.trim().to_owned())).collect(),
    }
}

/// A number as figures write it: `−9.1316×10⁻⁴`.
fn number_in(label: &str) -> f64 {
    let digits = ["⁰", "¹", "²", "³", "⁴", "⁵", "⁶", "⁷", "⁸", "⁹"];
    let plain = label.replace(['−', '⁻'], "-").replace("×10", "e");
    let plain = digits.iter().zip(0..).fold(plain, |text, (digit, value)| text.replace(digit, &format!("{value}")));
    plain.parse().unwrap_or_else(|_| panic!("`{label}` is no number"))
}

const CURVES: [(&str, &str, &str); 9] = [
    ("rates", "phi2_dot", "phi2d"),
    ("rates", "phi4_dot", "phi4d"),
    ("rates", "phi5_dot", "phi5d"),
    ("v_slide", "v_slide", "v_slide"),
    ("x6", "x6", "x6"),
    ("x6_dot", "x6_dot", "x6d"),
    ("x6_ddot", "x6_ddot", "x6dd"),
    ("reactions", "N3", "N3"),
    ("reactions", "N6", "N6"),
];

#[test]
fn figures_show_the_exact_extremes() {
    let run = run(&[]);
    let exact = Table::reference("quick-return-extremes.csv");
    let value = |quantity: &str, which: &str| {
        let row = (0..exact.rows.len())
            .find(|&row| exact.text(row, "quantity") == quantity && exact.text(row, "which") == which);
        exact.number(row.unwrap_or_else(|| panic!("no {which} of {quantity}")), "value")
    };
    for (file, name, quantity) in CURVES {
        let curve = curve(&run, file, name);
        for ((which, extreme), sign) in ["min", "max"].into_iter().zip(curve.extremes).zip([-1.0, 1.0]) {
            let expected = value(quantity, which);
            let what = format!("{which} of {name}");
            near(&what, extreme.1, expected, 1e-7 * expected.abs().max(1e-2));
            let seen = curve.points.iter().fold(f64::NEG_INFINITY, |most, point| most.max(sign * point.1)) * sign;
            // A twentieth of a pixel is one unit of the picture.
            near(&format!("{what}, as drawn"), seen, expected, 8.0 * curve.unit.1);
            let label = curve.labels.iter().find_map(|label| label.strip_prefix(&format!("{which} ")));
            let label = label.unwrap_or_else(|| panic!("{what} is not marked: {:?}", curve.labels));
            let written = number_in(label.split(' ').next().expect("a number"));
            near(&format!("{what}, as written"), written, expected, 1e-4 * expected.abs());
        }
    }
}

#[test]
fn figures_show_every_row_at_its_time() {
    let run = run(&[]);
    let rows = run.trajectory();
    for (file, name, _) in CURVES {
        let curve = curve(&run, file, name);
        for row in 0..rows.rows.len() {
            let (t, value) = (rows.number(row, "t"), rows.number(row, name));
            let after = curve.points.partition_point(|point| point.0 < t).clamp(1, curve.points.len() - 1);
            let ((t0, v0), (t1, v1)) = (curve.points[after - 1], curve.points[after]);
            let slope = (v1 - v0) / (t1 - t0);
            let drawn = v0 + slope * (t - t0);
            // One unit of the picture along either axis for what is rounded, and as much for what is left out.
            near(&format!("{name} at t = {t}"), drawn, value, 2.0 * curve.unit.1 + 2.0 * (slope * curve.unit.0).abs());
        }
    }
}

#[test]
fn a_column_is_plotted_over_another_one() {
    let run = run(&["--plot", "x6,v_slide:phi2", "--plot", "phi2_ddot,energy"]);
    let figures = run.summary()["figures"].as_array().expect("a list").clone();
    let expected = ["figures/health.svg", "figures/plot-x6-v_slide-phi2.svg", "figures/plot-phi2_ddot-energy-t.svg"];
    assert_eq!(figures[figures.len() - 3..], expected);
    let rows = run.trajectory();
    for (file, name, over) in [
        ("plot-x6-v_slide-phi2", "x6", "phi2"),
        ("plot-x6-v_slide-phi2", "v_slide", "phi2"),
        ("plot-phi2_ddot-energy-t", "phi2_ddot", "t"),
        ("plot-phi2_ddot-energy-t", "energy", "t"),
    ] {
        let Curve { points, unit, .. } = curve(&run, file, name);
        for row in 0..rows.rows.len() {
            let (x, y) = (rows.number(row, over), rows.number(row, name));
            let after = points.partition_point(|point| point.0 < x).clamp(1, points.len() - 1);
            let ((x0, y0), (x1, y1)) = (points[after - 1], points[after]);
            let slope = (y1 - y0) / (x1 - x0);
            let drawn = y0 + slope * (x - x0);
            near(&format!("{name} at {over} = {x}"), drawn, y, 2.0 * unit.1 + 2.0 * (slope * unit.0).abs());
        }
    }
}

#[test]
fn a_path_is_plotted_with_equal_scales() {
    let run = run(&["--plot", "B.y:B.x", "--step", "1e-4"]);
    let Curve { points, unit, .. } = curve(&run, "plot-B.y-B.x", "B.y");
    near("a metre across and up", unit.0 / unit.1, 1.0, 0.03);
    // B is on a circle of 0.7 m around the origin, and swings from -0.4667 m to 0.4667 m.
    for (x, y) in &points {
        near("distance from O4", x.hypot(*y), 0.7, 2.0 * unit.0);
    }
    let (least, most) = points.iter().fold((0.0_f64, 0.0_f64), |(l, m), (x, _)| (l.min(*x), m.max(*x)));
    near("to the left", least, -0.7 * 2.0 / 3.0, 2.0 * unit.0);
    near("to the right", most, 0.7 * 2.0 / 3.0, 2.0 * unit.0);
    assert!(points.iter().all(|(_, y)| *y > 0.5), "the origin is far below");
}

#[test]
fn figures_are_the_same_every_time() {
    let bytes = || -> Vec<(String, Vec<u8>)> {
        let run = run(&[]);
        let figures = run.summary()["figures"].as_array().expect("a list").clone();
        let names = figures.iter().map(|file| file.as_str().expect("a name").to_owned());
        names.map(|file| (file.clone(), std::fs::read(run.path(&file)).expect("a figure"))).collect()
    };
    let first = bytes();
    let expected = ["rates", "x6", "x6_dot", "x6_ddot", "v_slide", "reactions", "health"];
    assert_eq!(
        first.iter().map(|(file, _)| file.clone()).collect::<Vec<_>>(),
        expected.map(|n| format!("figures/{n}.svg"))
    );
    assert_eq!(first, bytes());
}

#[test]
fn figures_of_an_earlier_run_do_not_stay() {
    let first = run(&[]);
    let folder = first.path("");
    let own = first.path("figures/own.svg");
    std::fs::write(&own, "mine").expect("a file of the user");
    let mut again = common::qrm(&["run", "--no-figures", "--out"]);
    assert!(again.arg(&folder).output().expect("the command starts").status.success());
    assert!(!first.path("figures/x6.svg").exists());
    assert_eq!(std::fs::read_to_string(own).expect("still there"), "mine");
    assert_eq!(first.summary()["figures"], serde_json::json!([]));
}
