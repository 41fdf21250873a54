//! Pictures of recorded motions: figures as SVG, animations as HTML and GIF, reports.
//!
//! Knows nothing of mechanisms: what it is given are numbers under names ([`figure::Figure`], [`motion::Motion`]), what
//! it gives back is text or bytes; [`envelope::Envelope`] keeps long series of numbers. The same input
//! gives the same bytes.

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
