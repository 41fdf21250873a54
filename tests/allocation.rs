//! Steps allocate nothing: a run of four times as many steps allocates as often.

#![allow(unsafe_code, reason = "an allocator that counts is the only way to count allocations")]

use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::Cell;

use qrm_sim::integrate::MethodSettings;
use qrm_sim::run::{End, Request, simulate};
use qrm_sim::solve::Projection;

use crate::common;

struct Counting;

thread_local! {
    /// The allocations of this thread alone: the test runner allocates on its own, whenever it likes.
    static COUNT: Cell<usize> = const { Cell::new(0) };
}

fn count() -> usize {
    COUNT.with(Cell::get)
}

// SAFETY: every call is handed to the system's allocator unchanged; counting touches a constant-initialised cell of
// the thread, which allocates nothing and has no destructor.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        COUNT.with(|count| count.set(count.get() + 1));
        // SAFETY: the caller keeps the contract of `alloc`.
        unsafe { System.alloc(layout) }
    }

    unsafe fn dealloc(&self, block: *mut u8, layout: Layout) {
        // SAFETY: the caller keeps the contract of `dealloc`.
        unsafe { System.dealloc(block, layout) }
    }
}

#[global_allocator]
static ALLOCATOR: Counting = Counting;

fn allocations(projection: Projection, end_time: f64) -> usize {
    let mechanism = common::mechanism("quick-return", &[]);
    let settings = MethodSettings { projection, ..MethodSettings::default() };
    let request = Request { settings, end: Some(End::Time(end_time)), estimate_error: true, ..Request::default() };
    let before = count();
    let outcome = simulate(&*mechanism, &request, &mut ()).expect("the run starts");
    assert!(outcome.counts.accepted > 100);
    count() - before
}

#[test]
fn steps_allocate_nothing() {
    for projection in [Projection::None, Projection::Euclidean, Projection::Mass] {
        let few = allocations(projection, 10.0);
        assert!(few > 0, "the count counts");
        // Threads that wait for each other allocate now and then.
        let many = allocations(projection, 40.0);
        assert!(many <= few + 20, "{projection:?}: {many} instead of {few}");
    }
}
