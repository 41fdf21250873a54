//! The animation: its text, and its behaviour in a browser.

use std::f64::consts::PI;
use std::process::Command;

use qrm_view::animation::{fragment, page};
use qrm_view::motion::{Arrow, ForceElementPart, Motion, Node, Plot, PlotCurve, Shape, Track};

/// The number of frames of the sample.
const FRAMES: usize = 301;
/// The duration of the sample in s.
const DURATION: f64 = 0.88;

fn node(name: &str, is_traced: bool, x: Track, y: Track) -> Node {
    Node { name: name.to_owned(), is_traced, x, y }
}

fn plot(title: &str, unit: &str, curves: &[(&str, &Track)]) -> Plot {
    let curves = curves.iter().map(|&(name, values)| PlotCurve { name: name.to_owned(), values: values.clone() });
    Plot { title: title.to_owned(), unit: unit.to_owned(), curves: curves.collect() }
}

/// Difference quotients of neighbouring values.
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
        // Statics: the rod carries the load on the ram, and the die turns the rocker in the opposite direction.
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
            Shape::Guide { nodes: vec![5, 6], is_channel: false },
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

/// The sample, scaled in size and speed.
fn scaled(size: f64, pace: f64) -> Motion {
    let mut motion = quick_return();
    for node in &mut motion.nodes {
        for value in node.x.iter_mut().chain(&mut node.y) {
            *value *= size;
        }
    }
    for time in &mut motion.times {
        *time *= pace;
    }
    for curve in motion.plots.iter_mut().flat_map(|plot| &mut plot.curves) {
        for value in &mut curve.values {
            *value *= size;
        }
    }
    for arrow in &mut motion.arrows {
        for value in arrow.x.iter_mut().chain(&mut arrow.y) {
            *value *= size * size;
        }
    }
    motion
}

/// All kinds of shapes: a plate with three nodes, a guide that turns, centres of mass.
fn swinging_plate() -> Motion {
    // Unevenly spaced.
    let times: Track = (0..200).map(|frame| 3.0 * (f64::from(frame) / 199.0).powf(1.5)).collect();
    let angle: Track = times.iter().map(|time| -0.5 * PI + 1.1 * (2.0 * PI * time / 3.0).cos()).collect();
    let at = |length: f64, turn: f64| -> (Track, Track) {
        let point = |angle: &f64| (length * (angle + turn).cos(), length * (angle + turn).sin());
        angle.iter().map(point).unzip()
    };
    let [p, q, g, s] = [at(0.5, 0.4), at(0.6, -0.4), at(0.35, 0.0), at(0.9, 0.0)];
    Motion {
        title: "Swinging plate with a slot".to_owned(),
        doc: String::new(),
        nodes: vec![
            node("O", false, vec![0.0], vec![0.0]),
            node("P", true, p.0, p.1),
            node("Q", false, q.0, q.1),
            node("G", false, g.0.clone(), g.1.clone()),
            node("S", true, s.0, s.1),
        ],
        shapes: vec![
            Shape::Pivot { node: 0 },
            Shape::Link { name: "plate".to_owned(), nodes: vec![0, 1, 2] },
            Shape::Guide { nodes: vec![3, 4], is_channel: false },
            Shape::Block { name: "slide".to_owned(), node: 4, angle: angle.clone() },
            Shape::Mass { name: "plate".to_owned(), node: 3 },
        ],
        arrows: vec![
            Arrow {
                name: "G1".to_owned(),
                doc: String::new(),
                is_reaction: false,
                node: 3,
                x: vec![0.0],
                y: vec![-9.81],
            },
            Arrow {
                name: "R_O".to_owned(),
                doc: String::new(),
                is_reaction: true,
                node: 0,
                x: angle.iter().map(|angle| 6.0 * angle.cos()).collect(),
                y: angle.iter().map(|angle| 9.81 - 2.0 * angle.sin()).collect(),
            },
        ],
        plots: vec![plot("angle", "rad", &[("phi", &angle)])],
        times,
    }
}

