//! The plan of the generated file: the functions, their arguments and the shapes of their results.

use super::formulae;
use crate::formula::{Style, Writer};
use crate::term::{Equations, Term};
use qrm_core::named_tape::{Argument, Shape};
use qrm_scene::scene::Scene;

/// A planned function.
#[derive(Clone, Debug)]
pub(super) struct Plan<T> {
    pub(super) name: &'static str,
    pub(super) aliases: &'static [&'static str],
    pub(super) doc: String,
    pub(super) arguments: &'static [Argument],
    /// The result, or the named fields of the result.
    pub(super) parts: Vec<(&'static str, Shape<T>)>,
    /// The type of a result with several parts.
    pub(super) structure: Option<&'static str>,
}

impl<T> Plan<T> {
    /// The values of all parts.
    pub(super) fn values(&self) -> impl Iterator<Item = &T> {
        self.parts.iter().flat_map(|(_, shape)| shape.values())
    }

    /// Copies the plan with other values.
    pub(super) fn map<U>(&self, f: &mut impl FnMut(&T) -> U) -> Plan<U> {
        Plan {
            name: self.name,
            aliases: self.aliases,
            doc: self.doc.clone(),
            arguments: self.arguments,
            parts: self.parts.iter().map(|(name, shape)| (*name, shape.map(f))).collect(),
            structure: self.structure,
        }
    }
}

