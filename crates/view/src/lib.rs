//! Pictures of recorded motions: figures as SVG, animations as HTML and GIF, reports.
//!
//! This crate does not depend on mechanisms: its input consists of named numbers ([`figure::Figure`],
//! [`motion::Motion`]), its output of text or bytes; [`envelope::Envelope`] stores long series of numbers. Equal inputs
//! give equal bytes.

pub mod animation;
pub mod envelope;
#[cfg(feature = "figure")]
pub mod figure;
#[cfg(feature = "gif")]
pub mod gif;
mod html;
#[cfg(feature = "report")]
mod markdown;
pub mod motion;
#[cfg(feature = "report")]
pub mod report;
mod rounding;