/// Parts of machines on the swinging plate, some of them with size zero.
fn machine() -> Motion {
    let mut motion = swinging_plate();
    let angle: Track = motion.times.clone();
    let name = || "part".to_owned();
    let gear = |name: String, radius, teeth, is_internal| {
        let angle = angle.clone();
        Shape::Gear { name, node: 0, angle, radius, teeth, phase: 0.1, is_internal }
    };
    let force_element =
        |parts: &[ForceElementPart]| Shape::ForceElement { name: name(), nodes: vec![0, 2], parts: parts.to_vec() };
    let rack = |name: String, pitch| {
        let along = [-0.1, 0.3];
        Shape::Rack { name, node: 3, angle: vec![0.2], along, across: 0.05, pitch, phase: 0.01 }
    };
    let belt = |nodes, is_crossed| {
        let angle = angle.clone();
        Shape::Belt { name: name(), nodes, radii: [0.05, 0.08], is_crossed, angle }
    };
    let (x, y) = (vec![0.1, 0.0, -0.1], vec![0.0, 0.1, 0.0]);
    motion.shapes.extend([
        Shape::Guide { nodes: vec![0, 4], is_channel: true },
        Shape::Rod { name: name(), nodes: vec![1, 2] },
        force_element(&[ForceElementPart::Spring, ForceElementPart::Damper]),
        force_element(&[ForceElementPart::Actuator]),
        gear("wheel".to_owned(), 0.1, 12, false),
        gear(String::new(), 0.3, 40, true),
        gear(name(), 0.0, 1, false),
        rack(String::new(), 0.02),
        rack(name(), 0.0),
        Shape::Rail { node: 1, angle: angle.clone(), along: [0.0, 0.2] },
        belt(vec![0, 4], false),
        belt(vec![0, 4], true),
        belt(vec![0, 0], false),
        Shape::Outline { name: "cam".to_owned(), node: 2, angle, x, y },
    ]);
    motion
}

fn bare(nodes: Vec<Node>) -> Motion {
    Motion {
        title: String::new(),
        doc: String::new(),
        times: vec![0.0, 1.0],
        nodes,
        shapes: vec![],
        arrows: vec![],
        plots: vec![],
    }
}

/// Motions in extreme cases.
fn odd_motions() -> Vec<(&'static str, Motion)> {
    let place = |name: &str| node(name, true, vec![3.0], vec![-2.0]);
    let mut forceless = quick_return();
    for arrow in &mut forceless.arrows {
        (arrow.x, arrow.y) = (vec![0.0], vec![0.0]);
    }
    let mut hostile = quick_return();
    let name = "</script><b>&\"'{title}<!--Kurbelgetriebe-\u{3c6}\u{2082}";
    hostile.title = name.to_owned();
    hostile.doc = name.to_owned();
    hostile.nodes[2].name = name.to_owned();
    hostile.shapes.push(Shape::Mass { name: name.to_owned(), node: 3 });
    hostile.arrows[0].name = name.to_owned();
    hostile.plots[0].title = name.to_owned();
    hostile.plots[0].curves[0].name = name.to_owned();
    let mut broken = quick_return();
    broken.nodes[2].x[0] = f64::NAN;
    broken.plots[0].curves[1].values[100..150].fill(f64::INFINITY);
    let mut constant = bare(vec![place("P")]);
    constant.plots = vec![
        plot("constant", "m", &[("zero", &vec![0.0; 2]), ("none", &vec![0.0; 2])]),
        plot("large", "", &[("x", &vec![-4.2e9; 2])]),
        plot("empty", "N", &[]),
    ];
    constant.arrows = vec![Arrow {
        name: "F".to_owned(),
        doc: String::new(),
        is_reaction: true,
        node: 0,
        x: vec![0.0, 5.0],
        y: vec![1.0],
    }];
    vec![
        ("small", scaled(1e-6, 1e-5)),
        ("large", scaled(1e6, 1e4)),
        ("plate", swinging_plate()),
        ("machine", machine()),
        ("nothing", bare(vec![])),
        ("point", bare(vec![place("P"), place("Q")])),
        ("line", bare(vec![place("P"), node("", false, vec![3.0, 4.0], vec![-2.0])])),
        ("constant", constant),
        ("forceless", forceless),
        ("hostile", hostile),
        ("broken", broken),
    ]
}

/// The content of the script element with the data.
fn data(html: &str) -> serde_json::Value {
    let (_, rest) = html.split_once("<script type=\"application/json\">").expect("an element with the data");
    let (json, _) = rest.split_once("</script>").expect("the end of the data");
    serde_json::from_str(json).expect("the data are JSON")
}

