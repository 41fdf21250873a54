//! Prints large scenes with repeating structure.
//!
//! ```text
//! cargo run -p qrm-codegen --example make -- four-bars 40 > scenes/large/n-four-bar-40.toml
//! cargo run -p qrm-codegen --example make -- absolute 14  > scenes/large/absolute-14.toml
//! ```
//!
//! Chains are described in three ways: by `relative` angles, by `angles` relative to the ground, or by `absolute`
//! coordinates.

use std::process::ExitCode;

fn main() -> ExitCode {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let (kind, count) = match &arguments[..] {
        [kind, count] => (kind.as_str(), count.parse::<usize>().ok().filter(|count| *count > 0)),
        _ => ("", None),
    };
    let text = match (kind, count) {
        ("four-bars", Some(count)) => four_bars(count),
        ("relative", Some(count)) => chain(count, Chain::Relative),
        ("angles", Some(count)) => chain(count, Chain::Angles),
        ("absolute", Some(count)) => chain(count, Chain::Absolute),
        _ => {
            eprintln!(
                "error: say what to make and of how many: `four-bars N`, `relative N`, `angles N` or `absolute N`"
            );
            return ExitCode::from(2);
        }
    };
    print!("{text}");
    ExitCode::SUCCESS
}

/// Joins one line for each index below `count`.
fn lines(count: usize, line: impl Fn(usize) -> String) -> String {
    (0..count).map(|i| line(i) + "\n").collect()
}

/// Coupled four-bar linkages with equal rods: cranks one metre apart, with couplers between their tips.
pub fn four_bars(n: usize) -> String {
    let guesses: Vec<String> =
        (1..=n).map(|i| format!("a{i} = 'pi/2'")).chain((0..n).map(|i| format!("b{i} = 0"))).collect();
    [
        format!(
            "name = \"n-four-bar-{n}\"\n\
             doc = \"{n} coupled four-bars of equal rods under gravity: twice a turn all rods lie in line, and the \
             loops lose their rank.\"\n\n\
             # Gonzalez, Dopico, Lugris, Cuadrado, Multibody System Dynamics 16 (2006) 179-190. Made by \
             codegen/examples/make.rs.\n\
             coordinates = [\n"
        ),
        lines(n + 1, |i| format!("    {{ name = \"a{i}\", unit = \"rad\", doc = \"crank {i}\" }},")),
        lines(n, |i| format!("    {{ name = \"b{i}\", unit = \"rad\", doc = \"coupler {i}\" }},")),
        "]\n\n[parameters]\n\
         l  = { value = 1.0, unit = \"m\", doc = \"length of every rod\" }\n\
         m  = { value = 1.0, unit = \"kg\", doc = \"mass of every rod\" }\n\
         J  = { value = 'm*l^2/12', unit = \"kg m^2\", doc = \"inertia of every rod about its middle\" }\n\
         g  = { value = 9.81, unit = \"m/s^2\", doc = \"gravity\" }\n\
         v0 = { value = 1.0, unit = \"m/s\", doc = \"speed of the couplers at the start\" }\n\n[points]\n"
            .to_owned(),
        lines(n + 1, |i| format!("A{i} = ['{i}*l', '0']")),
        lines(n + 1, |i| format!("B{i} = ['A{i}.x + l*cos(a{i})', 'l*sin(a{i})']")),
        "\n[bodies]\n".to_owned(),
        lines(n + 1, |i| {
            format!(
                "crank{i} = {{ mass = 'm', com = ['A{i}.x + l/2*cos(a{i})', 'l/2*sin(a{i})'], angle = 'a{i}', \
                     inertia = 'J' }}"
            )
        }),
        lines(n, |i| {
            format!(
                "coupler{i} = {{ mass = 'm', com = ['B{i}.x + l/2*cos(b{i})', 'B{i}.y + l/2*sin(b{i})'], angle = \
                     'b{i}', inertia = 'J' }}"
            )
        }),
        "\n[constraints]\n".to_owned(),
        lines(n, |i| {
            let next = i + 1;
            format!(
                "loop{i}_x = {{ residual = 'B{i}.x + l*cos(b{i}) - B{next}.x', unit = \"m\" }}\n\
                 loop{i}_y = {{ residual = 'B{i}.y + l*sin(b{i}) - B{next}.y', unit = \"m\" }}"
            )
        }),
        format!(
            "\n[loads]\nweight = {{ gravity = ['0', '-g'] }}\n\n[initial]\ngiven = {{ a0 = 'pi/2', a0_dot = '-v0/l' \
             }}\nsolve = {{ {} }}\n\n",
            guesses.join(", ")
        ),
        "[outputs]\n\
         B0x     = { value = 'B0.x', unit = \"m\", doc = \"tip of the first crank\" }\n\
         B0y     = { value = 'B0.y', unit = \"m\", doc = \"tip of the first crank\" }\n\
         B0x_dot = { rate = 'B0.x', unit = \"m/s\", doc = \"its velocity\" }\n\
         B0y_dot = { rate = 'B0.y', unit = \"m/s\", doc = \"its velocity\" }\n\n"
            .to_owned(),
        known_four_bars(n).to_owned(),
        "[run]\nstep = 1e-3\nend_time = 20\n".to_owned(),
    ]
    .concat()
}

