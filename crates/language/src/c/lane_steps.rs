//! Steps of lanes on a device, in CUDA.

use qrm_core::BatchRequest;
use qrm_core::lane_layout::{BatchLayout, named_constants};

use super::cuda::{QUALIFIERS, qualified};
use super::{Writer, origin};
use crate::ir::{Program, StructKind};
use crate::untranslated::Untranslated;

/// The functions that steps of lanes call.
const FUNCTIONS: [&str; 8] = [
    "constants",
    "angles",
    "position",
    "residuals",
    "velocity_residual",
    "correction",
    "accelerations",
    "growth_factor",
];
/// The largest number of steps of a lane in one call: a driver may stop calls that take seconds.
const MOST_STEPS: usize = 8192;

/// Writes the function `advance(numbers, lanes)`. It makes steps in each lane until the lane needs its caller, or has
/// tried [`MOST_STEPS`]; the next call continues. The numbers have the places of the layout, lane by lane. `parameters`
/// are the names of the parameters in the order of the layout.
pub(crate) fn write_lane_steps(
    program: &Program,
    (layout, request): (&BatchLayout, &BatchRequest),
    residual: f64,
    parameters: &[&str],
) -> Result<String, Untranslated> {
    let writer = Writer::new(program)?;
    let [mechanism, of_parameters] = [StructKind::Mechanism, StructKind::Parameters].map(|kind| writer.structure(kind));
    let mut code = writer.sizes_and_structs() + &writer.states();
    code += &writer.functions(|name| match name {
        "event" => request.watches_event,
        "outputs_at" => request.ranges,
        other => FUNCTIONS.contains(&other),
    })?;
    code += &writer.construction();
    code += "\n// The places of the numbers of a lane, and counts.\nenum {\n";
    for (name, place) in layout.named_places() {
        code += &format!("    {name} = {place},\n");
    }
    code += &format!("    MOST_STEPS = {MOST_STEPS}\n}};\n\n");
    for (name, value) in
        named_constants().into_iter().chain([("RESIDUAL", residual), ("MOST_GROWTH", request.most_growth())])
    {
        code += &format!("static const double {name} = {value:?};\n");
    }
    code += &format!(
        "\nstatic void set_parameters(const double *x, {mechanism} *m)\n{{\n    {of_parameters} p;\n    (void)x;\n"
    );
    let fields = program.structs.iter().filter(|structure| structure.kind == StructKind::Parameters);
    for field in fields.flat_map(|structure| &structure.fields) {
        let place = parameters.iter().position(|name| *name == field.name);
        let place = place.unwrap_or_else(|| unreachable!("a parameter of the mechanism"));
        code += &format!("    p.{} = x[PARAMETERS + {place}];\n", writer.fields.get(&field.name));
    }
    code += &format!("    {}_new(&p, m);\n}}\n", program.name);
    let flags = [
        ("QRM_WATCHES_EVENT", request.watches_event),
        ("QRM_WAITS_EACH_STEP", request.waits_each_step),
        ("QRM_HAS_RANGES", request.ranges),
        ("QRM_HAS_CHECKPOINTS", request.checkpoints),
    ];
    let flags: String = flags.map(|(name, is_set)| format!("#define {name} {}\n", u8::from(is_set))).concat();
    Ok(origin() + QUALIFIERS + &flags + &qualified(&(code + &writer.lane_source()), &program.name))
}
