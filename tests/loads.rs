//! The shaper at work: what its loads do to the energy, and when.

use crate::common::run;

#[test]
fn the_work_of_all_loads_is_the_change_of_the_energy() {
    let run = run(&["shaper", "--method", "auto", "--tolerance", "1e-10", "--no-figures"]);
    assert_eq!(run.status(), 0, "{}", run.stderr());
    let table = run.trajectory();
    let last = table.last();
    // Those that have no potential; the bearings' is not asked for.
    let power = |row: usize| {
        let bearing = -2.0 * table.number(row, "phi2_dot").powi(2);
        ["P_motor", "P_cutting", "P_friction"].iter().map(|name| table.number(row, name)).sum::<f64>() + bearing
    };
    let step = |row: usize| table.number(row + 1, "t") - table.number(row, "t");
    let work: f64 = (0..last).map(|row| 0.5 * step(row) * (power(row) + power(row + 1))).sum();
    let change = table.number(last, "energy") - table.number(0, "energy");
    assert!((work - change).abs() < 0.05 && change > 600.0, "{work} J and {change} J");
    let mut cuts = 0;
    for row in 0..last {
        let (x, v, cut) = (table.number(row, "x6"), table.number(row, "x6_dot"), table.number(row, "P_cutting"));
        if v > 0.2 || !(-0.8..=-0.18).contains(&x) {
            assert!(cut.abs() < 1e-3, "it cuts on its way back: {cut} W at x6 = {x}, {v} m/s");
        } else if v < -0.2 && (-0.78..=-0.2).contains(&x) {
            assert!((cut - 2000.0 * v).abs() < 1e-6, "{cut} W at {v} m/s");
            cuts += 1;
        }
    }
    assert!(cuts > 1000);
}

#[test]
fn every_method_drives_the_shaper_alike() {
    let end = |arguments: &[&str]| {
        let run = run(&[&["shaper", "--no-figures"], arguments].concat());
        assert_eq!(run.status(), 0, "{}", run.stderr());
        run.summary()["end_time"].as_f64().expect("a time")
    };
    let exact = end(&["--method", "dop853", "--tolerance", "1e-11"]);
    for (arguments, allowed) in [
        (&["--method", "rk4", "--step", "1e-4"][..], 1e-7),
        (&["--method", "rodas", "--tolerance", "1e-9"][..], 1e-7),
        (&["--method", "auto", "--tolerance", "1e-10"][..], 1e-7),
    ] {
        let off = (end(arguments) - exact).abs();
        assert!(off < allowed, "{arguments:?}: off by {off:e} s");
    }
}
