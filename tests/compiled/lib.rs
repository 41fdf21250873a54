//! Tests of compiled scenes. They name the types of all scenes: `QRM_SCENES=all cargo test --release -p qrm-compiled`.
