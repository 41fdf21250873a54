//! Reads scene files: mechanisms described by formulae.
//!
//! [`source`] reads the text, [`document`] parses TOML with the location of every value, [`lexer`] and [`parser`] parse
//! formulae, and [`resolve`] looks up names and checks the rules; the result is a [`scene::Scene`]. All errors of a
//! file are reported together, with lines and columns ([`diagnostic`]). [`evaluate`] evaluates formulae on doubles and
//! dual numbers. [`layout`] compares the texts of scenes. [`time_scales`] finds how fast loads change with time.
//! [`files`] writes files atomically.

pub mod declarations;
pub mod diagnostic;
pub mod dimension;
pub mod direction;
pub mod document;
pub mod evaluate;
pub mod expression;
pub mod files;
pub mod formula_tape;
pub mod function;
pub mod layout;
pub mod lexer;
pub mod linkage;
pub mod names;
pub mod parser;
pub mod printer;
pub mod resolve;
pub mod scene;
pub mod scene_file;
pub mod source;
pub mod spline;
pub mod time_scales;
pub mod unit;
