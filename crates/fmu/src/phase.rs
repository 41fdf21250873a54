//! The phases of an instance, which determine the functions that can be called.

/// The phase of an instance.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Phase {
    /// Parameters can be set.
    Instantiated,
    /// Parameters can be set, and values can be read.
    Initializing,
    /// The motion is in progress, and the FMU makes the importer's steps.
    Stepping,
    /// The motion is in progress, and the importer handles an event.
    Event,
    /// The motion is in progress, and the importer integrates.
    Integrating,
    /// The motion has ended.
    Terminated,
}

impl Phase {
    /// Whether the motion is in progress.
    pub(crate) fn is_running(self) -> bool {
        matches!(self, Self::Stepping | Self::Event | Self::Integrating)
    }

    /// The name of the phase in the standard.
    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::Instantiated => "instantiated",
            Self::Initializing => "in initialization mode",
            Self::Stepping => "in step mode",
            Self::Event => "in event mode",
            Self::Integrating => "in continuous-time mode",
            Self::Terminated => "terminated",
        }
    }
}
