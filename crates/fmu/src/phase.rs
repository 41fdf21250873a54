//! The states of an instance, by which the interface says what can be called.

/// Where in its life an instance is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Phase {
    /// Parameters can be set.
    Instantiated,
    /// Parameters can be set, and values can be read.
    Initializing,
    /// The motion is under way; the importer steps by the unit.
    Stepping,
    /// The motion is under way; the importer deals with an event.
    Event,
    /// The motion is under way; the importer integrates.
    Integrating,
    /// The motion is over.
    Terminated,
}

impl Phase {
    /// Whether the motion is under way.
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