/// Reference values: the cranks stay parallel, so the motion is that of a pendulum, integrated with 140 bits.
fn known_four_bars(n: usize) -> &'static str {
    match n {
        40 => {
            "# The cranks stay parallel, so the motion is that of a pendulum, integrated with 140 bits.\n\
             [reference.second_20]\nt = 20\naccuracy = 1e-16\n\
             values = { B0x = 0.41090115376294522215, B0y = 0.91167990097198065163, B0x_dot = 1.566785371909069949, \
             B0y_dot = -0.706162235593837307, a0 = 'pi/2 - 63.255295368190928039' }\n\n"
        }
        _ => "",
    }
}

/// The coordinates that describe the links of a chain.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Chain {
    /// The angle of each link relative to the previous one.
    Relative,
    /// The angle of each link relative to the ground.
    Angles,
    /// The position and angle of each link; joints are constraints.
    Absolute,
}

/// A chain of hanging links.
pub fn chain(n: usize, kind: Chain) -> String {
    let (name, by) = match kind {
        Chain::Relative => ("relative", "relative angles"),
        Chain::Angles => ("angles", "angles against the ground"),
        Chain::Absolute => ("absolute", "position and angle of each"),
    };
    let is_absolute = kind == Chain::Absolute;
    let angle = |i: usize| match kind {
        Chain::Relative => (0..=i).map(|k| format!("a{k}")).collect::<Vec<_>>().join(" + "),
        Chain::Angles | Chain::Absolute => format!("a{i}"),
    };
    // The joint before a link, and a point on the link at a distance from that joint.
    let joint = |i: usize| i.checked_sub(1).map(|i| (format!("P{i}.x + "), format!("P{i}.y "))).unwrap_or_default();
    let along = |i: usize, part: &str| {
        let ((x, y), angle) = (joint(i), angle(i));
        format!("['{x}{part}*sin({angle})', '{y}- {part}*cos({angle})']")
    };
    let coordinates = |i: usize| {
        let place = format!("    {{ name = \"x{i}\", unit = \"m\" }},\n    {{ name = \"y{i}\", unit = \"m\" }},\n");
        format!("{}    {{ name = \"a{i}\", unit = \"rad\" }},", if is_absolute { place.as_str() } else { "" })
    };
    let point = |i: usize| match is_absolute {
        true => format!("P{i} = ['x{i} + l/2*sin(a{i})', 'y{i} - l/2*cos(a{i})']"),
        false => format!("P{i} = {}", along(i, "l")),
    };
    let body = |i: usize| {
        let com = if is_absolute { format!("['x{i}', 'y{i}']") } else { along(i, "l/2") };
        format!("link{i} = {{ mass = 'm', com = {com}, angle = '{}', inertia = 'J' }}", angle(i))
    };
    let closure = |i: usize| {
        let (x, y) = i.checked_sub(1).map(|i| (format!(" - P{i}.x"), format!(" - P{i}.y"))).unwrap_or_default();
        format!(
            "joint{i}_x = {{ residual = 'x{i} - l/2*sin(a{i}){x}', unit = \"m\" }}\n\
             joint{i}_y = {{ residual = 'y{i} + l/2*cos(a{i}){y}', unit = \"m\" }}"
        )
    };
    // All links in line.
    let given = |i: usize| format!("a{i} = {}, a{i}_dot = 0", u8::from(i == 0 || kind != Chain::Relative));
    let guess = |i: usize| format!("x{i} = '{i}.5*l*sin(1)', y{i} = '-{i}.5*l*cos(1)'");
    let list = |entry: &dyn Fn(usize) -> String| (0..n).map(entry).collect::<Vec<_>>().join(", ");
    [
        format!("name = \"{name}-{n}\"\ndoc = \"{n} links that hang from each other, by {by}.\"\n\n"),
        "# Made by codegen/examples/make.rs.\ncoordinates = [\n".to_owned(),
        lines(n, coordinates),
        "]\n\n[parameters]\n\
         l = { value = 0.2, unit = \"m\", doc = \"length of a link\" }\n\
         m = { value = 0.5, unit = \"kg\", doc = \"its mass\" }\n\
         J = { value = 'm*l^2/12', unit = \"kg m^2\", doc = \"its inertia\" }\n\
         g = { value = 9.81, unit = \"m/s^2\", doc = \"gravity\" }\n\n[points]\n"
            .to_owned(),
        lines(n, point),
        "\n[bodies]\n".to_owned(),
        lines(n, body),
        if is_absolute { format!("\n[constraints]\n{}", lines(n, closure)) } else { String::new() },
        format!("\n[loads]\nweight = {{ gravity = ['0', '-g'] }}\n\n[initial]\ngiven = {{ {} }}\n", list(&given)),
        if is_absolute { format!("solve = {{ {} }}\n", list(&guess)) } else { String::new() },
        "\n[run]\nstep = 1e-3\nend_time = 1\n".to_owned(),
    ]
    .concat()
}
