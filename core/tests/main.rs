//! The numbers of the kernel.

mod double_double;
mod sine;
mod tape;
