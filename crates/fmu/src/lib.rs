//! Generated mechanisms as FMUs of the Functional Mock-up Interface 3.0.
//!
//! A `cdylib` crate that contains
//!
//! ```ignore
//! qrm_fmu::export!(scenes::MODELS);
//! ```
//!
//! becomes a library with all functions of the interface, for all its mechanisms. The [`InstantiationToken`] names the
//! mechanism of an instance. `qrm export-fmu` packs the library with a description of the [`variables`] of one
//! mechanism.
//!
//! The functions are handwritten: the existing crate `fmi-export` 0.3 describes one model at compile time, by a macro
//! over a struct, and needs libclang to build; see docs/decisions/0013.

mod failure;
mod instance;
#[allow(unsafe_code, reason = "a C interface is made of pointers")]
mod interface;
mod phase;
mod token;
mod variables;

#[doc(hidden)]
pub use qrm_core::Model;
pub use token::{InstantiationToken, NotAToken};
pub use variables::variables;

/// Exports mechanisms through the interface: `export!(MODELS)`, once in a `cdylib`, with a `&'static [Model]`.
#[macro_export]
macro_rules! export {
    ($models:expr) => {
        #[doc(hidden)]
        #[allow(unsafe_code, reason = "the name is known to qrm-fmu")]
        #[unsafe(no_mangle)]
        pub fn qrm_fmu_models() -> &'static [$crate::Model] {
            $models
        }
    };
}
