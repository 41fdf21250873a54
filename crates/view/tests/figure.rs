//! Reads figures back and compares them with their curves.

use qrm_view::figure::{Abscissa, Curve, Extremes, Figure, NoPicture, Panel, Scale};
use roxmltree::{Document, Node};

fn curve(name: &str, count: usize, end: f64, value: impl Fn(f64) -> f64) -> Curve {
    let points: Vec<(f64, f64)> =
        (0..count).map(|i| end * i as f64 / (count - 1) as f64).map(|t| (t, value(t))).collect();
    let minimum = points.iter().copied().min_by(|a, b| a.1.total_cmp(&b.1)).expect("there are points");
    let maximum = points.iter().copied().max_by(|a, b| a.1.total_cmp(&b.1)).expect("there are points");
    Curve {
        name: name.to_owned(),
        doc: "a curve".to_owned(),
        points,
        extremes: Some(Extremes { minimum, maximum }),
        has_dots: false,
    }
}

fn panel(scale: Scale, curves: Vec<Curve>) -> Panel {
    Panel { quantity: "angular speed".to_owned(), unit: "rad/s".to_owned(), scale, curves, floor: None }
}

fn figure(panels: Vec<Panel>) -> Figure {
    Figure { title: "Rates".to_owned(), abscissa: Abscissa::time(), panels }
}

fn alone(curve: Curve) -> Figure {
    figure(vec![panel(Scale::Linear, vec![curve])])
}

fn drawn(figure: &Figure) -> String {
    let svg = figure.svg().expect("the figure can be drawn");
    Document::parse(&svg).expect("the figure is well-formed");
    assert!(!svg.contains("NaN") && !svg.contains("inf"), "numbers are finite");
    assert!(svg.len() < 150_000, "{} bytes", svg.len());
    svg
}

fn number(node: Node<'_, '_>, name: &str) -> f64 {
    node.attribute(name).and_then(|v| v.parse().ok()).unwrap_or_else(|| panic!("{name} is a number"))
}

fn with_class<'a>(node: Node<'a, 'a>, class: &str) -> Vec<Node<'a, 'a>> {
    node.descendants().filter(|n| n.attribute("class") == Some(class)).collect()
}

fn texts<'a>(document: &'a Document<'a>) -> Vec<(&'a str, Node<'a, 'a>)> {
    let nodes = document.descendants().filter(|n| n.has_tag_name("text"));
    nodes.map(|n| (n.text().unwrap_or_default(), n)).collect()
}

/// Time and value at a position in a panel.
fn value_at(panel: Node<'_, '_>, (x, y): (f64, f64)) -> (f64, f64) {
    let of = |name| number(panel, name);
    let along = (x - of("data-left")) / (of("data-right") - of("data-left"));
    let up = (y - of("data-bottom")) / (of("data-top") - of("data-bottom"));
    let (low, high) = (of("data-low"), of("data-high"));
    let is_linear = panel.attribute("data-scale") == Some("linear");
    let value = if is_linear { low + up * (high - low) } else { 10f64.powf(low.log10() + up * (high / low).log10()) };
    (of("data-t0") + along * (of("data-t1") - of("data-t0")), value)
}

/// The lines in a panel for the curve with this index.
fn lines(document: &Document<'_>, panel: Node<'_, '_>, place: usize) -> Vec<Vec<(f64, f64)>> {
    let curve = panel.children().filter(|n| n.is_element()).nth(place).expect("the curve is named");
    let (top, bottom) = (number(panel, "data-top"), number(panel, "data-bottom"));
    let read = |pair: &str| {
        let (x, y) = pair.split_once(',').expect("coordinates come in pairs");
        (x.parse::<f64>().expect("x"), y.parse::<f64>().expect("y"))
    };
    let all = document.descendants().filter(|n| n.has_tag_name("polyline"));
    let own = all.filter(|n| n.attribute("stroke") == curve.attribute("data-stroke"));
    let lines = own.map(|n| n.attribute("points").unwrap_or_default().split(' ').map(read).collect::<Vec<_>>());
    // The samples of the legend lie outside.
    lines.filter(|line| line.iter().all(|place| (top..=bottom).contains(&place.1))).collect()
}

