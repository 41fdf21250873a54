//! Valid and invalid scenes.

mod corpus;
mod errors;
