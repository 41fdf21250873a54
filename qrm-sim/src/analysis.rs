//! Analyses other than runs: manually moved positions, inverse dynamics, static equilibrium, linearized equations,
//! exact motions, reference motions, derivatives with respect to parameters, run times.

mod branches;
mod enclosure;
mod energy_integral;
mod equilibria;
mod equilibrium;
mod four_bar;
mod inverse_dynamics;
mod inverse_kinematics;
mod linear_model;
mod measure;
mod mechanism_without_drive;
mod modes;
mod motion_statistics;
mod reference;
mod revolution;
mod sensitivity;
mod singular_interval;
mod spectrum;
mod steady;

pub use branches::{MAX_BRANCHES, branches};
pub use enclosure::{Enclosure, EnclosureEnd, NoSeries, NotEnclosed, Reason, enclose};
pub use energy_integral::{EnergyIntegral, NoEnergyIntegral, PANELS};
pub use equilibria::{Equilibrium, equilibria, equilibrium};
pub use equilibrium::{NoEquilibrium, StaticEquilibrium, static_equilibrium};
pub use four_bar::{FourBar, GrashofClass};
pub use inverse_dynamics::{NotPossible, Prescribed, PrescribedMotion, PrescribedState};
pub use inverse_kinematics::{PositionError, inverse_kinematics};
pub use linear_model::{LinearModel, LinearOutput, linear_model};
pub use measure::{Measurement, Repetitions, StateAt, Trial, exact_states, measure};
pub use mechanism_without_drive::MechanismWithoutDrive;
pub use modes::{DampedMode, EquilibriumStability, Mode, ModeKind, Modes, NoModes, modes};
pub use motion_statistics::{MotionStatistics, Numbers, Statistics};
pub use reference::{ReferenceState, reference_states};
pub use revolution::{NoRevolution, Range, Revolution, Series, Vertex, can_revolve, revolution, wrap_angle};
pub use sensitivity::{
    DerivativeErrors, Derivatives, OutputValues, Sensitivity, SensitivityError, SensitivityRequest, sensitivity,
};
pub use spectrum::{Spectrum, longest_step, spectrum};
pub use steady::{
    BranchEnd, BranchPoint, BranchRequest, MotionStability, Multiplier, NoSteadyMotion, PointKind, SteadyMotion,
    SteadyRequest, steady_branch, steady_motion,
};