fn rates() -> Figure {
    let crank = curve("phi2_dot", 1757, 1.756, |t| 7.85 + 0.5 * (15.7 * t).cos());
    let rocker = curve("phi4_dot", 1757, 1.756, |t| 3.0 - 20.0 * (-(t - 0.7).powi(2) * 90.0).exp());
    let rod = curve("phi5_dot", 1757, 1.756, |t| 6.0 * (7.85 * t).sin() * (3.0 * t).cos());
    figure(vec![panel(Scale::Linear, vec![crank, rocker, rod])])
}

#[test]
fn curves_are_where_their_points_are() {
    let figure = rates();
    let svg = drawn(&figure);
    let document = Document::parse(&svg).expect("well-formed");
    let panel = with_class(document.root(), "panel")[0];
    let pixel = 20.0 * (number(panel, "data-high") - number(panel, "data-low"))
        / (number(panel, "data-bottom") - number(panel, "data-top"));
    for (place, curve) in figure.panels[0].curves.iter().enumerate() {
        let lines = lines(&document, panel, place);
        assert_eq!(lines.len(), 1);
        let read: Vec<(f64, f64)> = lines[0].iter().map(|place| value_at(panel, *place)).collect();
        assert!((100..1757).contains(&read.len()), "{} points", read.len());
        for &(t, v) in &curve.points {
            let after = read.partition_point(|r| r.0 < t).clamp(1, read.len() - 1);
            let ((t0, v0), (t1, v1)) = (read[after - 1], read[after]);
            // Rounding a time by half a unit moves a steep curve by more than half a unit.
            let slope = (v1 - v0) / (t1 - t0);
            let off = (v0 + slope * (t - t0) - v).abs();
            let unit_of_time = (number(panel, "data-t1") - number(panel, "data-t0"))
                / (number(panel, "data-right") - number(panel, "data-left"));
            assert!(off < 0.1 * pixel + slope.abs() * unit_of_time, "{} at {t}: {off}", curve.name);
        }
    }
}

#[test]
fn extremes_are_labelled() {
    let figure = rates();
    let svg = drawn(&figure);
    let document = Document::parse(&svg).expect("well-formed");
    let panel = with_class(document.root(), "panel")[0];
    for (curve, node) in figure.panels[0].curves.iter().zip(with_class(panel, "curve")) {
        let extremes = curve.extremes.expect("extremes are given");
        for (word, (t, v)) in [("min ", extremes.minimum), ("max ", extremes.maximum)] {
            let texts = texts(&document);
            let own = texts.iter().filter(|(_, n)| n.attribute("fill") == node.attribute("data-ink"));
            let label = own.filter_map(|(text, _)| text.strip_prefix(word)).next().expect("the extreme is labelled");
            let (value, time) = label.split_once(" at ").expect("value and time");
            let read = |text: &str| text.replace('−', "-").parse::<f64>().expect("a number");
            assert!((read(value) - v).abs() <= 6e-5 * v.abs(), "{label}: {v}");
            assert!((read(time.trim_end_matches(" s")) - t).abs() <= 5e-5 * 1.001, "{label}: {t}");
        }
        let exact: Vec<f64> =
            node.attribute("data-maximum").expect("given").split(' ').map(|n| n.parse().expect("number")).collect();
        assert_eq!(exact, [extremes.maximum.0, extremes.maximum.1]);
    }
}

