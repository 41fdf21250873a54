//! Pictures.

mod animation;
mod figure;
mod gif;
