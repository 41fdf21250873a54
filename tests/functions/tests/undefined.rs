//! Outputs that are undefined in one row only are noticed in lanes as in a run alone.
use qrm_core::{Model, ParameterOverrides};
use qrm_sim::batch::{LaneCount, SweepRequest, sweep};
use qrm_sim::run::{NonFiniteQuantity, Status};

fn model() -> &'static Model {
    qrm_functions::MODELS.iter().find(|model| model.description.name == "undefined").expect("a generated scene")
}

#[test]
fn a_row_with_an_undefined_output_ends_its_design() {
    // `root` is undefined at the start, `gap` at 0.5; the designs between them are sound.
    let design = |i: usize| match i % 4 {
        0 => ("before", 1e-6),
        2 => ("hole", 1e-6),
        _ => ("m", 2.0),
    };
    let replacements: Vec<_> =
        (0..24).map(|i| move |name: &str| (design(i).0 == name).then_some(design(i).1)).collect();
    let designs: Vec<ParameterOverrides> = replacements.iter().map(|replace| replace as ParameterOverrides).collect();
    for lanes in [LaneCount::Most, LaneCount::Four, LaneCount::One] {
        for extremes in [true, false] {
            let request = SweepRequest { extremes, ..SweepRequest::default() };
            for (i, result) in sweep(model(), &designs, &request, lanes).into_iter().enumerate() {
                let expected = match i % 4 {
                    // Without extremes outputs are not computed.
                    _ if !extremes => None,
                    0 => Some((0.0, 0)),
                    2 => Some((0.5, 1)),
                    _ => None,
                };
                let found = match result.status {
                    Ok(Status::NotFinite { t, what: NonFiniteQuantity::Output(output) }) => Some((t, output)),
                    Ok(Status::Completed) => None,
                    other => panic!("design {i}: {other:?}"),
                };
                assert_eq!(found, expected, "design {i}, {lanes:?}, extremes: {extremes}");
            }
        }
    }
}
