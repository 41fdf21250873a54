//! The functions of FMI 3.0 for features that these FMUs lack: types other than doubles, clocks, derivatives,
//! serialized states. An importer may look up any of them.

use std::ffi::{c_char, c_int, c_void};

use super::handle::{Status, with};
use super::interface;

fn refuse(handle: *mut c_void, why: &str) -> Status {
    with(handle, |_| Err(why.into()))
}

interface! {
    fn fmi3GetNumberOfVariableDependencies(handle: *mut c_void, reference: u32, count: *mut usize) -> Status {
        refuse(handle, "dependencies of variables are not known")
    }

    fn fmi3GetVariableDependencies(
        handle: *mut c_void,
        dependent: u32,
        elements: *mut usize,
        independents: *mut u32,
        independent_elements: *mut usize,
        kinds: *mut c_int,
        count: usize,
    ) -> Status {
        refuse(handle, "dependencies of variables are not known")
    }

    fn fmi3SerializedFMUStateSize(handle: *mut c_void, state: *mut c_void, size: *mut usize) -> Status {
        refuse(handle, "states cannot be serialized")
    }

    fn fmi3SerializeFMUState(handle: *mut c_void, state: *mut c_void, bytes: *mut u8, size: usize) -> Status {
        refuse(handle, "states cannot be serialized")
    }

    fn fmi3DeserializeFMUState(handle: *mut c_void, bytes: *const u8, size: usize, state: *mut *mut c_void) -> Status {
        refuse(handle, "states cannot be serialized")
    }

    fn fmi3GetDirectionalDerivative(
        handle: *mut c_void,
        unknowns: *const u32,
        unknown_count: usize,
        knowns: *const u32,
        known_count: usize,
        seed: *const f64,
        seed_count: usize,
        sensitivity: *mut f64,
        sensitivity_count: usize,
    ) -> Status {
        refuse(handle, "directional derivatives are not provided")
    }

    fn fmi3GetAdjointDerivative(
        handle: *mut c_void,
        unknowns: *const u32,
        unknown_count: usize,
        knowns: *const u32,
        known_count: usize,
        seed: *const f64,
        seed_count: usize,
        sensitivity: *mut f64,
        sensitivity_count: usize,
    ) -> Status {
        refuse(handle, "adjoint derivatives are not provided")
    }

    fn fmi3EnterConfigurationMode(handle: *mut c_void) -> Status {
        refuse(handle, "there is nothing to configure")
    }

    fn fmi3ExitConfigurationMode(handle: *mut c_void) -> Status {
        refuse(handle, "there is nothing to configure")
    }

    fn fmi3EnterStepMode(handle: *mut c_void) -> Status {
        refuse(handle, "there is no event mode to leave")
    }

    fn fmi3GetOutputDerivatives(
        handle: *mut c_void,
        references: *const u32,
        count: usize,
        orders: *const i32,
        values: *mut f64,
        value_count: usize,
    ) -> Status {
        refuse(handle, "derivatives of outputs are not provided")
    }

    fn fmi3ActivateModelPartition(handle: *mut c_void, clock: u32, time: f64) -> Status {
        refuse(handle, "there is no scheduled execution")
    }
}

/// Defines functions for types that no variable has; they refuse every request.
macro_rules! no_variables {
    ($($get:ident, $set:ident: $type:ty;)*) => {
        interface! {
            $(
                fn $get(
                    handle: *mut c_void, references: *const u32, count: usize, values: *mut $type, value_count: usize
                ) -> Status
                {
                    nothing(handle, count)
                }

                fn $set(
                    handle: *mut c_void, references: *const u32, count: usize, values: *const $type, value_count: usize
                ) -> Status
                {
                    nothing(handle, count)
                }
            )*
        }
    };
}

fn nothing(handle: *mut c_void, count: usize) -> Status {
    with(handle, |_| if count == 0 { Ok(()) } else { Err("all variables are of the type Float64".into()) })
}

no_variables! {
    fmi3GetFloat32, fmi3SetFloat32: f32;
    fmi3GetInt8, fmi3SetInt8: i8;
    fmi3GetUInt8, fmi3SetUInt8: u8;
    fmi3GetInt16, fmi3SetInt16: i16;
    fmi3GetUInt16, fmi3SetUInt16: u16;
    fmi3GetInt32, fmi3SetInt32: i32;
    fmi3GetUInt32, fmi3SetUInt32: u32;
    fmi3GetInt64, fmi3SetInt64: i64;
    fmi3GetUInt64, fmi3SetUInt64: u64;
    fmi3GetBoolean, fmi3SetBoolean: bool;
    fmi3GetString, fmi3SetString: *const c_char;
}

interface! {
    fn fmi3GetBinary(
        handle: *mut c_void,
        references: *const u32,
        count: usize,
        sizes: *mut usize,
        values: *mut *const u8,
        value_count: usize,
    ) -> Status {
        nothing(handle, count)
    }

    fn fmi3SetBinary(
        handle: *mut c_void,
        references: *const u32,
        count: usize,
        sizes: *const usize,
        values: *const *const u8,
        value_count: usize,
    ) -> Status {
        nothing(handle, count)
    }

    fn fmi3GetClock(handle: *mut c_void, references: *const u32, count: usize, values: *mut bool) -> Status {
        nothing(handle, count)
    }

    fn fmi3SetClock(handle: *mut c_void, references: *const u32, count: usize, values: *const bool) -> Status {
        nothing(handle, count)
    }

    fn fmi3GetIntervalDecimal(
        handle: *mut c_void,
        references: *const u32,
        count: usize,
        intervals: *mut f64,
        qualifiers: *mut c_int,
    ) -> Status {
        nothing(handle, count)
    }

    fn fmi3GetIntervalFraction(
        handle: *mut c_void,
        references: *const u32,
        count: usize,
        counters: *mut u64,
        resolutions: *mut u64,
        qualifiers: *mut c_int,
    ) -> Status {
        nothing(handle, count)
    }

    fn fmi3GetShiftDecimal(handle: *mut c_void, references: *const u32, count: usize, shifts: *mut f64) -> Status {
        nothing(handle, count)
    }

    fn fmi3GetShiftFraction(
        handle: *mut c_void,
        references: *const u32,
        count: usize,
        counters: *mut u64,
        resolutions: *mut u64,
    ) -> Status {
        nothing(handle, count)
    }

    fn fmi3SetIntervalDecimal(
        handle: *mut c_void,
        references: *const u32,
        count: usize,
        intervals: *const f64,
    ) -> Status {
        nothing(handle, count)
    }

    fn fmi3SetIntervalFraction(
        handle: *mut c_void,
        references: *const u32,
        count: usize,
        counters: *const u64,
        resolutions: *const u64,
    ) -> Status {
        nothing(handle, count)
    }

    fn fmi3SetShiftDecimal(handle: *mut c_void, references: *const u32, count: usize, shifts: *const f64) -> Status {
        nothing(handle, count)
    }

    fn fmi3SetShiftFraction(
        handle: *mut c_void,
        references: *const u32,
        count: usize,
        counters: *const u64,
        resolutions: *const u64,
    ) -> Status {
        nothing(handle, count)
    }
}
