//! Templates of the steps of a motion, identical for all mechanisms except for names and sizes.

use qrm_core::dop853::{DENSE, ERROR_3, ERROR_5, NODES, ROWS, Row};

use super::Writer;
use crate::constants::substitute;
use crate::ir::StructKind;

/// States and ends of steps.
const STATES: &str = include_str!("templates/states.h");
/// The declarations of the steps for other source files.
const HEADER: &str = include_str!("templates/steps.h");
/// The sizes of arrays.
const SIZES: &str = "\nenum { N = SCENE_COORDINATES, M = SCENE_CONSTRAINTS };\n";
/// The projection of the end of a step.
const PROJECTION: &str = include_str!("templates/projection.c");
/// States, completed and projected.
const COMPLETE: &str = include_str!("templates/states.c");
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
/// The parts of the step of order 8.
const DOP853: &str = include_str!("templates/dop853.c");
/// The step of order 8.
const DOP853_STEP: &str = include_str!("templates/dop853_step.c");
/// The kernel without the equations of motion for positions that it does not suit.
const KERNEL_ALONE: &str = include_str!("templates/kernel_alone.c");
/// The steps of lanes.
const LANE_STEPS: &str = include_str!("templates/lane_steps.c");
/// The number of stages of the step of order 8.
const STAGES: usize = 12;

impl Writer<'_> {
    /// States and ends of steps.
    pub(super) fn states(&self) -> String {
        self.named(STATES)
    }

    /// The declarations of the steps.
    pub(super) fn step_header(&self) -> String {
        self.named(HEADER)
    }

    /// The functions of the steps.
    pub(super) fn step_source(&self) -> String {
        let mass_matrix = if self.program.function("momenta").is_some() { MASS_MATRIX } else { "" };
        let (angles, dop853) = (self.angles(), self.dop853(STAGES));
        let parts =
            [SIZES, &angles, mass_matrix, SADDLE_POINT, PROJECTION, COMPLETE, INITIAL, RK4, &dop853, DOP853_STEP];
        self.named(&parts.concat())
    }

    /// The functions of the steps of lanes.
    pub(super) fn lane_source(&self) -> String {
        let dense = rows(&DENSE, ROWS.len());
        let lane_steps = LANE_STEPS.replace("NUMBERS_OF_DENSE", &dense);
        self.named(&[SIZES, &self.angles(), KERNEL_ALONE, PROJECTION, &self.dop853(ROWS.len()), &lane_steps].concat())
    }

    fn angles(&self) -> String {
        ANGLES.replace("NUMBERS_OF_ANGLES", &booleans(&self.program.has_angle))
    }

    /// The parts of the step of order 8, with this number of slopes: more than its stages for the dense output.
    fn dop853(&self, slopes: usize) -> String {
        let count = ROWS.len().min(slopes + 1);
        DOP853
            .replace("COUNT_OF_SLOPES", &slopes.to_string())
            .replace("COUNT_OF_ROWS", &count.to_string())
            .replace("NUMBERS_OF_NODES", &list(NODES[..slopes].iter().map(|node| format!("{node:?}")), ", "))
            .replace("NUMBERS_OF_ROWS", &rows(&ROWS[..count], slopes))
            .replace("NUMBERS_OF_ERRORS", &rows(&[ERROR_5, ERROR_3], slopes))
            .replace("NUMBERS_OF_LENGTHS", &booleans(&self.program.is_length))
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

/// Rows of weights of this number of slopes.
fn rows(rows: &[Row], slopes: usize) -> String {
    let weights = |row: &Row| {
        let mut weights = vec![0.0; slopes];
        row.iter().for_each(|&(slope, weight)| weights[slope] = weight);
        list(weights.iter().map(|weight| format!("{weight:?}")), ", ")
    };
    list(rows.iter().map(weights), ",\n    ")
}

fn booleans(booleans: &[bool]) -> String {
    list(booleans.iter().map(|boolean| u8::from(*boolean).to_string()), ", ")
}

fn list(items: impl Iterator<Item = String>, separator: &str) -> String {
    format!("{{{}}}", items.collect::<Vec<_>>().join(separator))
}
