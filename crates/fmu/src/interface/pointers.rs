//! Pointers of an importer to arrays and to places for results.

use std::slice;

use crate::failure::Failure;

/// Borrows an array of the importer; empty for null.
///
/// # Safety
/// `values` points to `count` values, or is null.
pub(super) unsafe fn read<'a, T>(values: *const T, count: usize) -> &'a [T] {
    // SAFETY: the caller's contract; an empty array may be a null pointer in C, but not in Rust.
    if values.is_null() || count == 0 { &[] } else { unsafe { slice::from_raw_parts(values, count) } }
}

/// Borrows an array of the importer for writing; empty for null.
///
/// # Safety
/// `values` points to `count` values that nobody else uses, or is null.
pub(super) unsafe fn room<'a, T>(values: *mut T, count: usize) -> &'a mut [T] {
    // SAFETY: as above.
    if values.is_null() || count == 0 { &mut [] } else { unsafe { slice::from_raw_parts_mut(values, count) } }
}

/// Writes a result, unless the pointer is null.
///
/// # Safety
/// `place` points to a value, or is null.
pub(super) unsafe fn put<T>(place: *mut T, value: T) {
    if !place.is_null() {
        // SAFETY: the caller's contract.
        unsafe { place.write(value) }
    }
}

/// Refuses null as the place for the result of a function.
pub(super) fn is_there<T>(place: *mut T) -> Result<(), Failure> {
    if place.is_null() { Err("there is no place for the result".into()) } else { Ok(()) }
}

pub(super) fn same_count(given: usize, needed: usize) -> Result<(), Failure> {
    if given == needed { Ok(()) } else { Err(format!("{given} values were given where there are {needed}").into()) }
}
