//! `qrm accuracy`

use super::{AccuracyArguments, Failure};
use crate::scenes::Scenes;

/// Measures run time and error of every method.
pub(super) fn accuracy(_scenes: &Scenes, _arguments: &AccuracyArguments) -> Result<(), Failure> {
    Ok(())
}
