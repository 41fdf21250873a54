//! Templates of the steps of a motion, identical for all mechanisms except for names and sizes.

use qrm_core::dop853::{ERROR_3, ERROR_5, NODES, ROWS, Row};

use super::Writer;
use crate::constants::substitute;
use crate::ir::StructKind;

/// The declarations of the steps for other source files.
const HEADER: &str = include_str!("templates/steps.h");
/// The sizes of arrays.
const SIZES: &str = "\nenum { N = SCENE_COORDINATES, M = SCENE_CONSTRAINTS };\n";
/// States and their projection.
const PROJECTION: &str = include_str!("templates/projection.c");
/// Sines and cosines that are updated by turns.
const ANGLES: &str = include_str!("templates/angles.c");
/// The mass matrix from the momenta of a large tree.
const MASS_MATRIX: &str = include_str!("templates/mass_matrix.c");
/// The equations of motion where the kernel is not valid.
const SADDLE_POINT: &str = include_str!("templates/saddle_point.c");
/// The state at the start of a motion.
const INITIAL: &str = include_str!("templates/initial.c");
/// The step of the Runge-Kutta method of order 4.
const RK4: &str = include_str!("templates/rk4.c");
/// The step of order 8.
const DOP853: &str = include_str!("templates/dop853.c");
/// The number of stages of the step of order 8.
const STAGES: usize = 12;

impl Writer<'_> {
    /// The declarations of the steps.
    pub(super) fn step_header(&self) -> String {
        self.named(HEADER)
    }

    /// The functions of the steps.
    pub(super) fn step_source(&self) -> String {
        let rows = |rows: &[Row]| list(rows.iter().map(|row| weights(row)), ",\n    ");
        let booleans = |booleans: &[bool]| list(booleans.iter().map(|boolean| u8::from(*boolean).to_string()), ", ");
        let dop853 = DOP853
            .replace("NUMBERS_OF_NODES", &list(NODES[..STAGES].iter().map(|node| format!("{node:?}")), ", "))
            .replace("NUMBERS_OF_ROWS", &rows(&ROWS[..=STAGES]))
            .replace("NUMBERS_OF_ERRORS", &rows(&[ERROR_5, ERROR_3]))
            .replace("NUMBERS_OF_LENGTHS", &booleans(&self.program.is_length));
        let angles = ANGLES.replace("NUMBERS_OF_ANGLES", &booleans(&self.program.has_angle));
        let mass_matrix = if self.program.function("momenta").is_some() { MASS_MATRIX } else { "" };
        self.named(&[SIZES, &angles, mass_matrix, SADDLE_POINT, PROJECTION, INITIAL, RK4, &dop853].concat())
    }

    /// Fills in the constants of the projection and the names of the program.
    pub(super) fn named(&self, template: &str) -> String {
        let name = &self.program.name;
        substitute(template)
            .replace("scene_", &format!("{name}_"))
            .replace("struct scene ", &format!("{} ", self.structure(StructKind::Mechanism)))
            .replace("SCENE_", &format!("{}_", name.to_uppercase()))
    }
}

/// The weights of all stages.
fn weights(row: Row) -> String {
    let mut weights = [0.0; STAGES];
    row.iter().for_each(|&(stage, weight)| weights[stage] = weight);
    list(weights.iter().map(|weight| format!("{weight:?}")), ", ")
}

fn list(items: impl Iterator<Item = String>, separator: &str) -> String {
    format!("{{{}}}", items.collect::<Vec<_>>().join(separator))
}