#[test]
fn labels_of_extremes_keep_clear_of_each_other() {
    let curves = (0..6).map(|k| curve("c", 500, 1.0, move |t| (6.0 * t + f64::from(k)).sin() * f64::from(k + 1)));
    let svg = drawn(&figure(vec![panel(Scale::Linear, curves.collect())]));
    let document = Document::parse(&svg).expect("well-formed");
    let texts = texts(&document);
    let labels: Vec<(f64, f64, f64)> = texts
        .iter()
        .filter(|(text, _)| text.starts_with("max ") || text.starts_with("min "))
        .map(|(text, n)| (number(*n, "x"), number(*n, "y"), 11.5 * 20.0 * 0.5 * text.chars().count() as f64))
        .collect();
    assert_eq!(labels.len(), 12);
    for (i, a) in labels.iter().enumerate() {
        assert!(a.0 - 0.5 * a.2 > 0.0 && a.0 + 0.5 * a.2 < 16_000.0 && (0.0..8400.0).contains(&a.1));
        let is_clear = |b: &(f64, f64, f64)| (a.1 - b.1).abs() >= 230.0 || (a.0 - b.0).abs() > 0.5 * (a.2 + b.2);
        assert!(labels[..i].iter().all(is_clear));
    }
}

#[test]
fn labels_of_extremes_keep_clear_of_steep_curves() {
    // The extremes of the small curve lie between flanks of the large one.
    let steep = [6.0, 2.8].map(|size| curve("c", 500, 5.0, move |t| size * (5.2 * t).sin()));
    let svg = drawn(&figure(vec![panel(Scale::Linear, steep.to_vec())]));
    let document = Document::parse(&svg).expect("well-formed");
    let panel = with_class(document.root(), "panel")[0];
    let lines = [0, 1].map(|place| lines(&document, panel, place)).concat();
    let texts = texts(&document);
    let labels = texts.iter().filter(|(text, _)| text.starts_with("max ") || text.starts_with("min "));
    let mut count = 0;
    for (text, node) in labels {
        let (x, y) = (number(*node, "x"), number(*node, "y"));
        let (half, high) = (0.5 * 11.5 * 20.0 * 0.5 * text.chars().count() as f64, 6.0 * 20.0);
        for step in lines.iter().flat_map(|line| line.windows(2)) {
            let ((x0, y0), (x1, y1)) = (step[0], step[1]);
            let on_way = |part: u32| f64::from(part) / 50.0;
            let places = (0..=50).map(|part| (x0 + on_way(part) * (x1 - x0), y0 + on_way(part) * (y1 - y0)));
            let is_covered = |place: (f64, f64)| (place.0 - x).abs() < half && (place.1 - y).abs() < high;
            assert!(!places.into_iter().any(is_covered), "{text}: {step:?}");
        }
        count += 1;
    }
    assert_eq!(count, 4);
}

#[test]
fn a_path_has_equal_scales_and_shows_the_origin_only_if_it_should() {
    let points = (0..200).map(|i| f64::from(i) * 0.05).map(|a| (10.0 + 0.4 * a.cos(), 7.0 + 0.3 * a.sin())).collect();
    let path = Curve { name: "P.y".to_owned(), doc: String::new(), points, extremes: None, has_dots: false };
    let mut figure = alone(path);
    for has_origin in [false, true] {
        let (quantity, unit) = ("P.x".to_owned(), "m".to_owned());
        figure.abscissa = Abscissa { quantity, unit, scale: Scale::Linear, is_isometric: true, has_origin };
        let svg = drawn(&figure);
        let document = Document::parse(&svg).expect("well-formed");
        let panel = with_class(document.root(), "panel")[0];
        let of = |name| number(panel, name);
        let across = (of("data-t1") - of("data-t0")) / (of("data-right") - of("data-left"));
        let up = (of("data-high") - of("data-low")) / (of("data-bottom") - of("data-top"));
        // The room for the numbers next to the axis depends on these numbers.
        assert!((across / up - 1.0).abs() < 0.03, "{across} and {up}");
        let is_inside = of("data-t0") < 0.0 && of("data-low") < 0.0;
        assert_eq!(is_inside, has_origin);
        assert!(svg.contains("over P.x: P.y."), "{svg}");
    }
}

