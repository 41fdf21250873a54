//! The functions of a scene as a tape: the operations of the printed functions, in the same order.
//!
//! The printed functions are run on numbers that note what is done with them.

mod places;
mod switching;
mod text;
mod trace;

use qrm_core::{OwnedKernel, OwnedTape};
use qrm_scene::scene::Scene;

use crate::interpret::{GeneratedModule, Value};
use places::Places;
use switching::Switching;
pub use text::text;
use trace::Traced;

/// The tape of a generated module; `operations` is the number that accelerations and multipliers take.
///
/// # Errors
/// If the module holds what generated code does not.
pub(crate) fn of_module(scene: &Scene, file: &syn::File, operations: usize) -> Result<OwnedTape, String> {
    let [n, m] = [scene.coordinates.len(), scene.constraints.len()];
    let module = GeneratedModule::new(file)?;
    trace::begin();
    let count = scene.parameters.iter().filter(|p| !p.left_out).count();
    // In the order of their places.
    let parameters = Traced::inputs(count);
    let t = Value::Number(Traced::inputs(1)[0]);
    let list = |count: usize| Value::numbers_of(&Traced::inputs(count));
    let [q, qd, qdd] = [list(n), list(n), list(n)];
    let multipliers = list(m);
    let angles = Value::fields([("sin", list(n)), ("cos", list(n))]);
    let residuals = list(m);
    let inputs = trace::len();
    let arguments = [
        ("t", t),
        ("q", q),
        ("qd", qd),
        ("qdd", qdd),
        ("multipliers", multipliers),
        ("angles", angles),
        ("residuals", residuals),
    ];
    let mut functions = Functions { module, arguments: arguments.into() };

    functions.module.method("with", &[Value::<Traced>::Nothing])?;
    let mut kept = parameters.into_iter();
    let values = scene.parameters.iter().map(|p| if p.left_out { None } else { kept.next() });
    let values: Vec<Traced> = values.map(|value| value.unwrap_or_else(|| Traced::number(0.0))).collect();
    let mechanism = functions.module.model_of(scene, &values)?;
    functions.arguments.push(("m", mechanism.clone()));
    functions.arguments.push(("self", mechanism));

    let dynamics = ["mass_matrix", "generalized_forces", "constraint_jacobian", "constraint_bias"];
    let dynamics = functions.numbers("dynamics", &dynamics)?;
    let loop_constraints = ["residuals", "constraint_jacobian", "constraint_rate"];
    let loop_constraints = functions.numbers("loop_constraints", &loop_constraints)?;
    let [mass_matrix, energy] = [functions.numbers("mass_matrix", &[])?, functions.numbers("energy", &[])?];
    let [power, outputs] = [functions.numbers("power", &[])?, functions.numbers("outputs", &[])?];
    let matrices = ["stiffness", "damping", "constraint_stiffness", "constraint_damping"];
    let linearization = [&matrices[..], &["forcing", "constraint_forcing"]].concat();
    let linearization = scene.run.stiff.then(|| functions.numbers("linearization", &linearization)).transpose()?;
    let event = scene.run.until.as_ref().map(|_| functions.numbers("event", &[])).transpose()?;
    let start = functions.numbers("start", &["q", "qd"])?;
    let given = functions.value("start")?;
    let given = [given.field("given")?.truths(), given.field("given_rates")?.truths()].concat();
    let schedule = functions.numbers("schedule", &["step", "end_time"])?;
    let has_angle = functions.value("has_angle")?.truths();
    let position = functions.value("position")?;
    let fields = position.all_numbers();
    functions.arguments.push(("position", position));
    let of_position = [functions.numbers("growth_factor", &[])?, functions.numbers("residuals", &[])?].concat();
    let velocity_residual = functions.numbers("velocity_residual", &[])?;
    let correction = functions.numbers("correction", &[])?;
    let mut accelerations = functions.numbers("accelerations", &[])?;
    let multipliers = accelerations.split_off(n);
    let outputs_at = functions.numbers("outputs_at", &[])?;

    let trace = trace::end();
    let mut places = Places::new(&trace, inputs);
    let Switching { functions: switching_functions, linear_in_time, tanh_arguments } =
        Switching::of(&trace, &places, &[&dynamics, &loop_constraints], scene.friction_by_forces().next().is_some());
    let of_state = [&dynamics, &loop_constraints, &mass_matrix, &energy, &power, &outputs, &start, &schedule];
    let of_kernel = [&fields, &of_position, &velocity_residual, &correction, &accelerations, &multipliers, &outputs_at];
    let all = of_state
        .into_iter()
        .chain(of_kernel)
        .chain(&linearization)
        .chain(&event)
        .chain([&switching_functions, &tanh_arguments]);
    let constants = places.constants(all.flatten());
    let mut kernel = places.clone();
    Ok(OwnedTape {
        coordinates: places::place(n),
        constraints: places::place(m),
        is_driven: scene.is_driven(),
        parameters: places.parameters(inputs),
        constants,
        dynamics: places.function(&dynamics),
        loop_constraints: places.function(&loop_constraints),
        mass_matrix: places.function(&mass_matrix),
        energy: places.function(&energy),
        power: places.function(&power),
        outputs: places.function(&outputs),
        linearization: linearization.map(|numbers| places.function(&numbers)),
        event: event.map(|numbers| places.function(&numbers)),
        switching_functions: places.function(&switching_functions),
        linear_in_time,
        tanh_arguments: places.function(&tanh_arguments),
        start: places.function(&start),
        given,
        schedule: places.function(&schedule),
        kernel: OwnedKernel {
            operations,
            has_angle,
            position: kernel.first_part(&fields, &of_position),
            velocity_residual: kernel.part(&velocity_residual),
            correction: kernel.part(&correction),
            accelerations: kernel.clone().function(&accelerations),
            multipliers: kernel.part_after(&accelerations, &multipliers),
            outputs: kernel.part(&outputs_at),
        },
    })
}