#[test]
fn the_same_motion_gives_the_same_page() {
    assert_eq!(page(&quick_return()), page(&quick_return()));
    assert_eq!(fragment(&quick_return()), fragment(&quick_return()));
}

#[test]
fn numbers_have_the_digits_that_can_be_seen() {
    let mut motion = bare(vec![
        node("P", false, vec![1.0 / 3.0, 1.0], vec![-0.0, 2e-9]),
        node("Q", false, vec![1000.0 + 1.0 / 3.0], vec![0.1]),
    ]);
    motion.times = vec![0.0, f64::NAN];
    let far = data(&page(&motion));
    assert_eq!(far["nodes"][0]["x"].to_string(), "[0.333,1]");
    assert_eq!(far["nodes"][0]["y"].to_string(), "[0,0]");
    assert_eq!(far["times"].to_string(), "[0,null]");
    motion.nodes.pop();
    let near = data(&page(&motion));
    assert_eq!(near["nodes"][0]["x"].to_string(), "[0.3333333,1]");
    // At a distance of a thousand metres a motion of one metre is as smooth as at the origin.
    motion.nodes[0].x = vec![1000.0 + 1.0 / 3.0, 1001.0];
    let moved = data(&page(&motion));
    assert_eq!(moved["nodes"][0]["x"].to_string(), "[1000.3333333,1001]");
}

#[test]
fn names_stay_text() {
    for (name, motion) in odd_motions() {
        let html = page(&motion);
        assert_eq!(html.matches("</script>").count(), 2, "{name}: a name ends a script");
        assert!(!html.contains("<b>"), "{name}: a name becomes an element");
        assert!(!html.contains("<!--"), "{name}: a name becomes a comment");
        assert_eq!(data(&html)["title"], motion.title, "{name}: the title is not kept");
        assert_eq!(data(&html)["nodes"].as_array().map(Vec::len), Some(motion.nodes.len()), "{name}");
    }
}

#[test]
fn nothing_is_fetched() {
    let html = page(&quick_return());
    let addresses = html.matches("http:").count() + html.matches("https:").count();
    assert_eq!(addresses, html.matches("\"http://www.w3.org/2000/svg\"").count());
    assert!(!html.contains("src=") && !html.contains("@import") && !html.contains("url("));
    assert_eq!(html.matches("href=").count(), 1, "only the empty icon");
    assert!(html.contains("href=\"data:,\""));
}

#[test]
fn a_fragment_claims_nothing_of_the_page_around_it() {
    let html = fragment(&quick_return());
    assert!(!html.contains(" id="));
    assert!(!html.contains("<html") && !html.contains("<body") && !html.contains("<title>"));
    let (_, css) = html.split_once("<style>").expect("a style");
    let (css, _) = css.split_once("</style>").expect("the end of the style");
    for line in css.lines().filter(|line| line.contains('{') && !line.trim_start().starts_with('@')) {
        let selector = line.split('{').next().unwrap_or_default();
        assert!(
            selector.split(',').all(|one| one.contains(".qrm-") || one.contains("[data-mode=") || !one.contains('.')),
            "`{selector}` reaches beyond the animation"
        );
    }
}

#[test]
fn long_runs_stay_small() {
    let mut motion = quick_return();
    let many = |seed: f64| -> Track { (0..1500).map(|frame| 0.7 * (seed + 0.01 * f64::from(frame)).sin()).collect() };
    motion.times = (0..1500).map(|frame| f64::from(frame) / 750.0).collect();
    motion.nodes = (0..10).map(|place| node("P", true, many(f64::from(place)), many(0.5 + f64::from(place)))).collect();
    let curves: Vec<(String, Track)> =
        (0..10).map(|place| (format!("q{place}"), many(0.3 * f64::from(place)))).collect();
    motion.plots = curves.iter().map(|(name, values)| plot(name, "m", &[(name, values)])).collect();
    let size = page(&motion).len();
    assert!(size < 700_000, "{size} bytes");
}

/// The results of a script in the page, and the messages of the browser.
struct Visit {
    document: String,
    said: String,
}