#[test]
fn text_is_escaped_and_readers_are_told() {
    let mut nasty = curve("q<&>\"'\u{1}Ω", 10, 1.0, |t| t);
    nasty.doc = "</svg><script>".to_owned();
    let plain = curve("b", 10, 1.0, |t| -t);
    let mut figure = figure(vec![panel(Scale::Linear, vec![nasty, plain])]);
    figure.title = "A & B <1> \"two\"".to_owned();
    let svg = drawn(&figure);
    let document = Document::parse(&svg).expect("well-formed");
    let texts = texts(&document);
    assert!(texts.iter().any(|(text, _)| *text == "A & B <1> \"two\""));
    assert!(texts.iter().any(|(text, _)| text.starts_with("q<&>\"'\u{fffd}Ω")));
    for text in ["angular speed (rad/s)", "t (s)", "b\u{2002}a curve"] {
        assert!(texts.iter().any(|(t, _)| *t == text), "{text}");
    }
    let root = document.root_element();
    assert_eq!(root.attribute("role"), Some("img"));
    let said = |tag: &str| root.children().find(|n| n.has_tag_name(tag)).and_then(|n| n.text()).unwrap_or_default();
    assert_eq!(said("title"), figure.title);
    assert!(said("desc").contains("q<&>\"'\u{fffd}Ω (</svg><script>), b (a curve)"), "{}", said("desc"));
}

#[test]
fn ranges_of_any_size_can_be_drawn() {
    let shapes: [fn(f64) -> f64; 5] = [|_| 0.0, |_| 1.0, |t| t, |t| -1.0 - t, |t| (9.0 * t).sin()];
    for end in [1e-9, 1.756, 1e6] {
        for power in [-320, -300, -12, -3, 0, 4, 12, 290] {
            for (i, shape) in shapes.iter().enumerate() {
                for offset in [0.0, 1.0, -1e7, 1e15] {
                    let size: f64 = format!("1e{power}").parse().expect("a number");
                    let curve = curve("c", 2 + 50 * i, end, |t| size * (offset + shape(t / end)));
                    let svg = drawn(&alone(curve.clone()));
                    assert_ticks_differ(&svg);
                    let is_positive = curve.points.iter().any(|point| point.1 > 0.0);
                    let svg = drawn(&figure(vec![panel(Scale::Logarithmic, vec![curve])]));
                    if is_positive {
                        assert_ticks_differ(&svg);
                    }
                }
            }
        }
    }
}

/// Asserts that there are at least two labels to the left of an axis and below one, all different.
fn assert_ticks_differ(svg: &str) {
    let document = Document::parse(svg).expect("well-formed");
    let panel = with_class(document.root(), "panel")[0];
    let (left, bottom) = (number(panel, "data-left"), number(panel, "data-bottom"));
    let ticks = texts(&document);
    let beside: Vec<&str> = ticks
        .iter()
        .filter(|(_, n)| n.attribute("text-anchor") == Some("end") && number(*n, "x") < left)
        .map(|(text, _)| *text)
        .collect();
    let below: Vec<&str> = ticks
        .iter()
        .filter(|(text, n)| number(*n, "y") > bottom && !text.contains('t'))
        .map(|(text, _)| *text)
        .collect();
    for labels in [beside, below] {
        assert!(labels.len() >= 2, "{labels:?}");
        let mut unique = labels.clone();
        unique.sort_unstable();
        unique.dedup();
        assert_eq!(unique.len(), labels.len(), "{labels:?}");
        assert!(labels.iter().all(|label| label.chars().count() <= 9), "{labels:?}");
    }
}

#[test]
fn what_differs_late_is_written_without_what_is_common() {
    let svg = drawn(&alone(curve("phi", 500, 1.0, |t| 3258.0374910400947 + 1e-6 * (6.0 * t).sin())));
    assert_ticks_differ(&svg);
    assert!(svg.contains(">angular speed − 3258.03749 (×10⁻⁶ rad/s)<"), "{svg}");
}

