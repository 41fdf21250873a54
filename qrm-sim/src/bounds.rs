//! Bounds of functions of the motion between states, in intervals.

mod arguments;
mod function;
mod peak;
mod rows;

pub(crate) use arguments::{ArgumentPolynomials, ball};
pub(crate) use function::FunctionBounds;
pub(crate) use peak::{PeakError, PeakSearch};
pub(crate) use rows::RowBoxes;
