//! Generated mechanisms as units of the Functional Mock-up Interface 3.0.
//!
//! A crate of the type `cdylib` that says
//!
//! ```ignore
//! qrm_fmu::export!(scenes::visit_all);
//! ```
//!
//! becomes a library with all functions of the interface, for all its mechanisms: which of them an instance is stands in its
//! instantiation token ([`Settings`](qrm_sim::unit::Settings)). `qrm export-fmu` packs the library with the description that belongs to one.
//!
//! The functions are written by hand: the crate that exists for them, `fmi-export` 0.3, describes one model at compile time, by a
//! macro over a struct, and needs libclang to build; see docs/decisions/0013.

mod instance;
#[allow(unsafe_code, reason = "a C interface is made of pointers")]
mod interface;

pub use qrm_sim::unit::Units;

/// Tells the interface which mechanisms there are: `export!(visit_all)`, once in a `cdylib`.
#[macro_export]
macro_rules! export {
    ($visit_all:path) => {
        #[doc(hidden)]
        #[allow(unsafe_code, reason = "the name is known to qrm-fmu")]
        #[unsafe(no_mangle)]
        pub fn qrm_fmu_visit_all(units: &mut $crate::Units) {
            $visit_all(units);
        }
    };
}
