//! Scenes that use every function, every kind of load and output, and time wherever it may stand.

mod processor;

mod branch;
mod driven;
mod friction;
mod functions;
mod loads;
mod pulse;
mod record;
mod redundant;
mod simulation;
mod singular;
mod undefined;