impl Visit {
    /// The value that the script stored under a name.
    fn found(&self, name: &str) -> &str {
        let (_, rest) = self.document.split_once(&format!(" data-{name}=\"")).unwrap_or_else(|| {
            panic!("the page says nothing of `{name}`; the browser said:\n{}", self.said);
        });
        rest.split('"').next().unwrap_or_default()
    }

    fn number(&self, name: &str) -> f64 {
        self.found(name).parse().unwrap_or_else(|_| panic!("`{name}` is {}", self.found(name)))
    }

    /// Asserts that neither the console nor the page reports a problem.
    fn assert_silent(&self, what: &str) {
        let complaints: Vec<&str> = self.said.lines().filter(|line| line.contains("CONSOLE")).collect();
        assert!(complaints.is_empty(), "{what}: {complaints:#?}");
        assert_eq!(self.found("errors"), "", "{what}");
    }
}

/// Opens a page in Chromium and runs the steps of a script in it, at intervals of 0.2 s.
fn visit(name: &str, html: &str, address: &str, steps: &str) -> Visit {
    let folder = std::env::temp_dir().join(format!("qrm-view-{}-{name}", std::process::id()));
    std::fs::create_dir_all(&folder).expect("a folder for the page");
    // Virtual time advances without drawing frames, so callbacks of frames are replaced by timers.
    let watch = "<head><script>
let errors = [];
onerror = (message) => { errors.push(message); };
requestAnimationFrame = (work) => setTimeout(() => work(performance.now()), 16);
</script>";
    let run = format!(
        "<script>{{
const root = document.querySelector('.qrm-animation');
const find = (name) => root.querySelector('.qrm-' + name);
const keep = (name, value) => document.body.setAttribute('data-' + name, value);
const press = (key) => document.dispatchEvent(new KeyboardEvent('keydown', {{ key, bubbles: true }}));
const steps = [{steps}, () => keep('errors', errors.join('; '))];
steps.forEach((step, place) => setTimeout(step, 200 * (place + 1)));
}}</script></body>"
    );
    let html = html.replacen("<head>", watch, 1).replacen("</body>", &run, 1);
    let file = folder.join("page.html");
    std::fs::write(&file, html).expect("the page is written");
    let chromium = std::env::var("CHROMIUM").unwrap_or_else(|_| "chromium".to_owned());
    let output = Command::new(&chromium)
        .args(["--headless=new", "--no-sandbox", "--disable-gpu", "--window-size=1400,900"])
        .args(["--virtual-time-budget=4000", "--dump-dom", "--enable-logging=stderr"])
        .arg(format!("--user-data-dir={}", folder.join("profile").display()))
        .arg(format!("file://{}{address}", file.display()))
        .output();
    let _ = std::fs::remove_dir_all(&folder);
    let output = output.unwrap_or_else(|error| panic!("`{chromium}` cannot be run ({error}): set CHROMIUM"));
    assert!(output.status.success(), "`{chromium}` failed: {}", String::from_utf8_lossy(&output.stderr));
    Visit {
        document: String::from_utf8_lossy(&output.stdout).into_owned(),
        said: String::from_utf8_lossy(&output.stderr).into_owned(),
    }
}

/// The direction of a bar on the screen, converted back to that of the mechanism.
const DIRECTION: &str = "const direction = (name) => {
  const bar = root.querySelector(`[data-name='${name}'] .qrm-bar`);
  const [ax, ay, bx, by] = bar.getAttribute('points').split(/[ ,]+/).map(Number);
  return Math.atan2(ay - by, bx - ax);
}";

fn turned(angle: f64) -> f64 {
    angle - 2.0 * PI * (angle / (2.0 * PI)).round()
}

