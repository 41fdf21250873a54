//! Constants of the projection, which the templates of all languages share with the steps in Rust.

use qrm_core::{CORRECTION_ROUNDING, MAX_CORRECTIONS, MAX_GROWTH, RESIDUAL_ROUNDING};

/// A template with the constants that it mentions.
pub(super) fn substitute(template: &str) -> String {
    template
        .replace("QRM_MAX_CORRECTIONS", &MAX_CORRECTIONS.to_string())
        .replace("QRM_RESIDUAL_ROUNDING", &format!("{RESIDUAL_ROUNDING:e}"))
        .replace("QRM_CORRECTION_ROUNDING", &format!("{CORRECTION_ROUNDING:e}"))
        .replace("QRM_MAX_GROWTH", &format!("{MAX_GROWTH:e}"))
}