pub(super) fn plans<'e>(scene: &Scene, e: &'e Equations) -> Vec<Plan<&'e Term>> {
    use Argument::{Accelerations, Coordinates, Multipliers, Rates, Time};
    let vector = |terms: &'e [Term]| Shape::Vector(terms.iter().collect());
    let matrix = |rows: &'e [Vec<Term>]| Shape::Matrix(rows.iter().map(|row| row.iter().collect()).collect());
    let quoted = |names: &[String]| names.iter().map(|name| format!("`{name}`")).collect::<Vec<_>>().join(", ");
    let row_names: Vec<String> =
        e.rows.iter().map(|row| format!("{}.{}", scene.bodies[row.body].name, ["x", "y", "angle"][row.axis])).collect();
    let rows = format!("Rows: {}.", quoted(&row_names));
    let constraint_names: Vec<String> = scene.constraints.iter().map(|c| c.name.clone()).collect();
    let constraints: Vec<String> = scene
        .constraints
        .iter()
        .map(|c| format!("`{}`{}", c.name, if c.unit.is_empty() { String::new() } else { format!(" ({})", c.unit) }))
        .collect();
    let constraints = format!("Rows: {}.", constraints.join(", "));
    let coordinate_names: Vec<String> = scene.coordinates.iter().map(|c| c.name.clone()).collect();
    let columns = format!("Columns: {}.", quoted(&coordinate_names));
    // Constraints that depend on time take it as an argument, and have more terms.
    let is_driven = scene.is_driven();
    let (at_position, of_motion): (&[Argument], &[Argument]) = match is_driven {
        true => (&[Time, Coordinates], &[Time, Coordinates, Rates]),
        false => (&[Coordinates], &[Coordinates, Rates]),
    };
    let angles = scene.coordinates.iter().all(|c| c.unit == "rad");
    let outputs: Vec<String> = scene.outputs.iter().map(|o| format!("`{}` ({})", o.name, o.unit)).collect();
    let output_names: Vec<String> = scene.outputs.iter().map(|o| o.name.clone()).collect();
    let energies = ["kinetic", "potential"].map(str::to_owned);
    let writer = Writer::new(scene, Style::Plain, &e.names).naming_roots(e.terms());
    let single = |name, aliases, doc: String, arguments, names: &[String], shape| Plan {
        name,
        aliases,
        doc: doc + formulae::block(&writer, names, &coordinate_names, &shape).as_str(),
        arguments,
        parts: vec![("", shape)],
        structure: None,
    };

    let is_large_tree = e.has_momenta();
    let of_velocities = if is_large_tree {
        single(
            "com_velocities",
            &["T qd"],
            format!(
                "Velocities of the centres of mass and angular velocities of the bodies due to the rates of the \
                 coordinates, `T qd`, in m/s and rad/s.\n\n{rows}"
            ),
            &[Coordinates, Rates],
            &row_names,
            vector(&e.com_velocities),
        )
    } else {
        single(
            "com_jacobian",
            &["T", "x_q"],
            format!(
                "The transformation matrix of the TMT method, `T = dx/dq`, each entry in the unit of its row over that \
                 of its column.\n\n{rows} {columns}"
            ),
            &[Coordinates],
            &row_names,
            matrix(&e.com_jacobian),
        )
    };
    let mut plans = vec![
        single(
            "com_positions",
            &["x"],
            format!("Positions of the centres of mass and angles of the bodies, `x(q)`, in m and rad.\n\n{rows}"),
            &[Coordinates],
            &row_names,
            vector(&e.com_positions),
        ),
        of_velocities,
        single(
            "com_bias",
            &["T_dq·qd", "convective acceleration"],
            format!("Convective accelerations `(T qd)_q qd`: `xdd = T qdd + bias`, in m/s^2 and rad/s^2.\n\n{rows}"),
            &[Coordinates, Rates],
            &row_names,
            vector(&e.com_bias),
        ),
    ];
    if !scene.constraints.is_empty() {
        plans.extend([
            single(
                "constraints",
                &["C"],
                format!(
                    "Residuals of the loop closures, `C(q{})`.\n\n{constraints}",
                    if is_driven { ", t" } else { "" }
                ),
                at_position,
                &constraint_names,
                vector(&e.constraints),
            ),
            single(
                "constraint_jacobian",
                &["C_q"],
                format!("The constraint Jacobian `C_q = dC/dq`.\n\n{constraints} {columns}"),
                at_position,
                &constraint_names,
                matrix(&e.constraint_jacobian),
            ),
            single(
                "constraint_bias",
                &["C_qq", "(C_q qd)_q qd"],
                format!(
                    "{}: `C_q qdd + bias = 0`, in the unit of each constraint per s^2.\n\n{constraints}",
                    if is_driven {
                        "`(C_q qd)_q qd + 2 C_qt qd + C_tt`"
                    } else {
                        "`(C_q qd)_q qd`, the contraction of `C_qq` with `qd qd`"
                    }
                ),
                of_motion,
                &constraint_names,
                vector(&e.constraint_bias),
            ),
        ]);
    }
    if is_driven {
        plans.push(single(
            "constraint_rate",
            &["C_t"],
            format!(
                "`C_t`, how fast the closures move by themselves: `C_q qd + C_t = 0`, in the unit of each constraint \
                 per s.\n\n\
                 {constraints}"
            ),
            at_position,
            &constraint_names,
            vector(&e.constraint_rate),
        ));
    }
    let of_inertia = if is_large_tree {
        single(
            "momenta",
            &["Mbar qd", "generalized momenta"],
            format!(
                "The generalized momenta `Mbar qd = T' M T qd`{}. Unit rates give the columns of the reduced mass \
                 matrix.\n\nRows: {}",
                if angles { ", in N m s" } else { ", in N s for lengths, N m s for angles" },
                columns.trim_start_matches("Columns: ")
            ),
            &[Coordinates, Rates],
            &coordinate_names,
            vector(&e.momenta),
        )
    } else {
        single(
            "mass_matrix",
            &["Mbar", "reduced mass matrix"],
            format!(
                "The reduced mass matrix `Mbar = T' M T`, symmetric{}.\n\nRows and columns: {}",
                if angles { ", in kg m^2" } else { "; kg between lengths, kg m^2 between angles, kg m between both" },
                columns.trim_start_matches("Columns: ")
            ),
            &[Coordinates],
            &coordinate_names,
            matrix(&e.mass_matrix),
        )
    };
    plans.extend([
        of_inertia,
        single(
            "generalized_forces",
            &["fbar"],
            format!(
                "The reduced forces `fbar = Q + T' (F - M bias)`, {}.\n\nRows: {}",
                if angles { "in N m" } else { "in N for lengths, N m for angles" },
                columns.trim_start_matches("Columns: ")
            ),
            &[Time, Coordinates, Rates],
            &coordinate_names,
            vector(&e.generalized_forces),
        ),
        single(
            "energy",
            &["T + V"],
            "Kinetic energy, and the potential of the conservative loads, in J.".to_owned(),
            &[Coordinates, Rates],
            &energies,
            vector(&e.energy),
        ),
        single(
            "power",
            &[],
            format!(
                "Power of the loads that have no potential{}, in W.",
                if is_driven { ", and of what drives the closures, `lambda' C_t`" } else { "" }
            ),
            power_arguments(scene),
            &[],
            Shape::Scalar(&e.power[0]),
        ),
        single(
            "outputs",
            &[],
            format!("What the scene asks for: {}.", outputs.join(", ")),
            &[Time, Coordinates, Rates, Accelerations, Multipliers],
            &output_names,
            vector(&e.outputs),
        ),
    ]);
    if !is_large_tree {
        plans.push(Plan {
            name: "dynamics",
            aliases: &["fused"],
            doc: "All that the accelerations need, with everything shared that the parts have in common.".to_owned(),
            arguments: &[Time, Coordinates, Rates],
            parts: vec![
                ("mass_matrix", matrix(&e.mass_matrix)),
                ("generalized_forces", vector(&e.generalized_forces)),
                ("constraint_jacobian", matrix(&e.constraint_jacobian)),
                ("constraint_bias", vector(&e.constraint_bias)),
            ],
            structure: Some("Dynamics"),
        });
    }
    plans.push(Plan {
        name: "loop_constraints",
        aliases: &[],
        doc: "All that a correction of positions and rates needs: `C`, `C_q` and `C_t`.".to_owned(),
        arguments: at_position,
        parts: vec![
            ("residuals", vector(&e.constraints)),
            ("constraint_jacobian", matrix(&e.constraint_jacobian)),
            ("constraint_rate", vector(&e.constraint_rate)),
        ],
        structure: Some("LoopConstraints"),
    });
    plans.extend(e.linearization.as_ref().map(|linearization| {
        Plan {
            name: "linearization",
            aliases: &["tangent stiffness", "tangent damping"],
            doc: "How the equations of motion change with the state, accelerations and multipliers held: \
              `stiffness = -d(fbar - Mbar qdd - C_q' lambda)/dq`, `damping = -d fbar/d qd`, \
              `constraint_stiffness = d(C_q qdd + bias)/dq`, `constraint_damping = d bias/d qd`, \
              `forcing = d(fbar - C_q' lambda)/dt`, `constraint_forcing = -d(C_q qdd + bias)/dt`."
                .to_owned(),
            arguments: &[Time, Coordinates, Rates, Accelerations, Multipliers],
            parts: linearization
                .parts()
                .map(|(name, rows)| (name, matrix(rows)))
                .into_iter()
                .chain([
                    ("forcing", vector(&linearization.forcing)),
                    ("constraint_forcing", vector(&linearization.constraint_forcing)),
                ])
                .collect(),
            structure: Some("Linearization"),
        }
    }));
    plans
}

/// The arguments of the power of loads and drives in a scene.
fn power_arguments(scene: &Scene) -> &'static [Argument] {
    use Argument::{Accelerations, Coordinates, Multipliers, Rates, Time};
    match (scene.is_driven(), scene.normal_forces().is_empty()) {
        (false, true) => &[Time, Coordinates, Rates],
        (true, true) => &[Time, Coordinates, Rates, Multipliers],
        (_, false) => &[Time, Coordinates, Rates, Accelerations, Multipliers],
    }
}
