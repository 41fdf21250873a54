//! Reads scene files: mechanisms described by formulae.
//!
//! [`source`] reads the text, [`document`] its TOML with the place of every value, [`lexer`] and [`parser`] the
//! formulae, and [`resolve`] looks up names and checks the rules, which gives a [`scene::Scene`]. All mistakes of a
//! file are reported together, at their lines and columns ([`diagnostic`]). [`evaluate`] gives formulae values, on
//! doubles and on dual numbers. [`layout`] compares the texts of scenes. [`time_scales`] tells how
//! fast loads change with time. [`files`] writes files whole, for whoever works with scenes.

pub mod diagnostic;
pub mod direction;
pub mod document;
pub mod evaluate;
pub mod expression;
pub mod files;
pub mod function;
pub mod layout;
pub mod lexer;
pub mod linkage;
pub mod names;
pub mod operations;
pub mod parser;
pub mod printer;
pub mod resolve;
pub mod scene;
pub mod scene_file;
pub mod source;
pub mod spline;
pub mod time_scales;