/// The functions of a module, and the arguments for all of them.
struct Functions<'f> {
    module: GeneratedModule<'f>,
    arguments: Vec<(&'static str, Value<Traced>)>,
}

impl Functions<'_> {
    /// The result of a function, or else of a method.
    fn value(&self, name: &str) -> Result<Value<Traced>, String> {
        let arguments = |signature: &syn::Signature| -> Result<Vec<Value<Traced>>, String> {
            signature.inputs.iter().map(|input| self.argument(input)).collect()
        };
        match self.module.functions.get(name) {
            Some(function) => self.module.value(name, &arguments(&function.sig)?),
            None => {
                let method = self.module.methods.get(name).ok_or_else(|| format!("no `{name}` was generated"))?;
                self.module.method(name, &arguments(&method.sig)?)
            }
        }
    }

    /// The numbers in some fields of the result, or all if there are no fields.
    fn numbers(&self, name: &str, fields: &[&str]) -> Result<Vec<Traced>, String> {
        let value = self.value(name)?;
        if fields.is_empty() {
            return Ok(value.numbers());
        }
        let fields: Result<Vec<_>, String> = fields.iter().map(|field| value.field(field)).collect();
        Ok(fields?.into_iter().flat_map(Value::numbers).collect())
    }

    /// The argument for a parameter by its name; unused ones begin with an underscore.
    fn argument(&self, input: &syn::FnArg) -> Result<Value<Traced>, String> {
        let name = match input {
            syn::FnArg::Receiver(_) => "self".to_owned(),
            syn::FnArg::Typed(input) => match &*input.pat {
                syn::Pat::Ident(name) => name.ident.to_string(),
                _ => return Err("an argument without a name".to_owned()),
            },
        };
        let name = name.trim_start_matches('_');
        let known = self.arguments.iter().find(|(known, _)| *known == name);
        known.map(|(_, value)| value.clone()).ok_or_else(|| format!("unknown argument `{name}`"))
    }
}