#[test]
#[ignore = "full tier: browser"]
fn it_plays_and_obeys() {
    let motion = quick_return();
    let steps = format!(
        "() => keep('early', root.dataset.time),
() => keep('late', root.dataset.time),
() => {{
  {DIRECTION};
  find('slider').value = 0.5;
  find('slider').dispatchEvent(new Event('input', {{ bubbles: true }}));
  keep('seeked', root.dataset.time);
  keep('shown', find('time').textContent);
  keep('playing', root.dataset.playing);
  keep('crank', direction('crank'));
  keep('rocker', direction('rocker'));
  keep('cursor', root.querySelector('.qrm-cursor').getAttribute('transform'));
  press('ArrowRight');
  keep('next', root.dataset.time);
  press('ArrowLeft');
  press('ArrowLeft');
  keep('previous', root.dataset.time);
  find('forces').click();
  keep('forces', getComputedStyle(root.querySelector('.qrm-layer-forces')).visibility);
  keep('outside', document.documentElement.scrollWidth > innerWidth || document.documentElement.scrollHeight > innerHeight);
  press(' ');
  keep('again', root.dataset.playing);
}}"
    );
    let visit = visit("plays", &page(&motion), "", &steps);
    visit.assert_silent("the sample");
    assert!(visit.number("early") > 0.1, "it does not play");
    assert!(visit.number("late") > visit.number("early") + 0.1, "it does not go on");
    assert_eq!(visit.number("seeked"), 0.5);
    assert_eq!(visit.found("shown"), "t = 0.500 s");
    assert_eq!(visit.found("playing"), "false");
    let crank = crank_angle(0.5);
    let rocker = (0.3 + 0.2 * crank.sin()).atan2(0.2 * crank.cos());
    assert!(turned(visit.number("crank") - crank).abs() < 1e-3, "crank at {}", visit.found("crank"));
    assert!(turned(visit.number("rocker") - rocker).abs() < 1e-3, "rocker at {}", visit.found("rocker"));
    assert!(visit.found("cursor").starts_with("translate("));
    let frame = |time: f64| motion.times.iter().any(|each| (each - time).abs() < 1e-6);
    assert!(frame(visit.number("next")) && visit.number("next") > 0.5);
    assert!(frame(visit.number("previous")) && visit.number("previous") < 0.5);
    assert_eq!(visit.found("forces"), "hidden");
    assert_eq!(visit.found("outside"), "false", "the page is larger than the window");
    assert_eq!(visit.found("again"), "true");
}

#[test]
#[ignore = "full tier: browser"]
fn the_address_sets_the_moment() {
    let keep = "() => { keep('moment', root.dataset.time); keep('playing', root.dataset.playing ?? 'never'); }";
    let visit = visit("address", &page(&quick_return()), "#t=0.25", keep);
    visit.assert_silent("the sample");
    assert_eq!(visit.number("moment"), 0.25);
    assert_eq!(visit.found("playing"), "never");
}

#[test]
#[ignore = "full tier: browser"]
fn odd_motions_are_drawn_without_complaint() {
    let steps = "() => {
  find('slider').value = find('slider').max;
  find('slider').dispatchEvent(new Event('input', { bubbles: true }));
  keep('shapes', find('canvas').querySelectorAll('svg > g').length);
  keep('bold', document.querySelectorAll('b').length);
  const drawn = [...root.querySelectorAll('svg, output')].map((each) => each.outerHTML).join();
  keep('strange', drawn.match(/NaN|Infinity|undefined/)?.[0] ?? '');
}";
    for (name, motion) in odd_motions() {
        let visit = visit(name, &page(&motion), "", steps);
        visit.assert_silent(name);
        assert!(visit.number("shapes") >= 5.0, "{name}: nothing is drawn");
        assert_eq!(visit.found("bold"), "0", "{name}: a name became an element");
        assert_eq!(visit.found("strange"), "", "{name}");
    }
}

#[test]
#[ignore = "full tier: browser"]
fn fragments_stand_side_by_side() {
    let (one, other) = (fragment(&quick_return()), fragment(&swinging_plate()));
    let html = format!("<!DOCTYPE html><html><head><title>Both</title></head><body>{one}{other}</body></html>");
    let steps = "() => {
  const [one, other] = document.querySelectorAll('.qrm-animation');
  const slider = other.querySelector('.qrm-slider');
  slider.value = 2;
  slider.dispatchEvent(new Event('input', { bubbles: true }));
  keep('one', one.dataset.time);
  keep('other', other.dataset.time);
  press(' ');
  keep('still', other.dataset.playing);
}";
    let visit = visit("both", &html, "#t=0.3", steps);
    visit.assert_silent("two fragments");
    assert!(visit.number("one") < DURATION);
    assert_eq!(visit.number("other"), 2.0);
    assert_eq!(visit.found("still"), "false", "a fragment takes keys of the page around it");
}
