//! The numbers and tapes of the kernel.

mod double_double;
mod rate;
mod sine;
mod tape;