#[test]
fn what_cannot_be_drawn_is_an_error() {
    assert_eq!(figure(Vec::new()).svg(), Err(NoPicture::Empty));
    let empty = Curve { name: "c".to_owned(), doc: String::new(), points: Vec::new(), extremes: None, has_dots: false };
    assert_eq!(alone(empty).svg(), Err(NoPicture::Empty));
    let wide = alone(curve("c", 2, 1.0, |t| (2.0 * t - 1.0) * 1.7e308)).svg();
    assert_eq!(wide, Err(NoPicture::TooFarApart("angular speed".to_owned())));
    let long = Curve { points: vec![(-1.7e308, 0.0), (1.7e308, 1.0)], ..curve("c", 2, 1.0, |t| t) };
    assert_eq!(alone(long).svg(), Err(NoPicture::TooFarApart("t".to_owned())));
    for bad in [f64::NAN, f64::INFINITY] {
        let broken = Curve { points: vec![(0.0, 1.0), (1.0, bad)], ..curve("c", 2, 1.0, |t| t) };
        assert_eq!(alone(broken).svg(), Err(NoPicture::NotFinite("c".to_owned())));
    }
    assert!(figure(Vec::new()).svg().expect_err("empty").to_string().contains("no points"));
}

#[test]
fn logarithmic_curves_break_where_they_are_zero() {
    let gap = curve("c", 101, 1.0, |t| if (0.3..0.6).contains(&t) { 0.0 } else { 1e-9 * (1.0 + t) });
    let zero = curve("z", 11, 1.0, |_| 0.0);
    let svg = drawn(&figure(vec![panel(Scale::Logarithmic, vec![gap]), panel(Scale::Logarithmic, vec![zero])]));
    let document = Document::parse(&svg).expect("well-formed");
    let panels = with_class(document.root(), "panel");
    let lines = lines(&document, panels[0], 0);
    assert_eq!(lines.len(), 2);
    let (t, v) = value_at(panels[0], *lines[1].last().expect("a point"));
    assert!((t - 1.0).abs() < 1e-9 && (v / 2e-9 - 1.0).abs() < 0.01, "{t} {v}");
    assert_eq!(texts(&document).iter().filter(|(text, _)| *text == "all zero").count(), 1);
}

#[test]
fn torn_curves_stay_small() {
    let torn = |k: u32| curve("c", 5000, 1.0, move |t| ((t * 4999.0).round() % 2.0) * f64::from(k));
    drawn(&figure(vec![panel(Scale::Logarithmic, (1..4).map(torn).collect())]));
}

#[test]
fn restless_curves_stay_small_and_keep_their_extremes() {
    let noise = |k: f64| move |t: f64| ((t * 1e4 + k).sin() * 43_758.545).fract();
    let curves: Vec<Curve> = (0..6).map(|k| curve("c", 100_001, 1.0, noise(f64::from(k)))).collect();
    let figure = figure(vec![panel(Scale::Linear, curves)]);
    let svg = drawn(&figure);
    let document = Document::parse(&svg).expect("well-formed");
    let panel = with_class(document.root(), "panel")[0];
    for (place, curve) in figure.panels[0].curves.iter().enumerate() {
        let highest = lines(&document, panel, place)[0].iter().map(|p| value_at(panel, *p).1).fold(f64::MIN, f64::max);
        let maximum = curve.extremes.expect("extremes are given").maximum.1;
        assert!((highest - maximum).abs() < 1e-3, "{highest} {maximum}");
    }
}

#[test]
fn figures_are_the_same_each_time_and_of_one_style() {
    let single = drawn(&rates());
    assert_eq!(single, drawn(&rates()));
    let many = drawn(&figure((0..4).map(|_| panel(Scale::Linear, vec![curve("c", 50, 2.0, |t| t * t)])).collect()));
    let style =
        |svg: &str| svg.split_once("</style>").map(|(head, _)| head[head.find("<style>").unwrap_or(0)..].to_owned());
    assert_eq!(style(&single), style(&many));
    assert!(style(&single).is_some_and(|css| css.contains("prefers-color-scheme:dark")));
    assert!(single.starts_with(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" class=\"qrm\" role=\"img\" width=\"800\" \
                                height=\"420\" viewBox=\"0 0 16000 8400\">"
    ));
    let document = Document::parse(&many).expect("well-formed");
    assert!((800.0..900.0).contains(&number(document.root_element(), "height")));
    assert_eq!(with_class(document.root(), "panel").len(), 4);
}
