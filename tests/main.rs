//! All tests of the command and of the library: one program, whose tests run side by side.
//!
//! Tests that are ignored belong to the full tier: `.ci/groups` says what they need and when they run.

mod common;

mod accuracy;
mod allocation;
mod api;
mod benchmarks;
mod book;
mod browser;
mod cams;
mod certify;
mod check;
mod command;
mod conditions;
mod corners;
mod corpus;
mod driven;
mod energy_integral;
mod error_estimates;
mod extremes;
mod figures;
mod force_elements;
mod formulae;
mod friction;
mod gauss;
mod inverse;
mod kernel;
mod languages;
mod linkage;
mod live;
mod live_page;
mod loads;
mod page;
mod quick_return;
mod random_conditions;
mod random_runs;
mod reading;
mod readme;
mod recipes;
mod reference_states;
mod scene_files;
mod sensitivity;
mod sensitivity_methods;
mod singular;
mod stability;
mod start;
mod stiff;
mod style;
mod sweep;
mod sweep_command;
mod third_party;
mod tolerance;
mod tolerance_nonlinear;
mod unit_conversion;
mod units;
