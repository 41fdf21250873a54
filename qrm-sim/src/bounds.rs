//! Bounds of functions of the motion between states, in intervals.

mod arguments;
mod function;
mod output;
mod peak;
mod resolution;
mod rows;

pub(crate) use arguments::{ArgumentPolynomials, argument, ball};
pub(crate) use function::FunctionBounds;
pub(crate) use output::{BoundedOutput, bounded_outputs};
pub(crate) use peak::{PeakError, PeakSearch};
pub(crate) use resolution::{Resolution, Unresolved};
pub(crate) use rows::RowBoxes;
