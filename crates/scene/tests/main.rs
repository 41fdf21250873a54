//! Scenes, right and wrong.

mod corpus;
mod errors;
